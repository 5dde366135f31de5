//! The recorder: what the node says and hears goes into a bag, by a thread of its own.
//!
//! The loop never waits and does little. Messages of several turns of the loop are gathered in a
//! batch and handed over; the thread is not woken, it looks now and then, and batches come back to
//! be filled again. It does much at a time and seldom: each time it leaves a loop on the same
//! processor with cold caches. The pucks are not written down at each tick: the thread is told
//! who [turned](crate::motion::watch) and makes the message of it. What does not fit into the queue
//! is dropped, counted, and noted in the bag at its place.

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
use crate::messages::{Header, Time};
use crate::motion::watch::{Listener, Look, Turn, Watcher};
use crate::publish;
use crate::world::Contact;

/// Bytes of messages that wait; beyond them new ones are dropped.
const WAITING_BYTES_MAX: usize = 64 << 20;
/// What a message that waits takes besides its content, bytes.
const MESSAGE_BYTES: usize = 256;
/// A batch with so many bytes is handed over at once, else so often.
const BATCH_BYTES: usize = 1 << 20;
const HAND_OVER_PERIOD: Duration = Duration::from_millis(200);
/// A batch waits so long at most, even if nothing else wakes the loop.
const HAND_OVER_LATEST: Duration = Duration::from_millis(250);
/// The thread looks for messages so often.
const LOOK_PERIOD: Duration = Duration::from_millis(50);
/// A chunk is written at least so often: in all, half a second is lost when the node is killed.
const FLUSH_PERIOD: Duration = Duration::from_millis(200);

/// Messages of a few turns of the loop.
#[derive(Default)]
struct Batch {
    items: Vec<Item>,
    /// Payloads of messages that are encoded, and frames of others, one behind the other.
    payloads: Vec<u8>,
    turns: Vec<Turn>,
    contacts: Vec<Contact>,
    bytes: usize,
}

enum Item {
    Topic { name: String, kind: String, qos: String },
    Message { topic: usize, time_ns: u64, content: Content },
}

enum Content {
    /// The next so many bytes of the payloads.
    Encoded(usize),
    Journal(Entry),
    /// The pucks at an instant, with the next turns.
    States(Head, Look),
    /// The next so many contacts, on the way there.
    Contacts(Head, usize),
}

/// A header, with the next so many bytes of the payloads as its frame.
struct Head {
    stamp: Time,
    frame_bytes: usize,
}

/// Hands messages to the thread that writes them. Clones write into the same bag.
#[derive(Clone)]
pub struct Recorder(Rc<Shared>);

struct Shared {
    /// Nothing when the bag is closed.
    sender: RefCell<Option<Sender<Batch>>>,
    /// Batches that were written.
    written: Receiver<Batch>,
    /// The one that is being filled.
    batch: RefCell<Batch>,
    handed_over_at: Cell<Instant>,
    watcher: RefCell<Watcher>,
    progress: Arc<Progress>,
    topics: Cell<usize>,
    journal: Cell<Option<usize>>,
    dropped: Cell<u64>,
    /// Of those, the ones that the journal does not know yet.
    untold: Cell<u64>,
    thread: RefCell<Option<JoinHandle<Result<Summary, WriteError>>>>,
}

