//! The parameters: every setting of the node, declared once with its meaning and its range.
//!
//! A value may come from the command line, a parameter file, the scene or, while the node runs,
//! from a service. It is refused with the reason, or it takes effect: what cannot change while the
//! node runs is read-only. Nothing here knows a service or a topic.

pub mod declared;

pub mod services;

use std::borrow::Cow;
use std::collections::BTreeSet;

use ros2_client::ParameterValue;
use ros2_client::parameters::{NumericRange, ParameterDescriptor, ParameterType, raw};

use super::arguments::Override;
use crate::world::limits;

/// A parameter and what is known about it.
#[derive(Clone, Debug)]
pub struct Parameter {
    name: Cow<'static, str>,
    description: &'static str,
    constraints: &'static str,
    read_only: bool,
    range: Option<(f64, f64)>,
    value: ParameterValue,
}

impl Parameter {
    /// One that stays what it was at the start.
    pub fn new(
        name: impl Into<Cow<'static, str>>,
        value: ParameterValue,
        description: &'static str,
    ) -> Self {
        let (name, constraints, read_only, range) = (name.into(), "", true, None);
        Self { name, description, constraints, read_only, range, value }
    }

    /// It may change while the node runs.
    pub fn settable(mut self) -> Self {
        self.read_only = false;
        self
    }

    /// Numbers from `least` to `most`.
    pub fn within(mut self, least: f64, most: f64) -> Self {
        self.range = Some((least, most));
        self
    }

    /// What its type and range do not say.
    pub fn only(mut self, constraints: &'static str) -> Self {
        self.constraints = constraints;
        self
    }

    /// The value as this parameter would hold it, or why it does not.
    pub(super) fn take(&self, value: ParameterValue) -> Result<ParameterValue, String> {
        let value = match (&self.value, value) {
            // Whole numbers are numbers: `publish_rate_hz: 60`. An empty list is one of any kind.
            (ParameterValue::Double(_), ParameterValue::Integer(whole)) => {
                ParameterValue::Double(whole as f64)
            }
            (_, value) => value,
        };
        let (is, shall) = (value.to_parameter_type(), self.value.to_parameter_type());
        if is != shall {
            return Err(format!(
                "Wrong parameter type, parameter {{{}}} is of type {{{}}}, setting it to {{{}}} is \
                 not allowed.",
                self.name,
                type_name(shall),
                type_name(is)
            ));
        }
        match (&value, self.range) {
            (ParameterValue::Double(x), Some((least, most))) if !(least..=most).contains(x) => {
                let (x, name) = (limits::short(*x), &self.name);
                Err(format!("parameter '{name}': {x} is not {}", span(least, most)))
            }
            _ => Ok(value),
        }
    }

    fn descriptor(&self) -> raw::ParameterDescriptor {
        let range = match self.range {
            Some((from_value, to_value)) => {
                NumericRange::FloatingPointRange { from_value, to_value, step: 0.0 }
            }
            None => NumericRange::NotSpecified,
        };
        ParameterDescriptor {
            name: self.name.clone().into_owned(),
            param_type: self.value.to_parameter_type(),
            description: self.description.to_owned(),
            additional_constraints: self.constraints.to_owned(),
            read_only: self.read_only,
            dynamic_typing: false,
            range,
        }
        .into()
    }
}

/// A range in words.
fn span(least: f64, most: f64) -> String {
    let from = limits::short(least);
    if most == f64::MAX {
        return format!("{from} or more");
    }
    format!("in {from} to {}", limits::short(most))
}

/// As ROS calls them.
fn type_name(kind: ParameterType) -> &'static str {
    match kind {
        ParameterType::NotSet => "not set",
        ParameterType::Bool => "bool",
        ParameterType::Integer => "integer",
        ParameterType::Double => "double",
        ParameterType::String => "string",
        ParameterType::ByteArray => "byte_array",
        ParameterType::BoolArray => "bool_array",
        ParameterType::IntegerArray => "integer_array",
        ParameterType::DoubleArray => "double_array",
        ParameterType::StringArray => "string_array",
    }
}

/// All parameters, by name.
#[derive(Clone, Debug)]
pub struct Parameters {
    all: Vec<Parameter>,
}

/// Why a change is not allowed besides type, range and being read-only.
pub type Veto<'a> = &'a dyn Fn(&str, &ParameterValue) -> Result<(), String>;

