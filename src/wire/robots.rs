//! Commands of a team to its robots: a datagram of the ports 10301 and 10302 becomes orders.
//!
//! What a command leaves unset stays as it is. A command with a bad number gives its robot no
//! order at all; the other robots of the datagram have theirs.

use glam::DVec2;
use prost::Message;

use super::fault::{Code, Fault, Faults, bounded, number, optional};
use super::orders::{Kick, Motion, Order, Orders};
use super::proto::simulation::{
    Move, RobotCommand, RobotControl, RobotControlResponse, RobotFeedback,
};
use super::{RobotName, Team, limits};

/// The fastest that a dribbler is asked to turn, rpm: beyond it, no number is meant.
const DRIBBLER_MAX_RPM: f64 = 1e6;

/// What a datagram to a team's port asks, and what is wrong with it.
pub fn read(team: Team, datagram: &[u8], is_there: impl Fn(RobotName) -> bool) -> (Orders, Faults) {
    let (mut orders, mut faults) = (Orders::default(), Faults::default());
    let control = match RobotControl::decode(datagram) {
        Ok(control) => control,
        Err(error) => {
            faults.add(Code::Unreadable, format!("this is no RobotControl: {error}"));
            return (orders, faults);
        }
    };
    faults.limit("robot_commands", control.robot_commands.len());
    for command in control.robot_commands.iter().take(limits::COMMANDS_PER_DATAGRAM) {
        let Some(name) = faults.sift(name(team, command)) else { continue };
        if !is_there(name) {
            faults.add(Code::Unknown, format!("there is no robot {name}"));
            continue;
        }
        if let Some(order) = faults.sift(order(name, command)) {
            if order.kick.is_some_and(|kick| kick.angle > 0.0 && kick.speed > 0.0) {
                let what = "the ball stays on the ground, with the horizontal part of the kick";
                faults.add(Code::Chip, format!("{name}: kick_angle: {what}"));
            }
            orders.add(name, order);
        }
    }
    (orders, faults)
}

fn name(team: Team, command: &RobotCommand) -> Result<RobotName, Fault> {
    let missing = || Fault::new(Code::Unreadable, "RobotCommand.id is missing");
    Ok(RobotName { team, number: command.id.ok_or_else(missing)? })
}

fn order(name: RobotName, command: &RobotCommand) -> Result<Order, Fault> {
    let motion = match command.move_command.map(|it| it.command) {
        None | Some(None) => None,
        Some(Some(asked)) => Some(motion(name, &asked)?),
    };
    let kick = optional(&format!("{name}: kick_speed"), command.kick_speed, limits::SPEED_MAX_MPS)?;
    let kick = kick.map(|speed| kick_of(name, speed, command.kick_angle)).transpose()?;
    let rpm = format!("{name}: dribbler_speed");
    let dribble = optional(&rpm, command.dribbler_speed, DRIBBLER_MAX_RPM)?.map(|rpm| rpm > 0.0);
    Ok(Order { motion, kick, dribble })
}

fn motion(name: RobotName, asked: &Move) -> Result<Motion, Fault> {
    let speed = |of: &str, value| number(&format!("{name}: {of}"), value, limits::SPEED_MAX_MPS);
    let turn = |value| number(&format!("{name}: angular"), value, limits::TURN_MAX_RADPS);
    Ok(match asked {
        Move::WheelVelocity(wheels) => Motion::Wheels([
            speed("front_right", wheels.front_right)?,
            speed("back_right", wheels.back_right)?,
            speed("back_left", wheels.back_left)?,
            speed("front_left", wheels.front_left)?,
        ]),
        Move::LocalVelocity(own) => Motion::Own {
            linear: DVec2::new(speed("forward", own.forward)?, speed("left", own.left)?),
            turn: turn(own.angular)?,
        },
        Move::GlobalVelocity(global) => Motion::Arena {
            linear: DVec2::new(speed("x", global.x)?, speed("y", global.y)?),
            turn: turn(global.angular)?,
        },
    })
}

fn kick_of(name: RobotName, speed: f64, angle: Option<f32>) -> Result<Kick, Fault> {
    let angle = bounded(&format!("{name}: kick_angle"), f64::from(angle.unwrap_or(0.0)), 360.0)?;
    if speed < 0.0 || !(0.0..90.0).contains(&angle) {
        let wanted = "0 or more, at 0 to below 90 degrees";
        let what = format!("{name}: a kick of {speed} m/s at {angle} degrees: must be {wanted}");
        return Err(Fault::new(Code::OutOfRange, what));
    }
    Ok(Kick { speed, angle: angle.to_radians() })
}

