//! The ball and the robots that play it: closed forms, kicks, dribblers, limits, the same bits.

use carom::world::{
    Ball, BallMotion, Command, Contact, Disc, Drive, Frame, HOLD_GAP_M, Instants, Kicker, Model,
    NotDone, Owner, PULL_MPS2, Pace, Settings, Wanted, World,
};
use glam::DVec2;

use crate::common::Random;

const TICK: f64 = 1e-3;
const ROBOT: f64 = 0.09;
const BALL: f64 = 0.0215;

fn settings() -> Settings {
    let method = Some(carom::plan::Method::Ticks);
    let pace = Pace { tick: TICK, ..Pace::default() };
    Settings { pace, method, restitution: 0.6, ..Settings::default() }
}

fn disc(id: u32, at: [f64; 2], velocity: [f64; 2]) -> Disc {
    let (radius, mass) = if id == 0 { (BALL, 0.046) } else { (ROBOT, 2.5) };
    let [position, velocity] = [at, velocity].map(DVec2::from_array);
    Disc { id, position, velocity, radius, mass }
}

const KICKER: Kicker = Kicker { speed_max: 6.5, half_angle: 0.4, reach: 0.01, grip: 50.0 };

fn robot() -> Drive {
    Drive {
        model: Model::Holonomic,
        speed_max: 3.0,
        acceleration_max: 3.0,
        braking_max: Some(6.0),
        turn_max: 6.0,
        turn_acceleration_max: 45.0,
        kicker: Some(KICKER),
        ..Drive::default()
    }
}

/// A ball (0), and robots (1 ...).
fn world(discs: &[Disc]) -> World {
    let mut world = World::new(settings(), discs);
    world.add_ball(0, Ball::default());
    discs.iter().filter(|disc| disc.id > 0).for_each(|disc| world.drive(disc.id, robot()));
    world
}

fn go(world: &mut World, commands: &[Command], to: f64) -> Vec<Contact> {
    let outcome = world.step(commands, Instants { heard_at: 0.0, advance_to: to });
    assert_eq!((outcome.stall, outcome.not_done), (None, vec![]));
    outcome.contacts
}

fn now(world: &World, id: u32) -> Disc {
    world.arena().unwrap().disc(id).unwrap()
}

/// The law in steps so small that only their number is an error: the judge of the closed form.
fn in_steps(ball: &Ball, mut motion: BallMotion, time: f64, steps: u32) -> (BallMotion, DVec2) {
    let (step, mut way) = (time / f64::from(steps), DVec2::ZERO);
    let share = ball.switch_ratio / (1.0 - ball.switch_ratio);
    for _ in 0..steps {
        let before = motion.velocity;
        let slip = motion.velocity - motion.spin;
        if slip.length() > ball.sliding * step / (1.0 - ball.switch_ratio) {
            let change = slip.normalize() * (ball.sliding * step);
            motion.velocity -= change;
            motion.spin += change * share;
        } else {
            let rolls = motion.velocity - slip * (1.0 - ball.switch_ratio);
            let slowing = ball.rolling + ball.drag * rolls.length();
            let speed = (rolls.length() - slowing * step).max(0.0);
            motion = BallMotion::rolling(rolls.normalize_or_zero() * speed);
        }
        way += 0.5 * (before + motion.velocity) * step;
    }
    (motion, way)
}

