//! MCAP: records one after another, many of them packed in chunks.
//!
//! Every length is checked against what is there before anything is allocated, a chunk is unpacked
//! and its checksum compared before a message of it is handed out, and a chunk that is damaged is
//! left out alone. Memory is that of one chunk. Records inside are parsed by the `mcap` crate, but
//! for those of which it trusts the lengths.

use std::collections::{BTreeMap, HashMap};
use std::io::{Read, Seek, SeekFrom};
use std::path::Path;

use mcap::records::{Record, op};

use super::fault::Fault;
use super::files;
use super::read::{Definition, Stored, Topic, Wanted};

/// Opcode and length of a record, bytes.
const HEAD_BYTES: u64 = 9;
/// Channel, number and two times of a message, bytes.
const MESSAGE_HEAD_BYTES: usize = 22;
/// The footer with its head, and the magic after it, bytes.
const TAIL_BYTES: u64 = 9 + 20 + 8;
/// Largest record, and largest chunk when it is unpacked: bytes.
const RECORD_BYTES_MAX: u64 = 1 << 30;

/// What a file holds, from its summary or from a look at all of it.
#[derive(Debug, Default)]
pub struct Index {
    /// Topics by the ids of their channels.
    pub topics: BTreeMap<u16, Topic>,
    /// Records of metadata: their names and what they say.
    pub metadata: Vec<(String, BTreeMap<String, String>)>,
    /// Messages, where a summary says it.
    pub count: Option<u64>,
    /// What is wrong with it.
    pub faults: Vec<Fault>,
}

/// Reads what a file says that it holds.
///
/// # Errors
/// [`Fault::Unreadable`] where nothing can be read.
pub fn index(path: &Path) -> Result<Index, Fault> {
    let mut file = McapReader::open(path)?;
    let mut faults = Vec::new();
    match file.summary() {
        Ok(index) => return Ok(index.checked()),
        Err(NoSummary::Unreadable(error)) => return Err(Fault::Unreadable(error)),
        Err(NoSummary::Absent(what)) => faults.push(Fault::Missing(what)),
        Err(NoSummary::Wrong(what)) => faults.push(Fault::Contradicts(what)),
    }
    let mut file = McapReader::open(path)?;
    let mut definitions = HashMap::new();
    let mut index = Index { faults, ..Index::default() };
    let mut counts: BTreeMap<u16, u64> = BTreeMap::new();
    while let Some(event) = file.next_event(|_| false) {
        match event {
            Ok(Event::Message { channel, .. }) => *counts.entry(channel).or_default() += 1,
            Ok(event) => index.take(event, &mut definitions),
            // Whoever reads the messages is told.
            Err(_) => {}
        }
    }
    for (id, topic) in &mut index.topics {
        topic.count = Some(counts.get(id).copied().unwrap_or(0));
    }
    Ok(index.checked())
}

impl Index {
    fn take(&mut self, event: Event, definitions: &mut HashMap<u16, (String, Definition)>) {
        match event {
            Event::Schema { id, kind, definition } => {
                definitions.entry(id).or_insert((kind, definition));
            }
            Event::Channel { channel, schema } => {
                let (kind, definition) = definitions.get(&schema).cloned().unzip();
                let said = |key: &str| channel.metadata.get(key).cloned().unwrap_or_default();
                let topic = Topic {
                    kind: kind.unwrap_or_default(),
                    definition: definition.filter(|definition| !definition.text.is_empty()),
                    qos: said("offered_qos_profiles"),
                    type_hash: said("topic_type_hash"),
                    name: channel.topic,
                    encoding: channel.message_encoding,
                    count: None,
                };
                self.topics.entry(channel.id).or_insert(topic);
            }
            Event::Metadata(name, said) => self.metadata.push((name, said)),
            Event::Message { .. } => {}
        }
    }

