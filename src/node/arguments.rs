//! `--ros-args`: what ROS tools say to a node on its command line, and in parameter files.
//!
//! Renaming rules, parameter values and the level of the log, as
//! <https://design.ros2.org/articles/ros_command_line_arguments.html> has them. An unknown argument
//! is refused; those about logs that carom does not write are taken and do nothing. Only files that
//! `--params-file` names are read.

use std::fs::File;
use std::io::Read;

use ros2_client::ParameterValue;
use serde_json::Value;

use super::names::Rule;

/// Largest parameter file, bytes.
const FILE_BYTES: u64 = 1 << 20;
/// Deepest nesting of namespaces and parameters in a file.
const DEPTH_MAX: usize = 32;

/// All of it, in the order in which it came.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RosArguments {
    /// What is called otherwise.
    pub rules: Vec<Rule>,
    /// Parameters; the last one that fits wins.
    pub values: Vec<Override>,
    /// A filter as `RUST_LOG` has them; nothing = the usual.
    pub log_level: Option<&'static str>,
}

/// A value for a parameter of the nodes that fit.
#[derive(Clone, Debug, PartialEq)]
pub struct Override {
    /// Whole name of a node; `*` stands for a part of it, `/**` for any number of them.
    pub node: String,
    /// The parameter.
    pub name: String,
    /// Its value.
    pub value: ParameterValue,
}

impl Override {
    /// Whether it is for the node of this whole name.
    pub fn is_for(&self, node: &str) -> bool {
        let pattern: Vec<&str> = self.node.trim_start_matches('/').split('/').collect();
        let parts: Vec<&str> = node.trim_start_matches('/').split('/').collect();
        fits(&pattern, &parts)
    }
}

fn fits(pattern: &[&str], parts: &[&str]) -> bool {
    match (pattern.split_first(), parts.split_first()) {
        (None, None) => true,
        (Some((&"**", rest)), _) => (0..=parts.len()).any(|skip| fits(rest, &parts[skip..])),
        (Some((first, rest)), Some((part, parts))) => {
            (*first == "*" || first == part) && fits(rest, parts)
        }
        _ => false,
    }
}

/// Takes the arguments between each `--ros-args` and the next `--`, or the end, out of the others.
///
/// # Errors
/// What was wrong, and what would be right.
pub fn split(arguments: Vec<String>) -> Result<(Vec<String>, Option<RosArguments>), String> {
    let (mut others, mut ros) = (Vec::new(), None);
    let mut arguments = arguments.into_iter();
    while let Some(argument) = arguments.next() {
        if argument != "--ros-args" {
            others.push(argument);
            continue;
        }
        let ros = ros.get_or_insert_default();
        while let Some(argument) = arguments.next().filter(|argument| argument != "--") {
            take(ros, &argument, &mut arguments).map_err(|error| format!("--ros-args: {error}"))?;
        }
    }
    Ok((others, ros))
}

fn take(
    ros: &mut RosArguments,
    argument: &str,
    rest: &mut impl Iterator<Item = String>,
) -> Result<(), String> {
    let mut value = || rest.next().ok_or_else(|| format!("{argument} needs a value"));
    match argument {
        "-r" | "--remap" => ros.rules.push(Rule::parse(&value()?)?),
        "-p" | "--param" => ros.values.push(parameter(&value()?)?),
        "--params-file" => ros.values.extend(file(&value()?)?),
        "--log-level" => ros.log_level = Some(level(&value()?)?),
        // carom takes no part in security, and its log has one form.
        "-e" | "--enclave" | "--log-config-file" | "--log-file-name" => drop(value()?),
        _ if is_about_logs(argument) => {}
        _ => {
            return Err(format!(
                "unknown argument `{argument}`; -r FROM:=TO, -p NAME:=VALUE, --params-file FILE, \
                 --log-level LEVEL"
            ));
        }
    }
    Ok(())
}

fn is_about_logs(argument: &str) -> bool {
    let rest = argument.strip_prefix("--enable-").or(argument.strip_prefix("--disable-"));
    matches!(rest, Some("rosout-logs" | "stdout-logs" | "external-lib-logs"))
}

/// `[logger:=]level`: carom has one logger.
fn level(text: &str) -> Result<&'static str, String> {
    let level = text.rsplit_once(":=").map_or(text, |(_, level)| level);
    match level.to_ascii_lowercase().as_str() {
        "debug" => Ok("debug"),
        "info" => Ok("info"),
        "warn" => Ok("warn"),
        "error" | "fatal" => Ok("error"),
        _ => Err(format!("--log-level {text}: debug, info, warn, error or fatal")),
    }
}