#[test]
fn the_closed_form_is_the_law() {
    let mut random = Random::new(3);
    for _ in 0..60 {
        let ball = Ball {
            sliding: random.uniform(1.0, 6.0),
            rolling: if random.below(4) == 0 { 0.0 } else { random.uniform(0.0, 1.0) },
            drag: if random.below(2) == 0 { 0.0 } else { random.uniform(0.0, 1.0) },
            switch_ratio: random.uniform(0.5, 0.9),
        };
        let mut vector = || DVec2::new(random.uniform(-4.0, 4.0), random.uniform(-4.0, 4.0));
        let motion = BallMotion { velocity: vector(), spin: 0.4 * vector() };
        let time = random.uniform(0.01, 6.0);
        let (after, way) = ball.after(motion, time);
        let (judged, judged_way) = in_steps(&ball, motion, time, 200_000);
        let off = (after.velocity - judged.velocity).length();
        assert!(off < 1e-3, "{ball:?} {motion:?} after {time}: {after:?} {judged:?}");
        assert!((after.spin - judged.spin).length() < 1e-3, "{after:?} {judged:?}");
        assert!((way - judged_way).length() < 2e-3, "{way} {judged_way}");
        // It stands when that is over, and not before.
        let rest = ball.rests_after(motion);
        if rest.is_finite() {
            let (stands, whole) = ball.after(motion, rest * (1.0 + 1e-12));
            assert_eq!(stands, BallMotion::default(), "{ball:?} {motion:?} {rest}");
            assert!((ball.after(motion, rest).1 - whole).length() < 1e-9);
            assert!(ball.after(motion, rest * (1.0 - 1e-6)).0 != BallMotion::default());
        } else {
            assert!(ball.rolling == 0.0);
        }
        // In parts it is the same.
        let (half, first) = ball.after(motion, 0.4 * time);
        let (whole, second) = ball.after(half, 0.6 * time);
        assert!((whole.velocity - after.velocity).length() < 1e-12);
        assert!((first + second - way).length() < 1e-12);
    }
}

#[test]
fn a_kicked_ball_slides_rolls_and_stops_where_it_should() {
    let ball = Ball::default();
    let (speed, ratio) = (5.0, ball.switch_ratio);
    let mut world = world(&[disc(0, [1.0, 2.0], [speed, 0.0])]);
    // Slides until its speed is that part, then rolls.
    let slides_for = speed * (1.0 - ratio) / ball.sliding;
    let slid = speed * slides_for - 0.5 * ball.sliding * slides_for * slides_for;
    let mut slid_out = world.clone();
    go(&mut slid_out, &[], slides_for);
    assert!((slid_out.ball(0).unwrap().velocity.x - ratio * speed).abs() < 1e-12);
    let rolls_for = ratio * speed / ball.rolling;
    let rolled = 0.5 * (ratio * speed).powi(2) / ball.rolling;
    let mut off = 0.0f64;
    for k in 1..=14_000u32 {
        let time = f64::from(k) * TICK;
        go(&mut world, &[], time);
        let (motion, way) =
            ball.after(BallMotion { velocity: DVec2::X * speed, spin: DVec2::ZERO }, time);
        off = off.max((now(&world, 0).position - DVec2::new(1.0, 2.0) - way).length());
        assert!((world.ball(0).unwrap().velocity - motion.velocity).length() < 1e-12);
    }
    assert!(off < 2e-14, "off the closed form by {off} m at a tick");
    let stop = (slides_for + rolls_for + TICK, 1.0 + slid + rolled);
    assert!(stop.0 < 14.0);
    let stands = now(&world, 0);
    assert_eq!(stands.velocity, DVec2::ZERO, "it stands, exactly");
    assert!((stands.position.x - stop.1).abs() < 1e-14, "{} {}", stands.position.x, stop.1);
    go(&mut world, &[], 20.0);
    assert_eq!(now(&world, 0), stands);
}

#[test]
fn a_ball_set_rolling_rolls_and_one_set_spinning_is_drawn_along() {
    let mut world = world(&[disc(0, [0.0, 0.0], [0.0, 0.0])]);
    let velocity = DVec2::new(0.0, 1.0);
    let place = Command::PlacePuck { id: 0, position: DVec2::X, velocity };
    go(&mut world, &[place.clone(), Command::Roll { id: 0 }], 1.0);
    let speed = 1.0 - Ball::default().rolling;
    assert!((world.ball(0).unwrap().velocity - DVec2::Y * speed).length() < 1e-12);
    // Between two ticks it is exact at the ticks that follow.
    go(&mut world, &[], 1.0004);
    go(&mut world, &[place], 1.003);
    let (_, way) = Ball::default().after(BallMotion { velocity, spin: DVec2::ZERO }, 0.0026);
    assert!((now(&world, 0).position - DVec2::X - way).length() < 1e-15);
}

