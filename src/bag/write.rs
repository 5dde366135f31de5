//! Writes a bag: a folder of MCAP files, and `metadata.yaml` when it is closed.
//!
//! A chunk is written whole, so that whoever is killed leaves a file that can be read up to the
//! last one; what the recorder noted stands at the beginning of every file. The same calls give the
//! same bytes: nothing here reads a clock.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use mcap::records::{MessageHeader, Metadata};
use mcap::write::NoSeek;
use mcap::{Compression, McapError, WriteOptions};

use super::definitions;
use super::files::{self, Output};
use super::metadata::{self, Part, TopicLine};
use super::read::Note;

/// A chunk is written when it has so many bytes: they stay in the nearest caches till then.
const CHUNK_BYTES: u64 = 256 << 10;
/// What a record of a message has besides the payload, bytes.
const MESSAGE_HEAD_BYTES: u64 = 31;

/// How to write.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Options {
    /// Whether chunks are packed with zstd.
    pub packed: bool,
    /// A new file after so many bytes.
    pub split_bytes: Option<u64>,
    /// A new file after so many nanoseconds.
    pub split_ns: Option<u64>,
}

/// Why a bag cannot be written.
#[derive(Debug, thiserror::Error)]
pub enum WriteError {
    /// Nothing is ever overwritten.
    #[error("{}: is there already; name a folder that is not", .0.display())]
    Exists(PathBuf),
    /// The operating system does not let the folder be made.
    #[error("{}: cannot be made: {error}", .path.display())]
    Folder {
        /// The folder.
        path: PathBuf,
        /// Why.
        error: std::io::Error,
    },
    /// The operating system does not let it be written.
    #[error("{}: cannot be written: {error}", .path.display())]
    Output {
        /// The file or folder.
        path: PathBuf,
        /// Why.
        error: std::io::Error,
    },
    /// Nobody knows what the type is made of.
    #[error("topic {topic}: the type {kind} is not known here")]
    UnknownType {
        /// The topic.
        topic: String,
        /// Its type.
        kind: String,
    },
}

/// A bag that is being written.
pub struct BagWriter {
    folder: PathBuf,
    name: String,
    options: Options,
    notes: Vec<Note>,
    topics: Vec<Channel>,
    parts: Vec<Part>,
    file: Option<mcap::Writer<NoSeek<Output>>>,
    /// In this file.
    bytes: u64,
}

/// A topic, and the channel that it has in this file.
struct Channel {
    name: String,
    kind: String,
    definition: String,
    hash: String,
    qos: String,
    id: u16,
    count: u64,
}

/// What was written.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Summary {
    /// Messages.
    pub messages: u64,
    /// Files.
    pub files: usize,
}

impl BagWriter {
    /// Makes the folder, and its first file with what is to be noted.
    ///
    /// # Errors
    /// [`WriteError::Exists`], [`WriteError::Folder`], [`WriteError::Output`].
    pub fn create(folder: &Path, options: Options, notes: Vec<Note>) -> Result<Self, WriteError> {
        files::create_folder(folder).map_err(|error| match error.kind() {
            std::io::ErrorKind::AlreadyExists => WriteError::Exists(folder.to_owned()),
            _ => WriteError::Folder { path: folder.to_owned(), error },
        })?;
        let name = folder.file_name().map(|name| name.to_string_lossy().into_owned());
        let mut bag = Self {
            folder: folder.to_owned(),
            name: name.unwrap_or_else(|| "bag".to_owned()),
            options,
            notes,
            topics: Vec::new(),
            parts: Vec::new(),
            file: None,
            bytes: 0,
        };
        bag.begin_file()?;
        Ok(bag)
    }

    /// One more topic, or the one that has this name and type; its number.
    ///
    /// # Errors
    /// [`WriteError::UnknownType`], [`WriteError::Output`].
    pub fn topic(&mut self, name: &str, kind: &str, qos: &str) -> Result<usize, WriteError> {
        let (Some(definition), Some(hash)) =
            (definitions::definition(kind), definitions::hash(kind))
        else {
            let (topic, kind) = (name.to_owned(), kind.to_owned());
            return Err(WriteError::UnknownType { topic, kind });
        };
        let same = |known: &Channel| (known.name.as_str(), known.kind.as_str()) == (name, kind);
        if let Some(known) = self.topics.iter().position(same) {
            return Ok(known);
        }
        let (name, kind, qos) = (name.to_owned(), kind.to_owned(), qos.trim_end().to_owned());
        let mut channel = Channel { name, kind, definition, hash, qos, id: 0, count: 0 };
        self.with_file(|file| channel.enter(file))?;
        self.topics.push(channel);
        Ok(self.topics.len() - 1)
    }

