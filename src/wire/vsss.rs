//! VSSS: commands and replacements of both teams in one packet, and the environment told to all, as
//! FIRASim has them.
//!
//! Wheels are told by their turning rates. The protocol has no answer: what is wrong is counted.

use glam::DVec2;
use prost::Message;

use super::fault::{Code, Fault, Faults, bounded, numbered};
use super::field::Field;
use super::orders::{Asked, Motion, Order, PlaceBall, PlaceRobot};
use super::proto::fira::{self, Command, Environment, Frame, Packet, RobotReplacement};
use super::{RobotName, Seen, Team, View, limits};

/// Radius of a wheel, m (FIRASim, `Parsian.ini`).
const WHEEL_RADIUS_M: f64 = 0.02;
/// Largest turning rate of a wheel that is accepted, rad/s.
const WHEEL_MAX_RADPS: f64 = limits::SPEED_MAX_MPS / WHEEL_RADIUS_M;

/// What a packet asks, and what is wrong with it; `radius` is that of a robot that is there, m.
pub fn read(datagram: &[u8], radius: impl Fn(RobotName) -> Option<f64>) -> (Asked, Faults) {
    let (mut asked, mut faults) = (Asked::default(), Faults::default());
    let packet = match Packet::decode(datagram) {
        Ok(packet) => packet,
        Err(error) => {
            faults.add(Code::Unreadable, format!("this is no Packet: {error}"));
            return (asked, faults);
        }
    };
    let commands = packet.cmd.map(|commands| commands.robot_commands).unwrap_or_default();
    faults.limit("robot_commands", commands.len());
    for command in commands.iter().take(limits::COMMANDS_PER_DATAGRAM) {
        let name = RobotName { team: team(command.yellowteam), number: command.id };
        let Some(radius) = radius(name) else {
            faults.add(Code::Unknown, format!("there is no robot {name}"));
            continue;
        };
        let Some(motion) = faults.sift(motion(name, command, radius)) else { continue };
        asked.orders.add(name, Order { motion: Some(motion), ..Order::default() });
    }
    let Some(replace) = &packet.replace else { return (asked, faults) };
    let ball = replace.ball.map(|it| PlaceBall::read([it.x, it.y, it.vx, it.vy].map(Some)));
    asked.ball = ball.and_then(|ball| faults.sift(ball));
    faults.limit("robots", replace.robots.len());
    for robot in replace.robots.iter().take(limits::COMMANDS_PER_DATAGRAM) {
        let Some(place) = faults.sift(place_robot(robot)) else { continue };
        asked.robots.retain(|other| other.name != place.name);
        asked.robots.push(place);
    }
    (asked, faults)
}

fn team(is_yellow: bool) -> Team {
    if is_yellow { Team::Yellow } else { Team::Blue }
}

/// The wheels are at the sides of the robot, a radius from its centre.
fn motion(name: RobotName, command: &Command, radius: f64) -> Result<Motion, Fault> {
    let rate = |of: &str, value| bounded(&format!("{name}: {of}"), value, WHEEL_MAX_RADPS);
    let left = rate("wheel_left", command.wheel_left)? * WHEEL_RADIUS_M;
    let right = rate("wheel_right", command.wheel_right)? * WHEEL_RADIUS_M;
    let turn = (right - left) / (2.0 * radius);
    Ok(Motion::Own { linear: DVec2::new(0.5 * (left + right), 0.0), turn })
}

/// Angles of a replacement are in degrees, though those of the environment are in radians.
fn place_robot(robot: &RobotReplacement) -> Result<PlaceRobot, Fault> {
    let missing = || Fault::new(Code::Unreadable, "RobotReplacement.position is missing");
    let position = robot.position.ok_or_else(missing)?;
    let number = position.robot_id;
    let name = numbered(RobotName { team: team(robot.yellowteam), number })?;
    let part = |of: &str, value, most| bounded(&format!("{name}: {of}"), value, most);
    let degrees = part("orientation", position.orientation, 1e6)?;
    Ok(PlaceRobot {
        name,
        x: Some(part("x", position.x, limits::PLACE_MAX_M)?),
        y: Some(part("y", position.y, limits::PLACE_MAX_M)?),
        heading: Some(degrees.to_radians()),
        velocity: DVec2::new(
            part("vx", position.vx, limits::SPEED_MAX_MPS)?,
            part("vy", position.vy, limits::SPEED_MAX_MPS)?,
        ),
        turn: part("vorientation", position.vorientation, limits::TURN_MAX_RADPS)?,
        present: Some(robot.turnon),
        by_force: false,
    })
}

