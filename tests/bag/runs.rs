//! Runs repeated from a bag, and recordings answered: bit by bit, or with the place where not.

use std::collections::BTreeMap;
use std::fs;
use std::io::Cursor;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use carom::bag::journal::{self, Asked, Entry, Line};
use carom::bag::offline;
use carom::bag::qos::Qos;
use carom::bag::read::{Bag, Note};
use carom::bag::verify::verify;
use carom::bag::write::{BagWriter, Options};
use carom::bag::{decode, read};
use carom::messages::{CircleStates, CircleVelocities, Contacts, Header, Time};
use carom::publish;
use carom::receive;
use carom::scene::Scene;
use carom::world::{
    Command as Asking, Disc, Drive, Frame, Instants, Kicker, Model, Owner, Wanted, World,
};
use glam::DVec2;

use super::common::{KIND, folder, states, time};

const TICKS: u32 = 120;

/// A run of a shipped scene as the node records it, with commands between the ticks.
fn recorded(folder: &Path, scene_name: &str, version: &str) -> PathBuf {
    let scene = Scene::load(scene_name).expect("shipped");
    let settings = &scene.settings;
    let method = settings.method.map_or("auto", |method| method.name());
    let parameters = BTreeMap::from([
        ("frame_id".to_owned(), "map".to_owned()),
        ("method".to_owned(), method.to_owned()),
        ("step_s".to_owned(), settings.pace.step.to_string()),
        ("stale_after_s".to_owned(), settings.stale_after.to_string()),
        ("contact_margin_m".to_owned(), settings.contact_margin.to_string()),
        ("command_timeout_s".to_owned(), settings.command_timeout.to_string()),
        ("keep_all".to_owned(), "false".to_owned()),
    ]);
    let mut said = journal::note(&scene, &parameters);
    said.insert("version".to_owned(), version.to_owned());
    for name in ["journal", "arena_states", "contacts", "corrected_velocities"] {
        said.insert(format!("topic.{name}"), format!("/{name}"));
    }
    let path = folder.join("run");
    let notes = vec![(journal::NOTE.to_owned(), said)];
    let bag = BagWriter::create(&path, Options::default(), notes).expect("new");
    let mut writing = Writing::new(bag, scene.world());
    let id = scene.pucks[0].disc.id;
    for tick in 1..=TICKS {
        let at = f64::from(tick) / 60.0;
        if tick % 40 == 7 {
            let between = at - 1.0 / 180.0;
            writing.step(between, None);
            let velocity = DVec2::new(0.1 * f64::from(tick), -1.0 / 3.0);
            writing.step(between, Some(Asking::SetVelocity { id, velocity }));
        }
        if tick == 50 {
            writing.observe(at - 0.01);
        }
        writing.step(at, None);
        writing.tell();
        if tick % 40 == 0 {
            // So that it has three chunks.
            writing.bag.flush().expect("room");
        }
    }
    writing.bag.finish().expect("room");
    path
}

struct Writing {
    bag: BagWriter,
    topics: [usize; 5],
    world: World,
    time_ns: u64,
}

impl Writing {
    fn new(mut bag: BagWriter, world: World) -> Self {
        let topics = [
            ("/journal", "std_msgs/msg/String"),
            ("/arena_states", KIND),
            ("/contacts", "carom/msg/Contacts"),
            ("/corrected_velocities", "carom/msg/CircleVelocities"),
            ("/circle_states", KIND),
        ];
        let topics = topics.map(|(name, kind)| bag.topic(name, kind, "").expect("known"));
        Self { bag, topics, world, time_ns: time(0) }
    }

    fn put(&mut self, topic: usize, payload: &[u8]) {
        self.time_ns += 1_000_000;
        self.bag.write(self.topics[topic], self.time_ns, self.time_ns, payload).expect("room");
    }

    fn now(&self) -> Header {
        let now = self.world.arena().expect("pucks").now();
        Header { stamp: Time::from_seconds(now), frame_id: "map".to_owned() }
    }

    fn enter(&mut self, entry: &Entry) {
        let text = serde_json::to_string(entry).expect("an entry");
        self.put(0, &decode::payload(&text).expect("a text"));
    }

    fn step(&mut self, to: f64, command: Option<Asking>) {
        let asked =
            command.as_ref().map(|command| Box::new(Asked::new(command, &Header::default())));
        self.enter(&Entry::Step { to, heard: Some(to), asked });
        let commands: Vec<Asking> = command.into_iter().collect();
        let outcome = self.world.step(&commands, Instants { heard_at: to, advance_to: to });
        self.arena(&outcome);
    }

