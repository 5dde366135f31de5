//! A bag: topics and messages, whatever it is stored in.
//!
//! A bag is a folder with `metadata.yaml`, a folder of recordings, or one recording. Messages come
//! as they are stored, file after file, which is the order of time in all that `ros2 bag` records;
//! memory is that of one chunk of one file. What is wrong is told at its place, and what can still
//! be read after it is read.

use std::collections::{BTreeMap, HashMap};
use std::io::Read;
use std::path::{Path, PathBuf};

use super::fault::{BagError, Fault};
pub use super::files::holds_a_bag;
use super::files::{self, Storage};
use super::mcap_file::{self, McapReader};
use super::metadata::{self, Metadata};
use super::sqlite_file::{self, SqliteReader};

/// Largest message that is unpacked, bytes.
const MESSAGE_BYTES_MAX: u64 = 1 << 30;

/// A topic of a bag.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Topic {
    /// Its name.
    pub name: String,
    /// Its type, such as `carom/msg/CircleStates`.
    pub kind: String,
    /// How payloads are encoded: `cdr`.
    pub encoding: String,
    /// What the type is made of, if the bag says it.
    pub definition: Option<Definition>,
    /// The profiles with which it was offered, in YAML as rosbag2 writes them; may be empty.
    pub qos: String,
    /// The hash of the type (RIHS01); may be empty.
    pub type_hash: String,
    /// Its messages in the whole bag, if that is known before they are read.
    pub count: Option<u64>,
}

/// What a type is made of.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Definition {
    /// The language, such as `ros2msg`.
    pub format: String,
    /// The definition, and those of the types in it.
    pub text: String,
}

/// A message of a bag.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Message {
    /// Which of [`Bag::topics`] it is of.
    pub topic: usize,
    /// When it was recorded, ns since 1970.
    pub log_time_ns: u64,
    /// When it was sent, ns since 1970; when it was recorded, where the bag does not say that.
    pub publish_time_ns: u64,
    /// Its number among those of its topic, as the recorder counted; where that does not count, 0.
    pub sequence: u32,
    /// Encapsulation and message; `decode::message` reads it.
    pub payload: Vec<u8>,
}

/// A message as a file has it.
pub(super) type Stored = Message;

/// Notes of the one who recorded: a name, and what it says.
pub type Note = (String, BTreeMap<String, String>);

/// Which topics the ids of one file stand for, and which of them are wanted.
pub(super) struct Wanted {
    ids: HashMap<i64, (usize, bool)>,
}

impl Wanted {
    /// The topic of an id, and whether it is wanted.
    pub(super) fn topic(&self, id: i64) -> Option<(usize, bool)> {
        self.ids.get(&id).copied()
    }

    /// Whether the topic of an id is wanted.
    pub(super) fn is_wanted(&self, id: i64) -> bool {
        self.topic(id).is_some_and(|(_, wanted)| wanted)
    }
}

/// One file of a bag.
#[derive(Debug)]
struct Part {
    path: PathBuf,
    storage: Storage,
    /// Topics by the ids that the file has for them.
    ids: HashMap<i64, usize>,
    count: Option<u64>,
    size: u64,
    /// Whether a file before it could not be read at all.
    follows_gap: bool,
}

/// A bag, opened for reading.
#[derive(Debug)]
pub struct Bag {
    path: PathBuf,
    parts: Vec<Part>,
    topics: Vec<Topic>,
    notes: Vec<Note>,
    faults: Vec<BagError>,
    /// Whether each message is packed with zstd.
    packed_messages: bool,
}

impl Bag {
    /// Opens a folder or a file, and reads what it says that it holds.
    ///
    /// # Errors
    /// [`BagError`] where nothing at all can be read; what is wrong besides is in [`Bag::faults`].
    pub fn open(path: &Path) -> Result<Self, BagError> {
        let mut bag = Self {
            path: path.to_owned(),
            parts: Vec::new(),
            topics: Vec::new(),
            notes: Vec::new(),
            faults: Vec::new(),
            packed_messages: false,
        };
        if !files::is_folder(path) {
            bag.add(path, false).map_err(|fault| fault.of(path))?;
            return Ok(bag);
        }
        let metadata = bag.read_metadata();
        let files = bag.files_of(metadata.as_ref())?;
        if files.is_empty() {
            let what = "is a folder without a recording (.mcap, .db3)".to_owned();
            return Err(Fault::NotABag(what).of(path));
        }
        let mut follows_gap = false;
        for file in files {
            if let Err(fault) = bag.add(&file, follows_gap) {
                follows_gap = true;
                bag.faults.push(fault.of(&file));
            }
        }
        if bag.parts.is_empty() {
            // There were files, and something is wrong with the last.
            let none = || Fault::NotABag("has no file that can be read".to_owned()).of(path);
            return Err(bag.faults.pop().unwrap_or_else(none));
        }
        if let Some(metadata) = metadata {
            bag.compare(&metadata);
        }
        Ok(bag)
    }

