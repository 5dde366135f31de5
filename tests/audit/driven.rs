//! Bags of pucks under command, whose drives take any velocity at once.

use std::collections::BTreeMap;
use std::path::Path;

use carom::audit::Frame;
use carom::bag::decode;
use carom::bag::qos::Qos;
use carom::bag::write::{BagWriter, Options};
use carom::messages::Twist;
use carom::scene::Scene;
use carom::world::{Command as Order, Disc, Frame as In, Instants, Owner, Wanted, World};
use glam::DVec2;

use super::recordings::{Engine, Spoil};
use super::{KIND, common, folder, json, states};

/// Samples, 60 a second.
const SAMPLES: u32 = 1_200;

/// A scene that runs, and what a bag of it holds so far.
struct Recorded<'a> {
    scene: &'a Scene,
    world: World,
    frames: Vec<Frame>,
    /// When, ns, and to which puck.
    commands: Vec<(u64, usize, Twist)>,
}

impl<'a> Recorded<'a> {
    /// Runs a scene whose first two pucks are told 30 times a second to go to each other.
    fn run(scene: &'a Scene) -> Self {
        let (frames, commands) = (Vec::new(), Vec::new());
        let mut recorded = Self { scene, world: scene.world(), frames, commands };
        for k in 0..SAMPLES {
            let sample = f64::from(k) / 60.0;
            if k % 2 == 1 {
                // Commands come between the ticks.
                recorded.advance(&[], sample - 0.007);
                recorded.chase(k, sample - 0.007);
            }
            recorded.advance(&[], sample);
            let discs = recorded.world.arena().expect("pucks").discs(Owner::Simulated).collect();
            let time_ns = (1e9 * sample).round() as i64;
            recorded.frames.push(Frame { time_ns, discs });
        }
        recorded
    }

    fn advance(&mut self, orders: &[Order], advance_to: f64) {
        let outcome = self.world.step(orders, Instants { heard_at: 0.0, advance_to });
        assert!(outcome.stall.is_none() && outcome.not_done.is_empty());
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

    /// Writes a bag, with or without the commands.
    fn write(&self, path: &Path, with_commands: bool) {
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
        for (log, place, twist) in self.commands.iter().filter(|_| with_commands) {
            let payload = decode::payload(twist).expect("a message");
            bag.write(topics[*place], *log, *log, &payload).expect("room");
        }
        bag.finish().expect("room");
    }
}

#[test]
fn pucks_that_are_commanded_while_they_collide_do_nothing_unlawful() {
    let folder = folder("commanded");
    let scene = Scene::load("arena").expect("shipped");
    let recorded = Recorded::run(&scene);
    let (with, without) = (folder.join("with"), folder.join("without"));
    recorded.write(&with, true);
    recorded.write(&without, false);
    let (told, code) = json(&with, &[]);
    assert_eq!((told["violations"].as_u64(), code), (Some(0), Some(0)), "{told}");
    let count = |what: &str| told["counts"][what].as_u64().expect("a count");
    assert!(count("beside") > 50 && count("alone") > 300, "{told}");
    // The same changes that nobody commanded are called what they are.
    let (told, code) = json(&without, &[]);
    assert!(told["violations"].as_u64() > Some(20) && code == Some(1), "{told}");
    assert_eq!(told["counts"]["beside"], 0, "{told}");
}

/// Two that are driven into each other, one that rolls by, and two far from all, which are spoilt.
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
fn what_is_unlawful_far_from_commands_is_found_in_the_same_bag() {
    let folder = folder("commanded_spoilt");
    let scene = carom::scene::file::parse(HALL, "hall").expect("sound");
    let mut recorded = Recorded::run(&scene);
    let ids = [3, 4].map(|place: usize| scene.pucks[place].disc.id);
    let discs = vec![
        common::disc(ids[0], [-30.0, 0.03], [1.1, 0.0], 0.1, 2.0),
        common::disc(ids[1], [-29.0, 0.0], [-0.6, 0.1], 0.15, 1.0),
    ];
    for (spoil, count) in [(None, 0), (Some(Spoil::Energy), 1)] {
        let mut engine = Engine::new(discs.clone(), 1.0, None);
        let (apart, _) = engine.record(60.0, SAMPLES as usize, spoil, |_, _, _, _| true);
        for (frame, apart) in recorded.frames.iter_mut().zip(apart) {
            frame.discs.retain(|disc| !ids.contains(&disc.id));
            frame.discs.extend(apart.discs);
            frame.discs.sort_by_key(|disc| disc.id);
        }
        let path = folder.join(count.to_string());
        recorded.write(&path, true);
        let (told, code) = json(&path, &[]);
        assert_eq!(
            (told["violations"].as_u64(), code),
            (Some(count), Some(count as i32)),
            "{told}"
        );
        assert!(told["counts"]["beside"].as_u64() > Some(20), "{told}");
        if count > 0 {
            assert_eq!(told["worst"][0]["kind"], "energy", "{told}");
            assert_eq!(told["worst"][0]["discs"], serde_json::json!(ids), "{told}");
        }
    }
}
