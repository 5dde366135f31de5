//! Small bags, made with the `mcap` crate and with SQLite and not with carom's own writer: that one
//! is judged by others.

use std::collections::BTreeMap;
use std::fs;
use std::io::Cursor;
use std::path::{Path, PathBuf};

use carom::bag::read::{Bag, Message};
use carom::messages::{CircleState, CircleStates, Header, Time};
use mcap::records::{MessageHeader, Metadata};
use mcap::{Compression, WriteOptions};

use crate::database::{database, insert};

pub const KIND: &str = "carom/msg/CircleStates";

/// A folder of its own for a test, empty.
pub fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("bag").join(name);
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).expect("cargo's scratch directory is writable");
    folder
}

/// The k-th message, and its payload with the lowest byte first.
pub fn states(k: u32) -> (CircleStates, Vec<u8>) {
    let circle = |id| CircleState {
        id,
        x: f64::from(k) + 0.25,
        y: -1.0 / 3.0,
        vx: 1.0,
        vy: f64::from(id),
        radius: 0.1,
        mass: 2.0,
    };
    let stamp = Time { sec: k as i32, nanosec: 5 };
    let message = CircleStates {
        header: Header { stamp, frame_id: "map".to_owned() },
        circles: (1..=k % 3 + 1).map(circle).collect(),
        ..CircleStates::default()
    };
    let mut payload = vec![0, 1, 0, 0];
    let body = cdr_encoding::to_vec::<_, byteorder::LittleEndian>(&message).expect("a message");
    payload.extend(body);
    (message, payload)
}

/// The log time of the k-th message, ns.
pub fn time(k: u32) -> u64 {
    1_700_000_000_000_000_000 + u64::from(k) * 10_000_000
}

/// An MCAP file of messages k on `circle_states`, a note, and a message on `other` at the end.
pub fn mcap_bytes(ks: std::ops::Range<u32>, compression: Option<Compression>) -> Vec<u8> {
    let options = WriteOptions::new().profile("ros2").compression(compression);
    let options = options.chunk_size(Some(400)).compression_threads(0);
    let mut writer = options.create(Cursor::new(Vec::new())).expect("memory");
    let note = BTreeMap::from([("seed".to_owned(), "7".to_owned())]);
    let note = Metadata { name: "carom".to_owned(), metadata: note };
    writer.write_metadata(&note).expect("memory");
    let definition = b"std_msgs/Header header\n".as_slice();
    let schema = writer.add_schema(KIND, "ros2msg", definition).expect("memory");
    let offered = "- history: keep_last\n".to_owned();
    let said = BTreeMap::from([("offered_qos_profiles".to_owned(), offered)]);
    let states_id = writer.add_channel(schema, "/circle_states", "cdr", &said).expect("memory");
    let other_id = writer.add_channel(0, "/other", "cdr", &BTreeMap::new()).expect("memory");
    let end = ks.end;
    for k in ks {
        let header = header(states_id, k);
        writer.write_to_known_channel(&header, &states(k).1).expect("memory");
    }
    writer.write_to_known_channel(&header(other_id, end), &[1, 2, 3]).expect("memory");
    writer.finish().expect("memory");
    writer.into_inner().into_inner()
}

fn header(channel_id: u16, k: u32) -> MessageHeader {
    MessageHeader { channel_id, sequence: k, log_time: time(k), publish_time: time(k) - 1 }
}

/// A database as rosbag2 makes them.
pub fn sqlite(path: &Path, ks: std::ops::Range<u32>) {
    let database = database(path, "/circle_states");
    for k in ks {
        insert(&database, i64::try_from(time(k)).expect("before 2262"), &states(k).1);
    }
}

/// All that can be read of a bag: messages, and what was wrong.
pub fn read_all(path: &Path) -> (Vec<Message>, Vec<String>) {
    let bag = match Bag::open(path) {
        Ok(bag) => bag,
        Err(error) => return (Vec::new(), vec![error.to_string()]),
    };
    let mut faults: Vec<String> = bag.faults().iter().map(ToString::to_string).collect();
    let mut messages = Vec::new();
    for next in bag.messages(|topic| topic.kind == KIND) {
        match next {
            Ok(message) => messages.push(message),
            Err(error) => faults.push(error.to_string()),
        }
    }
    (messages, faults)
}