    fn checked(mut self) -> Self {
        for topic in self.topics.values().filter(|topic| topic.definition.is_none()) {
            let Topic { name, kind, .. } = topic;
            let what = format!("topic {name} comes without a definition of its type `{kind}`");
            self.faults.push(Fault::Missing(what));
        }
        self
    }
}

/// Why there is no summary to be used.
enum NoSummary {
    Unreadable(std::io::Error),
    Absent(String),
    Wrong(String),
}

impl From<std::io::Error> for NoSummary {
    fn from(error: std::io::Error) -> Self {
        Self::Unreadable(error)
    }
}

fn absent(what: &str) -> NoSummary {
    NoSummary::Absent(format!("{what}, so all of it was looked through"))
}

fn wrong(what: &str) -> NoSummary {
    NoSummary::Wrong(format!("{what}, so all of it was looked through"))
}

/// A record that matters.
enum Event {
    Schema {
        id: u16,
        kind: String,
        definition: Definition,
    },
    Channel {
        channel: mcap::records::Channel,
        schema: u16,
    },
    Metadata(String, BTreeMap<String, String>),
    Message {
        channel: u16,
        sequence: u32,
        log_time_ns: u64,
        publish_time_ns: u64,
        payload: Vec<u8>,
    },
}

/// A file that is being read from its beginning to its end.
pub struct McapReader {
    input: files::Input,
    length: u64,
    /// Where the next record of the file begins.
    at: u64,
    chunk: Records,
    /// Where the chunk began.
    chunk_at: u64,
    ended: bool,
    last_time_ns: Option<u64>,
    /// Messages so far, wanted or not.
    pub count: u64,
    /// A message of a channel that nobody named was told of.
    is_stranger_told: bool,
}

impl McapReader {
    /// At the first record; the magic before it has been looked at.
    ///
    /// # Errors
    /// [`Fault::Unreadable`].
    pub fn open(path: &Path) -> Result<Self, Fault> {
        let (mut input, length) = files::open(path)?;
        let at = mcap::MAGIC.len() as u64;
        input.seek(SeekFrom::Start(at)).map_err(Fault::Unreadable)?;
        Ok(Self {
            input,
            length,
            at,
            chunk: Records::default(),
            chunk_at: 0,
            ended: false,
            last_time_ns: None,
            count: 0,
            is_stranger_told: false,
        })
    }

    /// Bytes that have been read.
    pub fn bytes_read(&self) -> u64 {
        self.at
    }

    /// The next message that is wanted.
    pub fn next(&mut self, wanted: &Wanted) -> Option<Result<Stored, Fault>> {
        loop {
            let event = match self.next_event(|channel| wanted.is_wanted(channel.into()))? {
                Ok(event) => event,
                Err(fault) => return Some(Err(fault)),
            };
            let Event::Message { channel, sequence, log_time_ns, publish_time_ns, payload } = event
            else {
                continue;
            };
            match wanted.topic(channel.into()) {
                Some((topic, true)) => {
                    let stored = Stored { topic, log_time_ns, publish_time_ns, sequence, payload };
                    return Some(Ok(stored));
                }
                Some(_) => {}
                None if self.is_stranger_told => {}
                None => {
                    self.is_stranger_told = true;
                    let what = format!("messages of channel {channel}, which has no topic");
                    return Some(Err(Fault::Contradicts(format!("{what}, are left out"))));
                }
            }
        }
    }