    fn arena(&mut self, outcome: &carom::world::Outcome) {
        if !outcome.corrections.is_empty() {
            let message = publish::corrected_velocities(self.now(), &outcome.corrections);
            self.put(3, &decode::payload(&message).expect("a message"));
        }
        if !outcome.contacts.is_empty() {
            let message = publish::contacts(self.now(), &outcome.contacts);
            self.put(2, &decode::payload(&message).expect("a message"));
        }
    }

    /// Two observed circles in contact, far from the pucks, as a message.
    fn observe(&mut self, at: f64) {
        let circle = |id, x, vx| carom::messages::CircleState {
            id,
            x,
            y: 1e4,
            vx,
            vy: 0.0,
            radius: 0.5,
            mass: f64::from(id),
        };
        let header = Header { stamp: Time { sec: 77, nanosec: 5 }, frame_id: "odom".to_owned() };
        let circles = vec![circle(1, 0.0, 1.0), circle(2, 1.0, -1.0)];
        let message = CircleStates { header: header.clone(), part: 0, parts: 0, circles };
        self.put(4, &decode::payload(&message).expect("a message"));
        let asked = Some(Box::new(Asked::Message { topic: "/circle_states".to_owned() }));
        self.enter(&Entry::Step { to: at, heard: Some(at), asked });
        let (report, _) = receive::report(&message).expect("sound");
        let instants = Instants { heard_at: at, advance_to: at };
        let outcome = self.world.step(&[Asking::Observe(report)], instants);
        self.arena(&outcome);
        let answer = &outcome.answers[0];
        let velocities = publish::corrected_velocities(header.clone(), &answer.velocities);
        self.put(3, &decode::payload(&velocities).expect("a message"));
        let contacts = publish::contacts(header, &answer.contacts);
        self.put(2, &decode::payload(&contacts).expect("a message"));
    }

    fn tell(&mut self) {
        let discs = self.world.arena().expect("pucks").discs(Owner::Simulated);
        let message = publish::arena_states(self.now(), discs);
        self.put(1, &decode::payload(&message).expect("a message"));
    }
}

/// The same bag, with something done to each message and to its notes.
fn changed(
    bag: &Bag,
    folder: &Path,
    notes: Vec<Note>,
    mut change: impl FnMut(&str, &mut Vec<u8>) -> bool,
) -> PathBuf {
    let mut out = BagWriter::create(folder, Options::default(), notes).expect("new");
    let topics: Vec<usize> = bag
        .topics()
        .iter()
        .map(|topic| out.topic(&topic.name, &topic.kind, &topic.qos).expect("known"))
        .collect();
    for message in bag.messages(|_| true) {
        let read::Message { topic, log_time_ns, mut payload, .. } = message.expect("sound");
        if change(&bag.topics()[topic].name, &mut payload) {
            out.write(topics[topic], log_time_ns, log_time_ns, &payload).expect("room");
        }
    }
    out.finish().expect("room");
    folder.to_owned()
}

fn carom(arguments: &[&str], path: &Path) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_carom"));
    command.args(arguments).arg(path).output().expect("the program was built")
}

fn run_from(path: &Path, more: &[&str]) -> (Option<i32>, String, String) {
    let arguments = [&["run"], more, &["--from"]].concat();
    let Output { status, stdout, stderr } = carom(&arguments, path);
    let text = |bytes| String::from_utf8(bytes).expect("text");
    (status.code(), text(stdout), text(stderr))
}

#[test]
fn a_run_is_repeated_bit_by_bit_under_every_method() {
    let folder = folder("repeated");
    for name in ["arena", "thousand", "teams", "newtons_cradle", "break_shot"] {
        let parent = folder.join(name);
        let path = recorded(&parent, name, env!("CARGO_PKG_VERSION"));
        let verdict = verify(&Bag::open(&path).expect("a bag")).expect("a run");
        assert!(verdict.agrees(), "{name}: {verdict}");
        assert_eq!(verdict.compared["/arena_states"], u64::from(TICKS), "{name}");
        assert!(verdict.compared["/contacts"] > 0, "{name}");
        assert!(verdict.missing.is_empty() && verdict.other_version.is_none(), "{name}");
    }
}

