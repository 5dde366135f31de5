//! `carom audit` on files: what it reads, says and writes, and how it ends.

#[path = "bag/database.rs"]
mod database;

#[path = "core/common.rs"]
#[allow(dead_code, reason = "other tests use the rest")]
mod common;

#[path = "audit/recordings.rs"]
#[allow(dead_code, reason = "other tests use the rest")]
mod recordings;

#[path = "audit/exact.rs"]
mod exact;

#[path = "audit/driven.rs"]
mod driven;

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use carom::audit::Frame;
use carom::bag::decode;
use carom::bag::qos::Qos;
use carom::bag::write::{BagWriter, Options};
use carom::messages::{CircleStates, Header, Odometry, Time};
use carom::publish;
use carom::world::{Disc, Owner};
use glam::DVec2;
use recordings::{Engine, Gas, Spoil, sampled};
use serde_json::Value;

const KIND: &str = "carom/msg/CircleStates";

fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("audit").join(name);
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).expect("cargo's scratch directory is writable");
    folder
}

fn stamp(time_ns: i64) -> Time {
    let second = 1_000_000_000;
    let nanosec = u32::try_from(time_ns.rem_euclid(second)).expect("below a second");
    Time { sec: i32::try_from(time_ns.div_euclid(second)).expect("short"), nanosec }
}

fn states(frame: &Frame, parts: usize) -> Vec<Vec<u8>> {
    let size = frame.discs.len().div_ceil(parts);
    let part = |(k, discs): (usize, &[Disc])| {
        let header = Header { stamp: stamp(frame.time_ns), frame_id: "map".to_owned() };
        let parts = if parts == 1 { 0 } else { parts as u32 };
        let whole = publish::arena_states(header, discs.iter().copied());
        CircleStates { part: k as u32, parts, ..whole }
    };
    let messages = frame.discs.chunks(size).enumerate().map(part);
    messages.map(|message| decode::payload(&message).expect("a message")).collect()
}

/// A bag of circle states; with a note of a scene, if there is one.
fn bag(path: &Path, frames: &[Frame], parts: usize, scene: Option<&str>) {
    let note = scene.map(|text| BTreeMap::from([("scene".to_owned(), text.to_owned())]));
    let notes = note.into_iter().map(|note| (carom::bag::journal::NOTE.to_owned(), note));
    let mut bag = BagWriter::create(path, Options::default(), notes.collect()).expect("new");
    let topic = bag.topic("/arena_states", KIND, &Qos::default().to_yaml()).expect("known");
    for frame in frames {
        let log = 1_700_000_000_000_000_000 + frame.time_ns as u64;
        for payload in states(frame, parts) {
            bag.write(topic, log, log, &payload).expect("room");
        }
    }
    bag.finish().expect("room");
}

