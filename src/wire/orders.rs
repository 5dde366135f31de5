//! Orders: what teams ask of robots and ball, in the words of the game, and the commands that it
//! becomes.
//!
//! Of several orders to one robot the latest counts, part by part, so that a flood of them costs
//! what one costs. Nothing here looks at the world.

use std::collections::BTreeMap;

use glam::DVec2;

use super::fault::{Fault, bounded};
use super::specs::Specs;
use super::{RobotName, Team, limits};
use crate::world::{Command, DiscId, Frame, Wanted};

/// How a robot shall move.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Motion {
    /// Speeds of the ground under its wheels, m/s: front right, back right, back left, front left;
    /// above 0 where they turn the robot against the clock.
    Wheels([f64; 4]),
    /// In its own frame, x forward.
    Own {
        /// m/s
        linear: DVec2,
        /// rad/s
        turn: f64,
    },
    /// In the frame of the field.
    Arena {
        /// m/s
        linear: DVec2,
        /// rad/s
        turn: f64,
    },
}

/// A kick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Kick {
    /// In space, m/s.
    pub speed: f64,
    /// Above the ground, rad.
    pub angle: f64,
}

/// What is asked of a robot; nothing = as before.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Order {
    /// How it shall move.
    pub motion: Option<Motion>,
    /// How it shall kick; speed 0 = not.
    pub kick: Option<Kick>,
    /// Whether its dribbler shall turn.
    pub dribble: Option<bool>,
}

impl Kick {
    /// Whether it is told as a chip: 1 m/s or more upward, as in grSim.
    pub fn is_chip(&self) -> bool {
        self.speed * libm::sin(self.angle) >= 1.0
    }
}

impl Order {
    /// The commands that it becomes, for a robot of this id and radius (m).
    pub fn commands(&self, id: DiscId, radius: f64, specs: &Specs) -> Vec<Command> {
        let wanted = self.motion.map(|motion| match motion {
            Motion::Wheels(speeds) => {
                let (linear, angular) = specs.motion(&speeds, radius);
                Wanted { linear, angular, frame: Frame::Own }
            }
            Motion::Own { linear, turn } => Wanted { linear, angular: turn, frame: Frame::Own },
            Motion::Arena { linear, turn } => Wanted { linear, angular: turn, frame: Frame::Arena },
        });
        let drive = wanted.map(|wanted| Command::Drive { id, wanted });
        let dribble = self.dribble.map(|on| Command::Dribble { id, on });
        let kick = |kick| Command::Kick { id, speed: specs.along_the_ground(kick) };
        let kick = self.kick.map(kick);
        [drive, dribble, kick].into_iter().flatten().collect()
    }
}

/// Orders by robot.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Orders(BTreeMap<RobotName, Order>);

impl Orders {
    /// One more, which is later than those that are there.
    pub fn add(&mut self, name: RobotName, later: Order) {
        let order = self.0.entry(name).or_default();
        order.motion = later.motion.or(order.motion);
        order.kick = later.kick.or(order.kick);
        order.dribble = later.dribble.or(order.dribble);
    }

    /// All of another, which is later.
    pub fn extend(&mut self, later: &Self) {
        later.iter().for_each(|(name, order)| self.add(name, order));
    }

    /// By name.
    pub fn iter(&self) -> impl Iterator<Item = (RobotName, Order)> + '_ {
        self.0.iter().map(|(name, order)| (*name, *order))
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

/// Where a robot shall be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlaceRobot {
    /// Which.
    pub name: RobotName,
    /// m; nothing = as before.
    pub x: Option<f64>,
    /// m; nothing = as before.
    pub y: Option<f64>,
    /// rad; nothing = as before.
    pub heading: Option<f64>,
    /// m/s
    pub velocity: DVec2,
    /// rad/s
    pub turn: f64,
    /// Whether it shall be on the field at all; nothing = as before.
    pub present: Option<bool>,
    /// Whether a force brings it there.
    pub by_force: bool,
}

