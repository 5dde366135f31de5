//! Control of the simulation: a datagram of port 10300 becomes what shall be done to game and
//! simulator.
//!
//! Each part stands for itself: what is sound is done, what is not is told. What carom does not
//! have (height) is told too, and the rest of the part is done.

use glam::DVec2;
use prost::Message;

use super::fault::{Code, Fault, Faults, numbered, optional};
use super::orders::{PlaceBall, PlaceRobot};
use super::proto::simulation::{
    RealismConfig, RealismConfigErForce, SimulatorCommand, SimulatorConfig, SimulatorControl,
    SimulatorResponse, TeleportBall, TeleportRobot,
};
use super::proto::vision::SslGeometryData;
use super::proto::{self, RobotId};
use super::realism::Change;
use super::specs::SpecsChange;
use super::{RobotName, Team, limits};

/// What a datagram to the control port asks.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Control {
    /// Robots, each once, where the last word on each has it.
    pub robots: Vec<PlaceRobot>,
    /// The ball.
    pub ball: Option<PlaceBall>,
    /// Simulated seconds in a second; 0 = a pause.
    pub speed: Option<f64>,
    /// What robots are from now on, each once.
    pub specs: Vec<SpecsChange>,
    /// How badly cameras see from now on.
    pub realism: Option<Change>,
    /// Where vision is sent to from now on.
    pub vision_port: Option<u16>,
    /// Which field it shall be: that of the scene can be asked for alone.
    pub geometry: Option<SslGeometryData>,
}

/// What a datagram asks, and what is wrong with it.
pub fn read(datagram: &[u8]) -> (Control, Faults) {
    let (mut control, mut faults) = (Control::default(), Faults::default());
    match SimulatorCommand::decode(datagram) {
        Ok(command) => {
            command.control.iter().for_each(|it| control.read_control(it, &mut faults));
            command.config.iter().for_each(|it| control.read_config(it, &mut faults));
        }
        Err(error) => faults.add(Code::Unreadable, format!("this is no SimulatorCommand: {error}")),
    }
    (control, faults)
}

/// The answer to a datagram.
pub fn answer(faults: &Faults) -> Vec<u8> {
    SimulatorResponse { errors: faults.errors() }.encode_to_vec()
}

impl Control {
    fn read_control(&mut self, control: &SimulatorControl, faults: &mut Faults) {
        if let Some(ball) = &control.teleport_ball {
            self.ball = place_ball(ball, faults);
        }
        faults.limit("teleport_robot", control.teleport_robot.len());
        for robot in control.teleport_robot.iter().take(limits::COMMANDS_PER_DATAGRAM) {
            let Some(place) = place_robot(robot, faults) else { continue };
            self.robots.retain(|other| other.name != place.name);
            self.robots.push(place);
        }
        let most = limits::SIMULATION_SPEED_MAX;
        let speed = faults.sift(optional("simulation_speed", control.simulation_speed, most));
        match speed.flatten() {
            Some(speed) if speed < 0.0 => {
                faults.add(Code::OutOfRange, "simulation_speed: must be 0 (a pause) or more");
            }
            speed => self.speed = speed,
        }
    }

    fn read_config(&mut self, config: &SimulatorConfig, faults: &mut Faults) {
        if let Some(geometry) = &config.geometry {
            match SslGeometryData::decode(geometry.as_slice()) {
                Ok(geometry) => self.geometry = Some(geometry),
                Err(error) => faults.add(Code::Unreadable, format!("config.geometry: {error}")),
            }
        }
        faults.limit("robot_specs", config.robot_specs.len());
        for specs in config.robot_specs.iter().take(limits::COMMANDS_PER_DATAGRAM) {
            let Some(change) = faults.sift(SpecsChange::read(specs)) else { continue };
            if !specs.custom.is_empty() {
                let what = format!("{}: custom specs are not known here", change.name);
                faults.add(Code::Unsupported, what);
            }
            if change.center_to_dribbler.is_some() {
                let what = "center_to_dribbler: the dribbler is where the scene has it";
                faults.add(Code::Unsupported, format!("{}: {what}", change.name));
            }
            self.specs.retain(|other| other.name != change.name);
            self.specs.push(change);
        }
        if let Some(realism) = &config.realism_config {
            self.realism = read_realism(realism, faults);
        }
        if let Some(port) = config.vision_port {
            match u16::try_from(port) {
                Ok(port) if port > 0 => self.vision_port = Some(port),
                _ => faults.add(Code::OutOfRange, format!("vision_port {port}: 1 to 65535")),
            }
        }
    }
}

