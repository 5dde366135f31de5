//! What types are made of: definitions as a bag carries them, and the hashes by which ROS tells
//! whether two of a name are the same.
//!
//! The hash is RIHS01 (REP-2016): SHA-256 over the fields of a type and of all types in it, in one
//! fixed spelling of JSON. Tests compare every one with those of other implementations.

use std::collections::BTreeMap;
use std::fmt::Write;

use sha2::{Digest, Sha256};

use super::standard::STANDARD;

macro_rules! own {
    ($($name:literal)*) => {
        /// Name and .msg file of carom's own types.
        const OWN: &[(&str, &str)] = &[
            $((concat!("carom/msg/", $name), include_str!(concat!("../../msg/", $name, ".msg"))),)*
        ];
    };
}

own! {
    "CircleState" "CircleStates" "CircleVelocities" "CircleVelocity" "Contact" "Contacts"
    "Crash" "Crashes" "ErrorReport"
}

/// Type ids of RIHS01 by their names in a .msg file.
const PRIMITIVES: [(&str, u8); 15] = [
    ("int8", 2),
    ("uint8", 3),
    ("char", 3),
    ("int16", 4),
    ("uint16", 5),
    ("int32", 6),
    ("uint32", 7),
    ("int64", 8),
    ("uint64", 9),
    ("float32", 10),
    ("float64", 11),
    ("bool", 15),
    ("byte", 16),
    ("string", 17),
    ("wstring", 18),
];
/// The id of a type that has fields of its own; what is added for arrays.
const NESTED: u8 = 1;
const ARRAY: u8 = 48;
const BOUNDED_SEQUENCE: u8 = 96;
const SEQUENCE: u8 = 144;

/// Names of all types that are known, such as `carom/msg/Contacts`.
pub fn kinds() -> impl Iterator<Item = &'static str> {
    OWN.iter().chain(STANDARD).map(|(name, _)| *name)
}

/// The definition of a type as `ros2msg`: it, and every type in it.
pub fn definition(kind: &str) -> Option<String> {
    let mut text = text(kind)?.trim_end().to_owned();
    text.push('\n');
    for inner in inner_kinds(kind) {
        let short = inner.replacen("/msg/", "/", 1);
        let line = "=".repeat(80);
        // Writing to a text cannot fail.
        let _ = write!(text, "{line}\nMSG: {short}\n{}\n", self::text(&inner)?.trim_end());
    }
    Some(text)
}

/// The hash of a type, `RIHS01_` and 64 digits.
pub fn hash(kind: &str) -> Option<String> {
    let mut inner = inner_kinds(kind);
    inner.sort();
    let inner: Option<Vec<String>> = inner.iter().map(|inner| described(inner)).collect();
    let json = format!(
        "{{\"type_description\": {}, \"referenced_type_descriptions\": [{}]}}",
        described(kind)?,
        inner?.join(", ")
    );
    let digest = Sha256::digest(json.as_bytes());
    let mut hash = "RIHS01_".to_owned();
    for byte in digest {
        // Writing to a text cannot fail.
        let _ = write!(hash, "{byte:02x}");
    }
    Some(hash)
}

fn text(kind: &str) -> Option<&'static str> {
    OWN.iter().chain(STANDARD).find(|(name, _)| *name == kind).map(|(_, text)| *text)
}

/// All types in a type, each once, as they come.
fn inner_kinds(kind: &str) -> Vec<String> {
    let mut found: Vec<String> = Vec::new();
    let mut waiting = vec![kind.to_owned()];
    while let Some(next) = waiting.pop() {
        let begin = found.len();
        for inner in fields(&next).into_iter().filter_map(|field| field.nested) {
            if !found.contains(&inner) {
                found.push(inner);
            }
        }
        waiting.extend(found[begin..].iter().rev().cloned());
    }
    found
}

fn described(kind: &str) -> Option<String> {
    text(kind)?;
    let fields: Vec<String> = fields(kind)
        .iter()
        .map(|field| {
            format!(
                "{{\"name\": \"{}\", \"type\": {{\"type_id\": {}, \"capacity\": {}, \
                 \"string_capacity\": {}, \"nested_type_name\": \"{}\"}}}}",
                field.name,
                field.type_id,
                field.capacity,
                field.string_capacity,
                field.nested.as_deref().unwrap_or_default()
            )
        })
        .collect();
    Some(format!("{{\"type_name\": \"{kind}\", \"fields\": [{}]}}", fields.join(", ")))
}

/// A field as the hash has it.
struct Field {
    name: String,
    type_id: u8,
    capacity: u64,
    string_capacity: u64,
    nested: Option<String>,
}

fn fields(kind: &str) -> Vec<Field> {
    let package = kind.split('/').next().unwrap_or_default();
    let lines = text(kind).unwrap_or_default().lines();
    lines.filter_map(|line| field(line.split('#').next().unwrap_or_default(), package)).collect()
}

/// Nothing of an empty line or a constant.
fn field(line: &str, package: &str) -> Option<Field> {
    let mut words = line.split_whitespace();
    let (whole, name) = (words.next()?, words.next()?);
    if name.contains('=') || words.next().is_some_and(|word| word.starts_with('=')) {
        return None;
    }
    let (element, array) = match whole.split_once('[') {
        Some((element, size)) => (element, Some(size.trim_end_matches(']'))),
        None => (whole, None),
    };
    let (base, string_capacity) = match element.split_once("<=") {
        Some((base, capacity)) => (base, capacity.parse().unwrap_or(0)),
        None => (element, 0),
    };
    let (offset, capacity) = match array {
        None => (0, 0),
        Some("") => (SEQUENCE, 0),
        Some(size) => match size.strip_prefix("<=") {
            Some(most) => (BOUNDED_SEQUENCE, most.parse().unwrap_or(0)),
            None => (ARRAY, size.parse().unwrap_or(0)),
        },
    };
    let primitives: BTreeMap<&str, u8> = PRIMITIVES.into_iter().collect();
    let nested = (!primitives.contains_key(base)).then(|| match base.split_once('/') {
        Some((package, base)) => format!("{package}/msg/{base}"),
        None => format!("{package}/msg/{base}"),
    });
    let type_id = primitives.get(base).copied().unwrap_or(NESTED) + offset;
    Some(Field { name: name.to_owned(), type_id, capacity, string_capacity, nested })
}
