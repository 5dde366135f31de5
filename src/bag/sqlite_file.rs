//! sqlite3, the storage of older ROS 2: topics and messages are rows.
//!
//! The database is opened read-only and as one that nobody changes, so that SQLite makes no file
//! beside it; what a writer left in its `-wal` is not read, and that is said. Rows come in batches:
//! memory is that of one batch.

use std::collections::{BTreeMap, HashMap, VecDeque};
use std::path::Path;

use rusqlite::types::ValueRef;
use rusqlite::{Connection, OpenFlags, Row};

use super::fault::Fault;
use super::files;
use super::read::{Definition, Stored, Topic, Wanted};

/// Rows of a batch, and bytes after which it is full.
const BATCH_ROWS: usize = 1_000;
const BATCH_BYTES: usize = 8 << 20;

/// What a database holds.
#[derive(Debug, Default)]
pub struct Index {
    /// Topics by their ids.
    pub topics: BTreeMap<i64, Topic>,
    /// What is wrong with it.
    pub faults: Vec<Fault>,
}

/// A database that is being read.
pub struct SqliteReader {
    connection: Connection,
    batch: VecDeque<(i64, Result<Stored, Fault>)>,
    last_id: i64,
    ended: bool,
    size: u64,
    last_id_of_all: i64,
    is_stranger_told: bool,
}

/// Reads what a database says that it holds.
///
/// # Errors
/// [`Fault::Unreadable`]; [`Fault::NotABag`] of a database that is no recording.
pub fn index(path: &Path) -> Result<Index, Fault> {
    let connection = open(path)?;
    for table in ["topics", "messages"] {
        if !is_table(&connection, table).map_err(|error| damaged(0, &error))? {
            let what = format!("is a database without the table `{table}` of a recording");
            return Err(Fault::NotABag(what));
        }
    }
    let mut index = Index::default();
    if files::holds_anything(path, "-wal") {
        let what = "was not closed: what its -wal file holds is left out";
        index.faults.push(Fault::Missing(what.to_owned()));
    }
    let definitions = definitions(&connection).unwrap_or_default();
    topics(&connection, &definitions, &mut index).map_err(|error| damaged(0, &error))?;
    for topic in index.topics.values().filter(|topic| topic.definition.is_none()) {
        let Topic { name, kind, .. } = topic;
        let what = format!("topic {name} comes without a definition of its type `{kind}`");
        index.faults.push(Fault::Missing(what));
    }
    Ok(index)
}

fn damaged(at: i64, error: &rusqlite::Error) -> Fault {
    Fault::Damaged { at: at.max(0).unsigned_abs(), what: error.to_string() }
}

fn open(path: &Path) -> Result<Connection, Fault> {
    let path = files::absolute(path).map_err(Fault::Unreadable)?;
    let Some(text) = path.to_str() else {
        return Err(Fault::NotABag("has a name that is no text".to_owned()));
    };
    let name = text.replace('%', "%25").replace('?', "%3f").replace('#', "%23");
    let flags = OpenFlags::SQLITE_OPEN_READ_ONLY
        | OpenFlags::SQLITE_OPEN_URI
        | OpenFlags::SQLITE_OPEN_NO_MUTEX;
    let uri = format!("file:{name}?mode=ro&immutable=1");
    let opened = Connection::open_with_flags(uri, flags).and_then(|connection| {
        // It may be made to harm: no function of its views and triggers is trusted.
        let careful = "PRAGMA trusted_schema=OFF; PRAGMA cell_size_check=ON; \
                       PRAGMA query_only=ON; PRAGMA temp_store=MEMORY;";
        connection.execute_batch(careful)?;
        if is_table(&connection, "messages").is_err() {
            // SQLite reads no file that is shorter than it says, but in this mode, which spares
            // what is damaged; nothing can be written here.
            connection.execute_batch("PRAGMA writable_schema=ON;")?;
        }
        Ok(connection)
    });
    opened.map_err(|error| damaged(0, &error))
}

fn is_table(connection: &Connection, name: &str) -> rusqlite::Result<bool> {
    let query = "SELECT COUNT(*) FROM sqlite_schema WHERE type = 'table' AND name = ?1 \
                 AND sql NOT LIKE 'CREATE VIRTUAL%'";
    connection.query_row(query, [name], |row| row.get::<_, i64>(0)).map(|count| count > 0)
}

/// By type: newer bags have them.
fn definitions(connection: &Connection) -> rusqlite::Result<HashMap<String, Definition>> {
    let mut found = HashMap::new();
    if !is_table(connection, "message_definitions")? {
        return Ok(found);
    }
    let query = "SELECT topic_type, encoding, encoded_message_definition FROM message_definitions";
    let mut statement = connection.prepare(query)?;
    let mut rows = statement.query([])?;
    while let Some(row) = rows.next()? {
        let (format, text) = (row.get(1)?, row.get::<_, String>(2)?);
        if !text.is_empty() {
            found.insert(row.get(0)?, Definition { format, text });
        }
    }
    Ok(found)
}

