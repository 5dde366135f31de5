//! States of robots and ball on topics of their own, as the A-Team's packages have them.
//!
//! The twist is in the frame of the field, `twist_body` in the robot's own. Accelerations are not
//! told: they are 0. What is not there is not visible, and nothing else is said of it.

use glam::DVec2;

use super::{RobotName, Team, View};
use crate::messages::{Accel, Pose, Quaternion, Twist, Vector3, VisionStateBall, VisionStateRobot};

/// The topic of a robot.
pub fn topic(name: RobotName) -> String {
    let team = match name.team {
        Team::Blue => "blue_team",
        Team::Yellow => "yellow_team",
    };
    format!("{team}/robot{}", name.number)
}

/// The state of the ball.
pub fn of_ball(view: &View) -> VisionStateBall {
    let Some((position, velocity)) = view.ball else { return VisionStateBall::default() };
    VisionStateBall {
        pose: Pose { position: space(position), orientation: Quaternion::UPRIGHT },
        twist: Twist { linear: space(velocity), ..Twist::default() },
        accel: Accel::default(),
        visible: true,
    }
}

/// The state of a robot.
pub fn of_robot(view: &View, name: RobotName) -> VisionStateRobot {
    let Some(robot) = view.robots.iter().find(|robot| robot.name == name) else {
        return VisionStateRobot::default();
    };
    let angular = Vector3 { z: robot.turn, ..Vector3::default() };
    let own = DVec2::from_angle(-robot.heading).rotate(robot.velocity);
    let (sine, cosine) = (0.5 * robot.heading).sin_cos();
    let orientation = Quaternion { z: sine, w: cosine, ..Quaternion::default() };
    VisionStateRobot {
        pose: Pose { position: space(robot.position), orientation },
        twist: Twist { linear: space(robot.velocity), angular },
        twist_body: Twist { linear: space(own), angular },
        accel: Accel::default(),
        visible: true,
    }
}

fn space(vector: DVec2) -> Vector3 {
    Vector3 { x: vector.x, y: vector.y, z: 0.0 }
}

#[cfg(test)]
mod tests {
    use super::super::Seen;
    use super::*;

    #[test]
    fn a_twist_is_told_in_both_frames_and_who_is_gone_is_not_visible() {
        let name = RobotName { team: Team::Yellow, number: 3 };
        let (position, velocity) = (DVec2::new(1.0, 2.0), DVec2::new(0.0, 3.0));
        let (heading, turn) = (std::f64::consts::FRAC_PI_2, 0.5);
        let robot = Seen { name, position, velocity, heading, turn, radius: 0.09, height: 0.15 };
        let view = View { robots: vec![robot], ..View::default() };
        let state = of_robot(&view, name);
        assert_eq!((state.twist.linear.y, state.visible), (3.0, true));
        let own = state.twist_body.linear;
        assert!((own.x - 3.0).abs() < 1e-15 && own.y.abs() < 1e-15, "straight ahead: {own:?}");
        assert_eq!(topic(name), "yellow_team/robot3");
        let gone = RobotName { team: Team::Blue, ..name };
        assert!(!of_robot(&view, gone).visible && !of_ball(&view).visible);
    }
}
