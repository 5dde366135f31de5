//! The file `metadata.yaml` of a bag: which files belong to it, and what they hold.
//!
//! Version 9 is written. Of other versions, what this one knows is read and the rest ignored.

use std::fmt::Write;

use serde::Deserialize;

/// Names of the keys that rosbag2 writes.
#[derive(Debug, Deserialize)]
struct Document {
    rosbag2_bagfile_information: Metadata,
}

/// What is read of it.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub struct Metadata {
    /// Names of its files, relative to the folder.
    pub relative_file_paths: Vec<String>,
    /// Messages in all of them.
    pub message_count: Option<u64>,
    /// Topics with their counts.
    pub topics_with_message_count: Vec<TopicCount>,
    /// `zstd`, or nothing.
    pub compression_format: String,
    /// `file`, `message`, or nothing.
    pub compression_mode: String,
}

/// How many messages a topic has.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub struct TopicCount {
    /// The topic.
    pub topic_metadata: TopicMetadata,
    /// Its messages.
    pub message_count: u64,
}

/// What a topic is.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub struct TopicMetadata {
    /// Its name.
    pub name: String,
    /// Its type.
    pub r#type: String,
}

/// Reads it.
///
/// # Errors
/// What is wrong with it, with line and column.
pub fn parse(text: &str) -> Result<Metadata, String> {
    let document: Result<Document, _> = serde_saphyr::from_str(text);
    document.map(|document| document.rosbag2_bagfile_information).map_err(|error| {
        let text = error.to_string();
        text.lines().next().unwrap_or_default().to_owned()
    })
}

/// A file of a bag that was written.
#[derive(Clone, Debug)]
pub struct Part {
    /// Its name.
    pub name: String,
    /// Messages in it.
    pub count: u64,
    /// The earliest, ns since 1970.
    pub first_ns: u64,
    last_ns: u64,
}

impl Part {
    /// Without messages.
    pub fn new(name: String) -> Self {
        Self { name, count: 0, first_ns: u64::MAX, last_ns: 0 }
    }

    /// One more message.
    pub fn note(&mut self, time_ns: u64) {
        self.count += 1;
        self.first_ns = self.first_ns.min(time_ns);
        self.last_ns = self.last_ns.max(time_ns);
    }

    /// Beginning and length; of a file without messages as rosbag2 has it.
    fn span(&self) -> (u64, u64) {
        if self.count == 0 {
            return (i64::MAX.unsigned_abs(), 0);
        }
        (self.first_ns, self.last_ns - self.first_ns)
    }
}

/// A topic of a bag that was written.
pub struct TopicLine<'a> {
    /// Its name.
    pub name: &'a str,
    /// Its type.
    pub kind: &'a str,
    /// The hash of the type.
    pub hash: &'a str,
    /// Its profiles, a list in YAML.
    pub qos: &'a str,
    /// Its messages.
    pub count: u64,
}

/// The text of the file.
pub fn text(parts: &[Part], topics: &[TopicLine]) -> String {
    let mut whole = Part::new(String::new());
    for part in parts.iter().filter(|part| part.count > 0) {
        whole.first_ns = whole.first_ns.min(part.first_ns);
        whole.last_ns = whole.last_ns.max(part.last_ns);
        whole.count += part.count;
    }
    let mut text = String::from("rosbag2_bagfile_information:\n  version: 9\n");
    let mut put = |line: std::fmt::Arguments| {
        // Writing to a text cannot fail.
        let _ = writeln!(text, "{line}");
    };
    let (start, length) = whole.span();
    put(format_args!("  storage_identifier: mcap"));
    put(format_args!("  duration:\n    nanoseconds: {length}"));
    put(format_args!("  starting_time:\n    nanoseconds_since_epoch: {start}"));
    put(format_args!("  message_count: {}", whole.count));
    put(format_args!("  topics_with_message_count:{}", or_none(topics)));
    for TopicLine { name, kind, hash, qos, count } in topics {
        put(format_args!("    - topic_metadata:\n        name: {name}\n        type: {kind}"));
        put(format_args!("        serialization_format: cdr"));
        put(format_args!(
            "        offered_qos_profiles:{}",
            if qos.is_empty() { " []" } else { "" }
        ));
        qos.lines().for_each(|line| put(format_args!("          {line}")));
        put(format_args!("        type_description_hash: {hash}"));
        put(format_args!("      message_count: {count}"));
    }
    put(format_args!("  compression_format: \"\"\n  compression_mode: \"\""));
    put(format_args!("  relative_file_paths:"));
    parts.iter().for_each(|part| put(format_args!("    - {:?}", part.name)));
    put(format_args!("  files:"));
    for part in parts {
        let (start, length) = part.span();
        put(format_args!("    - path: {:?}", part.name));
        put(format_args!("      starting_time:\n        nanoseconds_since_epoch: {start}"));
        put(format_args!("      duration:\n        nanoseconds: {length}"));
        put(format_args!("      message_count: {}", part.count));
    }
    put(format_args!("  custom_data: ~\n  ros_distro: unknown"));
    text
}

fn or_none<T>(list: &[T]) -> &'static str {
    if list.is_empty() { " []" } else { "" }
}