fn topics(
    connection: &Connection,
    definitions: &HashMap<String, Definition>,
    index: &mut Index,
) -> rusqlite::Result<()> {
    let mut statement = connection.prepare("SELECT * FROM topics")?;
    let mut rows = statement.query([])?;
    while let Some(row) = rows.next()? {
        // Columns came with the years.
        let text = |column: &str| row.get::<_, String>(column).unwrap_or_default();
        let kind: String = row.get("type")?;
        let topic = Topic {
            name: row.get("name")?,
            encoding: text("serialization_format"),
            definition: definitions.get(&kind).cloned(),
            qos: text("offered_qos_profiles"),
            type_hash: text("type_description_hash"),
            kind,
            count: None,
        };
        index.topics.insert(row.get("id")?, topic);
    }
    Ok(())
}

impl SqliteReader {
    /// Before the first message.
    ///
    /// # Errors
    /// [`Fault::Unreadable`], [`Fault::Damaged`].
    pub fn open(path: &Path) -> Result<Self, Fault> {
        let (_, size) = files::open(path)?;
        let connection = open(path)?;
        // For the progress alone: of a file that is cut off the last row cannot be read.
        let last = connection.query_row("SELECT MAX(id) FROM messages", [], |row| row.get(0));
        let last_id_of_all: Option<i64> = last.unwrap_or_default();
        Ok(Self {
            connection,
            batch: VecDeque::new(),
            last_id: i64::MIN,
            ended: false,
            size,
            last_id_of_all: last_id_of_all.unwrap_or(0),
            is_stranger_told: false,
        })
    }

    /// About how many bytes have been read: the share of the rows.
    pub fn bytes_read(&self) -> u64 {
        let part = self.last_id.max(0) as f64 / self.last_id_of_all.max(1) as f64;
        (part.min(1.0) * self.size as f64) as u64
    }

    /// The next message that is wanted.
    pub fn next(&mut self, wanted: &Wanted) -> Option<Result<Stored, Fault>> {
        loop {
            if let Some((_, next)) = self.batch.pop_front() {
                return Some(next);
            }
            if self.ended {
                return None;
            }
            if let Err(error) = self.fill(wanted) {
                self.ended = true;
                self.batch.push_back((0, Err(damaged(self.last_id, &error))));
            }
        }
    }

    fn fill(&mut self, wanted: &Wanted) -> rusqlite::Result<()> {
        let query = "SELECT id, topic_id, timestamp, data FROM messages \
                     WHERE id > ?1 ORDER BY id LIMIT ?2";
        let mut statement = self.connection.prepare(query)?;
        let mut rows = statement.query((self.last_id, BATCH_ROWS as i64))?;
        let (mut count, mut bytes) = (0, 0);
        while let Some(row) = rows.next()? {
            let id: i64 = row.get(0)?;
            if id <= self.last_id {
                let what = "its rows are in no order".to_owned();
                self.batch.push_back((id, Err(Fault::Damaged { at: id.unsigned_abs(), what })));
                self.ended = true;
                return Ok(());
            }
            self.last_id = id;
            count += 1;
            match wanted.topic(row.get(1)?) {
                Some((topic, true)) => {
                    let stored = stored(row, id, topic);
                    bytes += stored.as_ref().map_or(0, |stored| stored.payload.len());
                    self.batch.push_back((id, stored));
                }
                None if !self.is_stranger_told => {
                    self.is_stranger_told = true;
                    let what = "messages of a topic that it does not name are left out".to_owned();
                    self.batch.push_back((id, Err(Fault::Contradicts(what))));
                }
                _ => {}
            }
            if bytes >= BATCH_BYTES {
                return Ok(());
            }
        }
        self.ended = count < BATCH_ROWS;
        Ok(())
    }
}

fn stored(row: &Row, id: i64, topic: usize) -> Result<Stored, Fault> {
    let wrong = |what: &str| Fault::Damaged { at: id.unsigned_abs(), what: what.to_owned() };
    let time: i64 = row.get(2).map_err(|_| wrong("a message without a time"))?;
    let time = u64::try_from(time).map_err(|_| wrong("a message from before 1970"))?;
    match row.get_ref(3) {
        Ok(ValueRef::Blob(payload)) => Ok(Stored {
            topic,
            log_time_ns: time,
            publish_time_ns: time,
            sequence: 0,
            payload: payload.to_vec(),
        }),
        _ => Err(wrong("a message without a payload")),
    }
}
