//! Bags of pucks under command, whose drives take any velocity at once, and of pucks among circles
//! that others report.

use std::collections::BTreeMap;
use std::path::Path;

use carom::audit::Frame;
use carom::bag::decode;
use carom::bag::qos::Qos;
use carom::bag::write::{BagWriter, Options};
use carom::messages::{CircleState, CircleStates, Contacts, Header, Twist};
use carom::scene::Scene;
use carom::world::{Command as Order, Disc, Frame as In, Instants, Owner, Wanted, World};
use carom::{publish, receive};
use glam::DVec2;

use super::recordings::{Engine, Spoil};
use super::{KIND, common, folder, json, stamp, states};

/// Samples, 60 a second.
const SAMPLES: u32 = 1_200;

/// A scene that runs, and what a bag of it holds so far.
struct Recorded<'a> {
    scene: &'a Scene,
    world: World,
    frames: Vec<Frame>,
    /// When, ns, and to which puck.
    commands: Vec<(u64, usize, Twist)>,
    /// When, ns, and what somebody reported.
    circles: Vec<(u64, CircleStates)>,
    contacts: Vec<(u64, Contacts)>,
}

/// Which topics a bag has besides the pucks.
#[derive(Clone, Copy, Debug, Default)]
struct Besides {
    commands: bool,
    circles: bool,
    contacts: bool,
}

impl<'a> Recorded<'a> {
    fn new(scene: &'a Scene) -> Self {
        let (frames, commands, circles, contacts) = <_>::default();
        Self { scene, world: scene.world(), frames, commands, circles, contacts }
    }

    /// Runs a scene whose first two pucks are told 30 times a second to go to each other.
    fn run(scene: &'a Scene) -> Self {
        Self::sampled(scene, 2, |recorded, k, now| recorded.chase(k, now))
    }

    /// Runs a scene in which somebody reports a circle that goes round about a place, 20 times a
    /// second.
    fn visited(scene: &'a Scene, about: DVec2) -> Self {
        Self::sampled(scene, 3, |recorded, _, now| recorded.visit(about, now))
    }

    /// Runs a scene in which something happens before every so many samples, between the ticks.
    fn sampled(scene: &'a Scene, every: u32, act: impl Fn(&mut Self, u32, f64)) -> Self {
        let mut recorded = Self::new(scene);
        for k in 0..SAMPLES {
            let sample = f64::from(k) / 60.0;
            if k % every == 1 {
                recorded.advance(&[], sample - 0.007);
                act(&mut recorded, k, sample - 0.007);
            }
            recorded.sample(sample);
        }
        recorded
    }

    fn visit(&mut self, about: DVec2, now: f64) {
        let turned = DVec2::from_angle(0.7 * now);
        let (place, velocity) = (about + turned, 0.7 * turned.perp());
        let circle = CircleState {
            id: 4_000,
            x: place.x,
            y: place.y,
            vx: velocity.x,
            vy: velocity.y,
            radius: 0.2,
            mass: 5.0,
        };
        let header = Header { stamp: stamp(77_000_000_000), frame_id: "map".to_owned() };
        let message = CircleStates { header, part: 0, parts: 0, circles: vec![circle] };
        let (report, _) = receive::report(&message).expect("sound");
        self.circles.push(((1e9 * now) as u64, message));
        self.advance(&[Order::Observe(report)], now);
    }

    fn sample(&mut self, at: f64) {
        self.advance(&[], at);
        let discs = self.world.arena().expect("pucks").discs(Owner::Simulated).collect();
        self.frames.push(Frame { time_ns: (1e9 * at).round() as i64, discs });
    }

    fn advance(&mut self, orders: &[Order], advance_to: f64) {
        let outcome = self.world.step(orders, Instants { heard_at: 0.0, advance_to });
        assert!(outcome.stall.is_none() && outcome.not_done.is_empty());
        if !outcome.contacts.is_empty() {
            let time_ns = (1e9 * advance_to).round() as i64;
            let header = Header { stamp: stamp(time_ns), frame_id: "map".to_owned() };
            let message = publish::contacts(header, &outcome.contacts);
            self.contacts.push((time_ns as u64, message));
        }
    }