#[test]
fn one_wrong_bit_is_found_at_its_place() {
    let folder = folder("bit");
    let path = recorded(&folder, "arena", env!("CARGO_PKG_VERSION"));
    let bag = Bag::open(&path).expect("a bag");
    let mut count = 0;
    let wrong = changed(&bag, &folder.join("wrong"), bag.notes().to_vec(), |topic, payload| {
        count += u32::from(topic == "/arena_states");
        if topic == "/arena_states" && count == 60 {
            // The lowest bit of the x of the first puck.
            payload[40] ^= 1;
        }
        true
    });
    let verdict = verify(&Bag::open(&wrong).expect("a bag")).expect("a run");
    assert_eq!(verdict.differences, 1, "{verdict}");
    assert!(verdict.told[0].starts_with("/arena_states at 1 s: x of "), "{verdict}");
    assert_eq!(verdict.compared["/arena_states"], u64::from(TICKS));
    let (code, out, _) = run_from(&wrong, &["--verify"]);
    assert_eq!(code, Some(1));
    assert!(out.contains("it differs in 1 place"), "{out}");
    let (code, out, _) = run_from(&path, &["--verify"]);
    assert_eq!(code, Some(0), "{out}");
    assert!(out.contains("every bit agrees"), "{out}");
}

#[test]
fn what_is_left_out_is_a_difference() {
    let folder = folder("differences");
    let path = recorded(&folder, "arena", env!("CARGO_PKG_VERSION"));
    let bag = Bag::open(&path).expect("a bag");
    let mut contacts = 0;
    let fewer = changed(&bag, &folder.join("fewer"), bag.notes().to_vec(), |topic, _| {
        contacts += u32::from(topic == "/contacts");
        topic != "/contacts" || contacts != 3
    });
    assert!(!verify(&Bag::open(&fewer).expect("a bag")).expect("a run").agrees());
}

/// What `--verify` says of a run whose messages stand in the file so often, by topic and number.
fn verified_with(name: &str, times: impl Fn(&str, u32) -> usize) -> (Option<i32>, String) {
    let folder = folder(name);
    let path = recorded(&folder, "arena", env!("CARGO_PKG_VERSION"));
    let notes = Bag::open(&path).expect("a bag").notes().to_vec();
    let file = path.join("run_0.mcap");
    let whole = fs::read(&file).expect("a file");
    let mut writer = mcap::Writer::new(Cursor::new(Vec::new())).expect("memory");
    for (name, metadata) in notes {
        writer.write_metadata(&mcap::records::Metadata { name, metadata }).expect("memory");
    }
    for message in mcap::MessageStream::new(&whole).expect("a file of ours") {
        let message = message.expect("sound");
        for _ in 0..times(&message.channel.topic, message.sequence) {
            writer.write(&message).expect("memory");
        }
    }
    writer.finish().expect("memory");
    fs::write(&file, writer.into_inner().into_inner()).expect("a file");
    fs::remove_file(path.join("metadata.yaml")).expect("ours");
    let (code, out, _) = run_from(&path, &["--verify"]);
    (code, out)
}

#[test]
fn a_message_that_was_taken_out_is_missed_and_changes_nothing_else() {
    let gone = |topic: &'static str, number: u32| {
        move |t: &str, n: u32| usize::from((t, n) != (topic, number))
    };
    let (code, out) = verified_with("taken_contacts", gone("/contacts", 3));
    assert_eq!(code, Some(1), "{out}");
    assert!(out.contains("1 messages are not there"), "{out}");
    assert!(out.contains("every bit agrees; the bag is damaged in 1 place"), "{out}");
    let (code, out) = verified_with("taken_step", gone("/journal", 40));
    assert_eq!(code, Some(1), "{out}");
    assert!(out.contains("the journal has a hole") && !out.contains("differs"), "{out}");
    let (code, out) = verified_with("doubled", |t, n| 1 + usize::from((t, n) == ("/contacts", 3)));
    assert_eq!(code, Some(1), "{out}");
    assert!(out.contains("message 3 comes behind number 3"), "{out}");
    assert!(out.contains("every bit agrees; the bag is damaged in 1 place"), "{out}");
    let (code, out) = verified_with("taken", gone("/arena_states", 60));
    assert_eq!(code, Some(1), "{out}");
    assert!(
        out.contains("/arena_states at 1.0166666666666666 s: 1 messages are not there"),
        "{out}"
    );
    assert!(out.contains("every bit agrees; the bag is damaged in 1 place"), "{out}");
}

