//! Names in the graph: `~/x`, relative and absolute, in a namespace, and what the command line
//! renames.
//!
//! As in rcl: a name is expanded to an absolute one; the first rule whose left side expands to the
//! same gives the new one, which is expanded in turn. Nothing here knows DDS.

use std::fmt;

/// A name that ROS does not allow.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("`{name}` is not a ROS name: {reason}")]
pub struct BadName {
    /// The name as given, or as expanded.
    pub name: String,
    /// What is wrong with it.
    pub reason: &'static str,
}

/// What a rule renames.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// `__node` or `__name`
    Node,
    /// `__ns`
    Namespace,
    /// `rostopic://...`
    Topic,
    /// `rosservice://...`; actions are services and topics.
    Service,
    /// Topics and services.
    Any,
}

/// `[node:]from:=to`
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Rule {
    /// Only for the node of this name.
    pub node: Option<String>,
    /// What it renames.
    pub kind: Kind,
    /// The old name; of a node or namespace nothing.
    pub from: String,
    /// The new name.
    pub to: String,
}

impl Rule {
    /// Reads `[node:]from:=to`.
    ///
    /// # Errors
    /// What would be right.
    pub fn parse(text: &str) -> Result<Self, String> {
        let wanted = || format!("`{text}` is not a rule: [node:]from:=to");
        let (from, to) = text.split_once(":=").ok_or_else(wanted)?;
        if from.is_empty() || to.is_empty() {
            return Err(wanted());
        }
        let (node, from) = match from.split_once(':') {
            Some((node, from)) if !from.starts_with("//") => (Some(node.to_owned()), from),
            _ => (None, from),
        };
        let (kind, from) = match from {
            "__node" | "__name" => (Kind::Node, ""),
            "__ns" => (Kind::Namespace, ""),
            _ => match (from.strip_prefix("rostopic://"), from.strip_prefix("rosservice://")) {
                (Some(topic), _) => (Kind::Topic, topic),
                (_, Some(service)) => (Kind::Service, service),
                _ => (Kind::Any, from),
            },
        };
        let to = to.strip_prefix("rostopic://").unwrap_or(to);
        let to = to.strip_prefix("rosservice://").unwrap_or(to);
        if from.contains('*') || to.contains('\\') {
            return Err(format!("`{text}`: wildcards are not supported in rules"));
        }
        Ok(Self { node, kind, from: from.to_owned(), to: to.to_owned() })
    }

    fn is_for(&self, node: &str, kind: Kind) -> bool {
        let same = self.kind == kind
            || self.kind == Kind::Any && matches!(kind, Kind::Topic | Kind::Service);
        same && self.node.as_deref().is_none_or(|name| name == node)
    }
}

/// A node's own name and namespace, and the rules for all others.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Names {
    node: String,
    namespace: String,
    rules: Vec<Rule>,
}

impl Names {
    /// The node of this name, in this namespace unless a rule says otherwise.
    ///
    /// # Errors
    /// [`BadName`]
    pub fn new(node: &str, namespace: &str, rules: Vec<Rule>) -> Result<Self, BadName> {
        let first = |node: &str, kind| {
            rules.iter().find(|rule: &&Rule| rule.is_for(node, kind)).map(|rule| rule.to.clone())
        };
        let node = first(node, Kind::Node).unwrap_or_else(|| node.to_owned());
        let namespace = first(&node, Kind::Namespace).unwrap_or_else(|| namespace.to_owned());
        let namespace = match namespace.strip_prefix('/') {
            Some("") | None if namespace.len() < 2 => "/".to_owned(),
            Some(_) => namespace,
            None => format!("/{namespace}"),
        };
        check_token(&node, &node)?;
        if namespace != "/" {
            check_absolute(&namespace)?;
        }
        Ok(Self { node, namespace, rules })
    }

    /// Its name alone.
    pub fn node(&self) -> &str {
        &self.node
    }

    /// The namespace, absolute.
    pub fn namespace(&self) -> &str {
        &self.namespace
    }

    /// The whole name of a topic.
    ///
    /// # Errors
    /// [`BadName`]
    pub fn topic(&self, name: &str) -> Result<String, BadName> {
        self.resolve(name, Kind::Topic)
    }

    /// The whole name of a service.
    ///
    /// # Errors
    /// [`BadName`]
    pub fn service(&self, name: &str) -> Result<String, BadName> {
        self.resolve(name, Kind::Service)
    }

    fn resolve(&self, name: &str, kind: Kind) -> Result<String, BadName> {
        let full = self.expand(name)?;
        let rules = self.rules.iter().filter(|rule| rule.is_for(&self.node, kind));
        for rule in rules {
            if self.expand(&rule.from)? == full {
                return self.expand(&rule.to);
            }
        }
        Ok(full)
    }

    /// Absolute, with `~` and `{node}`, `{ns}`, `{namespace}` put in.
    fn expand(&self, name: &str) -> Result<String, BadName> {
        let own = self.to_string();
        let space = self.namespace.trim_end_matches('/');
        let name = name.replace("{node}", &self.node);
        let name = name.replace("{ns}", space).replace("{namespace}", space);
        let full = match name.strip_prefix('~') {
            Some(rest) if rest.is_empty() || rest.starts_with('/') => format!("{own}{rest}"),
            Some(_) => return Err(BadName { name, reason: "~ is followed by /" }),
            None if name.starts_with('/') => name,
            None => format!("{space}/{name}"),
        };
        check_absolute(&full)?;
        Ok(full)
    }
}

