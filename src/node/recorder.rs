//! The recorder: what the node says and hears goes into a bag, by a thread of its own.
//!
//! The loop hands messages over and never waits: it neither encodes nor writes, nor does it wake
//! the thread, which looks every few milliseconds. Messages that are written come back, so that
//! their memory is freed where the next ones need it. What does not fit into the queue is dropped,
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

/// A message that waits to be encoded.
trait Content: Send {
    /// Its payload; whether there is one.
    fn encode(&self, into: &mut Vec<u8>) -> bool;
}

struct Encoded(Vec<u8>);

impl Content for Encoded {
    fn encode(&self, into: &mut Vec<u8>) -> bool {
        into.extend_from_slice(&self.0);
        true
    }
}

struct Plain<M>(M);

impl<M: Serialize + Send> Content for Plain<M> {
    fn encode(&self, into: &mut Vec<u8>) -> bool {
        decode::payload_into(&self.0, into).is_ok()
    }
}

impl Content for Entry {
    fn encode(&self, into: &mut Vec<u8>) -> bool {
        let text = serde_json::to_string(self);
        text.is_ok_and(|text| decode::payload_into(&text, into).is_ok())
    }
}

enum Item {
    Topic { name: String, kind: String, qos: String },
    Message { topic: usize, time_ns: u64, bytes: usize, content: Box<dyn Content> },
}

/// Hands messages to the thread that writes them. Clones write into the same bag.
#[derive(Clone)]
pub struct Recorder(Rc<Shared>);

struct Shared {
    /// Nothing when the bag is closed.
    sender: RefCell<Option<Sender<Item>>>,
    /// Messages that were written.
    written: Receiver<Box<dyn Content>>,
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
    ///
    /// # Errors
    /// [`WriteError`] where there can be no bag.
    pub fn open(folder: &Path, options: Options, notes: Vec<Note>) -> Result<Self, WriteError> {
        let bag = BagWriter::create(folder, options, notes)?;
        let (sender, receiver) = channel();
        let (give_back, written) = channel();
        let (waiting_bytes, failure) = (Arc::new(AtomicUsize::new(0)), Arc::new(OnceLock::new()));
        let thread = {
            let (waiting_bytes, failure) = (waiting_bytes.clone(), failure.clone());
            std::thread::Builder::new().name("carom-record".to_owned()).spawn(move || {
                let outcome = write(bag, &receiver, &give_back, &waiting_bytes);
                if let Err(error) = &outcome {
                    // It is set nowhere else.
                    let _ = failure.set(error.to_string());
                }
                outcome
            })
        };
        let thread =
            thread.map_err(|error| WriteError::Output { path: folder.to_owned(), error })?;
        Ok(Self(Rc::new(Shared {
            sender: RefCell::new(Some(sender)),
            written,
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
        self.put(topic, 0, Box::new(entry));
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
    ///
    /// # Errors
    /// [`WriteError`] where it could not be written to the end.
    pub fn close(&self) -> Result<Summary, WriteError> {
        self.0.sender.borrow_mut().take();
        let thread = self.0.thread.borrow_mut().take();
        // A thread that has panicked has said so itself.
        thread.and_then(|thread| thread.join().ok()).unwrap_or_else(|| Ok(Summary::default()))
    }

    fn put(&self, topic: usize, content_bytes: usize, content: Box<dyn Content>) {
        let shared = &*self.0;
        shared.written.try_iter().for_each(drop);
        let bytes = content_bytes + MESSAGE_BYTES;
        let waiting = shared.waiting_bytes.load(Ordering::Relaxed);
        if waiting + bytes > WAITING_BYTES_MAX || shared.failure.get().is_some() {
            shared.dropped.set(shared.dropped.get() + 1);
            shared.untold.set(shared.untold.get() + 1);
            return;
        }
        shared.waiting_bytes.fetch_add(bytes, Ordering::Relaxed);
        self.send(Item::Message { topic, time_ns: now_ns(), bytes, content });
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
        self.recorder.put(self.topic, content_bytes, Box::new(Plain(message)));
    }

    /// Records a payload that is encoded already.
    pub fn record_payload(&self, payload: Vec<u8>) {
        self.recorder.put(self.topic, payload.len(), Box::new(Encoded(payload)));
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
    give_back: &Sender<Box<dyn Content>>,
    waiting_bytes: &AtomicUsize,
) -> Result<Summary, WriteError> {
    let mut flushed_at = Instant::now();
    let mut is_clean = true;
    // By the numbers that the taps have: two may be of one topic.
    let mut topics = Vec::new();
    let mut payload = Vec::new();
    loop {
        match receiver.try_recv() {
            Ok(Item::Topic { name, kind, qos }) => {
                topics.push(bag.topic(&name, &kind, &qos)?);
            }
            Ok(Item::Message { topic, time_ns, bytes, content }) => {
                payload.clear();
                let is_encoded = content.encode(&mut payload);
                // The loop may have ended.
                let _ = give_back.send(content);
                waiting_bytes.fetch_sub(bytes, Ordering::Relaxed);
                if is_encoded {
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
