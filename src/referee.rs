//! The referee's eye: which collisions of robots are crashes, whose fault they are, and goals.
//!
//! The rule is that of the Small Size League (ssl-rules, chapters/offenses.adoc, "Crashing"): at
//! the moment of a collision of two robots of different teams the difference of their velocities is
//! projected on the line through their centres; above 1.5 m/s the faster of them is at fault, and
//! both if their speeds differ by less than 0.3 m/s. One place for whoever asks: the arena, and the
//! audit of a recording. Nothing here looks for contacts.

mod goals;

use glam::DVec2;
use serde::Serialize;

use crate::world::{Contact, Disc, DiscId, Partner};
use goals::Goals;
pub use goals::{Goal, Posts};

/// Speed of approach along the line of centres above which a collision is a crash, m/s.
pub const CRASH_SPEED_MPS: f64 = 1.5;

/// Difference of the two speeds below which both are at fault, m/s.
pub const ALIKE_MPS: f64 = 0.3;

/// Who is at fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Fault {
    /// The first.
    First,
    /// The second.
    Second,
    /// Both: they were about as fast.
    Both,
}

/// Who is at fault for a crash of two with these speeds before it, m/s.
pub fn fault(speeds: [f64; 2]) -> Fault {
    let [a, b] = speeds;
    match a - b {
        more if more.abs() < ALIKE_MPS => Fault::Both,
        more if more > 0.0 => Fault::First,
        _ => Fault::Second,
    }
}

/// Whether a speed of approach along the line of centres is a crash under a limit, both m/s.
pub fn is_crash(approach_speed: f64, limit: f64) -> bool {
    approach_speed > limit
}

/// A crash of two robots.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crash {
    /// Their ids.
    pub robots: [u32; 2],
    /// Their speeds just before it, m/s.
    pub speeds: [f64; 2],
    /// Speed of approach along the line of centres, m/s.
    pub approach_speed: f64,
    /// Who is at fault.
    pub fault: Fault,
    /// Where they touched, m.
    pub place: DVec2,
    /// When, s.
    pub time: f64,
}

/// Watches robots of two teams in an arena: how fast each is between its contacts, so that both
/// speeds before a crash are known.
#[derive(Clone, Debug)]
pub struct Referee {
    limit: f64,
    robots: Vec<Watched>,
    goals: Option<Goals>,
}

#[derive(Clone, Copy, Debug)]
struct Watched {
    id: DiscId,
    team: u8,
    mass: f64,
    velocity: DVec2,
}

impl Referee {
    /// Watches these robots, each with its team; `limit`: of the speed of approach, m/s.
    pub fn new(robots: &[(DiscId, u8)], limit: f64) -> Self {
        let watched = |&(id, team): &(DiscId, u8)| Watched {
            id,
            team,
            mass: f64::INFINITY,
            velocity: DVec2::ZERO,
        };
        Self { limit, robots: robots.iter().map(watched).collect(), goals: None }
    }

    /// Watches the goals too, for this ball.
    pub fn with_goals(self, posts: Posts, ball: DiscId) -> Self {
        Self { goals: Some(Goals::new(posts, ball)), ..self }
    }

    /// Goals of the teams 0 and 1, if somebody counts them.
    pub fn score(&self) -> Option<[u32; 2]> {
        self.goals.as_ref().map(|goals| goals.score)
    }

    /// A puck was put elsewhere by hand.
    pub fn lose_sight(&mut self, id: DiscId) {
        self.goals.iter_mut().for_each(|goals| goals.lose_sight(id));
    }

    /// Looks at a control tick where the ball is; tells a goal.
    pub fn look(&mut self, discs: &[Disc], now: f64, told: &mut Vec<Goal>) {
        told.extend(self.goals.as_mut().and_then(|goals| goals.look(discs, now)));
    }

    /// Sees how the robots move now.
    pub fn see(&mut self, discs: impl Iterator<Item = Disc>) {
        for disc in discs {
            if let Some(robot) = self.robots.iter_mut().find(|robot| robot.id == disc.id) {
                (robot.mass, robot.velocity) = (disc.mass, disc.velocity);
            }
        }
    }

    /// Hears of all contacts since it saw them, in order; tells the crashes.
    pub fn hear(&mut self, contacts: &[Contact], crashes: &mut Vec<Crash>) {
        for contact in contacts {
            let find = |id| self.robots.iter().position(|robot| robot.id == id);
            let first = find(contact.a);
            let second = match contact.b {
                Partner::Disc(id) => find(id),
                Partner::Wall(_) | Partner::Segment(_) => None,
            };
            if let (Some(a), Some(b)) = (first, second) {
                let both = [self.robots[a], self.robots[b]];
                if both[0].team != both[1].team && is_crash(contact.approach_speed, self.limit) {
                    crashes.push(crash(contact, &both));
                }
            }
            // The impulse along the normal is all that a contact changes.
            for (robot, sign) in [(first, -1.0), (second, 1.0)] {
                if let Some(robot) = robot.map(|k| &mut self.robots[k]) {
                    robot.velocity += contact.normal * (sign * contact.impulse / robot.mass);
                }
            }
        }
    }
}

fn crash(contact: &Contact, both: &[Watched; 2]) -> Crash {
    let speeds = both.map(|robot| robot.velocity.length());
    Crash {
        robots: both.map(|robot| robot.id),
        speeds,
        approach_speed: contact.approach_speed,
        fault: fault(speeds),
        place: contact.point,
        time: contact.time,
    }
}
