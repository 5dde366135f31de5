//! grSim's older packets on port 20011, which consai and crane send: commands and replacements.
//!
//! Wheels are told by their turning rates, angles of replacements in degrees. There is no answer
//! for what is wrong: it is counted. What has changed with a team's robots is told to all who
//! just commanded it.

use std::collections::BTreeMap;

use glam::DVec2;
use prost::Message;

use super::fault::{Code, Fault, Faults, bounded, number, numbered, optional};
use super::orders::{Asked, Kick, Motion, Order, PlaceBall, PlaceRobot};
use super::proto::grsim::{
    GrSimPacket, GrSimRobotCommand, GrSimRobotReplacement, RobotStatus, RobotsStatus,
};
use super::{RobotName, Team, limits};

/// Radius of a wheel, m (grSim, `Parsian.ini`).
const WHEEL_RADIUS_M: f64 = 0.027;

/// What a packet asks, and what is wrong with it.
pub fn read(datagram: &[u8], is_there: impl Fn(RobotName) -> bool) -> (Asked, Faults) {
    let (mut asked, mut faults) = (Asked::default(), Faults::default());
    let packet = match GrSimPacket::decode(datagram) {
        Ok(packet) => packet,
        Err(error) => {
            faults.add(Code::Unreadable, format!("this is no grSim_Packet: {error}"));
            return (asked, faults);
        }
    };
    if let Some(commands) = &packet.commands {
        let team = team(commands.isteamyellow);
        asked.team = Some(team);
        faults.limit("robot_commands", commands.robot_commands.len());
        for command in commands.robot_commands.iter().take(limits::COMMANDS_PER_DATAGRAM) {
            let name = RobotName { team, number: command.id.unwrap_or(u32::MAX) };
            if !is_there(name) {
                faults.add(Code::Unknown, format!("there is no robot {name}"));
            } else if let Some(order) = faults.sift(order(name, command)) {
                asked.orders.add(name, order);
            }
        }
    }
    let Some(replacement) = &packet.replacement else { return (asked, faults) };
    let ball = replacement.ball.map(|ball| PlaceBall::read([ball.x, ball.y, ball.vx, ball.vy]));
    asked.ball = ball.and_then(|ball| faults.sift(ball));
    faults.limit("robots", replacement.robots.len());
    for robot in replacement.robots.iter().take(limits::COMMANDS_PER_DATAGRAM) {
        let Some(place) = faults.sift(place_robot(robot)) else { continue };
        asked.robots.retain(|other| other.name != place.name);
        asked.robots.push(place);
    }
    (asked, faults)
}

/// A robot as its status has it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Status {
    /// Whether it has the ball at its kicker.
    pub has_ball: bool,
    /// Whether it has just kicked along the ground.
    pub kicks: bool,
    /// Whether it has just chipped.
    pub chips: bool,
}

/// What has been told of robots: of one that is not in it, that it has no ball and does not kick.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Told(BTreeMap<RobotName, Status>);

impl Told {
    /// What there is to tell of a team that is like this now, as a datagram.
    pub fn news(&mut self, now: impl Iterator<Item = (RobotName, Status)>) -> Option<Vec<u8>> {
        let mut robots_status = Vec::new();
        for (name, status) in now {
            if self.0.insert(name, status).unwrap_or_default() == status {
                continue;
            }
            let Status { has_ball: infrared, kicks: flat_kick, chips: chip_kick } = status;
            let robot_id = name.number as i32;
            robots_status.push(RobotStatus { robot_id, infrared, flat_kick, chip_kick });
        }
        (!robots_status.is_empty()).then(|| RobotsStatus { robots_status }.encode_to_vec())
    }
}

fn team(is_yellow: Option<bool>) -> Team {
    if is_yellow == Some(true) { Team::Yellow } else { Team::Blue }
}

fn order(name: RobotName, command: &GrSimRobotCommand) -> Result<Order, Fault> {
    let speed = |of: &str, value: Option<f32>| {
        let value = optional(&format!("{name}: {of}"), value, limits::SPEED_MAX_MPS)?;
        Ok(value.unwrap_or(0.0))
    };
    let motion = if command.wheelsspeed == Some(true) {
        let most = limits::SPEED_MAX_MPS / WHEEL_RADIUS_M;
        let wheel =
            |of: &str, value| Ok(number(&format!("{name}: {of}"), value, most)? * WHEEL_RADIUS_M);
        // Counted against the clock here, from the front on the left.
        Motion::Wheels([
            wheel("wheel4", command.wheel4)?,
            wheel("wheel3", command.wheel3)?,
            wheel("wheel2", command.wheel2)?,
            wheel("wheel1", command.wheel1)?,
        ])
    } else {
        let of = format!("{name}: velangular");
        let turn = optional(&of, command.velangular, limits::TURN_MAX_RADPS)?.unwrap_or(0.0);
        let forward = speed("veltangent", command.veltangent)?;
        let linear = DVec2::new(forward, speed("velnormal", command.velnormal)?);
        Motion::Own { linear, turn }
    };
    let along = speed("kickspeedx", command.kickspeedx)?.max(0.0);
    let up = speed("kickspeedz", command.kickspeedz)?.max(0.0);
    let kick = Kick { speed: along.hypot(up), angle: libm::atan2(up, along) };
    Ok(Order { motion: Some(motion), kick: Some(kick), dribble: command.spinner })
}

