//! League scenes: fields, teams and ball as the league measures them; errors with their place; and
//! a game of twenty-two robots whose every contact obeys the law.

use carom::plan::Method;
use carom::referee::Goal;
use carom::scene::league::{Field, Member, Team};
use carom::scene::{Puck, Scene, file};
use carom::world::{
    BallMotion, Command, Contact, Disc, Frame, Instants, Model, NotDone, Owner, Partner, Segment,
    Wanted, World,
};
use glam::DVec2;

use crate::common::Random;

#[test]
fn leagues_are_what_they_are_called() {
    let scenes = [
        ("ssl-a", 11, 12.0, 9.0, 0.09, 0.0215),
        ("ssl-b", 6, 9.0, 6.0, 0.09, 0.0215),
        ("vsss-3v3", 3, 1.5, 1.3, 0.0375, 0.0215),
        ("vsss-5v5", 5, 2.2, 1.8, 0.0375, 0.0215),
        ("league-2d", 11, 105.0, 68.0, 0.3, 0.085),
    ];
    for (name, count, length, width, robot, ball) in scenes {
        let scene = Scene::load(name).expect(name);
        assert_eq!(scene.settings.method, Some(Method::Ticks));
        for (team, word) in [(Team::Blue, "blue"), (Team::Yellow, "yellow")] {
            for number in 0..count {
                let member = Some(Member { team, number });
                let found: Vec<_> =
                    scene.pucks.iter().filter(|puck| puck.member == member).collect();
                let [puck] = found[..] else { panic!("{name}: {member:?} {}", found.len()) };
                assert_eq!(puck.name, format!("{word}_{number}"));
                assert!(puck.driven && puck.drive.model != Model::Told, "{name}");
                assert_eq!(puck.disc.radius, robot);
            }
        }
        let balls: Vec<_> = scene.pucks.iter().filter(|puck| puck.ball.is_some()).collect();
        assert!(balls.len() == 1 && balls[0].name == "ball" && balls[0].disc.radius == ball);
        let field = scene.field.expect("a field");
        assert_eq!((field.length, field.width), (length, width));
        check_goals(name, &scene, &field);
    }
}

/// The goals that are drawn are those that the field tells of, and the walls have its margin.
fn check_goals(name: &str, scene: &Scene, field: &Field) {
    let Field { length, width, goal_width, goal_depth, margin, .. } = *field;
    let half = DVec2::new(0.5 * length + margin, 0.5 * width + margin);
    let segments = scene.settings.segments.map(|segments| segments.all().to_vec());
    let segments = segments.unwrap_or_default();
    assert_eq!(segments.len(), scene.segment_names.len());
    if let Some(walls) = scene.settings.walls {
        assert!((walls.max - half).length() < 1e-12 && (walls.min + half).length() < 1e-12);
    } else {
        let reach = segments.iter().map(|segment| segment.from.y).fold(0.0, f64::max);
        assert!((reach - half.y).abs() < 1e-12);
    }
    if name == "league-2d" {
        let posts = scene.pucks.iter().filter(|puck| puck.disc.mass.is_infinite());
        let inner = posts.map(|post| post.disc.position.y.abs() - post.disc.radius);
        assert!(inner.clone().count() == 4);
        assert!(inner.into_iter().all(|inner| (inner - 0.5 * goal_width).abs() < 1e-12));
        return;
    }
    for side in [-1.0, 1.0] {
        // Across the middle of the goal and along its middle axis the walls are where they should.
        let crosses =
            |segment: &&Segment, x: f64, y: f64| segment.distance(DVec2::new(x, y)) < 1e-12;
        let (line, back) = (side * 0.5 * length, side * (0.5 * length + goal_depth));
        let is_there = |x: f64, y: f64| segments.iter().any(|segment| crosses(&segment, x, y));
        let inside = 0.5 * (line + back);
        assert!(
            is_there(inside, 0.5 * goal_width) && is_there(inside, -0.5 * goal_width),
            "{name}"
        );
        assert!(is_there(back, 0.0) && !is_there(line, 0.0), "{name}: open in front");
    }
}