/// The places of the steps in the journal of a file that is not packed.
fn steps_in(bytes: &[u8]) -> Vec<usize> {
    let step = br#"{"step""#;
    (0..bytes.len()).filter(|at| bytes[*at..].starts_with(step)).collect()
}

#[test]
fn after_a_lost_chunk_nothing_is_compared_and_that_is_said() {
    let folder = folder("hole");
    let path = recorded(&folder, "arena", env!("CARGO_PKG_VERSION"));
    let file = path.join("run_0.mcap");
    let whole = fs::read(&file).expect("a file");
    let steps = steps_in(&whole);
    assert!(steps.len() > TICKS as usize);
    // Chunks 1, 2, 3: so many ticks before the hole.
    for (place, ticks) in [(0, 0u32), (steps.len() / 2, 40), (steps.len() - 1, 80)] {
        let mut bytes = whole.clone();
        bytes[steps[place]] ^= 4;
        fs::write(&file, bytes).expect("a file");
        let verdict = verify(&Bag::open(&path).expect("a bag")).expect("a run");
        assert_eq!((verdict.differences, verdict.damage.len()), (0, 1), "{verdict}");
        assert_eq!(verdict.compared.get("/arena_states").copied().unwrap_or(0), u64::from(ticks));
        let (code, out, _) = run_from(&path, &["--verify"]);
        let at = f64::from(ticks) / 60.0;
        let lost = format!("cannot be repeated from {at} s on: the journal has a hole");
        let agrees = if ticks == 0 { "nothing can be compared" } else { "every bit agrees" };
        let result = format!("up to {at} s: {agrees}; the bag is damaged in 1 place");
        assert_eq!(code, Some(1));
        for what in ["wrong checksum", &lost, &result] {
            assert!(out.contains(what), "{out}: {what}");
        }
    }
}

#[test]
fn a_bag_that_says_wrong_counts_or_is_cut_differs_nowhere() {
    let folder = folder("damage");
    let path = recorded(&folder, "arena", env!("CARGO_PKG_VERSION"));
    let metadata = path.join("metadata.yaml");
    let text = fs::read_to_string(&metadata).expect("a file");
    let wrong = text.replacen("message_count: 120\n", "message_count: 119\n", 1);
    assert_ne!(wrong, text);
    fs::write(&metadata, wrong).expect("a file");
    let (code, out, _) = run_from(&path, &["--verify"]);
    assert_eq!(code, Some(1));
    assert!(out.contains("says /arena_states has 119 messages, but it has 120"), "{out}");
    assert!(out.contains("every bit agrees; the bag is damaged in 1 place"), "{out}");
    fs::write(&metadata, text).expect("a file");
    let file = path.join("run_0.mcap");
    let whole = fs::read(&file).expect("a file");
    let steps = steps_in(&whole);
    fs::write(&file, &whole[..steps[steps.len() - 1]]).expect("a file");
    let verdict = verify(&Bag::open(&path).expect("a bag")).expect("a run");
    assert!(verdict.agrees() && !verdict.is_sound() && verdict.differences == 0, "{verdict}");
    assert_eq!(verdict.compared["/arena_states"], 80, "{verdict}");
    // Without the metadata it is as if the node had been killed.
    fs::remove_file(&metadata).expect("ours");
    let (code, out, _) = run_from(&path, &["--verify"]);
    assert_eq!(code, Some(0), "{out}");
    assert!(out.contains("ends too early") && out.ends_with("every bit agrees\n"), "{out}");
}

#[test]
fn a_verdict_that_cannot_be_said_is_an_error_and_a_closed_pipe_is_none() {
    let path = recorded(&folder("said"), "head_on", env!("CARGO_PKG_VERSION"));
    let run = |out: Stdio| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_carom"));
        command.args(["run", "--verify", "--from"]).arg(&path).stdout(out);
        let Output { status, stderr, .. } = command.output().expect("the program was built");
        (status.code(), String::from_utf8(stderr).expect("text"))
    };
    let full = fs::OpenOptions::new().write(true).open("/dev/full").expect("Linux");
    let (code, error) = run(full.into());
    assert_eq!((code, error.lines().count()), (Some(2), 1), "{error}");
    assert!(error.starts_with("carom: cannot write: "), "{error}");
    let (reader, writer) = std::io::pipe().expect("a pipe");
    drop(reader);
    assert_eq!(run(writer.into()), (Some(0), String::new()));
}

