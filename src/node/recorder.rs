//! The recorder: what the node says and hears goes into a bag, by a thread of its own.
//!
//! The loop hands messages over and never waits: it neither encodes nor writes, nor does it wake
//! the thread, which looks every few milliseconds. What does not fit into the queue is dropped,
//! counted, and noted in the bag at its place.

use std::cell::{Cell, RefCell};
use std::path::Path;
use std::rc::Rc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, Sender, TryRecvError, channel};
use std::sync::{Arc, OnceLock};
use std::thread::JoinHandle;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use serde::Serialize;

use crate::bag::decode;
use crate::bag::journal::Entry;
use crate::bag::qos::Qos;
use crate::bag::read::Note;
pub use crate::bag::write::Summary;
use crate::bag::write::{BagWriter, Options, WriteError};

/// Bytes of messages that wait; beyond them new ones are dropped.
const WAITING_BYTES_MAX: usize = 64 << 20;
/// What a message that waits takes besides its content, bytes.
const MESSAGE_BYTES: usize = 256;
/// The thread looks for messages so often.
const LOOK_PERIOD: Duration = Duration::from_millis(5);
/// A chunk is written at least so often: so much is lost at most when the node is killed.
const FLUSH_PERIOD: Duration = Duration::from_millis(500);

/// Makes the payload of a message; nothing of one that cannot be encoded.
type Encode = Box<dyn FnOnce() -> Option<Vec<u8>> + Send>;

enum Item {
    Topic { name: String, kind: String, qos: String },
    Message { topic: usize, time_ns: u64, bytes: usize, encode: Encode },
}

/// Hands messages to the thread that writes them. Clones write into the same bag.
#[derive(Clone)]
pub struct Recorder(Rc<Shared>);

struct Shared {
    /// Nothing when the bag is closed.
    sender: RefCell<Option<Sender<Item>>>,
    waiting_bytes: Arc<AtomicUsize>,
    topics: Cell<usize>,
    journal: Cell<Option<usize>>,
    dropped: Cell<u64>,
    /// Of those, the ones that the journal does not know yet.
    untold: Cell<u64>,
    failure: Arc<OnceLock<String>>,
    thread: RefCell<Option<JoinHandle<Result<Summary, WriteError>>>>,
}

/// A topic of the bag.
#[derive(Clone)]
pub struct Tap {
    recorder: Recorder,
    topic: usize,
}

impl Recorder {
    /// Makes the bag and begins to write.
    pub fn open(folder: &Path, options: Options, notes: Vec<Note>) -> Result<Self, WriteError> {
        let bag = BagWriter::create(folder, options, notes)?;
        let (sender, receiver) = channel();
        let (waiting_bytes, failure) = (Arc::new(AtomicUsize::new(0)), Arc::new(OnceLock::new()));
        let thread = {
            let (waiting_bytes, failure) = (waiting_bytes.clone(), failure.clone());
            std::thread::Builder::new().name("carom-record".to_owned()).spawn(move || {
                let written = write(bag, &receiver, &waiting_bytes);
                if let Err(error) = &written {
                    // It is set nowhere else.
                    let _ = failure.set(error.to_string());
                }
                written
            })
        };
        let thread =
            thread.map_err(|error| WriteError::Output { path: folder.to_owned(), error })?;
        Ok(Self(Rc::new(Shared {
            sender: RefCell::new(Some(sender)),
            waiting_bytes,
            topics: Cell::new(0),
            journal: Cell::new(None),
            dropped: Cell::new(0),
            untold: Cell::new(0),
            failure,
            thread: RefCell::new(Some(thread)),
        })))
    }

    /// One more topic, by its whole name, of a type that is known.
    pub fn tap(&self, name: &str, kind: &str, qos: &str) -> Tap {
        let topic = self.0.topics.get();
        self.0.topics.set(topic + 1);
        let (name, kind, qos) = (name.to_owned(), kind.to_owned(), qos.to_owned());
        self.send(Item::Topic { name, kind, qos });
        Tap { recorder: self.clone(), topic }
    }

