//! Specs: what a robot is, beyond its disc: where its wheels are, how hard it kicks, how tall it
//! stands.
//!
//! Radius, mass and the limits of its drive belong to the world; this says what they shall be.

use std::f64::consts::PI;

use glam::{DMat3, DVec2, DVec3};

use super::control::name;
use super::fault::{Code, Fault, number, optional, positive};
use super::limits;
use super::orders::Kick;
use super::proto::simulation::{RobotLimits, RobotSpecs, RobotWheelAngles};
use super::{RobotName, field::Field};
use crate::world::Drive;

/// Largest acceleration asked for, m/s^2 and rad/s^2.
const ACCELERATION_MAX: f64 = 1e5;
/// Wheels of a robot that says nothing of them: 60 and 135 degrees from ahead on both sides, as in
/// grSim's settings.
const WHEELS: [f64; 4] = [PI / 3.0, 0.75 * PI, 1.25 * PI, 5.0 * PI / 3.0];
/// Radius (m) of a robot and its mass (kg), as the protocol's fields have them at most.
const RADIUS_MAX_M: f64 = 1.0;
const MASS_MAX_KG: f64 = 1e3;

/// What a robot is, beyond its disc and drive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Specs {
    /// Where the wheels are, rad from ahead with the clock: front right, back right, back left,
    /// front left.
    pub wheels: [f64; 4],
    /// Fastest kick along the ground, m/s.
    pub kick_max: f64,
    /// Fastest chip kick, m/s.
    pub chip_max: f64,
    /// m
    pub height: f64,
}

/// What shall be different; nothing = as before.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpecsChange {
    /// Whose.
    pub name: RobotName,
    /// m
    pub radius: Option<f64>,
    /// m
    pub height: Option<f64>,
    /// kg
    pub mass: Option<f64>,
    /// m/s
    pub kick_max: Option<f64>,
    /// m/s
    pub chip_max: Option<f64>,
    /// m
    pub center_to_dribbler: Option<f64>,
    /// Of the drive.
    pub limits: LimitsChange,
    /// As in [`Specs`].
    pub wheels: Option<[f64; 4]>,
}

/// What shall be different in a drive; nothing = as before.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LimitsChange {
    /// m/s
    pub speed_max: Option<f64>,
    /// rad/s
    pub turn_max: Option<f64>,
    /// Speeding up, m/s^2.
    pub speed_up: Option<f64>,
    /// Braking, m/s^2.
    pub brake: Option<f64>,
    /// Speeding up, rad/s^2.
    pub turn_up: Option<f64>,
    /// Braking, rad/s^2.
    pub turn_brake: Option<f64>,
}

impl SpecsChange {
    /// Of the protocol's specs.
    ///
    /// # Errors
    /// [`Fault`]: nothing of them is taken.
    pub fn read(specs: &RobotSpecs) -> Result<Self, Fault> {
        let name = name("robot_specs", specs.id)?;
        let part = |of: &str, value, most| positive(&format!("{name}: {of}"), value, most);
        let speed = limits::SPEED_MAX_MPS;
        Ok(Self {
            name,
            radius: part("radius", specs.radius, RADIUS_MAX_M)?,
            height: part("height", specs.height, RADIUS_MAX_M)?,
            mass: part("mass", specs.mass, MASS_MAX_KG)?,
            kick_max: at_least_0(name, "max_linear_kick_speed", specs.max_linear_kick_speed)?,
            chip_max: at_least_0(name, "max_chip_kick_speed", specs.max_chip_kick_speed)?,
            center_to_dribbler: part("center_to_dribbler", specs.center_to_dribbler, speed)?,
            limits: match &specs.limits {
                Some(limits) => LimitsChange::read(name, limits)?,
                None => LimitsChange::default(),
            },
            wheels: specs.wheel_angles.map(|angles| wheels(name, &angles)).transpose()?,
        })
    }
}

fn at_least_0(name: RobotName, of: &str, value: Option<f32>) -> Result<Option<f64>, Fault> {
    let value = optional(&format!("{name}: {of}"), value, limits::SPEED_MAX_MPS)?;
    match value {
        Some(value) if value < 0.0 => {
            Err(Fault::new(Code::OutOfRange, format!("{name}: {of} is {value}: 0 or more")))
        }
        value => Ok(value),
    }
}

fn wheels(name: RobotName, angles: &RobotWheelAngles) -> Result<[f64; 4], Fault> {
    let angle = |of: &str, value| number(&format!("{name}: wheel_angles.{of}"), value, 100.0);
    let wheels = [
        angle("front_right", angles.front_right)?,
        angle("back_right", angles.back_right)?,
        angle("back_left", angles.back_left)?,
        angle("front_left", angles.front_left)?,
    ];
    // Three wheels that differ in direction move a robot every way; four parallel ones do not.
    if normal_equations(&wheels, 0.09).determinant().abs() < 1e-9 {
        let what = format!("{name}: wheel_angles: these wheels cannot move a robot every way");
        return Err(Fault::new(Code::OutOfRange, what));
    }
    Ok(wheels)
}

impl LimitsChange {
    fn read(name: RobotName, limits: &RobotLimits) -> Result<Self, Fault> {
        let part = |of: &str, value, most| positive(&format!("{name}: {of}"), value, most);
        let most = ACCELERATION_MAX;
        Ok(Self {
            speed_max: part("vel_absolute_max", limits.vel_absolute_max, ACCELERATION_MAX)?,
            turn_max: part("vel_angular_max", limits.vel_angular_max, ACCELERATION_MAX)?,
            speed_up: part("acc_speedup_absolute_max", limits.acc_speedup_absolute_max, most)?,
            brake: part("acc_brake_absolute_max", limits.acc_brake_absolute_max, most)?,
            turn_up: part("acc_speedup_angular_max", limits.acc_speedup_angular_max, most)?,
            turn_brake: part("acc_brake_angular_max", limits.acc_brake_angular_max, most)?,
        })
    }