    /// One more message of a topic, with its encapsulation.
    ///
    /// # Errors
    /// [`WriteError::Output`].
    pub fn write(
        &mut self,
        topic: usize,
        log_time_ns: u64,
        publish_time_ns: u64,
        payload: &[u8],
    ) -> Result<(), WriteError> {
        let size = payload.len() as u64 + MESSAGE_HEAD_BYTES;
        if self.is_full(log_time_ns, size) {
            self.end_file()?;
            self.begin_file()?;
        }
        let channel = &mut self.topics[topic];
        channel.count += 1;
        let header = MessageHeader {
            channel_id: channel.id,
            sequence: u32::try_from(channel.count & u64::from(u32::MAX)).unwrap_or(0),
            log_time: log_time_ns,
            publish_time: publish_time_ns,
        };
        self.bytes += size;
        if let Some(part) = self.parts.last_mut() {
            part.note(log_time_ns);
        }
        self.with_file(|file| file.write_to_known_channel(&header, payload))
    }

    /// Writes the chunk that has been begun: what was written so far survives.
    ///
    /// # Errors
    /// [`WriteError::Output`].
    pub fn flush(&mut self) -> Result<(), WriteError> {
        self.with_file(mcap::Writer::flush)
    }

    /// Closes it.
    ///
    /// # Errors
    /// [`WriteError::Output`].
    pub fn finish(mut self) -> Result<Summary, WriteError> {
        self.end_file()?;
        let topics: Vec<TopicLine> = self.topics.iter().map(Channel::line).collect();
        let text = metadata::text(&self.parts, &topics);
        let path = self.folder.join("metadata.yaml");
        files::write(&path, &text).map_err(|error| WriteError::Output { path, error })?;
        let messages = self.topics.iter().map(|topic| topic.count).sum();
        Ok(Summary { messages, files: self.parts.len() })
    }

    fn is_full(&self, log_time_ns: u64, size: u64) -> bool {
        let Some(part) = self.parts.last().filter(|part| part.count > 0) else { return false };
        let long = |most: u64| log_time_ns.saturating_sub(part.first_ns) >= most;
        self.options.split_bytes.is_some_and(|most| self.bytes + size > most)
            || self.options.split_ns.is_some_and(long)
    }

    fn begin_file(&mut self) -> Result<(), WriteError> {
        let name = format!("{}_{}.mcap", self.name, self.parts.len());
        let path = self.folder.join(&name);
        let output = files::create(&path);
        let output = output.map_err(|error| WriteError::Output { path, error })?;
        let mut options = WriteOptions::new()
            .profile("ros2")
            .library(format!("carom {}", env!("CARGO_PKG_VERSION")))
            .chunk_size(Some(CHUNK_BYTES))
            // Chunks are made in memory and written whole.
            .disable_seeking(true)
            .compression(self.options.packed.then_some(Compression::Zstd));
        // No threads of its own: the same bytes everywhere.
        options = options.compression_threads(0);
        self.parts.push(Part::new(name));
        self.bytes = 0;
        self.file = Some(options.create(NoSeek::new(output)).map_err(|error| self.failed(error))?);
        let notes = self.notes.clone();
        let mut topics = std::mem::take(&mut self.topics);
        let begun = self.with_file(|file| {
            for (name, metadata) in notes {
                file.write_metadata(&Metadata { name, metadata })?;
            }
            file.flush()?;
            topics.iter_mut().try_for_each(|topic| topic.enter(file))
        });
        self.topics = topics;
        begun
    }

    fn end_file(&mut self) -> Result<(), WriteError> {
        self.with_file(|file| file.finish().map(drop))?;
        self.file = None;
        Ok(())
    }

    /// After an error there is no file: what was written before stays.
    fn with_file(
        &mut self,
        work: impl FnOnce(&mut mcap::Writer<NoSeek<Output>>) -> Result<(), McapError>,
    ) -> Result<(), WriteError> {
        let Some(mut file) = self.file.take() else {
            let error = std::io::Error::other("it failed before");
            return Err(self.failed(McapError::Io(error)));
        };
        match work(&mut file) {
            Ok(()) => {
                self.file = Some(file);
                Ok(())
            }
            Err(error) => {
                // Dropped as it is: finishing it would fail again.
                drop(file.into_inner());
                Err(self.failed(error))
            }
        }
    }

    fn failed(&self, error: McapError) -> WriteError {
        let name = self.parts.last().map_or("", |part| &part.name);
        let error = match error {
            McapError::Io(error) => error,
            other => std::io::Error::other(other.to_string()),
        };
        WriteError::Output { path: self.folder.join(name), error }
    }
}

impl Channel {
    /// Gets a channel in a file.
    fn enter(&mut self, file: &mut mcap::Writer<NoSeek<Output>>) -> Result<(), McapError> {
        let schema = file.add_schema(&self.kind, "ros2msg", self.definition.as_bytes())?;
        let said = BTreeMap::from([
            ("offered_qos_profiles".to_owned(), self.qos.clone()),
            ("topic_type_hash".to_owned(), self.hash.clone()),
        ]);
        self.id = file.add_channel(schema, &self.name, "cdr", &said)?;
        Ok(())
    }

    fn line(&self) -> TopicLine<'_> {
        let Self { name, kind, hash, qos, count, .. } = self;
        TopicLine { name, kind, hash, qos, count: *count }
    }
}