#[test]
fn another_version_is_named_and_a_bag_of_others_is_no_run() {
    let folder = folder("version");
    let path = recorded(&folder, "head_on", "0.0.1");
    let (code, out, _) = run_from(&path, &["--verify"]);
    assert_eq!(code, Some(0), "{out}");
    assert!(out.contains("recorded by carom 0.0.1"), "{out}");
    let bag = Bag::open(&path).expect("a bag");
    let foreign = changed(&bag, &folder.join("foreign"), Vec::new(), |_, _| true);
    let (code, out, error) = run_from(&foreign, &["--verify"]);
    assert_eq!((code, out.as_str()), (Some(2), ""));
    assert!(error.contains("no run of carom"), "{error}");
}

#[test]
fn journals_keep_every_bit_of_every_command() {
    let disc = Disc {
        id: 7,
        position: DVec2::new(0.1, -1.0 / 3.0),
        velocity: DVec2::new(5e-324, 1.797e308),
        radius: 1e-9,
        mass: f64::INFINITY,
    };
    let to = 0.1 + 0.2;
    for asked in [
        Asked::Add { puck: Line::new(&disc) },
        Asked::Place { id: 7, position: [-0.0, 1.0 / 7.0], velocity: [2.0f64.sqrt(), 1e-310] },
        Asked::Drive { id: 7, linear: [0.1, 0.7], angular: -1e-17, frame: Frame::Own },
        Asked::Walls { min: [-1.0 / 3.0, 0.0], max: [1.0 / 3.0, 9.9] },
    ] {
        let entry = Entry::Step { to, heard: None, asked: Some(Box::new(asked)) };
        let text = serde_json::to_string(&entry).expect("an entry");
        let read: Entry = serde_json::from_str(&text).expect("the same");
        assert_eq!(format!("{read:?}"), format!("{entry:?}"));
    }
    assert_eq!(Line::new(&disc).disc(), disc);
}

#[test]
fn what_robots_are_asked_is_read_back_as_it_was() {
    let kicker = Some(Kicker { speed_max: 6.5, half_angle: 0.1, reach: 1.0 / 3.0, grip: 0.0 });
    let drive = Drive { model: Model::Holonomic, speed_max: 0.1 + 0.2, ..Drive::default() };
    let wanted = Wanted { linear: DVec2::new(0.1, -0.0), angular: 1e-300, frame: Frame::Arena };
    for command in [
        Asking::Drive { id: 1, wanted },
        Asking::Drive { id: 1, wanted: Wanted { frame: Frame::Own, ..wanted } },
        Asking::Kick { id: 2, speed: 1.0 / 7.0 },
        Asking::Dribble { id: 3, on: true },
        Asking::Pull { id: 3, to: Some(DVec2::new(0.1, -0.0)) },
        Asking::Pull { id: 3, to: None },
        Asking::Turn { id: 4, heading: -3.0, turn: 0.1 },
        Asking::Roll { id: 5 },
        Asking::SetDrive { id: 6, drive },
        Asking::SetDrive { id: 6, drive: Drive { kicker, ..drive } },
        Asking::SetDrive { id: 6, drive: Drive { braking_max: Some(0.7), ..drive } },
        Asking::SetDrive { id: 6, drive: Drive { turn_braking_max: Some(9.0), kicker, ..drive } },
    ] {
        let asked = Asked::new(&command, &Header::default());
        let text = serde_json::to_string(&asked).expect("an entry");
        let read: Asked = serde_json::from_str(&text).expect("the same");
        assert_eq!(read.command(0.0), Some(command), "{text}");
    }
    // As they were written before there were frames and kickers.
    let old = r#"{"drive":{"id":1,"linear":[1.0,0.0],"angular":0.0}}"#;
    let read: Asked = serde_json::from_str(old).expect("an older journal");
    assert!(matches!(read, Asked::Drive { frame: Frame::Own, .. }));
    let old = r#"{"driven":{"id":1,"drive":["holonomic",[null,1.0,null,null],0.5]}}"#;
    let read: Entry = serde_json::from_str(old).expect("an older journal");
    assert!(matches!(read, Entry::Driven { drive, .. } if drive.drive().kicker.is_none()));
}