impl Parameters {
    /// These, with the values that the command line gives to the node of this whole name.
    ///
    /// # Errors
    /// Which value is refused, and why.
    pub fn new(
        mut all: Vec<Parameter>,
        node: &str,
        overrides: &[Override],
    ) -> Result<Self, String> {
        all.sort_by(|a, b| a.name.cmp(&b.name));
        all.iter().try_for_each(|parameter| parameter.take(parameter.value.clone()).map(drop))?;
        for Override { name, value, .. } in overrides.iter().filter(|value| value.is_for(node)) {
            match all.iter_mut().find(|parameter| parameter.name == *name) {
                Some(parameter) => parameter.value = parameter.take(value.clone())?,
                // A file may speak of many nodes: this is no error anywhere in ROS.
                None => tracing::warn!("parameter `{name}` is not one of this node's"),
            }
        }
        Ok(Self { all })
    }

    /// The value of a parameter, or that it is not set.
    pub fn value(&self, name: &str) -> ParameterValue {
        self.find(name).map_or(ParameterValue::NotSet, |parameter| parameter.value.clone())
    }

    /// Type, meaning and range; of an unknown parameter the name alone.
    pub fn describe(&self, name: &str) -> raw::ParameterDescriptor {
        let unknown = || ParameterDescriptor {
            description: String::new(),
            read_only: false,
            ..ParameterDescriptor::unknown(name)
        };
        self.find(name).map_or_else(|| unknown().into(), Parameter::descriptor)
    }

    /// Names, and the prefixes that they share, below some prefixes; depth 0 = all of them.
    pub fn list(&self, prefixes: &[String], depth: u64) -> (Vec<String>, Vec<String>) {
        let deep = |rest: &str| depth == 0 || (rest.matches('.').count() as u64) < depth;
        let below = |name: &str, prefix: &str| match name.strip_prefix(prefix) {
            Some("") => true,
            Some(rest) => rest.strip_prefix('.').is_some_and(deep),
            None => false,
        };
        let wanted = |name: &&str| {
            let fits = || prefixes.iter().any(|prefix| below(name, prefix));
            if prefixes.is_empty() { deep(name) } else { fits() }
        };
        let names: Vec<&str> = self.all.iter().map(|each| &*each.name).filter(wanted).collect();
        let shared: BTreeSet<&str> =
            names.iter().filter_map(|name| Some(name.rsplit_once('.')?.0)).collect();
        let owned = |name: &str| name.to_owned();
        (names.into_iter().map(owned).collect(), shared.into_iter().map(owned).collect())
    }

    /// Sets all of them or none; what it was set to, in the same order.
    ///
    /// # Errors
    /// The reason, as `ros2 param set` shows it.
    pub fn set(
        &mut self,
        values: Vec<(String, ParameterValue)>,
        veto: Veto,
    ) -> Result<Vec<(String, ParameterValue)>, String> {
        let taken: Result<Vec<_>, String> = values
            .into_iter()
            .map(|(name, value)| {
                let parameter = self.find(&name).ok_or_else(|| {
                    format!("parameter '{name}' cannot be set because it was not declared")
                })?;
                if parameter.read_only {
                    let why = format!("parameter '{name}' cannot be set because it is read-only");
                    return Err(why);
                }
                let value = parameter.take(value)?;
                veto(&name, &value)?;
                Ok((name, value))
            })
            .collect();
        let taken = taken?;
        for (name, value) in &taken {
            self.put(name, value.clone());
        }
        Ok(taken)
    }

    /// All of them as an event tells them.
    pub fn all(&self) -> impl Iterator<Item = (String, ParameterValue)> {
        self.all.iter().map(|each| (each.name.clone().into_owned(), each.value.clone()))
    }

    /// A value that the node itself gives.
    pub fn put(&mut self, name: &str, value: ParameterValue) {
        self.all.iter_mut().filter(|each| each.name == name).for_each(|each| {
            each.value = value.clone();
        });
    }