    fn next_event(&mut self, wanted: impl Fn(u16) -> bool) -> Option<Result<Event, Fault>> {
        while !self.ended {
            let event = match self.chunk.next() {
                Some(Ok((opcode, body))) => event(opcode, body, &wanted),
                Some(Err(what)) => Some(Err(what)),
                None => match self.next_record() {
                    Ok(None) => None,
                    Ok(Some((opcode, body))) => {
                        let event = event(opcode, &body, &wanted);
                        match event {
                            Some(Err(what)) => {
                                let at = self.at.saturating_sub(body.len() as u64 + HEAD_BYTES);
                                return Some(Err(Fault::Damaged { at, what }));
                            }
                            event => event,
                        }
                    }
                    Err(fault) => return Some(Err(fault)),
                },
            };
            match event {
                Some(Ok(event)) => {
                    if let Event::Message { log_time_ns, .. } = event {
                        self.count += 1;
                        self.last_time_ns = Some(log_time_ns);
                    }
                    return Some(Ok(event));
                }
                Some(Err(what)) => return Some(Err(Fault::Damaged { at: self.chunk_at, what })),
                None => {}
            }
        }
        None
    }

    /// The next record of the file if it is one to be looked into; a chunk is unpacked, others are
    /// passed over.
    fn next_record(&mut self) -> Result<Option<(u8, Vec<u8>)>, Fault> {
        let cut = Fault::Cut { at_byte: self.at, last_time_ns: self.last_time_ns };
        if self.length - self.at < HEAD_BYTES {
            self.ended = true;
            return Err(cut);
        }
        let mut head = [0; HEAD_BYTES as usize];
        self.read(&mut head)?;
        let (opcode, length) = head_of(&head);
        if opcode == op::DATA_END {
            self.ended = true;
            return Ok(None);
        }
        let end = self.at.checked_add(HEAD_BYTES).and_then(|at| at.checked_add(length));
        let Some(end) = end.filter(|end| *end <= self.length) else {
            self.ended = true;
            return Err(cut);
        };
        let at = std::mem::replace(&mut self.at, end);
        let matters =
            matches!(opcode, op::CHUNK | op::SCHEMA | op::CHANNEL | op::MESSAGE | op::METADATA);
        if !matters || length > RECORD_BYTES_MAX {
            // Within the file, so within i64.
            let skip = i64::try_from(length).unwrap_or(i64::MAX);
            self.input.seek_relative(skip).map_err(|error| self.unreadable(error))?;
            let what = || format!("a record of {length} bytes, larger than {RECORD_BYTES_MAX}");
            return if matters { Err(Fault::Damaged { at, what: what() }) } else { Ok(None) };
        }
        let mut body = vec![0; usize::try_from(length).unwrap_or(0)];
        self.read(&mut body)?;
        if opcode != op::CHUNK {
            return Ok(Some((opcode, body)));
        }
        self.chunk_at = at;
        self.chunk.fill(&body).map_err(|what| Fault::Damaged { at, what })?;
        Ok(None)
    }

    fn read(&mut self, into: &mut [u8]) -> Result<(), Fault> {
        self.input.read_exact(into).map_err(|error| self.unreadable(error))
    }

    fn unreadable(&mut self, error: std::io::Error) -> Fault {
        self.ended = true;
        Fault::Unreadable(error)
    }

    /// What the summary at the end says, if it can be trusted.
    fn summary(&mut self) -> Result<Index, NoSummary> {
        let tail_at = self.length.checked_sub(TAIL_BYTES).filter(|at| *at >= self.at);
        let tail_at = tail_at.ok_or_else(|| absent("was not closed"))?;
        let mut tail = [0; TAIL_BYTES as usize];
        self.input.seek(SeekFrom::Start(tail_at))?;
        self.input.read_exact(&mut tail)?;
        let (opcode, length) = head_of(&tail);
        if !tail.ends_with(mcap::MAGIC) || opcode != op::FOOTER || length != 20 {
            return Err(absent("was not closed"));
        }
        let (start, crc) = (u64_at(&tail, 9), u32_at(&tail, 25));
        if start == 0 {
            return Err(absent("has no summary"));
        }
        let size = tail_at.checked_sub(start).filter(|_| start >= self.at);
        let size = size.filter(|size| *size <= RECORD_BYTES_MAX);
        let size = size.ok_or_else(|| wrong("has its summary where none can be"))?;
        let mut bytes = vec![0; usize::try_from(size).unwrap_or(0)];
        self.input.seek(SeekFrom::Start(start))?;
        self.input.read_exact(&mut bytes)?;
        let mut hasher = crc32fast::Hasher::new();
        hasher.update(&bytes);
        hasher.update(&tail[..25]);
        if crc != 0 && hasher.finalize() != crc {
            return Err(wrong("has a summary with a wrong checksum"));
        }
        self.read_summary(Records { bytes, at: 0 })
    }