#[test]
fn a_contact_leaves_the_spin() {
    // It rolls against a robot that stands and comes back sliding: the spin brakes it.
    let mut world = world(&[disc(0, [0.0, 0.0], [1.0, 0.0]), disc(1, [0.3, 0.0], [0.0, 0.0])]);
    go(&mut world, &[Command::Roll { id: 0 }], 0.0);
    let contacts = go(&mut world, &[], 0.5);
    assert_eq!(contacts.len(), 1);
    let (ball, time) = (Ball::default(), 0.5 - contacts[0].time);
    let rolled = 1.0 - ball.rolling * contacts[0].time;
    assert!((contacts[0].approach_speed - rolled).abs() < 0.5 * ball.rolling * TICK + 1e-12);
    let back = 1.6 * contacts[0].approach_speed * 2.5 / 2.546 - contacts[0].approach_speed;
    let bounced = BallMotion { velocity: DVec2::X * -back, spin: DVec2::X * rolled };
    let expected = ball.after(bounced, time).0;
    let found = world.ball(0).unwrap();
    assert!((found.velocity - expected.velocity).length() < ball.sliding * TICK, "{found:?}");
    assert!((found.spin - expected.spin).length() < 2.0 * ball.sliding * TICK, "{expected:?}");
}

#[test]
fn a_kick_needs_the_ball_and_gives_it_the_speed_asked_for() {
    let near = ROBOT + BALL + 0.005;
    let at = |angle: f64| [near * angle.cos(), near * angle.sin()];
    let kick = |place: [f64; 2], speed: f64| {
        let mut world = world(&[disc(0, place, [0.3, 0.2]), disc(1, [0.0, 0.0], [0.0, 0.0])]);
        let has = world.has_ball(1);
        go(&mut world, &[Command::Kick { id: 1, speed }], 0.0);
        (has, world.ball(0).unwrap())
    };
    let (has, kicked) = kick(at(0.1), 4.0);
    assert!(has && (kicked.velocity - DVec2::new(4.0, 0.2)).length() < 1e-12, "{kicked:?}");
    assert_eq!(kicked.spin, DVec2::ZERO);
    assert!((kick(at(0.1), 9.0).1.velocity.x - KICKER.speed_max).abs() < 1e-12, "no faster");
    for place in [at(0.5), [near + 0.01, 0.0]] {
        let (has, kicked) = kick(place, 4.0);
        assert!(!has && (kicked.velocity - DVec2::new(0.3, 0.2)).length() < 1e-12, "{kicked:?}");
    }
}

/// A ball that comes rolling to the robot at 2 m/s, and a kick of 4 m/s that is asked for now.
fn waiting(timeout: f64) -> World {
    let settings = Settings { command_timeout: timeout, ..settings() };
    let discs = [disc(0, [0.25, 0.0], [-2.0, 0.0]), disc(1, [0.0, 0.0], [0.0, 0.0])];
    let mut world = World::new(settings, &discs);
    world.add_ball(0, Ball::default());
    world.drive(1, robot());
    let kick = Command::Kick { id: 1, speed: 4.0 };
    go(&mut world, &[Command::Roll { id: 0 }, kick], 0.0);
    assert_eq!(world.armed(1), Some(4.0));
    world
}

#[test]
fn a_kick_waits_for_the_ball_and_goes_at_the_first_tick_that_has_it() {
    let mut world = waiting(0.0);
    let mut before = world.clone();
    // It is seen at every tick, and kicks before the ball has touched the robot.
    let mut tick = 0;
    while world.armed(1).is_some() {
        assert!(!world.has_ball(1), "tick {tick}: it has the ball and waits");
        before.clone_from(&world);
        tick += 1;
        assert!(go(&mut world, &[], f64::from(tick) * TICK).is_empty());
    }
    // At 2 m/s less what rolling takes, from a gap of 0.1385 m to the reach of 0.01 m.
    assert!((64..=66).contains(&tick), "{tick}");
    let gap = now(&world, 0).position.x - ROBOT - BALL;
    assert!(gap <= KICKER.reach && gap > KICKER.reach - 2.0 * TICK, "{gap}");
    assert!(!before.has_ball(1));
    let kicked = world.ball(0).unwrap();
    assert!((kicked.velocity - DVec2::X * 4.0).length() < 1e-12, "{kicked:?}");
    // The spin is that with which it came: it slides now, and is kicked but once.
    assert!((kicked.spin.x + 2.0).abs() < 0.02, "{kicked:?}");
    let from = now(&world, 0).position;
    assert!(go(&mut world, &[], 0.2).is_empty());
    let (_, way) = Ball::default().after(kicked, 0.2 - f64::from(tick) * TICK);
    assert!((now(&world, 0).position - from - way).length() < 1e-12);
}