/// The robot that an id means.
///
/// # Errors
/// [`Fault`] if it means none.
pub fn name(what: &str, id: Option<RobotId>) -> Result<RobotName, Fault> {
    let unreadable = |of: &str| Fault::new(Code::Unreadable, format!("{what}: {of} is missing"));
    let id = id.ok_or_else(|| unreadable("id"))?;
    let number = id.id.ok_or_else(|| unreadable("id.id"))?;
    let team = match id.team.map(proto::Team::try_from) {
        Some(Ok(proto::Team::Blue)) => Team::Blue,
        Some(Ok(proto::Team::Yellow)) => Team::Yellow,
        Some(Ok(proto::Team::Unknown)) | None => return Err(unreadable("id.team")),
        Some(Err(_)) => {
            let team = id.team.unwrap_or_default();
            let what = format!("{what}: team {team}: must be 1 (yellow) or 2 (blue)");
            return Err(Fault::new(Code::Unknown, what));
        }
    };
    numbered(RobotName { team, number })
}

fn place_robot(robot: &TeleportRobot, faults: &mut Faults) -> Option<PlaceRobot> {
    let name = faults.sift(name("teleport_robot", robot.id))?;
    let read = || {
        let part = |of: &str, value, most| optional(&format!("{name}: {of}"), value, most);
        let speed = |of, value| Ok(part(of, value, limits::SPEED_MAX_MPS)?.unwrap_or(0.0));
        Ok(PlaceRobot {
            name,
            x: part("x", robot.x, limits::PLACE_MAX_M)?,
            y: part("y", robot.y, limits::PLACE_MAX_M)?,
            heading: part("orientation", robot.orientation, limits::TURN_MAX_RADPS)?,
            velocity: DVec2::new(speed("v_x", robot.v_x)?, speed("v_y", robot.v_y)?),
            turn: part("v_angular", robot.v_angular, limits::TURN_MAX_RADPS)?.unwrap_or(0.0),
            present: robot.present,
            by_force: robot.by_force == Some(true),
        })
    };
    faults.sift(read())
}

fn place_ball(ball: &TeleportBall, faults: &mut Faults) -> Option<PlaceBall> {
    let part = |of: &str, value, most| optional(&format!("ball: {of}"), value, most);
    let read = || {
        let height = part("z", ball.z, limits::PLACE_MAX_M)?;
        let rise = part("vz", ball.vz, limits::SPEED_MAX_MPS)?;
        let place = PlaceBall::read([ball.x, ball.y, ball.vx, ball.vy].map(|it| it.map(f64::from)));
        let (roll, safely) = (ball.roll == Some(true), ball.teleport_safely == Some(true));
        let by_force = ball.by_force == Some(true);
        let place = PlaceBall { roll, safely, by_force, ..place? };
        // On the ground its centre is a radius high: teams send 0, or that.
        Ok((place, height.unwrap_or(0.0).abs() > 0.05 || rise.unwrap_or(0.0) != 0.0))
    };
    let (place, flies) = faults.sift(read())?;
    if flies {
        faults.add(Code::Unsupported, "ball: z, vz: the ball stays on the ground");
    }
    Some(place)
}

fn read_realism(realism: &RealismConfig, faults: &mut Faults) -> Option<Change> {
    let mut change = None;
    for custom in &realism.custom {
        let kind = custom.type_url.rsplit(['/', '.']).next().unwrap_or_default();
        if kind != "RealismConfigErForce" {
            let known = "RealismConfigErForce is known";
            let what = format!("realism_config: {:.80}: {known}", custom.type_url);
            faults.add(Code::Unsupported, what);
            continue;
        }
        match RealismConfigErForce::decode(custom.value.as_slice()) {
            Ok(config) => change = Change::read(&config, faults).or(change),
            Err(error) => {
                faults.add(Code::Unreadable, format!("this is no {kind}: {error}"));
            }
        }
    }
    change
}