/// `[node:]name:=value`
fn parameter(text: &str) -> Result<Override, String> {
    let wanted = || format!("`{text}` is not a parameter: [node:]name:=value");
    let (name, value) = text.split_once(":=").ok_or_else(wanted)?;
    let (node, name) = name.split_once(':').unwrap_or(("/**", name));
    if node.is_empty() || name.is_empty() {
        return Err(wanted());
    }
    // As YAML has it; what is none is text.
    let value = serde_saphyr::from_str(value).unwrap_or_else(|_| Value::String(value.to_owned()));
    let value =
        value_of(&value).ok_or_else(|| format!("`{text}`: neither one value nor a list"))?;
    Ok(Override { node: node.to_owned(), name: name.to_owned(), value })
}

fn file(path: &str) -> Result<Vec<Override>, String> {
    let error = |what: String| format!("--params-file {path}: {what}");
    let mut text = String::new();
    let file = File::open(path).map_err(|cause| error(cause.to_string()))?;
    file.take(FILE_BYTES + 1).read_to_string(&mut text).map_err(|e| error(e.to_string()))?;
    if text.len() as u64 > FILE_BYTES {
        return Err(error(format!("larger than {FILE_BYTES} bytes")));
    }
    values_of_file(&text).map_err(error)
}

/// Namespaces and nodes down to `ros__parameters`, and parameters below it.
fn values_of_file(text: &str) -> Result<Vec<Override>, String> {
    let root: Value = serde_saphyr::from_str(text)
        .map_err(|error| error.without_snippet().to_string().replace('\n', " "))?;
    let mut values = Vec::new();
    nodes("", &root, 0, &mut values)?;
    Ok(values)
}

fn nodes(node: &str, below: &Value, depth: usize, to: &mut Vec<Override>) -> Result<(), String> {
    let Value::Object(entries) = below else {
        let place = if node.is_empty() { "the file" } else { node };
        return Err(format!("{place}: must hold `ros__parameters`, or nodes that do"));
    };
    if depth > DEPTH_MAX {
        return Err(format!("nested deeper than {DEPTH_MAX}"));
    }
    for (key, value) in entries {
        if key == "ros__parameters" {
            if node.is_empty() {
                return Err("`ros__parameters` stands under the name of a node".to_owned());
            }
            parameters(node, "", value, depth, to)?;
        } else {
            nodes(&format!("{node}/{}", key.trim_matches('/')), value, depth + 1, to)?;
        }
    }
    Ok(())
}

fn parameters(
    node: &str,
    prefix: &str,
    below: &Value,
    depth: usize,
    to: &mut Vec<Override>,
) -> Result<(), String> {
    if let Value::Object(entries) = below {
        if depth > DEPTH_MAX {
            return Err(format!("nested deeper than {DEPTH_MAX}"));
        }
        let dot = if prefix.is_empty() { "" } else { "." };
        return entries.iter().try_for_each(|(key, value)| {
            parameters(node, &format!("{prefix}{dot}{key}"), value, depth + 1, to)
        });
    }
    if prefix.is_empty() {
        return Err(format!("{node}: `ros__parameters` holds names and values"));
    }
    let wrong = || format!("{node}: `{prefix}` must be one value, or a list of values of one kind");
    let value = value_of(below).ok_or_else(wrong)?;
    to.push(Override { node: node.to_owned(), name: prefix.to_owned(), value });
    Ok(())
}

/// The parameter that a YAML value stands for.
fn value_of(value: &Value) -> Option<ParameterValue> {
    Some(match value {
        Value::Bool(value) => ParameterValue::Boolean(*value),
        Value::String(text) => ParameterValue::String(text.clone()),
        Value::Number(number) => match number.as_i64() {
            Some(value) => ParameterValue::Integer(value),
            None => ParameterValue::Double(number.as_f64()?),
        },
        Value::Array(values) => list(values)?,
        Value::Null | Value::Object(_) => return None,
    })
}

