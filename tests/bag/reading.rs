//! What a whole bag holds, in every storage.

use std::fs;

use carom::bag::decode::{self, BadPayload};
use carom::bag::read::{Bag, Message};
use carom::messages::CircleStates;
use mcap::Compression;

use super::common::{KIND, folder, mcap_bytes, read_all, sqlite, states, time};

fn assert_holds(messages: &[Message], ks: std::ops::Range<u32>) {
    assert_eq!(messages.len(), ks.len());
    for (message, k) in messages.iter().zip(ks) {
        assert_eq!(message.log_time_ns, time(k));
        let read: CircleStates = decode::message(&message.payload).expect("a message");
        assert_eq!(read, states(k).0);
    }
}

#[test]
fn a_single_mcap_file_is_a_bag_however_it_is_packed() {
    let folder = folder("packed");
    for (name, packed) in
        [("none", None), ("zstd", Some(Compression::Zstd)), ("lz4", Some(Compression::Lz4))]
    {
        let path = folder.join(format!("{name}.mcap"));
        fs::write(&path, mcap_bytes(0..40, packed)).expect("a file");
        let bag = Bag::open(&path).expect("a bag");
        assert_eq!(bag.count(), Some(41));
        let topic = &bag.topics()[0];
        assert_eq!((topic.name.as_str(), topic.kind.as_str()), ("/circle_states", KIND));
        assert_eq!((topic.count, topic.qos.as_str()), (Some(40), "- history: keep_last\n"));
        let definition = topic.definition.as_ref().expect("a definition");
        assert_eq!(definition.text, "std_msgs/Header header\n");
        assert_eq!(bag.notes()[0].1["seed"], "7");
        let (messages, faults) = read_all(&path);
        assert_holds(&messages, 0..40);
        assert_eq!(messages[3].publish_time_ns, time(3) - 1);
        // The other topic has no schema, which is said and does no harm.
        assert!(faults.len() == 1 && faults[0].contains("/other"), "{faults:?}");
    }
}

#[test]
fn a_database_is_a_bag_and_gets_no_file_beside_it() {
    let folder = folder("sqlite");
    let path = folder.join("of 100 % and #1?.db3");
    sqlite(&path, 0..2_500);
    let before = fs::read(&path).expect("a file");
    let (messages, faults) = read_all(&path);
    assert_holds(&messages, 0..2_500);
    assert!(faults[0].contains("without a definition"), "{faults:?}");
    assert_eq!(fs::read(&path).expect("a file"), before);
    assert_eq!(fs::read_dir(&folder).expect("a folder").count(), 1);
}

#[test]
fn files_of_a_split_bag_come_in_order() {
    let folder = folder("split");
    for (number, ks) in [(10, 20..30), (2, 10..20), (0, 0..10)] {
        let path = folder.join(format!("split_{number}.mcap"));
        fs::write(path, mcap_bytes(ks, None)).expect("a file");
    }
    let (messages, faults) = read_all(&folder);
    assert_holds(&messages, 0..30);
    assert!(faults.iter().any(|fault| fault.contains("metadata.yaml: is missing")), "{faults:?}");
    assert_eq!(Bag::open(&folder).expect("a bag").topics()[0].count, Some(30));
}

#[test]
fn progress_rises_to_the_size_of_the_bag() {
    let folder = folder("progress");
    fs::write(folder.join("a.mcap"), mcap_bytes(0..50, None)).expect("a file");
    sqlite(&folder.join("b.db3"), 50..1_200);
    let bag = Bag::open(&folder).expect("a bag");
    let mut messages = bag.messages(|_| true);
    let mut last = 0;
    while let Some(next) = messages.next() {
        assert!(next.is_ok());
        assert!(messages.bytes_read() >= last && messages.bytes_read() <= bag.size());
        last = messages.bytes_read();
    }
    assert_eq!(messages.bytes_read(), bag.size());
}

#[test]
fn payloads_come_in_either_order_of_bytes() {
    let (message, payload) = states(2);
    let mut turned = vec![0, 0, 0, 0];
    let body = cdr_encoding::to_vec::<_, byteorder::BigEndian>(&message).expect("a message");
    turned.extend(body);
    assert_ne!(turned, payload);
    assert_eq!(decode::message::<CircleStates>(&turned), Ok(message));
}

#[test]
fn payloads_that_are_none_are_errors() {
    let (message, payload) = states(1);
    for end in 0..payload.len() {
        assert!(decode::message::<CircleStates>(&payload[..end]).is_err(), "{end}");
    }
    let longer = |by: usize| [payload.clone(), vec![0; by]].concat();
    assert_eq!(decode::message(&longer(7)), Ok(message));
    let error = decode::message::<CircleStates>(&longer(8));
    assert_eq!(error, Err(BadPayload::Long(8)));
    let mut other = payload.clone();
    other[1] = 6;
    assert_eq!(decode::message::<CircleStates>(&other), Err(BadPayload::Encoding(6)));
    // A count that no memory could hold.
    let mut huge = payload.clone();
    assert_eq!(huge[28..32], [2, 0, 0, 0]);
    huge[28..32].fill(0xff);
    assert!(decode::message::<CircleStates>(&huge).is_err());
}