    fn find(&self, name: &str) -> Option<&Parameter> {
        self.all.iter().find(|parameter| parameter.name == name)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NONE: Veto<'static> = &|_, _| Ok(());

    fn parameters(overrides: &[(&str, ParameterValue)]) -> Result<Parameters, String> {
        let all = vec![
            Parameter::new("rate", ParameterValue::Double(1.0), "r").settable().within(0.0, 9.0),
            Parameter::new("scene", ParameterValue::String("arena".to_owned()), "s"),
            Parameter::new("a.b", ParameterValue::Boolean(false), "b").settable(),
            Parameter::new("a.b.c", ParameterValue::Boolean(false), "c").settable(),
        ];
        let overrides: Vec<Override> = overrides
            .iter()
            .map(|(name, value)| Override {
                node: "/**".to_owned(),
                name: (*name).to_owned(),
                value: value.clone(),
            })
            .collect();
        Parameters::new(all, "/carom", &overrides)
    }

    fn set(parameters: &mut Parameters, name: &str, value: ParameterValue) -> Result<(), String> {
        parameters.set(vec![(name.to_owned(), value)], NONE).map(drop)
    }

    #[test]
    fn a_value_is_taken_or_refused_with_the_reason() {
        let mut all = parameters(&[]).unwrap_or_else(|error| panic!("{error:?}"));
        assert_eq!(set(&mut all, "rate", ParameterValue::Integer(2)), Ok(()));
        assert_eq!(all.value("rate"), ParameterValue::Double(2.0));
        let cases = [
            ("rate", ParameterValue::Double(10.0), "not in 0 to 9"),
            ("rate", ParameterValue::Double(f64::NAN), "not in 0 to 9"),
            ("rate", ParameterValue::String("2".to_owned()), "of type {double}"),
            ("rate", ParameterValue::NotSet, "{not set}"),
            ("scene", ParameterValue::String("teams".to_owned()), "read-only"),
            ("speed", ParameterValue::Double(1.0), "not declared"),
        ];
        for (name, value, reason) in cases {
            let error = set(&mut all, name, value).err().unwrap_or_default();
            assert!(error.contains(reason), "{error}");
        }
        assert_eq!(all.value("rate"), ParameterValue::Double(2.0));
    }

    #[test]
    fn many_are_set_together_or_not_at_all() {
        let mut all = parameters(&[]).unwrap_or_else(|error| panic!("{error:?}"));
        let good = ("rate".to_owned(), ParameterValue::Double(3.0));
        let bad = ("scene".to_owned(), ParameterValue::NotSet);
        assert!(all.set(vec![good.clone(), bad], NONE).is_err());
        assert_eq!(all.value("rate"), ParameterValue::Double(1.0));
        assert!(all.set(vec![good.clone()], &|_, _| Err("no".to_owned())).is_err());
        assert_eq!(all.set(vec![good.clone()], NONE), Ok(vec![good]));
    }

    #[test]
    fn the_command_line_wins_and_is_checked() {
        let scene = ParameterValue::String("teams".to_owned());
        let all = parameters(&[("scene", scene.clone()), ("unknown", scene.clone())])
            .unwrap_or_else(|error| panic!("{error:?}"));
        assert_eq!(all.value("scene"), scene);
        assert!(parameters(&[("rate", scene)]).is_err());
    }

    #[test]
    fn lists_know_prefixes_and_depth() {
        let all = parameters(&[]).unwrap_or_else(|error| panic!("{error:?}"));
        let list = |prefixes: &[&str], depth| {
            let prefixes: Vec<String> = prefixes.iter().map(|p| (*p).to_owned()).collect();
            all.list(&prefixes, depth)
        };
        assert_eq!(list(&[], 0).0, ["a.b", "a.b.c", "rate", "scene"]);
        assert_eq!(list(&[], 0).1, ["a", "a.b"]);
        assert_eq!(list(&[], 1).0, ["rate", "scene"]);
        assert_eq!(list(&["a"], 1).0, ["a.b"]);
        assert_eq!(list(&["a"], 0).0, ["a.b", "a.b.c"]);
        assert_eq!(list(&["rate"], 0).0, ["rate"]);
        assert!(list(&["rat"], 0).0.is_empty());
    }

    #[test]
    fn descriptions_have_type_range_and_whether_it_changes() {
        let all = parameters(&[]).unwrap_or_else(|error| panic!("{error:?}"));
        let rate = all.describe("rate");
        assert_eq!((rate.r#type, rate.read_only), (3, false));
        assert_eq!(rate.floating_point_range[0].to_value, 9.0);
        assert!(all.describe("scene").read_only);
        assert_eq!(all.describe("speed").r#type, 0);
    }
}