fn list(values: &[Value]) -> Option<ParameterValue> {
    let all_strings = || values.iter().map(|v| v.as_str().map(str::to_owned)).collect();
    let texts: Option<Vec<String>> = all_strings();
    if let Some(texts) = texts {
        return Some(ParameterValue::StringArray(texts));
    }
    if let Some(values) = values.iter().map(Value::as_bool).collect() {
        return Some(ParameterValue::BooleanArray(values));
    }
    if let Some(values) = values.iter().map(Value::as_i64).collect() {
        return Some(ParameterValue::IntegerArray(values));
    }
    values.iter().map(Value::as_f64).collect::<Option<_>>().map(ParameterValue::DoubleArray)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ros(arguments: &[&str]) -> Result<RosArguments, String> {
        let arguments = ["carom", "--ros-args"].iter().chain(arguments).map(|a| (*a).to_owned());
        split(arguments.collect()).map(|(_, ros)| ros.unwrap_or_default())
    }

    #[test]
    fn takes_out_what_is_meant_for_ros() {
        let text = "run a --ros-args -r x:=y -p p:=1 -- --rate 2 --ros-args --log-level DEBUG";
        let arguments = text.split(' ').map(str::to_owned).collect();
        let (others, ros) = split(arguments).unwrap_or_else(|error| panic!("{error:?}"));
        assert_eq!(others, ["run", "a", "--rate", "2"]);
        let ros = ros.unwrap_or_default();
        assert_eq!((ros.rules.len(), ros.values.len(), ros.log_level), (1, 1, Some("debug")));
        assert_eq!(
            split(vec!["run".to_owned()]).unwrap_or_else(|error| panic!("{error:?}")),
            (vec!["run".to_owned()], None)
        );
    }

    #[test]
    fn values_have_the_types_of_yaml() {
        let value = |text: &str| ros(&["-p", text]).map(|ros| ros.values[0].value.clone());
        assert_eq!(value("p:=1"), Ok(ParameterValue::Integer(1)));
        assert_eq!(value("p:=1.0"), Ok(ParameterValue::Double(1.0)));
        assert_eq!(value("p:=true"), Ok(ParameterValue::Boolean(true)));
        assert_eq!(value("p:=map"), Ok(ParameterValue::String("map".to_owned())));
        assert_eq!(value("p:='1'"), Ok(ParameterValue::String("1".to_owned())));
        let list = ParameterValue::StringArray(vec!["a".to_owned(), "b".to_owned()]);
        assert_eq!(value("p:=[a, b]"), Ok(list));
        assert_eq!(value("p:=[1, 2.5]"), Ok(ParameterValue::DoubleArray(vec![1.0, 2.5])));
        assert!(value("p:=").is_err());
        assert!(value("p:={a: 1}").is_err());
    }

    #[test]
    fn files_name_nodes_namespaces_and_wildcards() {
        let text = "/**:\n  ros__parameters: {a: 1, b: {c: x}}\nrobot:\n  carom:\n    \
                    ros__parameters:\n      a: 2\n/other:\n  ros__parameters: {a: 3}\n";
        let values = values_of_file(text).unwrap_or_else(|error| panic!("{error:?}"));
        let of = |node: &str| -> Vec<String> {
            let fitting = values.iter().filter(|value| value.is_for(node));
            fitting.map(|value| format!("{}={:?}", value.name, value.value)).collect()
        };
        assert_eq!(of("/carom"), ["a=Integer(1)", "b.c=String(\"x\")"]);
        assert_eq!(of("/robot/carom").last().map_or("", String::as_str), "a=Integer(2)");
        assert_eq!(of("/other").last().map_or("", String::as_str), "a=Integer(3)");
    }

    #[test]
    fn wildcards_stand_for_parts_of_a_name() {
        let is_for = |pattern: &str, node: &str| {
            let value = ParameterValue::NotSet;
            Override { node: pattern.to_owned(), name: "p".to_owned(), value }.is_for(node)
        };
        for pattern in ["/**", "/a/*", "/a/b", "a/b", "/**/b", "/*/b", "/a/**"] {
            assert!(is_for(pattern, "/a/b"), "{pattern}");
        }
        for pattern in ["/*", "b", "/a/b/c", "/a/*/b", "/a"] {
            assert!(!is_for(pattern, "/a/b"), "{pattern}");
        }
    }

    #[test]
    fn what_is_wrong_is_refused_in_one_line() {
        for arguments in [
            &["--frobnicate"][..],
            &["-r"],
            &["-r", "x"],
            &["-p", "x"],
            &["-p", ":=1"],
            &["--log-level", "loud"],
            &["--params-file", "/does/not/exist"],
        ] {
            let error = ros(arguments).err().unwrap_or_default();
            assert!(error.starts_with("--ros-args: ") && !error.contains('\n'), "{error}");
        }
        for file in ["", "- a", "ros__parameters: {a: 1}", "carom: {ros__parameters: 3}", "a: [1"] {
            assert!(values_of_file(file).is_err(), "{file}");
        }
        let deep = "{a: ".repeat(200) + "1" + &"}".repeat(200);
        assert!(values_of_file(&deep).is_err());
    }
}