fn place_robot(robot: &GrSimRobotReplacement) -> Result<PlaceRobot, Fault> {
    let missing = || Fault::new(Code::Unreadable, "grSim_RobotReplacement.id is missing");
    let number = robot.id.ok_or_else(missing)?;
    let name = numbered(RobotName { team: team(robot.yellowteam), number })?;
    let part = |of: &str, value: Option<f64>, most| {
        value.map(|value| bounded(&format!("{name}: {of}"), value, most)).transpose()
    };
    Ok(PlaceRobot {
        name,
        x: part("x", robot.x, limits::PLACE_MAX_M)?,
        y: part("y", robot.y, limits::PLACE_MAX_M)?,
        heading: part("dir", robot.dir, 1e6)?.map(f64::to_radians),
        velocity: DVec2::ZERO,
        turn: 0.0,
        present: robot.turnon,
        by_force: false,
    })
}

#[cfg(test)]
mod tests {
    use super::super::proto::grsim::{GrSimBallReplacement, GrSimCommands, GrSimReplacement};
    use super::*;

    #[test]
    fn commands_and_replacements_are_those_of_the_other_protocol() {
        let command = GrSimRobotCommand {
            id: Some(3),
            kickspeedx: Some(3.0),
            kickspeedz: Some(4.0),
            veltangent: Some(1.0),
            velnormal: Some(-0.5),
            velangular: Some(2.0),
            spinner: Some(true),
            ..GrSimRobotCommand::default()
        };
        let wheels = GrSimRobotCommand {
            id: Some(4),
            wheelsspeed: Some(true),
            wheel1: Some(100.0),
            wheel2: Some(200.0),
            wheel3: Some(300.0),
            wheel4: Some(400.0),
            ..GrSimRobotCommand::default()
        };
        let bad = GrSimRobotCommand { id: Some(5), veltangent: Some(f32::NAN), ..command };
        let unknown = GrSimRobotCommand { id: Some(9), ..command };
        let robot_commands = vec![command, wheels, bad, unknown];
        let commands = GrSimCommands { timestamp: None, isteamyellow: Some(true), robot_commands };
        let (id, dir) = (Some(2), Some(90.0));
        let robot = GrSimRobotReplacement { id, dir, turnon: Some(false), ..Default::default() };
        let ball = GrSimBallReplacement { x: Some(1.0), ..Default::default() };
        let replacement = GrSimReplacement { ball: Some(ball), robots: vec![robot] };
        let packet = GrSimPacket { commands: Some(commands), replacement: Some(replacement) };
        let (asked, faults) = read(&packet.encode_to_vec(), |name| name.number < 6);
        let codes: Vec<Code> = faults.iter().map(|fault| fault.code).collect();
        assert_eq!(codes, [Code::NotFinite, Code::Unknown]);
        let orders: Vec<(String, Order)> =
            asked.orders.iter().map(|(name, order)| (name.to_string(), order)).collect();
        let own = Motion::Own { linear: DVec2::new(1.0, -0.5), turn: 2.0 };
        assert_eq!((orders[0].0.as_str(), orders[0].1.motion), ("yellow_3", Some(own)));
        // Its packets always say one.
        let kick = orders[0].1.kick.expect("a kick");
        assert!((kick.speed - 5.0).abs() < 1e-12 && (kick.angle.cos() - 0.6).abs() < 1e-12);
        let Some(Motion::Wheels(speeds)) = orders[1].1.motion else { panic!("{orders:?}") };
        let expected = [10.8, 8.1, 5.4, 2.7];
        assert!(speeds.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12), "{speeds:?}");
        assert_eq!(asked.robots[0].heading, Some(std::f64::consts::FRAC_PI_2));
        assert_eq!(asked.robots[0].present, Some(false));
        assert_eq!(asked.ball.map(|ball| (ball.x, ball.vx)), Some((Some(1.0), None)));
    }
    #[test]
    fn only_what_has_changed_is_told() {
        let name = |number| RobotName { team: Team::Blue, number };
        let has_ball = Status { has_ball: true, ..Status::default() };
        let mut told = Told::default();
        let mut tell = |now: &[(RobotName, Status)]| {
            let news = told.news(now.iter().copied());
            // It is ours.
            news.map(|it| RobotsStatus::decode(it.as_slice()).expect("a status").robots_status)
        };
        assert_eq!(tell(&[(name(0), Status::default())]), None);
        let both = [(name(0), Status::default()), (name(3), has_ball)];
        let expected = RobotStatus { robot_id: 3, infrared: true, ..RobotStatus::default() };
        assert_eq!(tell(&both), Some(vec![expected]));
        assert_eq!(tell(&both), None);
        let kicks = Status { kicks: true, ..Status::default() };
        let expected = RobotStatus { robot_id: 3, flat_kick: true, ..RobotStatus::default() };
        assert_eq!(tell(&[(name(3), kicks)]), Some(vec![expected]));
    }
}