#[test]
fn a_waiting_kick_ends_with_its_time_or_when_it_is_taken_back() {
    let bounced = |world: &mut World| {
        let contacts = go(world, &[], 0.1);
        assert_eq!(contacts.len(), 1, "nobody kicked it away: {contacts:?}");
        assert!(world.ball(0).unwrap().velocity.x < 1.5 && world.armed(1).is_none());
    };
    let mut over = waiting(0.05);
    go(&mut over, &[], 0.05);
    assert_eq!(over.armed(1), Some(4.0), "its time is not over yet");
    go(&mut over, &[], 0.052);
    assert_eq!(over.armed(1), None);
    bounced(&mut over);
    // Said again, it waits on.
    let mut again = waiting(0.05);
    go(&mut again, &[], 0.04);
    assert!(go(&mut again, &[Command::Kick { id: 1, speed: 3.0 }], 0.075).is_empty());
    assert!((now(&again, 0).velocity.x - 3.0).abs() < 0.05);
    let mut back = waiting(0.0);
    go(&mut back, &[Command::Kick { id: 1, speed: 0.0 }], 0.05);
    assert_eq!(back.armed(1), None);
    bounced(&mut back);
}

#[test]
fn of_two_that_wait_for_one_ball_the_first_kicks() {
    let discs = [
        disc(0, [0.0, 1.0], [0.0, 0.0]),
        disc(1, [-0.12, 0.0], [0.0, 0.0]),
        disc(2, [0.12, 0.0], [0.0, 0.0]),
    ];
    let mut world = world(&discs);
    let turn = Command::Turn { id: 2, heading: std::f64::consts::PI, turn: 0.0 };
    let kicks = [1, 2].map(|id| Command::Kick { id, speed: f64::from(id) });
    go(&mut world, &[turn, kicks[1].clone(), kicks[0].clone()], 0.01);
    let place = Command::PlacePuck { id: 0, position: DVec2::ZERO, velocity: DVec2::ZERO };
    go(&mut world, &[place], 0.011);
    assert_eq!((world.armed(1), world.armed(2)), (None, Some(2.0)));
    assert!((world.ball(0).unwrap().velocity - DVec2::X).length() < 1e-12);
}

#[test]
fn a_dribbler_holds_the_ball_while_the_robot_drives_and_turns() {
    let mut world = world(&[disc(0, [0.118, 0.01], [-0.2, 0.0]), disc(1, [0.0, 0.0], [0.0, 0.0])]);
    let wanted = Wanted { linear: DVec2::new(1.0, 0.5), angular: 3.0, ..Wanted::default() };
    let commands = [Command::Dribble { id: 1, on: true }, Command::Drive { id: 1, wanted }];
    go(&mut world, &commands, 0.05);
    for k in 51..2_000u32 {
        let contacts = go(&mut world, &[], f64::from(k) * TICK);
        assert!(contacts.is_empty(), "held clear of the robot: {contacts:?}");
        let (ball, robot) = (now(&world, 0), now(&world, 1));
        let heading = DVec2::from_angle(world.pose(1).unwrap().heading);
        let front = robot.position + heading * (ROBOT + BALL + HOLD_GAP_M);
        // The pose is that of the end of the tick which begins; the ball goes there meanwhile.
        assert!((ball.position - front).length() < 3.5e-3 * 0.12 + 1e-6, "{k}: {ball:?} {front}");
    }
    // Let go, it rolls on at the speed it had.
    let before = now(&world, 0).velocity;
    go(&mut world, &[Command::Dribble { id: 1, on: false }], 2.0);
    let released = world.ball(0).unwrap();
    assert!((released.velocity - before).length() < 0.02 && released.spin == released.velocity);
}