#[test]
fn errors_of_fields_and_robots_name_their_place() {
    let line = "{name: a, points: [[0, 0], [1, 0]]}";
    let lines = format!("segments: {{lines: [{line}]}}");
    let robots = |rest: &str| format!("robots:\n  - {{name: a, radius: 1, mass: 1, {rest}}}");
    let field = "goal_width: 1, goal_depth: 1, margin: 1, penalty_depth: 1, penalty_width: 1";
    let drive = "drive: {model: holonomic, kicker: {speed_max: 1, half_angle: 0.1, reach: 0.1}}";
    let cases = [
        (format!("gravity: [0, -1]\n{lines}"), "2:11: segments: not with gravity"),
        (
            "segments:\n  lines:\n    - {name: a, points: [[0, 0]]}".to_owned(),
            "3:7: line `a`: needs 2 points or more",
        ),
        (
            "segments:\n  lines:\n    - {name: a, points: [[0, 0], [0, 0]]}".to_owned(),
            "3:7: line `a`: segment 0: two different points",
        ),
        (
            format!("{lines}\npucks:\n  - {{name: p, position: [0.5, 0.1], radius: 0.2}}"),
            "3:5: puck `p` must lie within the field, off all segments",
        ),
        (
            "ball: {position: [0, 0], radius: 0.1, mass: 1, switch_ratio: 1.5}".to_owned(),
            "1:62: switch_ratio = 1.5, must be above 0, 1 at most",
        ),
        (
            robots("team: red, places: []"),
            "2:41: unknown variant `red`, expected one of blue, yellow",
        ),
        (
            robots(&format!("team: blue, {drive}, places: [[0, 0, .nan]]")),
            "[x, y, heading], a turn at most in rad",
        ),
        (robots("team: blue, places: [[0, 0, 0], [1, 0, 0]]"), "puck `a_1` overlaps puck `a_0`"),
        (
            format!("field: {{length: 1, width: 0, {field}, centre_radius: 1}}"),
            "1:8: field: lengths in m",
        ),
    ];
    for (text, wanted) in cases {
        let error = file::parse(&text, "scene.yaml").expect_err(&text).to_string();
        assert!(error.starts_with("scene.yaml:") && error.contains(wanted), "{error}\n{wanted}");
    }
    let hundred = "[0, 0], [1, 1], ".repeat(33);
    let many = format!("segments: {{lines: [{{name: a, points: [{hundred}]}}]}}");
    let error = file::parse(&many, "s").expect_err("too many").to_string();
    assert!(error.contains("at most 64 segments"), "{error}");
}

/// Commands of a game: of each team one runs for the ball, dribbles it, and kicks what it has; the
/// others run about. A ball that leaves the field is put back, and at times it is shot at a goal.
struct Players {
    random: Random,
    /// The robots of both teams, and where each of them wants to go.
    teams: [Vec<(u32, DVec2)>; 2],
    ball: u32,
    periods: u32,
}

impl Players {
    fn command(&mut self, world: &World) -> Vec<Command> {
        let discs: Vec<Disc> = world.arena().expect("pucks").discs(Owner::Simulated).collect();
        let place = |id: u32| discs.iter().find(|disc| disc.id == id).expect("there").position;
        let ball = place(self.ball);
        let mut commands = Vec::new();
        if ball.x.abs() > 6.0 && ball.y.abs() > 1.0 || ball.y.abs() > 4.5 {
            let (position, velocity) = (self.random.vector(4.0), self.random.vector(1.0));
            commands.push(Command::PlacePuck { id: self.ball, position, velocity });
        }
        self.periods += 1;
        if self.periods.is_multiple_of(120) {
            let side = if self.random.below(2) == 0 { 1.0 } else { -1.0 };
            let position = DVec2::new(5.2 * side, self.random.uniform(-1.0, 1.0));
            let velocity = DVec2::X * (5.0 * side);
            commands.push(Command::PlacePuck { id: self.ball, position, velocity });
        }
        for team in &mut self.teams {
            team.sort_by(|a, b| place(a.0).distance(ball).total_cmp(&place(b.0).distance(ball)));
            for (k, (id, target)) in team.iter_mut().enumerate() {
                if self.random.below(90) == 0 {
                    *target = self.random.vector(4.0);
                }
                let (id, own) = (*id, place(*id));
                let to = if k == 0 { ball } else { *target };
                let heading = DVec2::from_angle(world.pose(id).expect("a robot").heading);
                let linear = (to - own).clamp_length_max(1.0) * 3.0;
                let angular = 5.0 * heading.angle_to(ball - own);
                let wanted = Wanted { linear, angular, frame: Frame::Arena };
                commands.push(Command::Drive { id, wanted });
                commands.push(Command::Dribble { id, on: k == 0 });
                if k == 0 && self.random.below(4) == 0 {
                    commands.push(Command::Kick { id, speed: self.random.uniform(1.0, 6.5) });
                }
            }
        }
        commands
    }
}