/// How far the thread is.
#[derive(Default)]
struct Progress {
    /// Handed over, and not yet written.
    waiting_bytes: AtomicUsize,
    failure: OnceLock<String>,
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
        let progress = Arc::new(Progress::default());
        let thread = {
            let progress = progress.clone();
            std::thread::Builder::new().name("carom-record".to_owned()).spawn(move || {
                let outcome = Writing::new(bag).run(&receiver, &give_back, &progress);
                if let Err(error) = &outcome {
                    // It is set nowhere else.
                    let _ = progress.failure.set(error.to_string());
                }
                outcome
            })
        };
        let thread =
            thread.map_err(|error| WriteError::Output { path: folder.to_owned(), error })?;
        Ok(Self(Rc::new(Shared {
            sender: RefCell::new(Some(sender)),
            written,
            batch: RefCell::default(),
            handed_over_at: Cell::new(Instant::now()),
            watcher: RefCell::default(),
            progress,
            topics: Cell::new(0),
            journal: Cell::new(None),
            dropped: Cell::new(0),
            untold: Cell::new(0),
            thread: RefCell::new(Some(thread)),
        })))
    }

    /// One more topic, by its whole name, of a type that is known.
    pub fn tap(&self, name: &str, kind: &str, qos: &str) -> Tap {
        let topic = self.0.topics.get();
        self.0.topics.set(topic + 1);
        let (name, kind, qos) = (name.to_owned(), kind.to_owned(), qos.to_owned());
        self.0.batch.borrow_mut().items.push(Item::Topic { name, kind, qos });
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
            self.put(topic, |_| Some(Content::Journal(Entry::Dropped { messages: untold })));
        }
        self.put(topic, |_| Some(Content::Journal(entry)));
    }

    /// Messages that found no room, since the start.
    pub fn dropped(&self) -> u64 {
        self.0.dropped.get()
    }

    /// Why nothing is recorded any more, if that is so.
    pub fn failure(&self) -> Option<&str> {
        self.0.progress.failure.get().map(String::as_str)
    }

    /// Hands over what was gathered, if that is much or some time ago.
    pub fn hand_over_if_due(&self, now: Instant) {
        let waits = now.saturating_duration_since(self.0.handed_over_at.get()) < HAND_OVER_PERIOD;
        if !waits || self.0.batch.borrow().bytes >= BATCH_BYTES {
            self.0.handed_over_at.set(now);
            self.hand_over();
        }
    }

    /// When it is to be done at the latest.
    pub fn due(&self) -> Option<Instant> {
        let waits = !self.0.batch.borrow().items.is_empty();
        waits.then(|| self.0.handed_over_at.get() + HAND_OVER_LATEST)
    }

    /// Hands over what was gathered.
    pub fn hand_over(&self) {
        let shared = &*self.0;
        if shared.batch.borrow().items.is_empty() {
            return;
        }
        // Only cleared: its memory is warm.
        let empty = shared.written.try_iter().last().unwrap_or_default();
        let batch = shared.batch.replace(empty);
        shared.progress.waiting_bytes.fetch_add(batch.bytes, Ordering::Relaxed);
        if let Some(sender) = &*shared.sender.borrow() {
            // After a failure nobody receives; that is told by itself.
            let _ = sender.send(batch);
        }
    }

    /// Closes the bag; what it then holds.
    ///
    /// # Errors
    /// [`WriteError`] where it could not be written to the end.
    pub fn close(&self) -> Result<Summary, WriteError> {
        self.hand_over();
        self.0.sender.borrow_mut().take();
        let thread = self.0.thread.borrow_mut().take();
        // A thread that has panicked has said so itself.
        thread.and_then(|thread| thread.join().ok()).unwrap_or_else(|| Ok(Summary::default()))
    }

    /// Puts a message into the batch, if there is room: of its content only what can be written.
    fn put(&self, topic: usize, content: impl FnOnce(&mut Batch) -> Option<Content>) {
        let shared = &*self.0;
        let batch = &mut *shared.batch.borrow_mut();
        let waiting = shared.progress.waiting_bytes.load(Ordering::Relaxed) + batch.bytes;
        if waiting > WAITING_BYTES_MAX || shared.progress.failure.get().is_some() {
            shared.dropped.set(shared.dropped.get() + 1);
            shared.untold.set(shared.untold.get() + 1);
            return;
        }
        if let Some(content) = content(batch) {
            batch.bytes += MESSAGE_BYTES + content.bytes();
            batch.items.push(Item::Message { topic, time_ns: now_ns(), content });
        }
    }
}

impl Content {
    fn bytes(&self) -> usize {
        match self {
            Self::Encoded(bytes) => *bytes,
            Self::Journal(_) => 0,
            Self::States(_, look) => look.bytes(),
            Self::Contacts(_, count) => count * size_of::<Contact>(),
        }
    }
}

impl Tap {
    /// Records a message.
    pub fn record<M: Serialize>(&self, message: &M) {
        self.recorder.put(self.topic, |Batch { payloads, .. }| {
            let before = payloads.len();
            let is_encoded = decode::payload_into(message, payloads).is_ok();
            payloads.truncate(if is_encoded { payloads.len() } else { before });
            is_encoded.then(|| Content::Encoded(payloads.len() - before))
        });
    }

    /// Records a payload that is encoded already.
    pub fn record_payload(&self, payload: &[u8]) {
        self.recorder.put(self.topic, |batch| {
            batch.payloads.extend_from_slice(payload);
            Some(Content::Encoded(payload.len()))
        });
    }

    /// Records contacts of an arena, with stamp and frame.
    pub fn record_contacts(&self, header: (Time, &str), contacts: &[Contact]) {
        self.recorder.put(self.topic, |batch| {
            batch.contacts.extend_from_slice(contacts);
            Some(Content::Contacts(batch.head(header), contacts.len()))
        });
    }

    /// Records the pucks of an arena as they are now, if somebody looks at it: with stamp and
    /// frame.
    pub fn record_states(
        &self,
        header: (Time, &str),
        look: impl FnOnce(&mut Watcher, &mut Vec<Turn>) -> Option<Look>,
    ) {
        self.recorder.put(self.topic, |batch| {
            let watcher = &mut self.recorder.0.watcher.borrow_mut();
            let look = look(watcher, &mut batch.turns)?;
            Some(Content::States(batch.head(header), look))
        });
    }
}