#[cfg(test)]
mod tests {
    use super::*;

    fn codes(faults: &Faults) -> Vec<Code> {
        faults.iter().map(|fault| fault.code).collect()
    }

    fn yellow(number: u32) -> Option<RobotId> {
        Some(RobotId { id: Some(number), team: Some(proto::Team::Yellow as i32) })
    }

    fn ask(control: SimulatorControl, config: SimulatorConfig) -> (Control, Vec<Code>) {
        let command = SimulatorCommand { control: Some(control), config: Some(config) };
        let (control, faults) = read(&command.encode_to_vec());
        (control, codes(&faults))
    }

    #[test]
    fn teleports_are_read_with_what_they_leave_out() {
        let ball = TeleportBall { x: Some(1.0), vy: Some(-2.0), ..TeleportBall::default() };
        let robot = TeleportRobot { id: yellow(3), present: Some(false), ..Default::default() };
        let placed = TeleportRobot { id: yellow(3), x: Some(0.5), v_x: Some(1.0), ..robot };
        let (control, codes) = ask(
            SimulatorControl {
                teleport_ball: Some(ball),
                teleport_robot: vec![robot, placed],
                simulation_speed: Some(0.5),
            },
            SimulatorConfig { vision_port: Some(10_006), ..Default::default() },
        );
        assert_eq!(codes, []);
        let asked = PlaceBall { x: Some(1.0), vy: Some(-2.0), ..PlaceBall::default() };
        assert_eq!((control.ball, control.speed), (Some(asked), Some(0.5)));
        assert_eq!(control.vision_port, Some(10_006));
        let place = control.robots[0];
        assert_eq!((control.robots.len(), place.x, place.y), (1, Some(0.5), None));
        assert_eq!((place.velocity, place.present), (DVec2::X, Some(false)));
        assert!(place.moves());
    }

    #[test]
    fn each_bad_part_is_told_and_the_others_are_done() {
        let good = TeleportRobot { id: yellow(3), x: Some(0.5), ..Default::default() };
        let team = |team| Some(RobotId { id: Some(1), team });
        let robots = [
            (TeleportRobot { id: None, ..good }, Code::Unreadable),
            (TeleportRobot { id: team(None), ..good }, Code::Unreadable),
            (TeleportRobot { id: team(Some(7)), ..good }, Code::Unknown),
            (TeleportRobot { id: yellow(16), ..good }, Code::Unknown),
            (TeleportRobot { id: yellow(1), x: Some(f32::NAN), ..good }, Code::NotFinite),
            (TeleportRobot { id: yellow(1), v_y: Some(1e9), ..good }, Code::OutOfRange),
        ];
        for (robot, code) in robots {
            let teleport_robot = vec![robot, good];
            let control = SimulatorControl { teleport_robot, ..Default::default() };
            let (control, codes) = ask(control, SimulatorConfig::default());
            assert_eq!((control.robots.len(), codes.as_slice()), (1, [code].as_slice()));
        }
        let config = SimulatorConfig { vision_port: Some(70_000), ..Default::default() };
        let config = SimulatorConfig { geometry: Some(vec![0xff]), ..config };
        let speed = SimulatorControl { simulation_speed: Some(-1.0), ..Default::default() };
        let (control, codes) = ask(speed, config);
        assert_eq!(codes, [Code::OutOfRange, Code::Unreadable, Code::OutOfRange]);
        assert_eq!(control, Control::default());
    }

    #[test]
    fn cut_datagrams_are_unreadable() {
        let teleport_robot = vec![TeleportRobot { id: yellow(3), ..Default::default() }];
        let control = SimulatorControl { teleport_robot, ..Default::default() };
        let command = SimulatorCommand { control: Some(control), config: None };
        let bytes = command.encode_to_vec();
        for end in 1..bytes.len() {
            let (control, faults) = read(&bytes[..end]);
            assert_eq!(control, Control::default());
            assert_eq!(codes(&faults), [Code::Unreadable], "{end}");
        }
    }
}
