//! Robots that speak standard messages alone: `<robot>/odom` in, `<robot>/corrected_velocity` out.
//!
//! Each is an observed circle with an id of its own; radius and mass come from parameters. All of
//! their `odom` must be in one frame. A twist is in the robot's own frame, on the way in and on the
//! way out.

use std::collections::BTreeMap;

use glam::DVec2;
use ros2_client::ParameterValue;

use super::complaints::Complaints;
use super::dds::{DdsError, Listeners, Publisher, Ros};
use super::outputs::send;
use super::parameters::Parameters;
use crate::messages::{Header, Odometry, TwistStamped};
use crate::publish::odometry;
use crate::receive::Standing;
use crate::world::{Disc, DiscId, limits};

/// Messages kept for a subscriber that is slow to acknowledge.
const DEPTH: usize = 10;

/// A robot by its name.
struct Robot {
    name: String,
    radius: f64,
    mass: f64,
    publisher: Publisher<TwistStamped>,
    /// As it was last reported.
    last: Option<(Odometry, Standing)>,
}

/// All that the parameter `robots` names.
pub struct Robots(BTreeMap<DiscId, Robot>);

impl Robots {
    /// Opens their publishers.
    pub fn open(ros: &mut Ros, parameters: &Parameters) -> Result<Self, DdsError> {
        let ParameterValue::StringArray(names) = parameters.value("robots") else {
            return Ok(Self(BTreeMap::new()));
        };
        let number = |name: &str, of: &str| match parameters.value(&format!("{name}.{of}")) {
            ParameterValue::Double(number) => number,
            _ => f64::NAN,
        };
        let mut robots = BTreeMap::new();
        for (id, name) in (limits::FIRST_ROBOT_ID..).zip(names) {
            let publisher = ros.publisher(&format!("{name}/corrected_velocity"), DEPTH)?;
            let (radius, mass) = (number(&name, "radius"), number(&name, "mass"));
            robots.insert(id, Robot { name, radius, mass, publisher, last: None });
        }
        Ok(Self(robots))
    }

    /// Ids and names.
    pub fn names(&self) -> impl Iterator<Item = (DiscId, &str)> {
        self.0.iter().map(|(id, robot)| (*id, robot.name.as_str()))
    }

    /// Takes note of where a robot is; the circle that it then is.
    pub fn report(&mut self, id: DiscId, odom: Odometry, standing: Standing) -> Option<Disc> {
        let robot = self.0.get_mut(&id)?;
        let Standing { position, velocity, .. } = standing;
        robot.last = Some((odom, standing));
        Some(Disc { id, position, velocity, radius: robot.radius, mass: robot.mass })
    }

    /// Tells the robots among these circles their velocities, at the time of a message.
    pub fn correct(
        &self,
        header: &Header,
        velocities: &[(DiscId, DVec2)],
        listeners: &Listeners,
        complaints: &mut Complaints,
    ) {
        for (id, velocity) in velocities {
            let Some(robot) = self.0.get(id) else { continue };
            let Some((odom, standing)) = &robot.last else { continue };
            send(listeners, &robot.publisher, complaints, || {
                odometry::corrected(header, odom, standing.heading, *velocity)
            });
        }
    }
}