impl Batch {
    fn head(&mut self, (stamp, frame_id): (Time, &str)) -> Head {
        self.payloads.extend_from_slice(frame_id.as_bytes());
        Head { stamp, frame_bytes: frame_id.len() }
    }

    /// It was written.
    fn clear(&mut self) {
        self.payloads.clear();
        self.turns.clear();
        self.contacts.clear();
        self.bytes = 0;
    }
}

/// What of a batch is still to be written.
struct Rest<'a> {
    payloads: &'a [u8],
    turns: &'a [Turn],
    contacts: &'a [Contact],
}

impl<'a> Rest<'a> {
    fn payload(&mut self, bytes: usize) -> &'a [u8] {
        split_off(&mut self.payloads, bytes)
    }

    fn header(&mut self, Head { stamp, frame_bytes }: Head) -> Header {
        let frame_id = String::from_utf8_lossy(self.payload(frame_bytes)).into_owned();
        Header { stamp, frame_id }
    }
}

/// The first so many.
fn split_off<'a, T>(all: &mut &'a [T], count: usize) -> &'a [T] {
    let (first, rest) = all.split_at(count);
    *all = rest;
    first
}

fn now_ns() -> u64 {
    let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    u64::try_from(since.as_nanos()).unwrap_or(u64::MAX)
}

/// What the thread does.
struct Writing {
    bag: BagWriter,
    /// By the numbers that the taps have: two may be of one topic.
    topics: Vec<usize>,
    listener: Listener,
    payload: Vec<u8>,
    flushed_at: Instant,
    is_clean: bool,
}

impl Writing {
    fn new(bag: BagWriter) -> Self {
        Self {
            bag,
            topics: Vec::new(),
            listener: Listener::default(),
            payload: Vec::new(),
            flushed_at: Instant::now(),
            is_clean: true,
        }
    }

    /// Until nobody can hand over any more.
    fn run(
        mut self,
        receiver: &Receiver<Batch>,
        give_back: &Sender<Batch>,
        progress: &Progress,
    ) -> Result<Summary, WriteError> {
        loop {
            match receiver.try_recv() {
                Ok(mut batch) => {
                    self.write(&mut batch)?;
                    progress.waiting_bytes.fetch_sub(batch.bytes, Ordering::Relaxed);
                    batch.clear();
                    // The loop may have ended.
                    let _ = give_back.send(batch);
                }
                Err(TryRecvError::Empty) => std::thread::sleep(LOOK_PERIOD),
                Err(TryRecvError::Disconnected) => return self.bag.finish(),
            }
            if !self.is_clean && self.flushed_at.elapsed() >= FLUSH_PERIOD {
                self.bag.flush()?;
                (self.flushed_at, self.is_clean) = (Instant::now(), true);
            }
        }
    }

    fn write(&mut self, batch: &mut Batch) -> Result<(), WriteError> {
        let Batch { items, payloads, turns, contacts, .. } = batch;
        let mut rest = Rest { payloads, turns, contacts };
        for item in items.drain(..) {
            let (topic, time_ns, content) = match item {
                Item::Topic { name, kind, qos } => {
                    self.topics.push(self.bag.topic(&name, &kind, &qos)?);
                    continue;
                }
                Item::Message { topic, time_ns, content } => (topic, time_ns, content),
            };
            let payload = match content {
                Content::Encoded(bytes) => rest.payload(bytes),
                Content::Journal(entry) => {
                    // Of a type that JSON and CDR have.
                    let text = serde_json::to_string(&entry).unwrap_or_default();
                    encoded(&text, &mut self.payload)
                }
                Content::States(head, look) => {
                    let header = rest.header(head);
                    let turns = split_off(&mut rest.turns, look.turns());
                    let discs = self.listener.hear(look, turns);
                    let message = publish::arena_states(header, discs);
                    encoded(&message, &mut self.payload)
                }
                Content::Contacts(head, count) => {
                    let header = rest.header(head);
                    let contacts = split_off(&mut rest.contacts, count);
                    encoded(&publish::contacts(header, contacts), &mut self.payload)
                }
            };
            self.bag.write(self.topics[topic], time_ns, time_ns, payload)?;
            self.is_clean = false;
        }
        Ok(())
    }
}

fn encoded<'a, M: Serialize>(message: &M, payload: &'a mut Vec<u8>) -> &'a [u8] {
    payload.clear();
    // Its type is ours, and CDR has it.
    decode::payload_into(message, payload).expect("a message of carom");
    payload
}