#[test]
fn a_kick_gets_away_from_a_running_dribbler_and_a_torn_away_ball_is_lost() {
    let start = [disc(0, [0.113, 0.0], [0.0, 0.0]), disc(1, [0.0, 0.0], [0.0, 0.0])];
    let mut world = world(&start);
    let dribble = Command::Dribble { id: 1, on: true };
    go(&mut world, std::slice::from_ref(&dribble), 0.1);
    go(&mut world, &[Command::Kick { id: 1, speed: 2.0 }], 0.3);
    assert!(now(&world, 0).position.x > 0.4, "{:?}", now(&world, 0));
    // A ball that passes at 6 m/s across the mouth needs more than the grip to be stopped.
    let passing = [disc(0, [0.113, -0.06], [0.0, 6.0]), start[1]];
    let mut world = self::world(&passing);
    go(&mut world, &[dribble], 0.2);
    assert!(now(&world, 0).position.y > 0.2, "{:?}", now(&world, 0));
}

#[test]
fn velocities_are_local_or_global_and_braking_is_a_limit_of_its_own() {
    for (frame, expected) in [(Frame::Own, DVec2::Y), (Frame::Arena, DVec2::X)] {
        let mut world = world(&[disc(1, [0.0, 0.0], [0.0, 0.0])]);
        let wanted = Wanted { linear: DVec2::X, angular: 0.0, frame };
        let quarter = std::f64::consts::FRAC_PI_2;
        let turn = Command::Turn { id: 1, heading: quarter, turn: 0.0 };
        go(&mut world, &[turn, Command::Drive { id: 1, wanted }], 1.0);
        assert!((now(&world, 1).velocity - expected).length() < 1e-12, "{frame:?}");
        assert_eq!(world.pose(1).unwrap().heading, quarter);
        go(&mut world, &[Command::Drive { id: 1, wanted: Wanted::default() }], 1.1);
        let left = now(&world, 1).velocity.length();
        assert!((left - 0.4).abs() < 0.01, "brakes at 6 m/s^2: {left}");
        let slow = Drive { acceleration_max: 0.1, ..robot() };
        let again = Command::Drive { id: 1, wanted };
        go(&mut world, &[Command::SetDrive { id: 1, drive: slow }, again], 2.1);
        assert!((now(&world, 1).velocity.length() - 0.5).abs() < 0.01);
    }
}

#[test]
fn a_force_brings_robot_and_ball_to_a_place_and_keeps_them_there() {
    let discs = [
        disc(0, [0.0, 1.0], [0.0, 0.0]),
        disc(1, [0.0, 0.0], [0.0, 0.0]),
        disc(2, [1.0, 1.45], [0.0, 0.0]),
    ];
    let mut world = world(&discs);
    let places = [DVec2::new(2.0, 2.0), DVec2::new(-1.5, 0.5)];
    let wanted = Wanted { linear: DVec2::X, angular: 1.0, frame: Frame::Arena };
    let drive = Command::Drive { id: 1, wanted };
    let pull = |id: u32, to| Command::Pull { id, to };
    go(&mut world, &[drive, pull(0, Some(places[0])), pull(1, Some(places[1]))], 0.0);
    let (mut contacts, mut before) = (Vec::new(), [0, 1].map(|id| now(&world, id)));
    for k in 1..=3_000u32 {
        let new = go(&mut world, &[], f64::from(k) * TICK);
        for id in 0..2 {
            let after = now(&world, id);
            let change = (after.velocity - before[id as usize].velocity).length();
            let has_touched = new.iter().any(|contact| contact.discs().any(|it| it == id));
            assert!(has_touched || change <= PULL_MPS2 * TICK * (1.0 + 1e-9), "{k} {change}");
            before[id as usize] = after;
        }
        contacts.extend(new);
    }
    // The ball had the robot 2 in its way, and came there all the same.
    assert!(!contacts.is_empty() && contacts.iter().all(|contact| contact.discs().eq([0, 2])));
    for id in 0..2 {
        let disc = now(&world, id);
        assert!((disc.position - places[id as usize]).length() < 1e-9, "{disc:?}");
        assert!(disc.velocity.length() < 1e-6, "{disc:?}");
    }
    assert!((world.pose(1).unwrap().heading - 3.0).abs() < 0.05, "it turns as commanded");
    // Without the force the ball stays and the robot drives; a teleport ends it too.
    let place = Command::PlacePuck { id: 0, position: DVec2::Y, velocity: DVec2::ZERO };
    go(&mut world, &[place, pull(1, None)], 4.0);
    assert_eq!(now(&world, 0).position, DVec2::Y);
    assert!((now(&world, 1).velocity - DVec2::X).length() < 1e-9);
    let bad = [pull(0, Some(DVec2::NAN)), pull(9, None)];
    let outcome = world.step(&bad, Instants { heard_at: 0.0, advance_to: 4.0 });
    assert_eq!(outcome.not_done.len(), 2);
}