    /// The folder or file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// All topics.
    pub fn topics(&self) -> &[Topic] {
        &self.topics
    }

    /// What the one who recorded noted.
    pub fn notes(&self) -> &[Note] {
        &self.notes
    }

    /// What was noted under a name.
    pub fn note(&self, name: &str) -> Option<&BTreeMap<String, String>> {
        self.notes.iter().find(|(of, _)| of == name).map(|(_, note)| note)
    }

    /// What is wrong or missing, as far as that is known before messages are read.
    pub fn faults(&self) -> &[BagError] {
        &self.faults
    }

    /// Messages altogether, if that is known.
    pub fn count(&self) -> Option<u64> {
        let mut counts = self.topics.iter().map(|topic| topic.count);
        counts.try_fold(0, |all: u64, count| Some(all.saturating_add(count?)))
    }

    /// Bytes of all files.
    pub fn size(&self) -> u64 {
        self.parts.iter().map(|part| part.size).sum()
    }

    /// The messages of the topics that are wanted, as they are stored.
    pub fn messages(&self, wanted: impl Fn(&Topic) -> bool) -> Messages<'_> {
        let wanted = self.topics.iter().map(wanted).collect();
        Messages { bag: self, wanted, part: 0, reading: None, bytes_before: 0, is_told: false }
    }

    fn read_metadata(&mut self) -> Option<Metadata> {
        let path = self.path.join("metadata.yaml");
        let fault = match files::text(&path) {
            Ok(Some(text)) => match metadata::parse(&text) {
                Ok(metadata) => return Some(metadata),
                Err(error) => Fault::Contradicts(format!(
                    "{error}; the files of the folder are read without it"
                )),
            },
            Ok(None) => Fault::Missing("is missing: the files of the folder are read".to_owned()),
            Err(fault) => {
                Fault::Missing(format!("{fault}: the files of the folder are read without it"))
            }
        };
        self.faults.push(fault.of(&path));
        None
    }

    fn files_of(&mut self, metadata: Option<&Metadata>) -> Result<Vec<PathBuf>, BagError> {
        let recordings = files::recordings(&self.path).map_err(|fault| fault.of(&self.path))?;
        let Some(metadata) = metadata else { return Ok(recordings) };
        self.packed_messages = metadata.compression_mode.eq_ignore_ascii_case("message");
        let mut listed: Vec<PathBuf> = Vec::new();
        for name in &metadata.relative_file_paths {
            let whole = self.path.join(name);
            // Early versions wrote the name of the folder too.
            let last = Path::new(name).file_name().map(|name| self.path.join(name));
            listed.push(last.filter(|last| !whole.exists() && last.exists()).unwrap_or(whole));
        }
        if !recordings.is_empty() && !listed.iter().any(|path| path.exists()) {
            let what = "names none of the files that are there; those are read".to_owned();
            self.faults.push(Fault::Contradicts(what).of(&self.path.join("metadata.yaml")));
            return Ok(recordings);
        }
        for path in recordings.into_iter().filter(|path| !listed.contains(path)) {
            let what = "is not in metadata.yaml and is left out".to_owned();
            self.faults.push(Fault::Contradicts(what).of(&path));
        }
        Ok(listed)
    }

    fn add(&mut self, path: &Path, follows_gap: bool) -> Result<(), Fault> {
        let storage = files::storage(path)?;
        let (topics, count, faults) = match storage {
            Storage::Mcap => {
                let index = mcap_file::index(path)?;
                self.notes.extend(index.metadata);
                let topics = index.topics.into_iter().map(|(id, topic)| (i64::from(id), topic));
                (topics.collect::<Vec<_>>(), index.count, index.faults)
            }
            Storage::Sqlite => {
                let index = sqlite_file::index(path)?;
                (index.topics.into_iter().collect(), None, index.faults)
            }
        };
        let (_, size) = files::open(path)?;
        let mut ids = HashMap::new();
        for (id, topic) in topics {
            ids.insert(id, self.know(topic));
        }
        self.faults.extend(faults.into_iter().map(|fault| fault.of(path)));
        self.parts.push(Part { path: path.to_owned(), storage, ids, count, size, follows_gap });
        Ok(())
    }

    /// The place of a topic: the one with its name and type, or a new one.
    fn know(&mut self, topic: Topic) -> usize {
        let same = |other: &Topic| (&other.name, &other.kind) == (&topic.name, &topic.kind);
        let Some(place) = self.topics.iter().position(same) else {
            self.topics.push(topic);
            return self.topics.len() - 1;
        };
        let known = &mut self.topics[place];
        known.count = known.count.zip(topic.count).map(|(a, b)| a.saturating_add(b));
        known.definition = known.definition.take().or(topic.definition);
        place
    }

    /// Says where the metadata and the files differ; counts that only the metadata knows are taken.
    fn compare(&mut self, metadata: &Metadata) {
        let path = self.path.join("metadata.yaml");
        let mut wrong = |what: String| self.faults.push(Fault::Contradicts(what).of(&path));
        for said in &metadata.topics_with_message_count {
            let (name, kind) = (&said.topic_metadata.name, &said.topic_metadata.r#type);
            let found = self.topics.iter_mut().find(|topic| topic.name == *name);
            match found {
                None if said.message_count == 0 => {}
                None => wrong(format!("names topic {name}, which no file has")),
                Some(topic) if topic.kind != *kind => {
                    wrong(format!("says {name} is a {kind}, but it is a {}", topic.kind));
                }
                Some(topic) => match topic.count {
                    None => topic.count = Some(said.message_count),
                    Some(count) if count != said.message_count => {
                        let said = said.message_count;
                        wrong(format!("says {name} has {said} messages, but it has {count}"));
                    }
                    Some(_) => {}
                },
            }
        }
    }
}