    /// Whether it says anything.
    pub fn is_some(&self) -> bool {
        *self != Self::default()
    }

    /// A drive with these limits. Braking that is not named is as strong as speeding up.
    pub fn apply(&self, drive: Drive) -> Drive {
        Drive {
            speed_max: self.speed_max.unwrap_or(drive.speed_max),
            turn_max: self.turn_max.unwrap_or(drive.turn_max),
            acceleration_max: self.speed_up.unwrap_or(drive.acceleration_max),
            turn_acceleration_max: self.turn_up.unwrap_or(drive.turn_acceleration_max),
            braking_max: self.brake.or(drive.braking_max),
            turn_braking_max: self.turn_brake.or(drive.turn_braking_max),
            ..drive
        }
    }
}

/// Motion from the speeds of wheels, by least squares: front right first, as in [`Specs`].
///
/// A wheel at the angle t against the clock that runs at speed v over the ground says
/// `v = -sin(t) vx + cos(t) vy + radius turn`.
fn normal_equations(wheels: &[f64; 4], radius: f64) -> DMat3 {
    let mut sum = DMat3::ZERO;
    for row in rows(wheels, radius) {
        sum += DMat3::from_cols(row * row.x, row * row.y, row * row.z);
    }
    sum
}

fn rows(wheels: &[f64; 4], radius: f64) -> [DVec3; 4] {
    wheels.map(|angle| {
        // The protocol counts wheels with the clock.
        let (sine, cosine) = libm::sincos(-angle);
        DVec3::new(-sine, cosine, radius)
    })
}

impl Specs {
    /// Of a robot of a league that nothing else was said of.
    pub fn new(field: &Field) -> Self {
        let unlimited = f64::INFINITY;
        let height = field.robot_height_m;
        Self { wheels: WHEELS, kick_max: unlimited, chip_max: unlimited, height }
    }

    /// Takes a change.
    pub fn change(&mut self, change: &SpecsChange) {
        self.wheels = change.wheels.unwrap_or(self.wheels);
        self.kick_max = change.kick_max.unwrap_or(self.kick_max);
        self.chip_max = change.chip_max.unwrap_or(self.chip_max);
        self.height = change.height.unwrap_or(self.height);
    }

    /// Speed along the ground of a kick, within what the kicker can, m/s.
    pub fn along_the_ground(&self, kick: Kick) -> f64 {
        let most = if kick.angle > 0.0 { self.chip_max } else { self.kick_max };
        kick.speed.min(most) * libm::cos(kick.angle)
    }

    /// Velocity in the robot's own frame (m/s) and turning rate (rad/s) that wheels of these speeds
    /// (m/s) make together; wheels that contradict each other slip least in sum of squares.
    pub fn motion(&self, speeds: &[f64; 4], radius: f64) -> (DVec2, f64) {
        let right = rows(&self.wheels, radius)
            .iter()
            .zip(speeds)
            .fold(DVec3::ZERO, |sum, (row, speed)| sum + *row * *speed);
        let motion = normal_equations(&self.wheels, radius).inverse() * right;
        (motion.truncate(), motion.z)
    }
}

#[cfg(test)]
mod tests {
    use super::super::field::division_b;
    use super::super::{Team, proto};
    use super::*;

    fn specs() -> RobotSpecs {
        let id = proto::RobotId { id: Some(2), team: Some(proto::Team::Blue as i32) };
        RobotSpecs { id: Some(id), ..RobotSpecs::default() }
    }

    #[test]
    fn wheels_make_the_motion_that_turns_them() {
        let specs = Specs::new(&division_b());
        let (linear, turn) = (DVec2::new(1.5, -0.25), 3.0);
        let asked = linear.extend(turn);
        let speeds = rows(&specs.wheels, 0.09).map(|row| row.dot(asked));
        let (made, turned) = specs.motion(&speeds, 0.09);
        assert!((made - linear).length() < 1e-12 && (turned - turn).abs() < 1e-12);
        // Ahead, the wheels on the right turn against the clock and those on the left with it.
        let ahead = rows(&specs.wheels, 0.09).map(|row| row.x);
        assert!(ahead[0] > 0.0 && ahead[1] > 0.0 && ahead[2] < 0.0 && ahead[3] < 0.0, "{ahead:?}");
    }

    #[test]
    fn bad_specs_change_nothing() {
        let angles = RobotWheelAngles {
            front_right: Some(0.0),
            back_right: Some(0.0),
            back_left: Some(0.0),
            front_left: Some(0.0),
        };
        for (bad, code) in [
            (RobotSpecs { id: None, ..specs() }, Code::Unreadable),
            (RobotSpecs { radius: Some(0.0), ..specs() }, Code::OutOfRange),
            (RobotSpecs { mass: Some(f32::NAN), ..specs() }, Code::NotFinite),
            (RobotSpecs { max_linear_kick_speed: Some(-1.0), ..specs() }, Code::OutOfRange),
            (RobotSpecs { wheel_angles: Some(angles), ..specs() }, Code::OutOfRange),
        ] {
            assert_eq!(SpecsChange::read(&bad).map_err(|fault| fault.code), Err(code));
        }
        let change = SpecsChange::read(&RobotSpecs { mass: Some(2.5), ..specs() });
        // A mass alone is sound.
        let change = change.expect("these are sound");
        assert_eq!((change.name.team, change.mass, change.radius), (Team::Blue, Some(2.5), None));
        assert!(!change.limits.is_some());
    }
}
