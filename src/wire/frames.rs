//! Tracked frames on topics, as consai's packages have them: robots and balls that somebody tracks
//! become circles, and frames are told of the arena or given back with corrected velocities.
//!
//! Positions and velocities are in metres, in the frame of the field. A tracker that tells no
//! velocity, or that does not see a thing any more, says nothing that could collide.

use glam::DVec2;

use super::proto::tracked::Capability;
use super::{Kicked, RobotName, Team, View, limits};
use crate::messages::{
    KickedBall, PlaneVector, RobotId, SpaceVector, TrackedBall, TrackedFrame, TrackedRobot,
};
use crate::world::{Defect, Disc, DiscId, Report, limits::FIRST_PLAYER_ID};

/// How large and heavy what a tracker sees is: it says nothing of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sizes {
    /// m
    pub robot_radius: f64,
    /// kg
    pub robot_mass: f64,
    /// m
    pub ball_radius: f64,
    /// kg
    pub ball_mass: f64,
}

impl Default for Sizes {
    /// Small Size League: robots as large as allowed and as heavy as TIGERs' simulator has them, a
    /// golf ball.
    fn default() -> Self {
        Self { robot_radius: 0.09, robot_mass: 2.5, ball_radius: 0.0215, ball_mass: 0.046 }
    }
}

/// Balls have ids from here on, by their place in the frame.
const FIRST_BALL_ID: DiscId = FIRST_PLAYER_ID + 2 * limits::ROBOTS_PER_TEAM;
/// Most balls of a frame that are circles.
const BALLS: usize = 64;

/// The id of the circle that a robot is; nothing for one that no team has.
pub fn id_of_robot(robot: RobotId) -> Option<DiscId> {
    let team = match robot.team_color {
        RobotId::BLUE => 0,
        RobotId::YELLOW => limits::ROBOTS_PER_TEAM,
        _ => return None,
    };
    (robot.id < limits::ROBOTS_PER_TEAM).then_some(FIRST_PLAYER_ID + team + robot.id)
}

/// What a frame reports as circles, and what of it is none: with its name, and why.
pub fn report(frame: &TrackedFrame, sizes: &Sizes) -> (Report, Vec<(String, Bad)>) {
    let mut report = Report { discs: Vec::new(), time: frame.timestamp };
    let mut bad = Vec::new();
    for robot in &frame.robots {
        let name = format!("robot {} of team {}", robot.robot_id.id, robot.robot_id.team_color);
        let Some(id) = id_of_robot(robot.robot_id) else {
            bad.push((name, Bad::Unknown));
            continue;
        };
        let Some(velocity) = robot.vel.first().filter(|_| is_seen(&robot.visibility)) else {
            continue;
        };
        let (position, velocity) = (plane(robot.pos), plane(*velocity));
        let (radius, mass) = (sizes.robot_radius, sizes.robot_mass);
        take(&mut report, &mut bad, name, Disc { id, position, velocity, radius, mass });
    }
    for (k, ball) in frame.balls.iter().take(BALLS).enumerate() {
        let Some(velocity) = ball.vel.first().filter(|_| is_seen(&ball.visibility)) else {
            continue;
        };
        let id = FIRST_BALL_ID + k as DiscId;
        let (position, velocity) = (space(ball.pos), space(*velocity));
        let (radius, mass) = (sizes.ball_radius, sizes.ball_mass);
        take(
            &mut report,
            &mut bad,
            format!("ball {k}"),
            Disc { id, position, velocity, radius, mass },
        );
    }
    (report, bad)
}

/// Why a thing of a frame is no circle.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Bad {
    /// No team has it.
    #[error("teams are 1 (yellow) and 2 (blue), robots 0 to 15")]
    Unknown,
    /// It is there already.
    #[error("it is in the frame twice: the first is taken")]
    Twice,
    /// A number is none.
    #[error(transparent)]
    Defect(#[from] Defect),
}

fn take(report: &mut Report, bad: &mut Vec<(String, Bad)>, name: String, disc: Disc) {
    if let Some(defect) = disc.refusal() {
        bad.push((name, defect.into()));
    } else if report.discs.iter().any(|other| other.id == disc.id) {
        bad.push((name, Bad::Twice));
    } else {
        report.discs.push(disc);
    }
}

/// A thing of which no visibility is told is seen.
fn is_seen(visibility: &[f32]) -> bool {
    visibility.first().is_none_or(|visibility| *visibility > 0.0)
}

fn plane(vector: PlaneVector) -> DVec2 {
    DVec2::new(vector.x.into(), vector.y.into())
}

fn space(vector: SpaceVector) -> DVec2 {
    DVec2::new(vector.x.into(), vector.y.into())
}

/// A frame in which those that touched have the velocities that they must have.
pub fn corrected(mut frame: TrackedFrame, velocities: &[(DiscId, DVec2)]) -> TrackedFrame {
    let of = |id: DiscId| velocities.iter().find(|(other, _)| *other == id).map(|(_, v)| *v);
    for robot in &mut frame.robots {
        if let (Some(velocity), Some(vel)) =
            (id_of_robot(robot.robot_id).and_then(of), robot.vel.first_mut())
        {
            *vel = PlaneVector { x: velocity.x as f32, y: velocity.y as f32 };
        }
    }
    for (k, ball) in frame.balls.iter_mut().take(BALLS).enumerate() {
        if let (Some(velocity), Some(vel)) = (of(FIRST_BALL_ID + k as DiscId), ball.vel.first_mut())
        {
            (vel.x, vel.y) = (velocity.x as f32, velocity.y as f32);
        }
    }
    frame
}