#[test]
fn a_recording_is_answered_as_it_would_have_been_live_and_always_alike() {
    let folder = folder("answered");
    let path = folder.join("asked");
    let qos = Qos::default().to_yaml();
    let mut bag = BagWriter::create(&path, Options::default(), Vec::new()).expect("new");
    let topic = bag.topic("/circle_states", KIND, &qos).expect("known");
    let circle = |id: u32, x: f64, vx: f64| carom::messages::CircleState {
        id,
        x,
        y: 0.0,
        vx,
        vy: 0.0,
        radius: 0.5,
        mass: f64::from(id),
    };
    let asked: Vec<CircleStates> = (0..200)
        .map(|k| {
            let circles = vec![circle(1, 0.0, 1.0), circle(2, 0.9 + 0.001 * f64::from(k), -0.1)];
            CircleStates { header: states(k).0.header, part: 0, parts: 0, circles }
        })
        .collect();
    for (k, message) in (0..).zip(&asked) {
        let payload = decode::payload(message).expect("a message");
        bag.write(topic, time(k), time(k), &payload).expect("room");
    }
    bag.finish().expect("room");
    let scene = Scene::load("resolver").expect("shipped");
    let bag = Bag::open(&path).expect("a bag");
    let outs = ["a", "b"].map(|parent| folder.join(parent).join("answers"));
    for out in &outs {
        let done = offline::answer(&bag, &scene, out).expect("answers");
        // They touch up to a distance of 1: the first 100 or 101 of them.
        assert_eq!((done.messages, done.refused), (200, 0));
        assert!((100..=101).contains(&done.answers), "{done:?}");
    }
    let bytes = |out: &Path, name: &str| fs::read(out.join(name)).expect("a file");
    for name in ["answers_0.mcap", "metadata.yaml"] {
        assert!(bytes(&outs[0], name) == bytes(&outs[1], name), "{name}");
    }
    let mut live = World::new(scene.settings, &[]);
    let answers = Bag::open(&outs[0]).expect("a bag");
    let mut told = answers.messages(|_| true).map(|message| message.expect("sound").payload);
    for (k, message) in (0..).zip(&asked) {
        let (report, _) = receive::report(message).expect("sound");
        let heard_at = 0.01 * f64::from(k);
        let instants = Instants { heard_at, advance_to: 0.0 };
        let outcome = live.step(&[Asking::Observe(report)], instants);
        let answer = &outcome.answers[0];
        if answer.contacts.is_empty() {
            continue;
        }
        let header = message.header.clone();
        let velocities = publish::corrected_velocities(header.clone(), &answer.velocities);
        let read: CircleVelocities = decode::message(&told.next().expect("told")).expect("sound");
        assert_eq!(read, velocities);
        let read: Contacts = decode::message(&told.next().expect("told")).expect("sound");
        assert_eq!(read, publish::contacts(header, &answer.contacts));
    }
    assert_eq!(told.next(), None);
}

#[test]
fn the_command_line_says_in_one_line_what_is_wrong_with_a_bag() {
    let folder = folder("command");
    let text = folder.join("notes.mcap");
    fs::write(&text, "some text, and more of it").expect("a file");
    let foreign = folder.join("foreign.mcap");
    fs::write(&foreign, super::common::mcap_bytes(0..3, None)).expect("a file");
    let there = folder.join("there");
    fs::create_dir(&there).expect("a folder");
    let there = there.to_str().expect("text");
    let cases: [(&Path, &[&str], &str); 6] = [
        (&text, &[], "is no recording"),
        (&text, &["--verify"], "is no recording"),
        (Path::new("/nowhere/at/all"), &[], "cannot be read"),
        (&folder.join("there"), &[], "without a recording"),
        (&foreign, &["--out", there], "is there already"),
        (&foreign, &["--out", "x", "--verify"], "cannot be used with"),
    ];
    for (path, more, what) in cases {
        let (code, out, error) = run_from(path, more);
        assert_eq!((code, out.as_str()), (Some(2), ""), "{error}");
        assert!(error.lines().last().is_some_and(|line| line.contains(what)), "{error}: {what}");
        assert!(error.lines().all(|line| line.starts_with("carom: ")), "{error}");
    }
    // A part of a bag is answered, and what is missing is said.
    let whole = super::common::mcap_bytes(0..40, None);
    let cut = folder.join("cut.mcap");
    fs::write(&cut, &whole[..whole.len() / 2]).expect("a file");
    let out = folder.join("answers");
    let (code, _, error) = run_from(&cut, &["--out", out.to_str().expect("text")]);
    assert_eq!(code, Some(0), "{error}");
    assert!(error.contains("not closed") && error.contains("ends too early"), "{error}");
    assert!(Bag::open(&out).expect("a bag").faults().is_empty());
}
