//! Realism: how badly cameras see. All of it is off by default; then vision is exact.
//!
//! Noise comes from a generator with a fixed definition and from basic arithmetic: the same seed
//! and the same game give the same packets. It is drawn for vision alone, never for the motion.

use glam::DVec2;
use rand_pcg::Pcg64;
use rand_pcg::rand_core::{Rng, SeedableRng};

use super::fault::{Code, Fault, Faults, bounded};
use super::limits;
use super::proto::simulation::RealismConfigErForce;

/// How badly cameras see.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Realism {
    /// Standard deviation of the ball's place, each way, m.
    pub ball_deviation_m: f64,
    /// Standard deviation of a robot's place, each way, m.
    pub robot_deviation_m: f64,
    /// Standard deviation of a robot's heading, rad.
    pub heading_deviation_rad: f64,
    /// Part of the frames in which the ball is not seen, 0 to 1.
    pub missing_balls: f64,
    /// By how much a camera sees into the field of the next, m.
    pub camera_overlap_m: f64,
    /// A frame is sent so long after its capture, s of simulated time.
    pub delay_s: f64,
}

/// What shall be different; nothing = as before.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Change {
    /// As in [`Realism`].
    pub ball_deviation_m: Option<f64>,
    /// As in [`Realism`].
    pub robot_deviation_m: Option<f64>,
    /// As in [`Realism`].
    pub heading_deviation_rad: Option<f64>,
    /// As in [`Realism`].
    pub missing_balls: Option<f64>,
    /// As in [`Realism`].
    pub camera_overlap_m: Option<f64>,
    /// As in [`Realism`].
    pub delay_s: Option<f64>,
}

impl Realism {
    /// With a change.
    pub fn with(self, change: Change) -> Self {
        Self {
            ball_deviation_m: change.ball_deviation_m.unwrap_or(self.ball_deviation_m),
            robot_deviation_m: change.robot_deviation_m.unwrap_or(self.robot_deviation_m),
            heading_deviation_rad: change
                .heading_deviation_rad
                .unwrap_or(self.heading_deviation_rad),
            missing_balls: change.missing_balls.unwrap_or(self.missing_balls),
            camera_overlap_m: change.camera_overlap_m.unwrap_or(self.camera_overlap_m),
            delay_s: change.delay_s.unwrap_or(self.delay_s),
        }
    }
}

impl Change {
    /// What the configuration of the ER-Force simulator asks, as far as carom has it. Nothing of it
    /// is taken if a number is wrong.
    pub fn read(config: &RealismConfigErForce, faults: &mut Faults) -> Option<Self> {
        let change = faults.sift(Self::numbers(config))?;
        for (what, is_asked) in [
            ("stddev_ball_area", is_above_0(config.stddev_ball_area)),
            ("enable_invisible_ball", config.enable_invisible_ball == Some(true)),
            ("dribbler_ball_detections", is_above_0(config.dribbler_ball_detections)),
            ("camera_position_error", is_above_0(config.camera_position_error)),
            ("robot_command_loss", is_above_0(config.robot_command_loss)),
            ("robot_response_loss", is_above_0(config.robot_response_loss)),
        ] {
            if is_asked {
                faults.add(Code::Unsupported, format!("realism: {what} is not simulated"));
            }
        }
        Some(change)
    }

    fn numbers(config: &RealismConfigErForce) -> Result<Self, Fault> {
        let number = |what: &str, value: Option<f32>, most: f64| {
            value.map(|value| at_least_0(what, f64::from(value), most)).transpose()
        };
        let nanoseconds = config.vision_delay.map(|delay| delay as f64 * 1e-9);
        let most = limits::DELAY_MAX_S;
        Ok(Self {
            ball_deviation_m: number("stddev_ball_p", config.stddev_ball_p, 1.0)?,
            robot_deviation_m: number("stddev_robot_p", config.stddev_robot_p, 1.0)?,
            heading_deviation_rad: number("stddev_robot_phi", config.stddev_robot_phi, 10.0)?,
            missing_balls: number("missing_ball_detections", config.missing_ball_detections, 1.0)?,
            camera_overlap_m: number("camera_overlap", config.camera_overlap, 100.0)?,
            delay_s: nanoseconds.map(|s| at_least_0("vision_delay", s, most)).transpose()?,
        })
    }
}

