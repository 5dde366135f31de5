//! What is wrong with a bag is said; what can be read is read; nothing panics, hangs or changes.

use std::fs;
use std::path::Path;

use carom::bag::read::Message;
use mcap::Compression;

use super::common::{folder, mcap_bytes, read_all, sqlite};

/// The whole bag is changed in one way; it is read, and stays as it is.
fn read_changed(path: &Path, bytes: &[u8]) -> (Vec<Message>, Vec<String>) {
    fs::write(path, bytes).expect("a file");
    let read = read_all(path);
    assert!(fs::read(path).expect("a file") == bytes, "the input was changed");
    read
}

#[test]
fn every_beginning_of_an_mcap_file_gives_its_whole_chunks() {
    let folder = folder("beginnings");
    for (name, packed) in [("none", None), ("zstd", Some(Compression::Zstd))] {
        let whole = mcap_bytes(0..9, packed);
        let path = folder.join(format!("{name}.mcap"));
        let (all, _) = read_changed(&path, &whole);
        let mut most = 0;
        for end in 0..whole.len() {
            let (messages, faults) = read_changed(&path, &whole[..end]);
            assert!(!faults.is_empty() && faults[0].contains(".mcap: "), "{end}: {faults:?}");
            assert_eq!(messages, all[..messages.len()], "{end}");
            assert!(messages.len() >= most, "{end}: {} after {most}", messages.len());
            most = messages.len();
        }
        assert_eq!(most, all.len());
    }
}

#[test]
fn every_wrong_byte_of_an_mcap_file_is_noticed_or_harmless() {
    let folder = folder("bytes");
    for (name, packed) in [("none", None), ("lz4", Some(Compression::Lz4))] {
        let whole = mcap_bytes(0..5, packed);
        let path = folder.join(format!("{name}.mcap"));
        let (all, usual) = read_changed(&path, &whole);
        for at in 0..whole.len() {
            for flip in [0x01, 0x80, 0xff] {
                let mut bytes = whole.clone();
                bytes[at] ^= flip;
                let (messages, faults) = read_changed(&path, &bytes);
                // Chunks have checksums: what comes is right.
                assert!(messages.iter().all(|message| all.contains(message)), "{at}");
                assert!(messages == all || faults != usual, "{at}: messages lost, nothing said");
            }
        }
    }
}

#[test]
fn every_beginning_and_wrong_byte_of_a_database_is_an_error_or_a_part() {
    let folder = folder("database");
    let path = folder.join("a.db3");
    sqlite(&path, 0..60);
    let whole = fs::read(&path).expect("a file");
    let (all, _) = read_all(&path);
    assert_eq!(all.len(), 60);
    for end in (0..whole.len()).step_by(41) {
        let (messages, faults) = read_changed(&path, &whole[..end]);
        assert!(!faults.is_empty() && messages.len() <= all.len(), "{end}");
    }
    for at in (0..whole.len()).step_by(5) {
        let mut bytes = whole.clone();
        bytes[at] ^= 0xff;
        let (messages, _) = read_changed(&path, &bytes);
        assert!(messages.len() <= 2 * all.len(), "{at}");
    }
    assert_eq!(fs::read_dir(&folder).expect("a folder").count(), 1);
}

#[test]
fn a_wrong_chunk_is_left_out_and_the_next_is_read() {
    let folder = folder("chunk");
    let mut whole = mcap_bytes(0..30, None);
    let path = folder.join("a.mcap");
    let (all, _) = read_changed(&path, &whole);
    let place = whole.windows(8).position(|bytes| bytes == 15.25f64.to_le_bytes());
    whole[place.expect("x of message 15")] ^= 1;
    let (messages, faults) = read_changed(&path, &whole);
    assert!(messages.len() >= 25 && messages.len() < 30 && messages.last() == all.last());
    let said = faults.iter().filter(|fault| fault.contains("wrong checksum")).count();
    assert_eq!(said, 1, "{faults:?}");
}