/// The answer to a datagram: what was wrong, and for each robot of it whether it has the ball at
/// its dribbler.
pub fn answer(faults: &Faults, feedback: impl Iterator<Item = (RobotName, bool)>) -> Vec<u8> {
    let feedback = feedback.map(|(name, has_ball)| RobotFeedback {
        id: name.number,
        dribbler_ball_contact: Some(has_ball),
        custom: None,
    });
    RobotControlResponse { errors: faults.errors(), feedback: feedback.collect() }.encode_to_vec()
}

#[cfg(test)]
mod tests {
    use super::super::proto::simulation::{MoveLocalVelocity, RobotMoveCommand};
    use super::*;

    fn local(forward: f32, left: Option<f32>) -> Option<RobotMoveCommand> {
        let (forward, angular) = (Some(forward), Some(0.5));
        let own = MoveLocalVelocity { forward, left, angular };
        Some(RobotMoveCommand { command: Some(Move::LocalVelocity(own)) })
    }

    fn ask(commands: &[RobotCommand]) -> (Orders, Vec<Code>) {
        let control = RobotControl { robot_commands: commands.to_vec() };
        let bytes = control.encode_to_vec();
        let (orders, faults) = read(Team::Blue, &bytes, |name| name.number < 6);
        (orders, faults.iter().map(|fault| fault.code).collect())
    }

    fn blue(number: u32) -> RobotName {
        RobotName { team: Team::Blue, number }
    }

    #[test]
    fn one_bad_robot_leaves_the_others_their_orders() {
        let command = RobotCommand { id: Some(2), ..RobotCommand::default() };
        let good = RobotCommand { move_command: local(1.5, Some(0.0)), ..command };
        let bad = [
            (RobotCommand { id: None, ..good }, Code::Unreadable),
            (RobotCommand { id: Some(7), ..good }, Code::Unknown),
            (RobotCommand { move_command: local(f32::NAN, Some(0.0)), ..good }, Code::NotFinite),
            (RobotCommand { move_command: local(1e30, Some(0.0)), ..good }, Code::OutOfRange),
            (RobotCommand { move_command: local(1.0, None), ..good }, Code::Unreadable),
            (RobotCommand { kick_speed: Some(f32::INFINITY), ..good }, Code::NotFinite),
            (RobotCommand { kick_speed: Some(-1.0), ..good }, Code::OutOfRange),
            (
                RobotCommand { kick_speed: Some(1.0), kick_angle: Some(90.0), ..good },
                Code::OutOfRange,
            ),
        ];
        for (bad, code) in bad {
            let id = bad.id.map(|id| if id == 2 { 1 } else { id });
            let (orders, codes) = ask(&[RobotCommand { id, ..bad }, good]);
            assert_eq!(codes, [code]);
            let motion = Motion::Own { linear: DVec2::new(1.5, 0.0), turn: 0.5 };
            let order = Order { motion: Some(motion), kick: None, dribble: None };
            assert_eq!(orders.iter().collect::<Vec<_>>(), [(blue(2), order)], "{code:?}");
        }
    }

    #[test]
    fn a_chip_is_told_and_kept() {
        let kick_speed = Some(2.0);
        let command = RobotCommand { id: Some(3), kick_speed, ..RobotCommand::default() };
        let (orders, codes) =
            ask(&[RobotCommand { kick_angle: Some(45.0), dribbler_speed: Some(0.0), ..command }]);
        assert_eq!(codes, [Code::Chip]);
        let kick = Some(Kick { speed: 2.0, angle: 45_f64.to_radians() });
        let order = Order { motion: None, kick, dribble: Some(false) };
        assert_eq!(orders.iter().next(), Some((blue(3), order)));
    }

    #[test]
    fn no_datagram_makes_more_errors_than_an_answer_holds() {
        let (orders, faults) = read(Team::Yellow, &[0x0a, 0x00].repeat(30_000), |_| true);
        assert_eq!(orders.iter().count(), 0);
        assert_eq!(faults.errors().len(), limits::FAULTS_TOLD + 1);
        assert!(answer(&faults, std::iter::empty()).len() < 8_192);
        // Cut off in the middle of a field.
        let (_, faults) = read(Team::Yellow, &[0x0a, 0x7f, 0x08], |_| true);
        assert_eq!(faults.iter().map(|fault| fault.code).collect::<Vec<_>>(), [Code::Unreadable]);
    }
}