impl PlaceRobot {
    /// Whether it says more than whether the robot is there.
    pub fn moves(&self) -> bool {
        self.x.is_some()
            || self.y.is_some()
            || self.heading.is_some()
            || self.velocity != DVec2::ZERO
            || self.turn != 0.0
    }
}

/// Where the ball shall be; what is nothing stays as it is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PlaceBall {
    /// m
    pub x: Option<f64>,
    /// m
    pub y: Option<f64>,
    /// m/s
    pub vx: Option<f64>,
    /// m/s
    pub vy: Option<f64>,
    /// Whether it rolls from there, instead of sliding first.
    pub roll: bool,
    /// Whether robots make way for it, and those beside it stand still.
    pub safely: bool,
    /// Whether a force brings it there.
    pub by_force: bool,
}

impl PlaceBall {
    /// Whether it says where the ball shall be, or how fast.
    pub fn moves(&self) -> bool {
        [self.x, self.y, self.vx, self.vy].iter().any(Option::is_some) || self.roll
    }

    /// Of place (m) and velocity (m/s), and no more.
    ///
    /// # Errors
    /// [`Fault`] with the name of the number.
    pub fn read([x, y, vx, vy]: [Option<f64>; 4]) -> Result<Self, Fault> {
        let part = |of: &str, value: Option<f64>, most| {
            value.map(|value| bounded(&format!("ball: {of}"), value, most)).transpose()
        };
        Ok(Self {
            x: part("x", x, limits::PLACE_MAX_M)?,
            y: part("y", y, limits::PLACE_MAX_M)?,
            vx: part("vx", vx, limits::SPEED_MAX_MPS)?,
            vy: part("vy", vy, limits::SPEED_MAX_MPS)?,
            ..Self::default()
        })
    }
}

/// What a packet asks in which all of it may stand.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Asked {
    /// Of robots.
    pub orders: Orders,
    /// Whose robots, where a packet is one team's and there is status to be told.
    pub team: Option<Team>,
    /// Where robots shall be, each once.
    pub robots: Vec<PlaceRobot>,
    /// Where the ball shall be.
    pub ball: Option<PlaceBall>,
}

#[cfg(test)]
mod tests {
    use super::super::field::division_b;
    use super::*;

    #[test]
    fn of_two_orders_each_part_of_the_later_counts() {
        let name = RobotName { team: Team::Blue, number: 0 };
        let kick = Some(Kick { speed: 3.0, angle: 0.0 });
        let mut orders = Orders::default();
        orders.add(name, Order { kick, dribble: Some(true), motion: None });
        let motion = Some(Motion::Arena { linear: DVec2::X, turn: 0.0 });
        let mut later = Orders::default();
        later.add(name, Order { motion, dribble: Some(false), kick: None });
        orders.extend(&later);
        let all: Vec<_> = orders.iter().collect();
        assert_eq!(all, [(name, Order { motion, kick, dribble: Some(false) })]);
        let wanted = Wanted { linear: DVec2::X, angular: 0.0, frame: Frame::Arena };
        let commands = all[0].1.commands(7, 0.09, &Specs::new(&division_b()));
        let id = 7;
        assert_eq!(
            commands,
            [
                Command::Drive { id, wanted },
                Command::Dribble { id, on: false },
                Command::Kick { id, speed: 3.0 }
            ]
        );
    }

    #[test]
    fn kicks_are_as_fast_as_the_kicker_and_stay_on_the_ground() {
        let specs = Specs { kick_max: 6.0, chip_max: 4.0, ..Specs::new(&division_b()) };
        for (speed, angle, along) in
            [(8.0, 0.0, 6.0), (5.0, 0.0, 5.0), (8.0, 60_f64, 2.0), (1.0, 60.0, 0.5)]
        {
            let kick = Some(Kick { speed, angle: angle.to_radians() });
            let order = Order { kick, ..Order::default() };
            let commands = order.commands(7, 0.09, &specs);
            let [Command::Kick { speed, .. }] = commands.as_slice() else { panic!("{commands:?}") };
            assert!((speed - along).abs() < 1e-12, "{speed}");
        }
    }
}