    fn chase(&mut self, k: u32, now: f64) {
        let discs: Vec<Disc> = self.world.arena().expect("pucks").discs(Owner::Simulated).collect();
        let of = |place: usize| {
            let id = self.scene.pucks[place].disc.id;
            *discs.iter().find(|disc| disc.id == id).expect("it is there")
        };
        let [a, b] = [of(0), of(1)];
        let way = (b.position - a.position).normalize();
        for (place, sign) in [(0, 1.0), (1, -1.0)] {
            let linear = DVec2::from_angle(0.01 * f64::from(k)).lerp(sign * way, 0.7);
            let wanted = Wanted { linear, angular: 0.0, frame: In::Arena };
            let id = self.scene.pucks[place].disc.id;
            self.advance(&[Order::Drive { id, wanted }], now);
            let mut twist = Twist::default();
            (twist.linear.x, twist.linear.y) = (linear.x, linear.y);
            self.commands.push(((1e9 * now) as u64, place, twist));
        }
    }

    /// Writes a bag.
    fn write(&self, path: &Path, besides: Besides) {
        let note = BTreeMap::from([("scene".to_owned(), self.scene.text.to_string())]);
        let notes = vec![(carom::bag::journal::NOTE.to_owned(), note)];
        let mut bag = BagWriter::create(path, Options::default(), notes).expect("new");
        let qos = Qos::default().to_yaml();
        let arena = bag.topic("/arena_states", KIND, &qos).expect("known");
        let topics = [0, 1].map(|place| {
            let name = format!("/{}", self.scene.pucks[place].topic("cmd_vel"));
            bag.topic(&name, "geometry_msgs/msg/Twist", &qos).expect("known")
        });
        for frame in &self.frames {
            let log = frame.time_ns as u64;
            bag.write(arena, log, log, &states(frame, 1)[0]).expect("room");
        }
        for (log, place, twist) in self.commands.iter().filter(|_| besides.commands) {
            let payload = decode::payload(twist).expect("a message");
            bag.write(topics[*place], *log, *log, &payload).expect("room");
        }
        if besides.circles {
            let topic = bag.topic("/circle_states", KIND, &qos).expect("known");
            for (log, message) in &self.circles {
                let payload = decode::payload(message).expect("a message");
                bag.write(topic, *log, *log, &payload).expect("room");
            }
        }
        if besides.contacts {
            let topic = bag.topic("/contacts", "carom/msg/Contacts", &qos).expect("known");
            for (log, message) in &self.contacts {
                let payload = decode::payload(message).expect("a message");
                bag.write(topic, *log, *log, &payload).expect("room");
            }
        }
        bag.finish().expect("room");
    }

    /// Two pucks of the hall, far from all others, collide: as they should, or spoilt.
    fn collide_apart(&mut self, how: Option<Spoil>) -> [u32; 2] {
        let ids = [3, 4].map(|place: usize| self.scene.pucks[place].disc.id);
        let discs = vec![
            common::disc(ids[0], [-30.0, 0.03], [1.1, 0.0], 0.1, 2.0),
            common::disc(ids[1], [-29.0, 0.0], [-0.6, 0.1], 0.15, 1.0),
        ];
        let mut engine = Engine::new(discs, 1.0, None);
        let (apart, _) = engine.record(60.0, SAMPLES as usize, how, |_, _, _, _| true);
        for (frame, apart) in self.frames.iter_mut().zip(apart) {
            frame.discs.retain(|disc| !ids.contains(&disc.id));
            frame.discs.extend(apart.discs);
            frame.discs.sort_by_key(|disc| disc.id);
        }
        ids
    }
}

