//! The tables of a database as rosbag2 makes them.

use std::path::Path;

use rusqlite::Connection;

/// A new one, with one topic of circle states, whose id is 1.
pub fn database(path: &Path, topic: &str) -> Connection {
    let database = Connection::open(path).expect("a new file");
    database
        .execute_batch(
            "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL, \
             serialization_format TEXT NOT NULL, offered_qos_profiles TEXT NOT NULL);\
             CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, \
             timestamp INTEGER NOT NULL, data BLOB NOT NULL);\
             CREATE INDEX timestamp_idx ON messages (timestamp ASC);",
        )
        .expect("tables");
    let row = "INSERT INTO topics VALUES (1, ?1, 'carom/msg/CircleStates', 'cdr', '')";
    database.execute(row, [topic]).expect("a row");
    database
}

/// One message of that topic, recorded at a time in ns.
pub fn insert(database: &Connection, time_ns: i64, payload: &[u8]) {
    let row = "INSERT INTO messages(topic_id, timestamp, data) VALUES (1, ?1, ?2)";
    database.execute(row, (time_ns, payload)).expect("a row");
}
