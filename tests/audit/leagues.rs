//! Games: what the audit says of robots that drive, of a ball that slows down, and of a boundary of
//! segments.

use carom::audit::findings::{Findings, Kind, Met};
use carom::audit::surroundings::Surroundings;
use carom::audit::{Frame, Options};
use carom::plan::Method;
use carom::scene::Scene;
use carom::world::{
    Command, Disc, Frame as In, Instants, Owner, Segment, Segments, Settings, Walls, Wanted, World,
};
use glam::DVec2;

use crate::audited;
use crate::clean::{assert_clean, told};
use crate::common::disc;
use crate::recordings::{Engine, Spoil};

/// Whether no robot is within a quarter of a metre of the ball.
fn is_free(world: &World, ball: u32) -> bool {
    let pucks = || world.arena().expect("pucks").discs(Owner::Simulated);
    let own = pucks().find(|disc| disc.id == ball).expect("a ball");
    let gap = |disc: &Disc| disc.position.distance(own.position) - disc.radius - own.radius;
    pucks().all(|disc| disc.id == ball || gap(&disc) > 0.25)
}

/// A league's game: robots drive, a ball slows down, goals are no box.
#[test]
fn a_league_game_has_no_violation() {
    // In the two-dimensional league there is so much room that contacts take longer to come.
    let leagues = ["ssl-a", "ssl-b", "vsss-3v3", "vsss-5v5", "league-2d"];
    for (name, samples) in leagues.into_iter().zip([1_800, 1_800, 1_800, 1_800, 7_200]) {
        let scene = Scene::load(name).expect("shipped");
        let mut world = scene.world();
        let mut frames = Vec::new();
        let ball = scene.pucks.iter().find(|puck| puck.ball.is_some()).expect("a ball").disc.id;
        let half = 0.4 * scene.field.expect("a field").length;
        for k in 0..samples {
            let mut commands = Vec::new();
            // Commands are over after a tenth of a second.
            if k % 5 == 0 {
                for (place, puck) in scene.pucks.iter().filter(|puck| puck.driven).enumerate() {
                    let angle = 2.4 * (place as f64 + f64::from(k / 60));
                    let wanted = Wanted {
                        linear: DVec2::from_angle(angle) * half,
                        angular: 1.0,
                        frame: In::Arena,
                    };
                    commands.push(Command::Drive { id: puck.disc.id, wanted });
                }
            }
            // A hand that takes the ball off a robot is neither a drive nor a kicker.
            if k % 60 == 0 && is_free(&world, ball) {
                let velocity = DVec2::from_angle(1.9 * f64::from(k / 60)) * 2.0;
                commands.push(Command::SetVelocity { id: ball, velocity });
            }
            let advance_to = f64::from(k) / 60.0;
            let outcome = world.step(&commands, Instants { heard_at: 0.0, advance_to });
            assert!(outcome.stall.is_none() && outcome.not_done.is_empty());
            let discs = world.arena().expect("pucks").discs(Owner::Simulated).collect();
            frames.push(Frame { time_ns: (1e9 * advance_to).round() as i64, discs });
        }
        let contacts = world.arena().expect("pucks").contacts();
        assert!(contacts > 30, "{name}: {contacts}");
        let Settings { restitution, walls, .. } = scene.settings;
        let mut options = told(restitution, walls);
        options.take_surroundings(&scene);
        let (findings, collisions) = audited(frames, &options);
        assert_clean(&findings, name);
        assert!(!collisions.is_empty(), "{name}: {:?}", findings.counts);
        if scene.settings.segments.is_some() {
            assert!(findings.counts.walls > 20, "{name}: {:?}", findings.counts);
        }
    }
}

/// A collision that loses too much is found in the open, and not judged beside a segment.
#[test]
fn beside_a_segment_only_what_the_law_of_discs_explains_is_judged() {
    let discs = vec![
        disc(0, [-0.5, 0.02], [1.0, 0.0], 0.1, 1.0),
        disc(1, [0.5, 0.0], [-1.0, 0.0], 0.1, 2.0),
    ];
    for (spoil, y, wanted) in [
        (Some(Spoil::Energy), 5.0, (1, 0)),
        (Some(Spoil::Energy), 0.11, (0, 1)),
        (None, 0.11, (0, 0)),
    ] {
        let mut engine = Engine::new(discs.clone(), 0.9, None);
        // Until one of them comes to the segment, of which that engine knows nothing.
        let (frames, _) = engine.record(60.0, 44, spoil, |_, _, _, _| true);
        let (from, to) = (DVec2::new(-9.0, y), DVec2::new(9.0, y));
        let segments = vec![Segment { from, to }];
        let surroundings = Surroundings { segments, ..Surroundings::default() };
        let (findings, _) = audited(frames, &Options { surroundings, ..told(0.9, None) });
        let found = (findings.violations_in_all(), findings.counts.beside);
        assert_eq!(found, wanted, "{spoil:?} {y} {:?}", findings.violations);
    }
}