#[test]
fn pucks_that_are_commanded_while_they_collide_do_nothing_unlawful() {
    let folder = folder("commanded");
    let scene = Scene::load("arena").expect("shipped");
    let recorded = Recorded::run(&scene);
    let (with, without) = (folder.join("with"), folder.join("without"));
    recorded.write(&with, Besides { commands: true, contacts: true, ..Besides::default() });
    recorded.write(&without, Besides { contacts: true, ..Besides::default() });
    let (told, code) = json(&with, &[]);
    assert_eq!((told["violations"].as_u64(), code), (Some(0), Some(0)), "{told}");
    let count = |what: &str| told["counts"][what].as_u64().expect("a count");
    assert!(count("beside") > 50 && count("alone") > 300, "{told}");
    // The same changes that nobody commanded are called what they are.
    let (told, code) = json(&without, &[]);
    assert!(told["violations"].as_u64() > Some(20) && code == Some(1), "{told}");
    assert_eq!(told["counts"]["beside"], 0, "{told}");
}

/// Two that are driven into each other, one that rolls by, and two far from all.
const HALL: &str = "restitution: 1.0
walls: {x: [-40, 40], y: [-3, 3]}
pucks:
  - {name: alice, position: [20, 0], radius: 0.2, mass: 3.0}
  - {name: bob, position: [22, 0.1], radius: 0.2, mass: 3.0}
  - {name: carol, position: [21, 1.5], velocity: [0.3, -0.9], radius: 0.1, mass: 1.0, driven: false}
  - {name: left, position: [-30, 0], radius: 0.1, mass: 2.0}
  - {name: right, position: [-28, 0], radius: 0.15, mass: 1.0}
";

#[test]
fn what_is_unlawful_far_from_commands_or_circles_of_others_is_found_in_the_same_bag() {
    let folder = folder("commanded_spoilt");
    let scene = carom::scene::file::parse(HALL, "hall").expect("sound");
    let driven = Recorded::run(&scene);
    let visited = Recorded::visited(&scene, DVec2::new(21.0, 0.3));
    for (name, mut recorded) in [("driven", driven), ("visited", visited)] {
        for (spoil, count) in [(None, 0), (Some(Spoil::Energy), 1)] {
            let ids = recorded.collide_apart(spoil);
            let path = folder.join(format!("{name}_{count}"));
            recorded.write(&path, Besides { commands: true, circles: true, contacts: true });
            let (told, code) = json(&path, &[]);
            let found = (told["violations"].as_u64(), code);
            assert_eq!(found, (Some(count), Some(count as i32)), "{name} {told}");
            assert!(told["counts"]["beside"].as_u64() > Some(0), "{name} {told}");
            if count > 0 {
                assert_eq!(told["worst"][0]["kind"], "energy", "{told}");
                assert_eq!(told["worst"][0]["discs"], serde_json::json!(ids), "{told}");
            }
        }
    }
}

#[test]
fn pucks_that_meet_circles_of_others_do_nothing_unlawful() {
    let folder = folder("visited");
    let scene = Scene::load("arena").expect("shipped");
    let mut recorded = Recorded::visited(&scene, DVec2::new(2.0, 1.5));
    let whole = recorded.frames.clone();
    let mut unlawful = [0; 2];
    // The fewer samples, the more contacts of others fall on those of circles.
    for every in [1, 3, 6] {
        recorded.frames = whole.iter().step_by(every).cloned().collect();
        let besides = [(true, true), (true, false), (false, true)];
        let told = besides.map(|(circles, contacts)| {
            let path = folder.join(format!("{every}_{circles}_{contacts}"));
            recorded.write(&path, Besides { commands: false, circles, contacts });
            json(&path, &[])
        });
        let [(all, code), (no_contacts, _), (no_circles, _)] = told;
        let said = all["worst"].to_string();
        assert_eq!((all["violations"].as_u64(), code), (Some(0), Some(0)), "{every} {said}");
        let count = |what: &str| all["counts"][what].as_u64().expect("a count");
        assert!(count("beside") > 20 && count("alone") > 100, "{every} {}", all["counts"]);
        // Whom nobody reported nobody has met; where contacts are missing, it is said.
        for (told, unlawful) in [&no_contacts, &no_circles].into_iter().zip(&mut unlawful) {
            *unlawful += told["violations"].as_u64().expect("a count");
            assert_eq!(told["counts"]["beside"], 0, "{}", told["counts"]);
        }
        assert!(no_contacts["notes"].to_string().contains("no contacts are recorded"));
    }
    assert!(unlawful.into_iter().all(|count| count > 0), "{unlawful:?}");
}