    fn read_summary(&mut self, mut records: Records) -> Result<Index, NoSummary> {
        let damaged = || wrong("has a damaged summary");
        let (mut index, mut definitions) = (Index::default(), HashMap::new());
        let (mut statistics, mut places) = (None, Vec::new());
        while let Some(record) = records.next() {
            let (opcode, body) = record.map_err(|_| damaged())?;
            match opcode {
                op::STATISTICS | op::METADATA_INDEX => match mcap::parse_record(opcode, body) {
                    Ok(Record::Statistics(said)) => statistics = Some(said),
                    Ok(Record::MetadataIndex(said)) => places.push(said.offset),
                    _ => return Err(damaged()),
                },
                _ => match event(opcode, body, &|_| false) {
                    Some(Ok(event)) => index.take(event, &mut definitions),
                    Some(Err(_)) => return Err(damaged()),
                    None => {}
                },
            }
        }
        let said = statistics.ok_or_else(|| absent("has a summary without counts"))?;
        if said.channel_count as usize != index.topics.len() {
            return Err(wrong("has a summary without its topics"));
        }
        for (id, topic) in &mut index.topics {
            topic.count = Some(said.channel_message_counts.get(id).copied().unwrap_or(0));
        }
        index.count = Some(said.message_count);
        for place in places {
            self.read_metadata(place, &mut index)?;
        }
        Ok(index)
    }

    fn read_metadata(&mut self, at: u64, index: &mut Index) -> Result<(), NoSummary> {
        let beside = || wrong("has a summary that points beside its metadata");
        let room = self.length.checked_sub(at).ok_or_else(beside)?;
        let mut head = [0; HEAD_BYTES as usize];
        self.input.seek(SeekFrom::Start(at))?;
        self.input.read_exact(&mut head).map_err(|_| beside())?;
        let (opcode, length) = head_of(&head);
        if opcode != op::METADATA || length > room.min(RECORD_BYTES_MAX) {
            return Err(beside());
        }
        let mut body = vec![0; usize::try_from(length).unwrap_or(0)];
        self.input.read_exact(&mut body).map_err(|_| beside())?;
        match event(opcode, &body, &|_| false) {
            Some(Ok(event)) => index.take(event, &mut HashMap::new()),
            _ => return Err(beside()),
        }
        Ok(())
    }
}

/// Records in memory.
#[derive(Default)]
struct Records {
    bytes: Vec<u8>,
    at: usize,
}

impl Records {
    /// Opcode and body of the next one; after an error there is none.
    fn next(&mut self) -> Option<Result<(u8, &[u8]), String>> {
        let rest = self.bytes.get(self.at..).filter(|rest| !rest.is_empty())?;
        let left = rest.len() as u64;
        let length = if left < HEAD_BYTES { u64::MAX } else { head_of(rest).1 };
        if length > left.saturating_sub(HEAD_BYTES) {
            self.at = self.bytes.len();
            return Some(Err("a record in it is longer than what is left".to_owned()));
        }
        let opcode = rest[0];
        let begin = self.at + HEAD_BYTES as usize;
        // At most what is left, which is in memory.
        let end = begin + length as usize;
        self.at = end;
        Some(Ok((opcode, &self.bytes[begin..end])))
    }

