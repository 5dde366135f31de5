//! `pucks/<name>/odom`, where a driven puck is, as any robot tells it; and what a robot that tells
//! its own must do. The twist is in the robot's frame, as the type has it.

use glam::DVec2;

use crate::messages::{
    Header, Odometry, Pose, PoseWithCovariance, Quaternion, Twist, TwistStamped,
    TwistWithCovariance, Vector3,
};
use crate::world::{self, Disc};

/// The message of a puck that looks and turns like this; its covariances are 0, for it is exact.
pub fn of_puck(header: Header, name: &str, disc: &Disc, pose: world::Pose) -> Odometry {
    let forward = DVec2::from_angle(-pose.heading).rotate(disc.velocity);
    let (sine, cosine) = (0.5 * pose.heading).sin_cos();
    let DVec2 { x, y } = disc.position;
    Odometry {
        header,
        child_frame_id: format!("{name}/base_link"),
        pose: PoseWithCovariance {
            pose: Pose {
                position: Vector3 { x, y, z: 0.0 },
                orientation: Quaternion { z: sine, w: cosine, ..Quaternion::default() },
            },
            ..Default::default()
        },
        twist: TwistWithCovariance {
            twist: Twist {
                linear: Vector3 { x: forward.x, y: forward.y, z: 0.0 },
                angular: Vector3 { z: pose.turn, ..Vector3::default() },
            },
            ..Default::default()
        },
    }
}

/// `<robot>/corrected_velocity` of a robot that has told this and looks there: it turns as before.
pub fn corrected(header: &Header, odom: &Odometry, heading: f64, velocity: DVec2) -> TwistStamped {
    let forward = DVec2::from_angle(-heading).rotate(velocity);
    TwistStamped {
        header: Header { stamp: header.stamp, frame_id: odom.child_frame_id.clone() },
        twist: Twist {
            linear: Vector3 { x: forward.x, y: forward.y, z: 0.0 },
            angular: odom.twist.twist.angular,
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_twist_is_in_the_pucks_own_frame() {
        let disc = Disc {
            id: 1,
            position: DVec2::new(1.0, 2.0),
            velocity: DVec2::new(0.0, 3.0),
            radius: 0.1,
            mass: 1.0,
        };
        let pose = world::Pose { heading: std::f64::consts::FRAC_PI_2, turn: 0.5 };
        let odom = of_puck(Header::default(), "alice", &disc, pose);
        let Vector3 { x, y, .. } = odom.twist.twist.linear;
        assert!((x - 3.0).abs() < 1e-15 && y.abs() < 1e-15, "straight ahead: {x} {y}");
        assert_eq!(odom.twist.twist.angular.z, 0.5);
        assert_eq!(odom.child_frame_id, "alice/base_link");
        let Quaternion { z, w, .. } = odom.pose.pose.orientation;
        assert!((2.0 * z.atan2(w) - pose.heading).abs() < 1e-15);
    }
}
