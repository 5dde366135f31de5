//! The thread that records: in order, and with what it had no room for noted at its place.

use carom::bag::journal::Entry;
use carom::bag::read::Bag;
use carom::bag::write::Options;
use carom::bag::{decode, qos::Qos};
use carom::messages::{Clock, Time};
use carom::node::recorder::Recorder;

use super::common::folder;

fn clock(sec: i32) -> Clock {
    Clock { clock: Time { sec, nanosec: 0 } }
}

#[test]
fn what_finds_no_room_is_counted_and_noted_at_its_place() {
    let path = folder("recorder").join("bag");
    let recorder = Recorder::open(&path, Options::default(), Vec::new()).expect("a new folder");
    recorder.keep_journal("/journal");
    let qos = Qos::default().to_yaml();
    let taps = ["/clock", "/clock"].map(|name| recorder.tap(name, "rosgraph_msgs/msg/Clock", &qos));
    taps[0].record(&clock(1));
    // More than the queue holds, so that there is no room for what comes before it is written.
    let image = recorder.tap("/image", "std_msgs/msg/String", &qos);
    image.record_payload(&vec![0; 65 << 20]);
    taps[0].record(&clock(2));
    taps[1].record(&clock(3));
    recorder.hand_over();
    let start = std::time::Instant::now();
    let dropped = loop {
        let dropped = recorder.dropped();
        taps[1].record(&clock(4));
        if recorder.dropped() == dropped {
            break dropped;
        }
        assert!(start.elapsed().as_secs() < 60, "it is never written");
        std::thread::sleep(std::time::Duration::from_millis(1));
    };
    recorder.journal(Entry::Forget {});
    recorder.journal(Entry::Forget {});
    assert!(dropped >= 2);
    assert_eq!(recorder.dropped(), dropped);
    let summary = recorder.close().expect("room");
    assert_eq!((summary.messages, recorder.failure()), (6, None));
    let bag = Bag::open(&path).expect("a bag");
    assert_eq!((bag.topics().len(), bag.faults().len()), (3, 0));
    let messages: Vec<(String, Vec<u8>)> = bag
        .messages(|topic| topic.name != "/image")
        .map(|message| message.expect("sound"))
        .map(|message| (bag.topics()[message.topic].name.clone(), message.payload))
        .collect();
    let clocks: Vec<Clock> = messages[..2]
        .iter()
        .map(|(_, payload)| decode::message(payload).expect("a clock"))
        .collect();
    assert_eq!(clocks, [clock(1), clock(4)]);
    let entries: Vec<Entry> = messages[2..]
        .iter()
        .map(|(_, payload)| decode::message::<String>(payload).expect("a text"))
        .map(|text| serde_json::from_str(&text).expect("an entry"))
        .collect();
    let dropped = Entry::Dropped { messages: dropped };
    assert_eq!(entries, [dropped, Entry::Forget {}, Entry::Forget {}]);
}

#[test]
fn a_bag_that_cannot_be_written_ends_the_recording_and_not_the_run() {
    let path = folder("recorder_full").join("bag");
    let recorder = Recorder::open(&path, Options::default(), Vec::new()).expect("a new folder");
    let unknown = recorder.tap("/image", "sensor_msgs/msg/Image", "");
    let known = recorder.tap("/clock", "rosgraph_msgs/msg/Clock", "");
    recorder.hand_over();
    let start = std::time::Instant::now();
    while recorder.failure().is_none() && start.elapsed().as_secs() < 10 {
        std::thread::sleep(std::time::Duration::from_millis(1));
    }
    assert!(recorder.failure().is_some_and(|why| why.contains("sensor_msgs/msg/Image")));
    unknown.record(&clock(1));
    known.record(&clock(2));
    assert_eq!(recorder.dropped(), 2);
    assert!(recorder.close().is_err());
}