    /// The records of a chunk instead of those that were here.
    fn fill(&mut self, chunk: &[u8]) -> Result<(), String> {
        self.bytes.clear();
        self.at = 0;
        let unpacked = unpack(chunk, &mut self.bytes);
        unpacked.inspect_err(|_| self.bytes.clear())
    }
}

fn unpack(chunk: &[u8], into: &mut Vec<u8>) -> Result<(), String> {
    let parsed = mcap::parse_record(op::CHUNK, chunk);
    let Ok(Record::Chunk { header, data }) = parsed else {
        return Err("a chunk that is none".to_owned());
    };
    let size = header.uncompressed_size;
    if size > RECORD_BYTES_MAX {
        return Err(format!("a chunk of {size} bytes, larger than {RECORD_BYTES_MAX}"));
    }
    let failed = |error: std::io::Error| format!("a chunk that cannot be unpacked: {error}");
    // One byte more than it may have shows that it has too many.
    match header.compression.as_str() {
        "" => into.extend_from_slice(&data),
        "zstd" => {
            let packed = zstd::stream::read::Decoder::new(&*data).map_err(failed)?;
            packed.take(size + 1).read_to_end(into).map_err(failed)?;
        }
        "lz4" => {
            let packed = lz4::Decoder::new(&*data).map_err(failed)?;
            packed.take(size + 1).read_to_end(into).map_err(failed)?;
        }
        other => return Err(format!("a chunk packed with `{other}`, not zstd or lz4")),
    }
    if into.len() as u64 != size {
        return Err(format!("a chunk of {} bytes that should have {size}", into.len()));
    }
    if header.uncompressed_crc != 0 && crc32fast::hash(into) != header.uncompressed_crc {
        return Err("a chunk with a wrong checksum".to_owned());
    }
    Ok(())
}

/// The record, if it is one that matters.
fn event(opcode: u8, body: &[u8], wanted: &impl Fn(u16) -> bool) -> Option<Result<Event, String>> {
    let event = match opcode {
        op::MESSAGE => message(body, wanted).ok_or_else(|| "a message that is none".to_owned()),
        op::SCHEMA | op::CHANNEL | op::METADATA => match mcap::parse_record(opcode, body) {
            Ok(Record::Schema { header, data }) => {
                let text = String::from_utf8_lossy(&data).into_owned();
                let definition = Definition { format: header.encoding, text };
                Ok(Event::Schema { id: header.id, kind: header.name, definition })
            }
            Ok(Record::Channel(channel)) => {
                Ok(Event::Channel { schema: channel.schema_id, channel })
            }
            Ok(Record::Metadata(said)) => Ok(Event::Metadata(said.name, said.metadata)),
            _ => Err(format!("a record of kind {opcode} that is none")),
        },
        _ => return None,
    };
    Some(event)
}

fn message(body: &[u8], wanted: &impl Fn(u16) -> bool) -> Option<Event> {
    let (head, payload) = body.split_at_checked(MESSAGE_HEAD_BYTES)?;
    let channel = u16::from_le_bytes([head[0], head[1]]);
    let payload = if wanted(channel) { payload.to_vec() } else { Vec::new() };
    let sequence = u32::from_le_bytes([head[2], head[3], head[4], head[5]]);
    let (log_time_ns, publish_time_ns) = (u64_at(head, 6), u64_at(head, 14));
    Some(Event::Message { channel, sequence, log_time_ns, publish_time_ns, payload })
}

/// Opcode and length; `bytes` has them.
fn head_of(bytes: &[u8]) -> (u8, u64) {
    (bytes[0], u64_at(bytes, 1))
}

fn u64_at(bytes: &[u8], at: usize) -> u64 {
    let mut value = [0; 8];
    value.copy_from_slice(&bytes[at..at + 8]);
    u64::from_le_bytes(value)
}

fn u32_at(bytes: &[u8], at: usize) -> u32 {
    let mut value = [0; 4];
    value.copy_from_slice(&bytes[at..at + 4]);
    u32::from_le_bytes(value)
}