/// The arena's own frame.
pub fn of_view(view: &View, frame_number: u32) -> TrackedFrame {
    let balls = view.ball.map(|(at, velocity)| TrackedBall {
        pos: SpaceVector { x: at.x as f32, y: at.y as f32, z: 0.0 },
        vel: vec![SpaceVector { x: velocity.x as f32, y: velocity.y as f32, z: 0.0 }],
        visibility: vec![1.0],
    });
    let robots = view.robots.iter().map(|robot| TrackedRobot {
        robot_id: id(robot.name),
        pos: PlaneVector { x: robot.position.x as f32, y: robot.position.y as f32 },
        orientation: robot.heading as f32,
        vel: vec![PlaneVector { x: robot.velocity.x as f32, y: robot.velocity.y as f32 }],
        vel_angular: vec![robot.turn as f32],
        visibility: vec![1.0],
    });
    TrackedFrame {
        frame_number,
        timestamp: view.time,
        balls: balls.into_iter().collect(),
        robots: robots.collect(),
        kicked_ball: view.kicked.iter().map(kicked).collect(),
        capabilities: vec![Capability::DetectKickedBalls as u32],
    }
}

fn kicked(kick: &Kicked) -> KickedBall {
    let (at, velocity) = (kick.position, kick.velocity);
    let place = |(_, place): (f64, DVec2)| PlaneVector { x: place.x as f32, y: place.y as f32 };
    KickedBall {
        pos: PlaneVector { x: at.x as f32, y: at.y as f32 },
        vel: SpaceVector { x: velocity.x as f32, y: velocity.y as f32, z: 0.0 },
        start_timestamp: kick.time,
        stop_timestamp: kick.stop.iter().map(|(time, _)| *time).collect(),
        stop_pos: kick.stop.map(place).into_iter().collect(),
        robot_id: kick.by.map(id).into_iter().collect(),
    }
}

fn id(name: RobotName) -> RobotId {
    let team_color = match name.team {
        Team::Blue => RobotId::BLUE,
        Team::Yellow => RobotId::YELLOW,
    };
    RobotId { id: name.number, team_color }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn robot(id: u32, team_color: u32, x: f32, vx: f32) -> TrackedRobot {
        TrackedRobot {
            robot_id: RobotId { id, team_color },
            pos: PlaneVector { x, y: 0.0 },
            vel: vec![PlaneVector { x: vx, y: 0.0 }],
            ..TrackedRobot::default()
        }
    }

    #[test]
    fn what_is_seen_with_a_velocity_is_a_circle() {
        let unseen = TrackedRobot { visibility: vec![0.0], ..robot(3, 1, 1.0, 0.0) };
        let slow = TrackedRobot { vel: Vec::new(), ..robot(4, 1, 2.0, 0.0) };
        let ball = TrackedBall { vel: vec![SpaceVector::default()], ..TrackedBall::default() };
        let frame = TrackedFrame {
            timestamp: 5.0,
            robots: vec![
                robot(2, 2, 0.5, 1.0),
                robot(2, 1, 1.5, -1.0),
                unseen,
                slow,
                robot(16, 1, 3.0, 0.0),
                robot(1, 0, 3.0, 0.0),
                robot(2, 2, 4.0, 0.0),
                robot(5, 2, f32::NAN, 0.0),
            ],
            balls: vec![ball],
            ..TrackedFrame::default()
        };
        let (report, bad) = report(&frame, &Sizes::default());
        let ids: Vec<DiscId> = report.discs.iter().map(|disc| disc.id).collect();
        assert_eq!(ids, [FIRST_PLAYER_ID + 2, FIRST_PLAYER_ID + 18, FIRST_BALL_ID]);
        assert_eq!((report.time, report.discs[2].mass), (5.0, 0.046));
        let why: Vec<&Bad> = bad.iter().map(|(_, why)| why).collect();
        assert!(matches!(why.as_slice(), [Bad::Unknown, Bad::Unknown, Bad::Twice, Bad::Defect(_)]));
    }

    #[test]
    fn a_corrected_frame_differs_in_the_velocities_of_those_that_touched_alone() {
        let ball = TrackedBall { vel: vec![SpaceVector::default()], ..TrackedBall::default() };
        let robots = vec![robot(2, 2, 0.5, 1.0), robot(2, 1, 1.5, -1.0)];
        let frame = TrackedFrame { robots, balls: vec![ball], ..TrackedFrame::default() };
        let velocities = [(FIRST_PLAYER_ID + 18, DVec2::new(0.5, 0.25)), (FIRST_BALL_ID, DVec2::X)];
        let told = corrected(frame.clone(), &velocities);
        assert_eq!(told.robots[0], frame.robots[0]);
        assert_eq!(told.robots[1].vel, [PlaneVector { x: 0.5, y: 0.25 }]);
        assert_eq!(told.balls[0].vel, [SpaceVector { x: 1.0, y: 0.0, z: 0.0 }]);
        assert_eq!(told.robots[1].pos, frame.robots[1].pos);
    }
}