/// A way around the end of a segment goes through none, though the straight line does.
#[test]
fn a_way_around_a_segment_is_no_tunnelling() {
    let bar = Segment { from: DVec2::ZERO, to: DVec2::new(10.0, 0.0) };
    let walls = Walls { min: DVec2::new(-1.2, -50.0), max: DVec2::splat(50.0), restitution: 1.0 };
    let seen = [([5.0, 3.0], [-2.0, -1.0]), ([1.0, 1.0], [-2.0, -1.0]), ([0.8, -1.0], [2.0, -1.0])];
    let frame = |(k, (at, velocity)): (usize, ([f64; 2], [f64; 2]))| Frame {
        time_ns: 2_000_000_000 * k as i64,
        discs: vec![disc(0, at, velocity, 0.1, 1.0)],
    };
    let frames = seen.into_iter().enumerate().map(frame).collect();
    let surroundings = Surroundings { segments: vec![bar], ..Surroundings::default() };
    let (findings, _) = audited(frames, &Options { surroundings, ..told(1.0, Some(walls)) });
    assert_clean(&findings, "around a bar");
    assert_eq!(findings.counts.walls, 1);
}

/// A room without a right angle.
fn room() -> Vec<Segment> {
    let corners = [[-2.0, -1.1], [1.7, -1.3], [2.1, 0.9], [0.1, 1.6], [-1.9, 1.2]].map(DVec2::from);
    let ends = corners.iter().zip(corners.iter().cycle().skip(1));
    ends.map(|(from, to)| Segment { from: *from, to: *to }).collect()
}

/// What the bounce with this number is like: lawful, or not.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Bounce {
    Lawful,
    /// With another restitution.
    Weak,
    /// And turned.
    Turned,
    /// There is none.
    Through,
}

const LAW: f64 = 0.98;

/// One disc in a room at 60 Hz, whose twelfth bounce is like this, and how often it bounced.
fn bouncing(twelfth: Bounce, sizes: (f64, f64)) -> (Vec<Frame>, usize) {
    let (radius, speed) = sizes;
    let mut one = disc(0, [0.1, 0.2], [speed, 0.61 * speed], radius, 0.5);
    let (mut frames, mut bounces) = (Vec::new(), 0);
    for k in 0..2_400i64 {
        let frame = Frame { time_ns: (k * 1_000_000_000) / 60, discs: vec![one] };
        frames.push(frame);
        let is_twelfth = bounces == 11 && twelfth != Bounce::Lawful;
        let restitution = if is_twelfth { 0.6 * LAW } else { LAW };
        let segments = Segments::new(&room(), restitution).expect("a room");
        let settings = Settings {
            segments: Some(segments),
            method: Some(Method::Plain),
            ..Settings::default()
        };
        let mut world = World::new(settings, &[one]);
        let outcome = world.step(&[], Instants { heard_at: 0.0, advance_to: 1.0 / 60.0 });
        assert!(outcome.stall.is_none());
        let next = world.arena().expect("a puck").discs(Owner::Simulated).next().expect("one");
        bounces += outcome.contacts.len();
        one = match (twelfth, is_twelfth && !outcome.contacts.is_empty()) {
            (Bounce::Turned, true) => {
                let time = outcome.contacts[0].time;
                let velocity = DVec2::from_angle(0.3).rotate(next.velocity);
                let place = one.position + one.velocity * time;
                Disc { position: place + velocity * (1.0 / 60.0 - time), velocity, ..next }
            }
            (Bounce::Through, true) => {
                frames.extend((1..12).map(|more| {
                    let position = one.position + one.velocity * more as f64 / 60.0;
                    let time_ns = ((k + more) * 1_000_000_000) / 60;
                    Frame { time_ns, discs: vec![Disc { position, ..one }] }
                }));
                break;
            }
            _ => next,
        };
    }
    (frames, bounces)
}

fn in_the_room(frames: Vec<Frame>) -> (Findings, usize) {
    let around =
        Surroundings { segments: room(), segment_restitution: LAW, ..Surroundings::default() };
    let options = Options { surroundings: around, ..told(1.0, None) };
    let (findings, collisions) = audited(frames, &options);
    (findings, collisions.iter().filter(|each| each.b == Met::Wall).count())
}

/// Alone at a segment a disc is judged: every bounce but those into two segments at once.
#[test]
fn bounces_off_segments_are_judged() {
    for sizes in [(0.1, 1.5), (0.03, 4.0)] {
        let (frames, bounces) = bouncing(Bounce::Lawful, sizes);
        let (findings, judged) = in_the_room(frames);
        assert_clean(&findings, "a room");
        assert!(judged * 10 >= bounces * 9 && bounces > 20, "{judged} of {bounces}");
        for (spoilt, kinds) in [
            (Bounce::Weak, vec![Kind::Energy]),
            (Bounce::Turned, vec![Kind::Normal]),
            (Bounce::Through, vec![Kind::Tunnelling]),
        ] {
            let (findings, _) = in_the_room(bouncing(spoilt, sizes).0);
            assert_eq!(findings.violations_in_all(), 1, "{spoilt:?} {:?}", findings.violations);
            let found = &findings.violations[0];
            let named = |kind: &Kind| found.kind == *kind || found.also.contains(kind);
            assert!(kinds.iter().all(named) && found.wall, "{spoilt:?}: {found:?}");
        }
    }
}