/// The environment as a datagram.
pub fn environment(view: &View, step: u32, field: &Field) -> Vec<u8> {
    let ball = view.ball.map(|(at, velocity)| fira::Ball {
        x: at.x,
        y: at.y,
        z: 0.0,
        vx: velocity.x,
        vy: velocity.y,
        vz: 0.0,
    });
    let of = |team| view.robots.iter().filter(move |robot| robot.name.team == team).map(robot);
    let frame = Frame {
        ball,
        robots_yellow: of(Team::Yellow).collect(),
        robots_blue: of(Team::Blue).collect(),
    };
    let field = fira::Field {
        width: field.marks.width,
        length: field.marks.length,
        goal_width: field.marks.goal_width,
        goal_depth: field.marks.goal_depth,
        center_radius: field.marks.centre_radius,
        penalty_width: field.marks.penalty_width,
        penalty_depth: field.marks.penalty_depth,
        penalty_point: field.penalty_mark_m,
    };
    let [goals_blue, goals_yellow] = view.score;
    let (frame, field) = (Some(frame), Some(field));
    Environment { step, frame, field, goals_blue, goals_yellow }.encode_to_vec()
}

fn robot(robot: &Seen) -> fira::Robot {
    fira::Robot {
        robot_id: robot.name.number,
        x: robot.position.x,
        y: robot.position.y,
        orientation: robot.heading,
        vx: robot.velocity.x,
        vy: robot.velocity.y,
        vorientation: robot.turn,
    }
}

#[cfg(test)]
mod tests {
    use super::super::proto::fira::{BallReplacement, Commands, Replacement};
    use super::*;

    fn ask(packet: &Packet) -> (Asked, Vec<Code>) {
        let radius = |name: RobotName| (name.number < 3).then_some(0.0375);
        let (asked, faults) = read(&packet.encode_to_vec(), radius);
        (asked, faults.iter().map(|fault| fault.code).collect())
    }

    #[test]
    fn two_wheels_drive_and_turn() {
        let command = Command { id: 1, yellowteam: true, wheel_left: 10.0, wheel_right: 30.0 };
        let unknown = Command { id: 3, ..command };
        let bad = Command { id: 2, wheel_left: f64::NAN, ..command };
        let robot_commands = vec![command, unknown, bad];
        let (asked, codes) = ask(&Packet { cmd: Some(Commands { robot_commands }), replace: None });
        assert_eq!(codes, [Code::Unknown, Code::NotFinite]);
        // One of the three is good.
        let (name, order) = asked.orders.iter().next().expect("one order");
        assert_eq!((name.to_string().as_str(), asked.orders.iter().count()), ("yellow_1", 1));
        let Some(Motion::Own { linear, turn }) = order.motion else { panic!("{order:?}") };
        // 20 rad/s on average, 20 rad/s apart, over 0.075 m.
        assert!((linear - DVec2::new(0.4, 0.0)).length() < 1e-15, "{linear}");
        assert!((turn - 0.4 / 0.075).abs() < 1e-12, "{turn}");
    }

    #[test]
    fn replacements_turn_by_degrees() {
        let position =
            fira::Robot { robot_id: 2, orientation: 90.0, x: 0.25, ..Default::default() };
        let robot = RobotReplacement { position: Some(position), yellowteam: false, turnon: true };
        let gone = RobotReplacement { position: None, ..robot };
        let ball = BallReplacement { x: 0.5, vy: -1.0, ..Default::default() };
        let replace = Replacement { ball: Some(ball), robots: vec![robot, gone] };
        let (asked, codes) = ask(&Packet { cmd: None, replace: Some(replace) });
        assert_eq!(codes, [Code::Unreadable]);
        let place = asked.robots[0];
        assert_eq!(place.heading, Some(std::f64::consts::FRAC_PI_2));
        assert_eq!((place.x, place.present), (Some(0.25), Some(true)));
        assert_eq!(asked.ball.map(|ball| (ball.x, ball.vy)), Some((Some(0.5), Some(-1.0))));
    }
}
