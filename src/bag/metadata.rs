//! The file `metadata.yaml` of a bag: which files belong to it, and what they should hold.
//!
//! Of other versions, what this one knows is read and the rest ignored.

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
