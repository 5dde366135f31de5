//! The wire of a node whose scene changes: what teams are told, as they read it.

use std::net::{Ipv4Addr, SocketAddr, UdpSocket as Listener};
use std::time::Instant;

use prost::Message;
use tokio::runtime::Runtime;

use super::*;
use crate::node::stage::ALL;
use crate::node::timeline::Timeline;
use crate::scene::Scene;
use crate::wire::proto::vision::{SslDetectionFrame, SslGeometryFieldSize, SslWrapperPacket};
use crate::world::Instants;

/// A node with a wire, without its loop, and a team that listens.
struct Game {
    wire: Wire,
    stage: Stage,
    complaints: Complaints,
    vision: Listener,
    _tracked: Listener,
    _runtime: Runtime,
}

fn listener() -> (Listener, SocketAddrV4) {
    // Loopback is there, and the system chooses a port that is free.
    let listener = Listener::bind((Ipv4Addr::LOCALHOST, 0)).expect("loopback");
    // It is a socket.
    listener.set_nonblocking(true).expect("a socket");
    let Ok(SocketAddr::V4(address)) = listener.local_addr() else { panic!("bound to it") };
    (listener, address)
}

fn scene(name: &str) -> Scene {
    // Those that are named here are shipped.
    Scene::load(name).expect("shipped")
}

impl Game {
    fn new(name: &str) -> Self {
        let ((vision, address), (_tracked, tracked)) = (listener(), listener());
        // Scenes of leagues have a field.
        let field = Field::new(League::Ssl, scene(name).field.expect("a field"));
        let options =
            WireOptions { ports: vec![0; 4], vision: address, tracked, ..WireOptions::new(field) };
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build();
        // As the node has it.
        let _runtime = runtime.expect("a runtime");
        let now = Instant::now();
        let wire = _runtime.block_on(async {
            // Loopback is there.
            let (wire, _) = Wire::new(Ports::open(&options).expect("ports")).expect("sockets");
            // It has sent nothing yet.
            wire.out.writable().await.expect("a socket");
            wire
        });
        let stage = Stage::new(scene(name), Timeline::new(1.0, 60.0, None, now));
        let complaints = Complaints::new(now);
        Self { wire, stage, complaints, vision, _tracked, _runtime }
    }

    /// What is told of the next frame: what is seen, and the field.
    fn see(&mut self) -> (Vec<SslDetectionFrame>, Option<SslGeometryFieldSize>) {
        let advance_to = self.wire.next_frame();
        let outcome = self.stage.step(None, Instants { heard_at: f64::NEG_INFINITY, advance_to });
        assert_eq!(outcome.stall, None);
        self.wire.look(&self.stage, &mut self.complaints);
        let (mut seen, mut field, mut buffer) = (Vec::new(), None, [0; 65_536]);
        while let Ok(length) = self.vision.recv(&mut buffer) {
            // They are ours.
            let packet = SslWrapperPacket::decode(&buffer[..length]).expect("a packet");
            seen.extend(packet.detection);
            field = packet.geometry.map(|data| data.field).or(field);
        }
        (seen, field)
    }

    fn follow(&mut self, is_new: bool) {
        self.wire.follow(&self.stage, is_new, &mut self.complaints);
    }
}

fn robots(seen: &[SslDetectionFrame]) -> usize {
    seen.iter().map(|frame| frame.robots_blue.len() + frame.robots_yellow.len()).sum()
}

#[test]
fn another_scene_is_told_with_its_own_field_and_robots() {
    let mut game = Game::new("ssl-b");
    let (seen, field) = game.see();
    let size =
        |field: Option<SslGeometryFieldSize>| field.map(|it| (it.field_length, it.goal_width));
    assert_eq!((robots(&seen), size(field)), (12, Some((9_000, 1_000))));
    for _ in 0..10 {
        assert_eq!(game.see().1, None, "geometry comes once a second");
    }
    let before = game.see().0[0].t_capture;
    game.stage.load(scene("ssl-a"), Instant::now());
    game.follow(true);
    let (seen, field) = game.see();
    assert_eq!((robots(&seen), size(field)), (22, Some((12_000, 1_800))));
    assert!(seen[0].t_capture >= before, "time stamps go on");
    // A scene without a field is no game.
    game.stage.load(scene("break_shot"), Instant::now());
    game.follow(true);
    for _ in 0..100 {
        assert_eq!(game.see(), (Vec::new(), None));
    }
    game.stage.load(scene("ssl-b"), Instant::now());
    game.follow(true);
    let (seen, field) = game.see();
    assert_eq!((robots(&seen), size(field)), (12, Some((9_000, 1_000))));
}

#[test]
fn time_stamps_go_on_over_a_pause_and_over_a_reset() {
    let mut game = Game::new("ssl-b");
    let mut last = game.see().0[0].t_capture;
    let mut next = |game: &mut Game, passed: f64, what: &str| {
        let now = game.see().0[0].t_capture;
        assert!((now - last - passed).abs() < 2e-6, "{what}: {} s", now - last);
        last = now;
    };
    let period = 1.0 / 60.0;
    (0..20).for_each(|_| next(&mut game, period, "a frame"));
    game.stage.pause();
    game.follow(false);
    game.stage.play(Instant::now());
    game.follow(false);
    next(&mut game, period, "a pause");
    // What is there is reset to where it was.
    game.stage.reset(ALL, Instant::now()).expect("nobody is in the way");
    game.follow(true);
    next(&mut game, 0.0, "a reset");
    next(&mut game, period, "after a reset");
}