impl fmt::Display for Names {
    /// The node's whole name.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.namespace.trim_end_matches('/'), self.node)
    }
}

/// Refuses what is no absolute name.
///
/// # Errors
/// [`BadName`]
pub fn check_absolute(name: &str) -> Result<(), BadName> {
    name.split('/').skip(1).try_for_each(|token| check_token(token, name))
}

/// Letters, digits and single `_`, and no digit first.
fn check_token(token: &str, name: &str) -> Result<(), BadName> {
    let bad = |reason| Err(BadName { name: name.to_owned(), reason });
    match token.chars().next() {
        None => return bad("between two slashes, or at its end, there must be something"),
        Some(first) if first.is_ascii_digit() => return bad("no part of it begins with a digit"),
        _ => {}
    }
    if !token.chars().all(|c| c.is_ascii_alphanumeric() || c == '_') {
        return bad("letters, digits, _ and / alone are allowed");
    }
    if token.contains("__") {
        return bad("__ is not allowed");
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(rules: &[&str]) -> Names {
        let rules = rules
            .iter()
            .map(|rule| Rule::parse(rule).unwrap_or_else(|error| panic!("{error:?}")))
            .collect();
        Names::new("carom", "/", rules).unwrap_or_else(|error| panic!("{error:?}"))
    }

    #[test]
    fn expands_relative_private_and_absolute_names() {
        let plain = names(&[]);
        assert_eq!(
            plain.topic("contacts").unwrap_or_else(|error| panic!("{error:?}")),
            "/contacts"
        );
        assert_eq!(plain.topic("~/x").unwrap_or_else(|error| panic!("{error:?}")), "/carom/x");
        assert_eq!(plain.topic("/clock").unwrap_or_else(|error| panic!("{error:?}")), "/clock");
        let spaced = names(&["__ns:=/a/b", "__node:=c"]);
        assert_eq!(spaced.to_string(), "/a/b/c");
        assert_eq!(
            spaced.topic("contacts").unwrap_or_else(|error| panic!("{error:?}")),
            "/a/b/contacts"
        );
        assert_eq!(spaced.topic("~/x").unwrap_or_else(|error| panic!("{error:?}")), "/a/b/c/x");
        assert_eq!(
            spaced.topic("{node}/x").unwrap_or_else(|error| panic!("{error:?}")),
            "/a/b/c/x"
        );
        assert_eq!(spaced.topic("/clock").unwrap_or_else(|error| panic!("{error:?}")), "/clock");
    }

    #[test]
    fn the_first_rule_that_fits_renames() {
        let names = names(&["contacts:=hits", "/contacts:=never", "__ns:=/a", "/a/contacts:=no"]);
        assert_eq!(names.topic("contacts").unwrap_or_else(|error| panic!("{error:?}")), "/a/hits");
        assert_eq!(
            names.topic("/contacts").unwrap_or_else(|error| panic!("{error:?}")),
            "/a/never"
        );
        assert_eq!(
            names.topic("/a/contacts").unwrap_or_else(|error| panic!("{error:?}")),
            "/a/hits"
        );
    }

    #[test]
    fn rules_are_for_a_node_and_a_kind() {
        let names = names(&[
            "other:x:=y",
            "carom:x:=z",
            "rosservice://s:=t",
            "rostopic://u:=v",
            "other:__node:=w",
        ]);
        assert_eq!(names.node(), "carom");
        assert_eq!(names.topic("x").unwrap_or_else(|error| panic!("{error:?}")), "/z");
        assert_eq!(
            (
                names.topic("s").unwrap_or_else(|error| panic!("{error:?}")),
                names.service("s").unwrap_or_else(|error| panic!("{error:?}"))
            ),
            ("/s".into(), "/t".into())
        );
        assert_eq!(
            (
                names.topic("u").unwrap_or_else(|error| panic!("{error:?}")),
                names.service("u").unwrap_or_else(|error| panic!("{error:?}"))
            ),
            ("/v".into(), "/u".into())
        );
    }

    #[test]
    fn a_namespace_may_come_without_its_slash() {
        let node = |space| {
            Names::new("carom", space, vec![])
                .unwrap_or_else(|error| panic!("{error:?}"))
                .to_string()
        };
        assert_eq!(node("robot1"), "/robot1/carom");
        assert_eq!([node(""), node("/")], ["/carom", "/carom"]);
        assert!(Names::new("carom", "/a/", vec![]).is_err());
    }

    #[test]
    fn what_is_no_name_or_rule_is_refused() {
        let names = names(&[]);
        for name in ["", "a//b", "a/", "2a", "a b", "a__b", "~x", "ä", "{x}"] {
            assert!(names.topic(name).is_err(), "{name}");
        }
        for rule in ["a", ":=b", "a:=", "", "*:=b"] {
            assert!(Rule::parse(rule).is_err(), "{rule}");
        }
        for node in ["", "a/b", "1", "a-b"] {
            assert!(Names::new(node, "/", vec![]).is_err(), "{node}");
        }
    }
}
