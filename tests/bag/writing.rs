//! What carom writes: read back by carom here, and by others in tests/ros.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use carom::bag::definitions;
use carom::bag::qos::Qos;
use carom::bag::read::Bag;
use carom::bag::write::{BagWriter, Options, Summary, WriteError};

use super::common::{KIND, folder, read_all, states, time};

fn written(folder: &Path, options: &Options, ks: std::ops::Range<u32>) -> Summary {
    let note = BTreeMap::from([("seed".to_owned(), "7".to_owned())]);
    let notes = vec![("carom".to_owned(), note)];
    let mut bag = BagWriter::create(folder, options.clone(), notes).expect("a new folder");
    let qos = Qos::default().to_yaml();
    let clock = bag.topic("/clock", "rosgraph_msgs/msg/Clock", &qos).expect("a known type");
    let topic = bag.topic("/circle_states", KIND, &qos).expect("a known type");
    for k in ks {
        bag.write(topic, time(k), time(k), &states(k).1).expect("room");
        if k % 10 == 0 {
            bag.write(clock, time(k), time(k), &[0, 1, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0])
                .expect("room");
        }
    }
    bag.finish().expect("room")
}

#[test]
fn what_is_written_is_read_back_without_a_fault() {
    let folder = folder("written");
    for (name, packed) in [("plain", false), ("packed", true)] {
        let path = folder.join(name);
        let options = Options { packed, ..Options::default() };
        let summary = written(&path, &options, 0..50);
        assert_eq!(summary, Summary { messages: 55, files: 1 });
        let (messages, faults) = read_all(&path);
        assert_eq!(faults, Vec::<String>::new());
        assert_eq!(messages.len(), 50);
        assert!(messages.iter().zip(0..).all(|(message, k)| message.payload == states(k).1));
        let bag = Bag::open(&path).expect("a bag");
        assert_eq!(bag.notes()[0].1["seed"], "7");
        let topic = bag.topics().iter().find(|topic| topic.kind == KIND).expect("there");
        assert_eq!(
            topic.definition.as_ref().map(|d| d.text.clone()),
            definitions::definition(KIND)
        );
        assert_eq!(Some(topic.type_hash.clone()), definitions::hash(KIND));
        assert_eq!(Qos::of_yaml(&topic.qos), Qos::default());
    }
}

#[test]
fn the_same_calls_give_the_same_bytes() {
    let folder = folder("same");
    let options = Options { packed: true, ..Options::default() };
    let bytes = ["a", "b"].map(|parent| {
        let path = folder.join(parent).join("bag");
        written(&path, &options, 0..3_000);
        let read = |name: &str| fs::read(path.join(name)).expect("a file");
        (read("bag_0.mcap"), read("metadata.yaml"))
    });
    assert!(bytes[0] == bytes[1]);
}

#[test]
fn bags_are_split_by_size_and_by_time_and_read_as_one() {
    let folder = folder("parts");
    let by_size = Options { split_bytes: Some(2_000), ..Options::default() };
    let by_time = Options { split_ns: Some(100_000_000), ..Options::default() };
    for (name, options, at_least) in [("size", by_size, 6), ("time", by_time, 10)] {
        let path = folder.join(name);
        let summary = written(&path, &options, 0..100);
        assert!(summary.files >= at_least, "{summary:?}");
        let (messages, faults) = read_all(&path);
        assert_eq!(faults, Vec::<String>::new());
        assert!(messages.iter().zip(0..100).all(|(message, k)| message.payload == states(k).1));
        assert_eq!(messages.len(), 100);
        // Every file is a bag with the notes of the whole.
        let last = path.join(format!("{name}_{}.mcap", summary.files - 1));
        let bag = Bag::open(&last).expect("a bag");
        assert_eq!((bag.faults().len(), bag.notes().len()), (0, 1));
    }
}

#[test]
fn what_was_flushed_survives_a_writer_that_is_killed() {
    let folder = folder("killed").join("bag");
    let mut bag = BagWriter::create(&folder, Options::default(), Vec::new()).expect("new");
    let topic = bag.topic("/circle_states", KIND, "").expect("a known type");
    for k in 0..20 {
        bag.write(topic, time(k), time(k), &states(k).1).expect("room");
        if k == 14 {
            bag.flush().expect("room");
        }
    }
    // As a killed process does: nothing is closed.
    std::mem::forget(bag);
    let (messages, faults) = read_all(&folder);
    assert_eq!(messages.len(), 15);
    assert!(faults.iter().any(|fault| fault.contains("not closed")), "{faults:?}");
    let end = format!("the message of {}.140000000 s", time(0) / 1_000_000_000);
    assert!(faults.iter().any(|fault| fault.contains(&end)), "{faults:?}");
}

#[test]
fn nothing_is_overwritten_and_unknown_types_are_refused() {
    let folder = folder("refused");
    let again = BagWriter::create(&folder, Options::default(), Vec::new());
    assert!(matches!(again, Err(WriteError::Exists(_))));
    let mut bag =
        BagWriter::create(&folder.join("a"), Options::default(), Vec::new()).expect("new");
    let unknown = bag.topic("/image", "sensor_msgs/msg/Image", "");
    assert!(matches!(unknown, Err(WriteError::UnknownType { .. })));
    let twice = ["a", "b", "a"].map(|name| bag.topic(name, KIND, "").expect("known"));
    assert_eq!(twice, [0, 1, 0]);
    assert_eq!(bag.finish().expect("room"), Summary { messages: 0, files: 1 });
    let (messages, faults) = read_all(&folder.join("a"));
    assert!(messages.is_empty() && faults.is_empty(), "{faults:?}");
}

#[test]
fn hashes_of_types_are_those_that_others_compute() {
    // By rosbags 0.11.9, a line for each type: its `Typestore.hash_rihs01`, Kilted.
    let theirs: BTreeMap<&str, &str> = include_str!("hashes.txt")
        .lines()
        .map(|line| line.split_once(' ').expect("a name and a hash"))
        .collect();
    assert_eq!(theirs.len(), definitions::kinds().count());
    for kind in definitions::kinds() {
        assert_eq!(definitions::hash(kind).as_deref(), theirs.get(kind).copied(), "{kind}");
    }
}

#[test]
fn qualities_of_service_are_read_from_every_version() {
    let qos = Qos { depth: 3, reliable: false, transient_local: true };
    assert_eq!(Qos::of_yaml(&qos.to_yaml()), qos);
    let numbers = "- history: 1\n  depth: 3\n  reliability: 2\n  durability: 1\n";
    assert_eq!(Qos::of_yaml(numbers), qos);
    assert_eq!(Qos::of_yaml(""), Qos::default());
}