/// What the law says of a contact, from the record alone: whatever is off, in units of rounding.
fn check_law(contact: &Contact, discs: &[Disc], segments: &[Segment], restitution: f64, wall: f64) {
    let mass = |id: u32| discs.iter().find(|disc| disc.id == id).expect("a disc").mass;
    let (reduced, kept) = match contact.b {
        Partner::Disc(b) => (mass(contact.a) * mass(b) / (mass(contact.a) + mass(b)), restitution),
        _ => (mass(contact.a), wall),
    };
    // The bound of the law: 16 u (1 + e) times the relative speed, here 10 m/s at most.
    let speed = contact.approach_speed;
    let bound = 16.0 * f64::EPSILON * 10.0;
    // A disc that has many contacts in a row within the contact time keeps all: the collapse model.
    let is_lawful = |kept: f64| {
        let impulse = (1.0 + kept) * reduced * speed;
        let loss = 0.5 * reduced * (1.0 - kept) * (1.0 + kept) * speed * speed;
        (contact.impulse - impulse).abs() <= (1.0 + kept) * reduced * bound
            && (contact.energy_loss - loss).abs() <= reduced * (speed + bound) * bound
    };
    assert!(is_lawful(kept) || is_lawful(1.0), "{contact:?}");
    assert!(contact.approach_speed > 0.0 && (contact.normal.length() - 1.0).abs() < 1e-14);
    assert!(contact.gap.abs() < 1e-9, "neither early nor late: {contact:?}");
    if let Partner::Segment(k) = contact.b {
        assert!(segments[k as usize].distance(contact.point) < 1e-9, "{contact:?}");
    }
}

#[test]
fn a_game_of_twenty_two_robots_obeys_the_law_for_a_minute() {
    let mut scene = Scene::load("ssl-a").expect("shipped");
    scene.settings.keep = carom::plan::parts::Parts::only(carom::plan::parts::Part::Account);
    let segments = scene.settings.segments.expect("goals").all().to_vec();
    let mut world = scene.world();
    let ball = scene.pucks.iter().find(|puck| puck.ball.is_some()).expect("a ball").disc.id;
    let teams = [Team::Blue, Team::Yellow].map(|team| {
        let of_team = |puck: &&Puck| puck.member.is_some_and(|member| member.team == team);
        let robots = scene.pucks.iter().filter(of_team);
        robots.map(|puck| (puck.disc.id, puck.disc.position)).collect()
    });
    let mut players = Players { random: Random::new(22), teams, ball, periods: 0 };
    let (mut pairs, mut at_goals, mut kicked, mut together, mut time) = (0, 0, 0, 0, 0.0);
    let (restitution, wall) = (scene.settings.restitution, 0.5);
    for period in 1..=3_600u32 {
        let commands = players.command(&world);
        let until = f64::from(period) / 60.0;
        let before = world.ball(ball).expect("a ball").velocity.length();
        let instants = Instants { heard_at: 0.0, advance_to: until };
        let mut outcome = world.step(&commands, instants);
        kicked += u32::from(world.ball(ball).expect("a ball").velocity.length() > before + 1.0);
        while world.arena().expect("pucks").now() < until {
            let more = world.step(&[], instants);
            outcome.contacts.extend(more.contacts);
        }
        // The place for the ball may be taken.
        let overlaps = |(_, why): &(usize, NotDone)| matches!(why, NotDone::Overlaps(_));
        assert!(outcome.stall.is_none() && outcome.not_done.iter().all(overlaps));
        let discs: Vec<Disc> = world.arena().expect("pucks").discs(Owner::Simulated).collect();
        for (k, contact) in outcome.contacts.iter().enumerate() {
            if shares_a_disc(&outcome.contacts, k) {
                // Several at one instant are resolved together: the law of one says too little.
                assert!(contact.impulse >= 0.0 && contact.gap.abs() < 1e-9, "{contact:?}");
                together += 1;
            } else {
                check_law(contact, &discs, &segments, restitution, wall);
            }
            assert!(contact.time >= time && contact.time <= until);
            time = contact.time;
            pairs += u32::from(matches!(contact.b, Partner::Disc(_)));
            at_goals += u32::from(matches!(contact.b, Partner::Segment(_)));
        }
        no_overlaps(&discs, &segments);
    }
    let arena = world.arena().expect("pucks");
    assert!(
        pairs > 2_000 && together < 1_000_000 && at_goals > 20 && kicked > 15,
        "{pairs} {at_goals} {kicked} {together}"
    );
    assert!(arena.largest_overlap() < 1e-12, "{}", arena.largest_overlap());
    assert!(arena.relative_energy_drift().abs() < 1e-12, "{}", arena.relative_energy_drift());
    let drift = arena.momentum_drift().expect("an account").length();
    assert!(drift < 1e-10, "{drift} N s");
}