/// Reads one file.
enum Reading {
    Mcap(Box<McapReader>),
    Sqlite(Box<SqliteReader>),
}

/// The messages of a bag. An error is no end: what can be read after it comes after it.
pub struct Messages<'a> {
    bag: &'a Bag,
    /// By topic.
    wanted: Vec<bool>,
    part: usize,
    reading: Option<(Reading, Wanted)>,
    /// In files that are over.
    bytes_before: u64,
    /// Whether something was wrong with this file.
    is_told: bool,
}

impl Messages<'_> {
    /// Bytes that have been read, of [`Bag::size`].
    pub fn bytes_read(&self) -> u64 {
        let here = match &self.reading {
            Some((Reading::Mcap(file), _)) => file.bytes_read(),
            Some((Reading::Sqlite(file), _)) => file.bytes_read(),
            None => 0,
        };
        self.bytes_before + here
    }

    /// Whether a file before the one that is being read could not be read at all.
    pub fn follows_gap(&self) -> bool {
        self.bag.parts.get(self.part).is_some_and(|part| part.follows_gap)
    }

    fn begin(&self, part: &Part) -> Result<(Reading, Wanted), Fault> {
        let ids = part.ids.iter().map(|(id, topic)| (*id, (*topic, self.wanted[*topic])));
        let wanted = Wanted { ids: ids.collect() };
        let reading = match part.storage {
            Storage::Mcap => Reading::Mcap(Box::new(McapReader::open(&part.path)?)),
            Storage::Sqlite => Reading::Sqlite(Box::new(SqliteReader::open(&part.path)?)),
        };
        Ok((reading, wanted))
    }

    /// The file is over: whether it held what it promised.
    fn end(&mut self, part: &Part) -> Option<BagError> {
        let reading = self.reading.take();
        self.part += 1;
        self.bytes_before += part.size;
        let is_told = std::mem::take(&mut self.is_told);
        let Some((Reading::Mcap(file), _)) = reading else { return None };
        let promised = part.count.filter(|count| *count != file.count && !is_told)?;
        let what = format!("promises {promised} messages, but it has {}", file.count);
        Some(Fault::Contradicts(what).of(&part.path))
    }
}

impl Iterator for Messages<'_> {
    type Item = Result<Message, BagError>;

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            let part = self.bag.parts.get(self.part)?;
            if self.reading.is_none() {
                match self.begin(part) {
                    Ok(reading) => self.reading = Some(reading),
                    Err(fault) => {
                        self.part += 1;
                        return Some(Err(fault.of(&part.path)));
                    }
                }
            }
            let next = match &mut self.reading {
                Some((Reading::Mcap(file), wanted)) => file.next(wanted),
                Some((Reading::Sqlite(file), wanted)) => file.next(wanted),
                None => None,
            };
            let unpacked = next.map(|next| match next {
                Ok(message) if self.bag.packed_messages => unpack(message),
                next => next,
            });
            match unpacked {
                Some(Ok(message)) => return Some(Ok(message)),
                Some(Err(fault)) => {
                    self.is_told = true;
                    return Some(Err(fault.of(&part.path)));
                }
                None => {
                    if let Some(error) = self.end(part) {
                        return Some(Err(error));
                    }
                }
            }
        }
    }
}

fn unpack(message: Message) -> Result<Message, Fault> {
    let unpacked = zstd::stream::read::Decoder::new(&*message.payload).and_then(|packed| {
        let mut payload = Vec::new();
        packed.take(MESSAGE_BYTES_MAX).read_to_end(&mut payload)?;
        Ok(payload)
    });
    match unpacked {
        Ok(payload) => Ok(Message { payload, ..message }),
        Err(error) => {
            let what = format!("a message that cannot be unpacked: {error}");
            Err(Fault::Damaged { at: message.log_time_ns, what })
        }
    }
}