fn audit(arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_carom"));
    command.arg("audit").args(arguments).output().expect("carom runs")
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

fn json(path: &Path, arguments: &[&str]) -> (Value, Option<i32>) {
    let path = path.display().to_string();
    let output = audit(&[&[path.as_str(), "--json"], arguments].concat());
    let value = serde_json::from_slice(&output.stdout);
    (value.unwrap_or_else(|_| panic!("{}", text(&output.stderr))), output.status.code())
}

fn gas() -> (Vec<Frame>, carom::world::Settings) {
    let gas = Gas { size_ratio: 1.5, mass_max: 4.0, restitution: 0.9, ..Gas::new(60, 0.2) };
    let (mut arena, settings) = gas.arena();
    (sampled(&mut arena, 60.0, 120), settings)
}

/// A recording with one collision of half the restitution.
fn spoilt() -> (Vec<Frame>, recordings::Spoilt) {
    let gas = Gas { mass_max: 4.0, restitution: 0.9, ..Gas::new(60, 0.2) };
    let (arena, settings) = gas.arena();
    let discs = arena.discs(Owner::Simulated).collect();
    let mut engine = Engine::new(discs, 0.9, settings.walls);
    let (frames, spoilt) = engine.record(240.0, 240, Some(Spoil::Energy), |_, _, _, now| now > 0.3);
    (frames, spoilt.expect("a collision"))
}

#[test]
fn a_clean_bag_has_no_violation_whole_or_in_parts() {
    let folder = folder("clean");
    let (frames, _) = gas();
    for (name, parts) in [("whole", 1), ("parts", 4)] {
        let path = folder.join(name);
        bag(&path, &frames, parts, None);
        let (told, code) = json(&path, &[]);
        assert_eq!((told["violations"].as_u64(), code), (Some(0), Some(0)), "{told}");
        assert_eq!(told["counts"]["samples"], 7200);
        assert!(told["counts"]["alone"].as_u64() > Some(50), "{told}");
        let e = told["law"]["restitution"].as_f64().expect("a number");
        assert!((e - 0.9).abs() < 1e-9, "{e}");
        assert_eq!(told["law"]["restitution_source"], "estimated");
    }
}

#[test]
fn a_spoilt_bag_is_found_out_and_all_files_are_written() {
    let folder = folder("spoilt");
    let (frames, spoilt) = spoilt();
    let (path, out) = (folder.join("bag"), folder.join("out"));
    bag(&path, &frames, 1, None);
    let (told, code) = json(&path, &["--out", &out.display().to_string()]);
    assert_eq!((told["violations"].as_u64(), code), (Some(1), Some(1)), "{told}");
    let worst = &told["worst"][0];
    assert_eq!(worst["kind"], "energy");
    assert!((worst["time_s"].as_f64().expect("a time") - spoilt.time).abs() < 1e-6, "{worst}");
    let mut pair = spoilt.pair;
    pair.sort_unstable();
    assert_eq!(worst["discs"], serde_json::json!(pair));
    let page = fs::read_to_string(out.join("index.html")).expect("a page");
    assert!(page.contains("carom audit") && page.contains("One violation"));
    assert!(
        roxmltree::Document::parse(
            &fs::read_to_string(out.join("audit_restitution.svg")).expect("a plot")
        )
        .is_ok()
    );
    let csv = fs::read_to_string(out.join("collisions.csv")).expect("data");
    let columns = |line: &str| line.split(',').count();
    let lines: Vec<&str> = csv.lines().collect();
    assert!(lines.iter().all(|line| columns(line) == columns(lines[0])), "{csv}");
    assert_eq!(lines.iter().filter(|line| line.ends_with("alone,energy")).count(), 1);
    let words = audit(&[&path.display().to_string()]);
    assert_eq!(words.status.code(), Some(1));
    assert!(text(&words.stdout).contains("1 violations\n"), "{}", text(&words.stdout));
}

#[test]
fn the_scene_in_a_bag_is_its_law() {
    let folder = folder("scene");
    let (frames, settings) = gas();
    let walls = settings.walls.expect("walls");
    let scene = |e: f64| {
        format!(
            "restitution: {e}\nwalls: {{x: [{}, {}], y: [{}, {}], restitution: 0.9}}\n",
            walls.min.x, walls.max.x, walls.min.y, walls.max.y
        )
    };
    for (e, violations) in [(0.9, false), (0.8, true)] {
        let path = folder.join(format!("bag{e}"));
        bag(&path, &frames, 1, Some(&scene(e)));
        let (told, code) = json(&path, &[]);
        assert_eq!(told["law"]["restitution_source"], "told", "{told}");
        assert_eq!(told["law"]["walls_source"], "told");
        assert_eq!(code, Some(i32::from(violations)), "{told}");
        // What the command line says counts more.
        let (told, code) = json(&path, &["--restitution", "0.9"]);
        assert_eq!((told["law"]["restitution"].as_f64(), code), (Some(0.9), Some(0)));
    }
}

#[test]
fn odometry_of_robots_that_turn_is_read_in_their_own_frames() {
    let folder = folder("robots");
    let (frames, spoilt) = spoilt();
    let path = folder.join("bag");
    let mut bag = BagWriter::create(&path, Options::default(), Vec::new()).expect("new");
    let ids: Vec<u32> = spoilt.pair.to_vec();
    let qos = Qos::default().to_yaml();
    let topics: Vec<usize> = ids
        .iter()
        .map(|id| bag.topic(&format!("/r{id}/odom"), "nav_msgs/msg/Odometry", &qos).expect("known"))
        .collect();
    let near =
        frames.iter().filter(|frame| (1e-9 * frame.time_ns as f64 - spoilt.time).abs() < 0.012);
    for frame in near {
        for (id, topic) in ids.iter().zip(&topics) {
            let disc = frame.discs.iter().find(|disc| disc.id == *id).expect("there");
            let heading = 1.0 + 3.0 * 1e-9 * frame.time_ns as f64;
            let payload = odometry(disc, frame.time_ns, heading);
            let log = frame.time_ns as u64;
            bag.write(*topic, log, log, &payload).expect("room");
        }
    }
    bag.finish().expect("room");
    let size = |id: u32| {
        let disc = frames[0].discs.iter().find(|disc| disc.id == id).expect("there");
        format!("r{id}={},{}", disc.radius, disc.mass)
    };
    let (a, b) = (size(ids[0]), size(ids[1]));
    let (told, code) =
        json(&path, &["--robot", &a, "--robot", &b, "--restitution", "0.9", "--no-walls"]);
    assert_eq!((told["worst"][0]["kind"].as_str(), code), (Some("energy"), Some(1)), "{told}");
    let detail = told["worst"][0]["detail"].as_str().expect("words");
    assert!(detail.starts_with("restitution 0.4500"), "{detail}");
    // The same collision is a crash above its speed.
    let speed = told["worst"][0]["approach_speed_mps"].as_f64().expect("a speed");
    for (limit, count) in [(0.99 * speed, 1), (1.01 * speed, 0)] {
        let limit = limit.to_string();
        let more = ["--robot", &a, "--robot", &b, "--no-walls", "--crash-speed", &limit];
        let (told, _) = json(&path, &more);
        assert_eq!(told["crashes"].as_array().map(Vec::len), Some(count), "{told}");
    }
}

/// Ten robots that are sampled exactly, each at stamps of its own: robot k by k lags later.
#[test]
fn robots_that_are_stamped_one_by_one_collide_as_they_did() {
    let folder = folder("lags");
    for (at, lag_ns) in [20_000, 100_000, 300_000, 700_000].into_iter().enumerate() {
        let discs = common::gas(91, 10, 3.0, (0.08, 0.12), (0.5, 2.0));
        let settings = common::box_settings(3.0, 1.0);
        let plan = carom::plan::Plan::of(&settings, &discs);
        let mut arena = carom::motion::arena::Arena::new(&plan, plan.laws(&settings), &discs);
        let path = folder.join(at.to_string());
        let mut bag = BagWriter::create(&path, Options::default(), Vec::new()).expect("new");
        let qos = Qos::default().to_yaml();
        let topic = |disc: &Disc, bag: &mut BagWriter| {
            let name = format!("/r{}/odom", disc.id);
            bag.topic(&name, "nav_msgs/msg/Odometry", &qos).expect("known")
        };
        let topics: Vec<usize> = discs.iter().map(|disc| topic(disc, &mut bag)).collect();
        for round in 1..600_i64 {
            for (k, topic) in (0..).zip(&topics) {
                let time_ns = round * 16_666_667 + lag_ns * k;
                while arena.now() < 1e-9 * time_ns as f64 {
                    arena.advance(1e-9 * time_ns as f64, &mut Vec::new()).expect("no stall");
                }
                let id = discs[k as usize].id;
                let disc = arena.discs(Owner::Simulated).find(|disc| disc.id == id).expect("there");
                let log = time_ns as u64;
                bag.write(*topic, log, log, &odometry(&disc, time_ns, 0.0)).expect("room");
            }
        }
        bag.finish().expect("room");
        let robots: Vec<String> = discs
            .iter()
            .flat_map(|disc| {
                ["--robot".to_owned(), format!("r{}={},{}", disc.id, disc.radius, disc.mass)]
            })
            .collect();
        let robots: Vec<&str> = robots.iter().map(String::as_str).collect();
        let (told, code) = json(&path, &robots);
        let seen = told["counts"]["alone"].as_u64().expect("a count");
        assert_eq!((told["violations"].as_u64(), code), (Some(0), Some(0)), "{lag_ns}: {told}");
        assert!(seen > 30, "{lag_ns}: {seen}");
        assert!(told["notes"].to_string().contains("to a common stamp"), "{told}");
    }
}

/// A disc as the odometry of a robot that looks in this direction, rad.
fn odometry(disc: &Disc, time_ns: i64, heading: f64) -> Vec<u8> {
    let own = DVec2::from_angle(-heading).rotate(disc.velocity);
    let mut odometry = Odometry::default();
    odometry.header.stamp = stamp(time_ns);
    odometry.pose.pose.position.x = disc.position.x;
    odometry.pose.pose.position.y = disc.position.y;
    odometry.pose.pose.orientation.z = (0.5 * heading).sin();
    odometry.pose.pose.orientation.w = (0.5 * heading).cos();
    odometry.twist.twist.linear.x = own.x;
    odometry.twist.twist.linear.y = own.y;
    decode::payload(&odometry).expect("a message")
}

#[test]
fn without_stamps_the_times_of_recording_count_and_sqlite_is_read() {
    let folder = folder("sqlite");
    let (mut frames, _) = gas();
    let path = folder.join("bag.db3");
    let database = database::database(&path, "/circles");
    for frame in &mut frames {
        let log = 1_700_000_000_000_000_000 + frame.time_ns;
        frame.time_ns = 0;
        for payload in states(frame, 1) {
            database::insert(&database, log, &payload);
        }
    }
    drop(database);
    let (told, code) = json(&path, &[]);
    assert_eq!((told["violations"].as_u64(), code), (Some(0), Some(0)), "{told}");
    assert!(told["counts"]["alone"].as_u64() > Some(50), "{told}");
    let notes = told["notes"].to_string();
    assert!(notes.contains("stamps are 0"), "{notes}");
}

/// Names of the files in a folder.
fn files_in(folder: &Path) -> Vec<String> {
    let name = |entry: fs::DirEntry| entry.file_name().to_string_lossy().into_owned();
    let mut names: Vec<String> = fs::read_dir(folder)
        .expect("it is there")
        .map(|entry| name(entry.expect("an entry")))
        .collect();
    names.sort();
    names
}

#[test]
fn no_file_of_an_earlier_audit_stays_beside_a_new_page() {
    let folder = folder("twice");
    let [bad, good, first, out, fresh] =
        ["bad", "good", "first", "out", "fresh"].map(|name| folder.join(name));
    let (mut frames, _) = spoilt();
    // A hole, and walls that are not there: all that a page may hold.
    frames.drain(20..23);
    bag(&bad, &frames, 1, None);
    bag(&good, &gas().0[..3], 1, None);
    let into = |bag: &Path, out: &Path| {
        let [bag, out] = [bag, out].map(|path| path.display().to_string());
        let options = ["--crash-speed", "0.01", "--no-walls"];
        audit(&[&[bag.as_str(), "--out", out.as_str()], &options[..]].concat()).status.code()
    };
    assert_eq!(into(&bad, &first), Some(1));
    let mut names = carom::audit::page::names();
    names.extend(["collisions.csv", "index.html"].map(str::to_owned));
    names.sort();
    assert_eq!(files_in(&first), names);
    assert_eq!(into(&bad, &out), Some(1));
    for stranger in ["audit_notes.csv", "violations.csv"] {
        fs::write(out.join(stranger), "mine").expect("room");
    }
    assert_eq!((into(&good, &out), into(&good, &fresh)), (Some(0), Some(0)));
    let mut kept = files_in(&out);
    kept.retain(|name| name != "audit_notes.csv" && name != "violations.csv");
    assert_eq!(kept.len() + 2, files_in(&out).len());
    assert_eq!(kept, files_in(&fresh));
}

#[test]
fn messages_that_speak_of_different_frames_are_told() {
    let folder = folder("frame_ids");
    let (frames, _) = gas();
    for (name, ids) in [("one", ["map", "map"]), ("two", ["map", "odom"])] {
        let path = folder.join(name);
        let mut bag = BagWriter::create(&path, Options::default(), Vec::new()).expect("new");
        let topic = bag.topic("/arena_states", KIND, &Qos::default().to_yaml()).expect("known");
        for (frame, id) in frames[..30].iter().zip(ids.iter().cycle()) {
            let header = Header { stamp: stamp(frame.time_ns), frame_id: (*id).to_owned() };
            let states = publish::arena_states(header, frame.discs.iter().copied());
            let payload = decode::payload(&states).expect("a message");
            bag.write(topic, frame.time_ns as u64, frame.time_ns as u64, &payload).expect("room");
        }
        bag.finish().expect("room");
        let (told, _) = json(&path, &[]);
        let notes = told["notes"].to_string();
        let is_told =
            notes.contains("messages speak of different frames, taken for one: 'map', 'odom'");
        assert_eq!(is_told, name == "two", "{notes}");
    }
}

/// Two discs that collide once: samples, every 1/60 s.
fn collided(how: Option<Spoil>) -> Vec<Frame> {
    let discs = vec![
        common::disc(0, [-0.7, 0.03], [1.1, 0.0], 0.1, 2.0),
        common::disc(1, [0.5, 0.0], [-0.6, 0.1], 0.15, 1.0),
    ];
    Engine::new(discs, 0.9, None).record(60.0, 100, how, |_, _, _, _| true).0
}

/// What is told of that collision when it is as it should be, of half the restitution, and unseen.
const COLLIDED: [(Option<Spoil>, &[&str]); 3] = [
    (None, &[]),
    (Some(Spoil::Energy), &["energy"]),
    (Some(Spoil::Unseen), &["missed", "tunnelling"]),
];

fn assert_told(told: &Value, code: Option<i32>, wanted: &[&str], what: &str) {
    let count = u64::from(!wanted.is_empty());
    assert_eq!(
        (told["violations"].as_u64(), code),
        (Some(count), Some(count as i32)),
        "{what} {told}"
    );
    let kind = told["worst"][0]["kind"].as_str();
    assert!(kind.is_none_or(|kind| wanted.contains(&kind)), "{what}: {told}");
    let judged = told["counts"]["alone"].as_u64();
    assert!(judged == Some(1) || kind.is_some(), "{what}: {told}");
}

#[test]
fn robots_at_different_rates_are_judged_by_what_they_do_to_each_other() {
    let folder = folder("rates");
    for (at, (how, wanted)) in COLLIDED.into_iter().enumerate() {
        let frames = collided(how);
        // The second speaks at every so many stamps only, from each of them on.
        for (every, first) in [(1, 0), (2, 0), (2, 1), (3, 0), (3, 1), (3, 2), (5, 3)] {
            let what = format!("{at}_{every}_{first}");
            let path = folder.join(&what);
            let mut bag = BagWriter::create(&path, Options::default(), Vec::new()).expect("new");
            let qos = Qos::default().to_yaml();
            let topics = ["/a/odom", "/b/odom"]
                .map(|name| bag.topic(name, "nav_msgs/msg/Odometry", &qos).expect("known"));
            for (k, frame) in frames.iter().enumerate() {
                let speak = 1 + usize::from(k % every == first);
                for (disc, topic) in frame.discs.iter().zip(topics).take(speak) {
                    let log = frame.time_ns as u64;
                    bag.write(topic, log, log, &odometry(disc, frame.time_ns, 0.3)).expect("room");
                }
            }
            bag.finish().expect("room");
            let robots = ["--robot", "a=0.1,2", "--robot", "b=0.15,1"];
            let (told, code) = json(&path, &[&robots[..], &["--restitution", "0.9"]].concat());
            assert_told(&told, code, wanted, &what);
        }
    }
}

/// Four robots between walls at different rates: as many collisions are judged as noise allows, and
/// none is called wrong.
#[test]
fn robots_at_different_rates_have_no_violation_in_noise_either() {
    let folder = folder("rates_noise");
    for (seed, noise) in [(1, 0.0), (2, 0.0), (1, 1.0), (2, 1.0), (3, 1.0), (4, 1.0)] {
        let discs = common::gas(seed, 4, 2.0, (0.1, 0.15), (1.0, 2.0));
        let walls = common::box_settings(2.0, 1.0).walls;
        let mut engine = Engine::new(discs.clone(), 1.0, walls);
        let (mut frames, _) = engine.record(60.0, 2400, None, |_, _, _, _| false);
        let mut random = common::Random::new(seed);
        recordings::with_noise(&mut frames, 1e-3 * noise, 5e-3 * noise, &mut random);
        let path = folder.join(format!("{seed}_{noise}"));
        let mut bag = BagWriter::create(&path, Options::default(), Vec::new()).expect("new");
        let qos = Qos::default().to_yaml();
        let topic = |disc: &Disc| {
            let name = format!("/r{}/odom", disc.id);
            bag.topic(&name, "nav_msgs/msg/Odometry", &qos).expect("known")
        };
        let topics: Vec<usize> = discs.iter().map(topic).collect();
        for (k, frame) in frames.iter().enumerate() {
            let speaks = [0, 1, 2, 3].map(|robot| k % [1, 1, 3, 5][robot] == [0, 0, 1, 2][robot]);
            for ((disc, topic), _) in frame.discs.iter().zip(&topics).zip(speaks).filter(|x| x.1) {
                let log = frame.time_ns as u64;
                bag.write(*topic, log, log, &odometry(disc, frame.time_ns, 0.0)).expect("room");
            }
        }
        bag.finish().expect("room");
        let robots = discs.iter().map(|d| format!("--robot=r{}={},{}", d.id, d.radius, d.mass));
        let robots: Vec<String> = robots.collect();
        let robots: Vec<&str> = robots.iter().map(String::as_str).collect();
        let (told, code) = json(&path, &[&robots[..], &["--walls", "0,0,2,2"]].concat());
        assert_eq!(
            (told["violations"].as_u64(), code),
            (Some(0), Some(0)),
            "{seed} {noise} {told}"
        );
        let count = |what: &str| told["counts"][what].as_u64().expect("a count");
        let (alone, unexplained) = (count("alone"), count("unexplained"));
        assert!(noise > 0.0 || alone > 4 * unexplained && alone > 8, "{seed}: {told}");
        assert!(count("carried") > 3000 && alone > 0, "{seed} {noise}: {told}");
    }
}

#[test]
fn two_publishers_on_one_topic_are_one_world_or_it_is_said_that_nothing_was_judged() {
    let folder = folder("publishers");
    for (at, (how, wanted)) in COLLIDED.into_iter().enumerate() {
        // At the same stamps, and each at its own.
        for apart_ns in [0, 3_000_000] {
            let what = format!("{at}_{apart_ns}");
            let each = |frame: Frame| {
                let own = |(k, disc): (i64, &Disc)| Frame {
                    time_ns: frame.time_ns + k * apart_ns,
                    discs: vec![*disc],
                };
                (0..).zip(&frame.discs).map(own).collect::<Vec<Frame>>()
            };
            let frames: Vec<Frame> = collided(how).into_iter().flat_map(each).collect();
            let path = folder.join(&what);
            bag(&path, &frames, 1, None);
            let (told, code) = json(&path, &["--restitution", "0.9"]);
            if apart_ns == 0 {
                assert_told(&told, code, wanted, &what);
                continue;
            }
            let said = text(&audit(&[&path.display().to_string()]).stdout);
            let last = said.lines().last().expect("a verdict");
            assert!(told["not_judged"].as_u64() > Some(100), "{told}");
            assert!(last.starts_with("no violation in what was judged; not judged: 19"), "{said}");
        }
    }
}

#[test]
fn broken_bags_and_bad_use_are_one_line_and_code_2() {
    let folder = folder("broken");
    let (frames, _) = gas();
    let path = folder.join("bag");
    bag(&path, &frames, 1, None);
    let name = path.display().to_string();
    let nothing = folder.join("nothing").display().to_string();
    let file = folder.join("text.mcap");
    fs::write(&file, "no bag").expect("room");
    for arguments in [
        &[nothing.as_str()][..],
        &[&file.display().to_string()],
        &[&name, "--topic", "other"],
        &[&name, "--robot", "a"],
        &[&name, "--robot", "a=1"],
        &[&name, "--robot", "a=0.1,2"],
        &[&name, "--robot", "a=0.1,2", "--robot", "a=0.2,2"],
        &[&name, "--restitution", "1.1"],
        &[&name, "--walls", "0,0,1"],
        &[&name, "--gravity", "0"],
        &[&name, "--tolerance", "-1"],
        &[&name, "--out", &file.display().to_string()],
        &[],
    ] {
        let output = audit(arguments);
        let error = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {error}");
        assert!(error.lines().count() == 1 && error.starts_with("carom: "), "{error}");
        assert!(output.stdout.is_empty());
    }
}

#[test]
fn of_a_bag_that_is_cut_off_what_is_left_is_judged_and_said_to_be_not_all() {
    let folder = folder("cut");
    let (mut arena, _) = Gas::new(200, 0.2).arena();
    let frames = sampled(&mut arena, 60.0, 240);
    let path = folder.join("bag");
    bag(&path, &frames, 1, None);
    let files = fs::read_dir(&path).expect("a folder").flatten().map(|entry| entry.path());
    let whole = files.into_iter().find(|path| path.extension().is_some_and(|e| e == "mcap"));
    let bytes = fs::read(whole.expect("a recording")).expect("bytes");
    let cut = folder.join("cut.mcap");
    let left = &bytes[..bytes.len() / 3 * 2];
    fs::write(&cut, left).expect("room");
    let (told, code) = json(&cut, &[]);
    assert_eq!((told["violations"].as_u64(), code), (Some(0), Some(0)), "{told}");
    let samples = told["counts"]["samples"].as_u64().expect("a number");
    assert!((5_000..32_000).contains(&samples), "{samples}");
    let notes = told["notes"].to_string();
    assert!(notes.contains("cut.mcap"), "{notes}");
    assert_eq!(fs::read(&cut).expect("bytes"), left, "never changed");
}

/// A robot soccer scene with a wall that is no box: two robots of a team, and a ball.
const LEAGUE: &str = "method: ticks
tick_s: 0.001
restitution: 0.5
segments: {lines: [{name: side, points: [[-9, 0.6], [9, 0.6]]}]}
ball: {position: [0, 0], radius: 0.02, mass: 0.05}
robots:
  - {name: a, team: blue, radius: 0.09, mass: 2.5, places: [[-1, 0, 0], [1, 0.3, 0]],
     drive: {model: holonomic, speed_max: 2, acceleration_max: 4}}
";

#[test]
fn a_game_recorded_with_its_scene_has_no_violation_without_any_option() {
    use carom::world::{Command as Order, Frame as In, Instants, Wanted};
    let scene = carom::scene::file::parse(LEAGUE, "scene").expect("sound");
    let mut world = scene.world();
    let record = |k: u32| {
        let order = |puck: &carom::scene::Puck| {
            let linear = DVec2::from_angle(f64::from(k / 40) + f64::from(puck.disc.id)) * 2.0;
            let wanted = Wanted { linear, angular: 0.0, frame: In::Arena };
            Order::Drive { id: puck.disc.id, wanted }
        };
        let orders: Vec<Order> = scene.pucks.iter().filter(|p| p.driven).map(order).collect();
        let advance_to = f64::from(k) / 60.0;
        world.step(&orders, Instants { heard_at: 0.0, advance_to });
        let discs = world.arena().expect("pucks").discs(Owner::Simulated).collect();
        Frame { time_ns: (1e9 * advance_to).round() as i64, discs }
    };
    let frames: Vec<Frame> = (0..600).map(record).collect();
    assert!(world.arena().expect("pucks").contacts() > 3);
    let path = folder("game").join("bag");
    bag(&path, &frames, 1, Some(LEAGUE));
    let (told, code) = json(&path, &[]);
    assert_eq!((told["violations"].as_u64(), code), (Some(0), Some(0)), "{told}");
    assert!(told["counts"]["beside"].as_u64() > Some(0), "{told}");
}

#[test]
fn what_cannot_be_written_or_would_lie_in_a_bag_is_code_2() {
    let folder = folder("refused");
    let path = folder.join("bag");
    let (frames, _) = gas();
    bag(&path, &frames[..20], 1, None);
    let name = path.display().to_string();
    let full = fs::OpenOptions::new().write(true).open("/dev/full").expect("Linux");
    let mut command = Command::new(env!("CARGO_BIN_EXE_carom"));
    let child = command.args(["audit", &name]).stdout(full).output().expect("carom runs");
    let said = text(&child.stderr);
    assert_eq!((child.status.code(), said.lines().count()), (Some(2), 1), "{said}");
    let list = || {
        let entries = fs::read_dir(&path).expect("a folder").flatten();
        entries.map(|entry| entry.file_name()).collect::<Vec<_>>()
    };
    let before = list();
    let output = audit(&[&name, "--out", &name]);
    let said = text(&output.stderr);
    assert_eq!((output.status.code(), said.lines().count()), (Some(2), 1), "{said}");
    assert!(said.contains("a bag is in it"), "{said}");
    assert_eq!(list(), before);
    let output = audit(&[&name, "--robot", "red=0.1,1"]);
    let said = text(&output.stderr);
    assert!(said.contains("; the bag has no topic of nav_msgs/msg/Odometry"), "{said}");
}