/// Whether another contact of the same instant has a disc of this one.
fn shares_a_disc(contacts: &[Contact], k: usize) -> bool {
    let same = |other: &&Contact| other.time == contacts[k].time;
    let (before, after) = (contacts[..k].iter().rev(), contacts[k + 1..].iter());
    let mut others = before.take_while(same).chain(after.take_while(same));
    others.any(|other| other.discs().any(|id| contacts[k].discs().any(|own| own == id)))
}

fn no_overlaps(discs: &[Disc], segments: &[Segment]) {
    for (k, a) in discs.iter().enumerate() {
        for b in &discs[..k] {
            let sum = a.radius + b.radius;
            assert!(a.position.distance(b.position) > sum * (1.0 - 1e-12), "{a:?} {b:?}");
        }
        for segment in segments {
            assert!(segment.distance(a.position) > a.radius * (1.0 - 1e-11), "{a:?} {segment:?}");
        }
    }
}

#[test]
fn a_crash_is_told_with_both_speeds_and_whose_fault_it_is() {
    use carom::referee::{Fault, fault};
    assert_eq!(
        [[2.0, 1.0], [1.0, 2.0], [1.2, 1.0]].map(fault),
        [Fault::First, Fault::Second, Fault::Both]
    );
    // Two head on, the blue one faster; two of one team; two that are slow; two about as fast.
    let scenes = [
        ((1.4, 0.6), "yellow", Some(Fault::First)),
        ((1.4, 0.6), "blue", None),
        ((0.8, 0.6), "yellow", None),
        ((0.9, 1.1), "yellow", Some(Fault::Both)),
    ];
    for ((fast, slow), team, wanted) in scenes {
        let robots = |name: &str, team: &str, x: f64| {
            let places = format!("places: [[{x}, 0, 0]]");
            format!("  - {{name: {name}, team: {team}, radius: 0.09, mass: 2.5, {places}}}\n")
        };
        let far = robots("far", "yellow", 50.0);
        let text = format!(
            "method: ticks\ntick_s: 0.001\nrestitution: 0.3\nrobots:\n{}{}{far}",
            robots("a", "blue", 0.0),
            robots("b", team, 1.0)
        );
        let scene = file::parse(&text, "scene").expect("sound");
        let mut world = scene.world();
        let ids: Vec<u32> = scene.pucks.iter().map(|puck| puck.disc.id).collect();
        let commands = [
            Command::SetVelocity { id: ids[0], velocity: DVec2::X * fast },
            Command::SetVelocity { id: ids[1], velocity: DVec2::X * -slow },
        ];
        let outcome = world.step(&commands, Instants { heard_at: 0.0, advance_to: 1.0 });
        assert_eq!(outcome.contacts.len(), 1);
        let told = outcome.crashes.first();
        assert_eq!(told.map(|crash| crash.fault), wanted, "{team} {fast} {slow}");
        let Some(crash) = told else { continue };
        assert_eq!(crash.robots, [ids[0], ids[1]]);
        assert!((crash.speeds[0] - fast).abs() + (crash.speeds[1] - slow).abs() < 1e-12);
        assert!((crash.approach_speed - fast - slow).abs() < 1e-12);
        let when = 0.82 / (fast + slow);
        assert!((crash.time - when).abs() < 1e-12);
        assert!((crash.place.x - fast * when - 0.09).abs() < 1e-12, "{crash:?}");
    }
}