#[test]
fn a_force_is_stronger_than_commands_that_are_obeyed_at_once() {
    let mut world = World::new(settings(), &[disc(1, [0.0, 0.0], [0.0, 0.0])]);
    world.drive(1, Drive::default());
    let place = DVec2::new(1.0, 0.5);
    go(&mut world, &[Command::Pull { id: 1, to: Some(place) }], 0.0);
    let wanted = Wanted { linear: DVec2::NEG_X * 2.0, angular: 0.0, frame: Frame::Arena };
    for k in 1..=3_000u32 {
        let commands: &[Command] =
            if k % 16 == 0 { &[Command::Drive { id: 1, wanted }] } else { &[] };
        go(&mut world, commands, f64::from(k) * TICK);
    }
    assert!((now(&world, 1).position - place).length() < 1e-9, "{:?}", now(&world, 1));
}

#[test]
fn what_makes_no_sense_is_refused() {
    let mut world = world(&[disc(0, [0.0, 1.0], [0.0, 0.0]), disc(1, [0.0, 0.0], [0.0, 0.0])]);
    let no_speed = Drive { speed_max: f64::NAN, ..robot() };
    let commands = [
        Command::Kick { id: 1, speed: f64::NAN },
        Command::Kick { id: 0, speed: 1.0 },
        Command::Turn { id: 1, heading: f64::INFINITY, turn: 0.0 },
        Command::SetDrive { id: 1, drive: no_speed },
        Command::Roll { id: 1 },
        Command::Roll { id: 7 },
        Command::Dribble { id: 7, on: true },
    ];
    let outcome = world.step(&commands, Instants { heard_at: 0.0, advance_to: 0.0 });
    assert_eq!(outcome.not_done.len(), commands.len());
    assert_eq!(outcome.not_done[1].1, NotDone::NotDriven(0));
    assert_eq!(outcome.not_done[4].1, NotDone::NoBall(1));
    assert_eq!(outcome.not_done[5].1, NotDone::Unknown(7));
}

#[test]
fn the_same_game_has_the_same_bits_however_often_one_looks() {
    let discs: Vec<Disc> = (0..7)
        .map(|id| disc(id, [0.3 * f64::from(id), 0.1 * f64::from(id % 3)], [1.0, 0.2]))
        .collect();
    let run = |looks: u32| {
        let (min, max) = (DVec2::new(-0.5, -0.5), DVec2::new(2.2, 0.8));
        let walls = Some(carom::world::Walls { min, max, restitution: 0.5 });
        let mut world = World::new(Settings { walls, ..settings() }, &discs);
        world.add_ball(0, Ball::default());
        (1..7).for_each(|id| world.drive(id, robot()));
        let mut contacts = Vec::new();
        for k in 0..10u32 {
            let mut commands: Vec<Command> = Vec::new();
            for id in 1..7 {
                let turn = f64::from(k * id % 7) - 3.0;
                let wanted = Wanted { linear: DVec2::X, angular: turn, frame: Frame::Own };
                commands.push(Command::Drive { id, wanted });
                commands.push(Command::Dribble { id, on: k % 2 == 0 });
                commands.push(Command::Kick { id, speed: 3.0 });
            }
            for look in 1..=looks {
                let part = f64::from(look) / f64::from(looks);
                let asked = if look == 1 { &commands[..] } else { &[] };
                contacts.extend(go(&mut world, asked, 0.25 * (f64::from(k) + part)));
            }
        }
        (world.arena().unwrap().discs(Owner::Simulated).collect::<Vec<_>>(), contacts)
    };
    let once = run(1);
    assert_eq!(run(1), once);
    assert_eq!(run(83), once);
    assert!(once.1.len() > 10, "they met: {}", once.1.len());
}