fn is_above_0(value: Option<f32>) -> bool {
    value.is_some_and(|value| value != 0.0)
}

fn at_least_0(what: &str, value: f64, most: f64) -> Result<f64, Fault> {
    let value = bounded(&format!("realism: {what}"), value, most)?;
    if value < 0.0 {
        return Err(Fault::new(Code::OutOfRange, format!("realism: {what} is {value}: 0 or more")));
    }
    Ok(value)
}

/// A source of noise.
#[derive(Clone, Debug)]
pub struct Noise(Pcg64);

impl Noise {
    /// From a seed.
    pub fn new(seed: u64) -> Self {
        Self(Pcg64::seed_from_u64(seed))
    }

    /// A number in [0, 1).
    pub fn uniform(&mut self) -> f64 {
        // The 53 high bits, as a multiple of 2^-53.
        (self.0.next_u64() >> 11) as f64 * (1.0 / (1u64 << 53) as f64)
    }

    /// Two independent numbers, normal with deviation 1 (Marsaglia's polar method).
    pub fn normal(&mut self) -> DVec2 {
        loop {
            let point = DVec2::new(self.uniform(), self.uniform()) * 2.0 - 1.0;
            let square = point.length_squared();
            if square > 0.0 && square < 1.0 {
                return point * (-2.0 * libm::log(square) / square).sqrt();
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_is_normal_and_of_its_seed() {
        let (mut noise, mut again) = (Noise::new(7), Noise::new(7));
        let drawn: Vec<DVec2> = (0..20_000).map(|_| noise.normal()).collect();
        assert!(drawn.iter().all(|point| *point == again.normal()));
        let mean = drawn.iter().copied().sum::<DVec2>() / drawn.len() as f64;
        let square = drawn.iter().map(|point| *point * *point).sum::<DVec2>() / drawn.len() as f64;
        let fourth = drawn.iter().map(|point| point.x.powi(4)).sum::<f64>() / drawn.len() as f64;
        // Five deviations of each mean.
        assert!(mean.abs().max_element() < 0.036, "{mean}");
        assert!((square - 1.0).abs().max_element() < 0.05, "{square}");
        assert!((fourth - 3.0).abs() < 0.36, "{fourth}");
    }

    #[test]
    fn what_is_not_simulated_is_told_and_bad_numbers_change_nothing() {
        let config = RealismConfigErForce {
            stddev_ball_p: Some(0.01),
            vision_delay: Some(35_000_000),
            robot_command_loss: Some(0.1),
            ..Default::default()
        };
        let mut faults = Faults::default();
        // None of its numbers is out of range.
        let change = Change::read(&config, &mut faults).expect("its numbers are sound");
        assert!((change.delay_s.unwrap_or(0.0) - 0.035).abs() < 1e-12);
        let realism = Realism { camera_overlap_m: 0.2, ..Realism::default() }.with(change);
        assert!((realism.ball_deviation_m - 0.01).abs() < 1e-9);
        assert_eq!(realism.camera_overlap_m, 0.2);
        assert_eq!(faults.iter().map(|it| it.code).collect::<Vec<_>>(), [Code::Unsupported]);
        for bad in [
            RealismConfigErForce { stddev_robot_p: Some(f32::NAN), ..config },
            RealismConfigErForce { stddev_robot_phi: Some(-0.1), ..config },
            RealismConfigErForce { vision_delay: Some(i64::MAX), ..config },
        ] {
            let mut faults = Faults::default();
            assert_eq!(Change::read(&bad, &mut faults), None);
            assert!(!faults.is_empty());
        }
    }
}