/// Gives the ball another place, if there is one, and a velocity with which it rolls, and lets time
/// pass: the goals.
fn shoot(world: &mut World, id: u32, at: Option<DVec2>, velocity: DVec2, lasts: f64) -> Vec<Goal> {
    let asked = match at {
        Some(position) => Command::PlacePuck { id, position, velocity },
        None => Command::SetVelocity { id, velocity },
    };
    let until = world.arena().expect("pucks").now() + lasts;
    let instants = Instants { heard_at: 0.0, advance_to: until };
    let outcome = world.step(&[asked, Command::Roll { id }], instants);
    assert_eq!((outcome.stall, outcome.not_done), (None, vec![]));
    outcome.goals
}

/// A field without its robots, whose goals are watched, and its ball.
fn empty_field(name: &str) -> (Scene, World, Puck) {
    let scene = Scene::load(name).expect(name);
    let mut world = scene.world();
    let robots = scene.pucks.iter().filter(|puck| puck.member.is_some());
    let gone: Vec<Command> = robots.map(|puck| Command::RemovePuck { id: puck.disc.id }).collect();
    world.step(&gone, Instants { heard_at: 0.0, advance_to: 0.0 });
    let ball = scene.pucks.iter().find(|puck| puck.ball.is_some()).expect("a ball").clone();
    (scene, world, ball)
}

#[test]
fn a_goal_counts_for_the_team_that_attacks_it_when_the_ball_is_wholly_in() {
    for name in ["ssl-a", "ssl-b", "vsss-3v3", "vsss-5v5", "league-2d"] {
        let (scene, mut world, ball) = empty_field(name);
        let (id, field) = (ball.disc.id, scene.field.expect("a field"));
        for (side, team, score) in [(1.0, 0, [1, 0]), (-1.0, 1, [1, 1]), (1.0, 0, [2, 1])] {
            let from = DVec2::new(side * (0.5 * field.length - 0.2), -0.25 * field.goal_width);
            let (velocity, begin) = (DVec2::X * (2.0 * side), world.arena().expect("pucks").now());
            let goals = shoot(&mut world, id, Some(from), velocity, 0.3);
            let [goal] = goals[..] else { panic!("{name} {side}: {goals:?}") };
            assert_eq!((goal.team, goal.score, world.score()), (team, score, Some(score)));
            let way = 0.2 + ball.disc.radius;
            assert!((goal.place - from - DVec2::X * (side * way)).length() < 1e-9, "{goal:?}");
            let law = ball.ball.expect("it is one");
            let crossed = law.after(BallMotion::rolling(velocity), goal.time - begin).1.length();
            let tick = scene.settings.pace.tick;
            assert!((crossed - way).abs() < tick * tick, "{name}: {crossed} {way} {goal:?}");
        }
    }
}

#[test]
fn what_is_no_goal_is_not_counted() {
    let (_, mut world, ball) = empty_field("ssl-b");
    let (id, right) = (ball.disc.id, |x: f64, y: f64| Some(DVec2::new(x, y)));
    let mut none = |at: Option<DVec2>, velocity: DVec2, lasts: f64| {
        let goals = shoot(&mut world, id, at, velocity, lasts);
        assert!(goals.is_empty(), "{goals:?}");
    };
    // Beside the goal; put into it, and out of it; on the line, where it stops.
    none(right(4.4, 0.8), DVec2::X * 3.0, 0.5);
    none(right(4.6, 0.0), DVec2::ZERO, 0.5);
    none(right(4.6, 0.1), DVec2::X * -2.0, 0.5);
    none(right(4.51 - 0.25 / 0.52, 0.1), DVec2::X * 0.5, 3.0);
    // Pushed over it, it is one; not again when it comes from the net, before it has been out.
    assert_eq!(shoot(&mut world, id, None, DVec2::X * 1.0, 0.2).len(), 1);
    assert_eq!(shoot(&mut world, id, right(4.3, 0.1), DVec2::X * 3.0, 0.11).len(), 1);
    assert_eq!(shoot(&mut world, id, None, DVec2::X * -1.0, 0.13).len(), 0);
    let place = world.arena().expect("pucks").disc(id).expect("a ball").position;
    assert!((place.x - 4.5).abs() < ball.disc.radius, "on the line: {place}");
    assert_eq!(shoot(&mut world, id, None, DVec2::X * 1.0, 0.2).len(), 0);
    assert_eq!(shoot(&mut world, id, None, DVec2::X * -2.0, 0.3).len(), 0);
    assert_eq!(shoot(&mut world, id, None, DVec2::X * 3.0, 0.3).len(), 1);
    assert_eq!(world.score(), Some([3, 0]));
}