    /// The topic of the journal.
    pub fn keep_journal(&self, name: &str) {
        let qos = Qos { depth: 1_000, ..Qos::default() };
        let tap = self.tap(name, "std_msgs/msg/String", &qos.to_yaml());
        self.0.journal.set(Some(tap.topic));
    }

    /// Something that was done to the world.
    pub fn journal(&self, entry: Entry) {
        let Some(topic) = self.0.journal.get() else { return };
        let untold = self.0.untold.take();
        if untold > 0 {
            self.enter(topic, Entry::Dropped { messages: untold });
        }
        self.enter(topic, entry);
    }

    fn enter(&self, topic: usize, entry: Entry) {
        let encode = Box::new(move || {
            let text = serde_json::to_string(&entry).ok()?;
            decode::payload(&text).ok()
        });
        self.put(topic, 0, encode);
    }

    /// Messages that found no room, since the start.
    pub fn dropped(&self) -> u64 {
        self.0.dropped.get()
    }

    /// Why nothing is recorded any more, if that is so.
    pub fn failure(&self) -> Option<&str> {
        self.0.failure.get().map(String::as_str)
    }

    /// Closes the bag; what it then holds.
    pub fn close(&self) -> Result<Summary, WriteError> {
        self.0.sender.borrow_mut().take();
        let thread = self.0.thread.borrow_mut().take();
        // A thread that has panicked has said so itself.
        thread.and_then(|thread| thread.join().ok()).unwrap_or_else(|| Ok(Summary::default()))
    }

    fn put(&self, topic: usize, content_bytes: usize, encode: Encode) {
        let shared = &*self.0;
        let bytes = content_bytes + MESSAGE_BYTES;
        let waiting = shared.waiting_bytes.load(Ordering::Relaxed);
        if waiting + bytes > WAITING_BYTES_MAX || shared.failure.get().is_some() {
            shared.dropped.set(shared.dropped.get() + 1);
            shared.untold.set(shared.untold.get() + 1);
            return;
        }
        shared.waiting_bytes.fetch_add(bytes, Ordering::Relaxed);
        self.send(Item::Message { topic, time_ns: now_ns(), bytes, encode });
    }

    fn send(&self, item: Item) {
        if let Some(sender) = &*self.0.sender.borrow() {
            // After a failure nobody receives; that is told by itself.
            let _ = sender.send(item);
        }
    }
}

impl Tap {
    /// Records a message of about so many bytes.
    pub fn record<M: Serialize + Send + 'static>(&self, content_bytes: usize, message: M) {
        let encode = Box::new(move || decode::payload(&message).ok());
        self.recorder.put(self.topic, content_bytes, encode);
    }

    /// Records a payload that is encoded already.
    pub fn record_payload(&self, payload: Vec<u8>) {
        self.recorder.put(self.topic, payload.len(), Box::new(move || Some(payload)));
    }
}

fn now_ns() -> u64 {
    let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    u64::try_from(since.as_nanos()).unwrap_or(u64::MAX)
}

/// The thread: until nobody can send any more.
fn write(
    mut bag: BagWriter,
    receiver: &Receiver<Item>,
    waiting_bytes: &AtomicUsize,
) -> Result<Summary, WriteError> {
    let mut flushed_at = Instant::now();
    let mut is_clean = true;
    // By the numbers that the taps have: two may be of one topic.
    let mut topics = Vec::new();
    loop {
        match receiver.try_recv() {
            Ok(Item::Topic { name, kind, qos }) => {
                topics.push(bag.topic(&name, &kind, &qos)?);
            }
            Ok(Item::Message { topic, time_ns, bytes, encode }) => {
                let payload = encode();
                waiting_bytes.fetch_sub(bytes, Ordering::Relaxed);
                if let Some(payload) = payload {
                    bag.write(topics[topic], time_ns, time_ns, &payload)?;
                }
                is_clean = false;
            }
            Err(TryRecvError::Empty) => std::thread::sleep(LOOK_PERIOD),
            Err(TryRecvError::Disconnected) => return bag.finish(),
        }
        if !is_clean && flushed_at.elapsed() >= FLUSH_PERIOD {
            bag.flush()?;
            (flushed_at, is_clean) = (Instant::now(), true);
        }
    }
}