#[test]
fn what_is_no_bag_is_refused_with_what_it_is() {
    let folder = folder("none");
    let file = |name: &str, bytes: &[u8]| {
        let path = folder.join(name);
        fs::write(&path, bytes).expect("a file");
        path
    };
    let text = file("notes.txt", b"some text that is longer than a magic\n");
    let other = folder.join("other.db3");
    rusqlite::Connection::open(&other)
        .and_then(|database| database.execute_batch("CREATE TABLE a(b)"))
        .expect("a database");
    let inner = folder.join("inner");
    fs::create_dir(&inner).expect("a folder");
    let cases = [
        (file("empty.mcap", b""), "is empty"),
        (text, "is no recording"),
        (file("short.mcap", &mcap::MAGIC[..5]), "ends within its first bytes"),
        (file("all.mcap.zstd", &[0x28, 0xb5, 0x2f, 0xfd, 0, 0, 0]), "zstd -d"),
        (other, "without the table `topics`"),
        (inner, "without a recording"),
        (folder.join("nothing"), "cannot be read"),
        ("/dev/null".into(), "neither a file nor a folder"),
    ];
    for (path, what) in cases {
        let (messages, faults) = read_all(&path);
        assert!(messages.is_empty());
        let name = path.display().to_string();
        assert!(faults.len() == 1 && faults[0].starts_with(&name), "{faults:?}");
        assert!(faults[0].contains(what), "{faults:?}: {what}");
    }
}

#[test]
fn metadata_that_contradicts_the_files_is_told_and_they_are_read() {
    let folder = folder("metadata");
    fs::write(folder.join("a.mcap"), mcap_bytes(0..12, None)).expect("a file");
    fs::write(folder.join("b.mcap"), mcap_bytes(0..3, None)).expect("a file");
    let metadata = folder.join("metadata.yaml");
    let text = r"rosbag2_bagfile_information:
  version: 9
  storage_identifier: mcap
  message_count: 99
  topics_with_message_count:
    - topic_metadata:
        name: /circle_states
        type: carom/msg/CircleStates
        offered_qos_profiles:
          - history: keep_last
      message_count: 99
    - topic_metadata: {name: /gone, type: std_msgs/msg/String}
      message_count: 1
  relative_file_paths: [old/a.mcap, c.mcap]
";
    fs::write(&metadata, text).expect("a file");
    let (messages, faults) = read_all(&folder);
    assert_eq!(messages.len(), 12);
    for what in [
        "says /circle_states has 99 messages, but it has 12",
        "names topic /gone",
        "c.mcap: cannot be read",
        "b.mcap: is not in metadata.yaml",
    ] {
        assert!(faults.iter().any(|fault| fault.contains(what)), "{faults:?}: {what}");
    }
    let text: [&[u8]; 6] = [
        b"",
        b"a: [",
        b"rosbag2_bagfile_information: 3",
        b"\x00\x01",
        b"\xff\xfe",
        b"rosbag2_bagfile_information: {version: 9, relative_file_paths: [other.mcap]}",
    ];
    for text in text {
        fs::write(&metadata, text).expect("a file");
        let (messages, faults) = read_all(&folder);
        assert_eq!(messages.len(), 15, "{text:?}");
        assert!(faults.iter().any(|fault| fault.contains("metadata.yaml: ")), "{faults:?}");
    }
    fs::remove_file(&metadata).expect("ours");
    fs::create_dir(&metadata).expect("a folder of that name");
    assert_eq!(read_all(&folder).0.len(), 15);
}

#[test]
fn a_database_that_is_cut_off_is_read_as_far_as_it_goes() {
    let path = folder("cut").join("a.db3");
    sqlite(&path, 0..600);
    let whole = fs::read(&path).expect("a file");
    let (messages, faults) = read_changed(&path, &whole[..whole.len() * 9 / 10]);
    assert!((400..600).contains(&messages.len()), "{}: {faults:?}", messages.len());
    assert!(faults.iter().any(|fault| fault.contains("damaged")), "{faults:?}");
}

#[test]
fn a_log_beside_a_database_is_said_to_be_left_out() {
    let folder = folder("wal");
    let path = folder.join("a.db3");
    sqlite(&path, 0..5);
    fs::write(folder.join("a.db3-wal"), b"something").expect("a file");
    let (messages, faults) = read_all(&path);
    assert_eq!(messages.len(), 5);
    assert!(faults.iter().any(|fault| fault.contains("-wal")), "{faults:?}");
    assert_eq!(fs::read(folder.join("a.db3-wal")).expect("a file"), b"something");
}
