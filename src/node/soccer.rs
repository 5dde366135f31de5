//! Robot soccer on topics: tracked frames in and out, as teams' ROS 2 packages have them.
//!
//! A scene with teams tells its own frames, at the rate of its states; a tracker's frames come in
//! on a topic that a parameter names and go out again with corrected velocities. What nobody hears
//! is not built.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;

use glam::DVec2;
use ros2_client::ParameterValue;

use super::complaints::Complaints;
use super::dds::{DdsError, Publisher, Ros};
use super::outputs::send;
use super::parameters::{Parameter, Parameters};
use super::peers::Peers;
use super::stage::Stage;
use super::wire;
use crate::messages::{TrackedFrame, VisionStateBall, VisionStateRobot};
use crate::receive::Cause;
use crate::scene::Puck;
use crate::wire::frames::{self, Bad, Sizes};
use crate::wire::{RobotName, View, states};
use crate::world::{DiscId, Report, limits};

/// Messages kept for a subscriber that is slow to acknowledge.
const DEPTH: usize = 10;
/// Parameters.
const IN: &str = "tracked_in";
const OUT: &str = "tracked_out";
const CORRECTED: &str = "tracked_corrected";
const STATES: &str = "team_states";

/// Frames in and out.
pub struct Soccer {
    sizes: Sizes,
    /// The topic of a tracker.
    heard: Option<String>,
    corrected: Option<Publisher<TrackedFrame>>,
    arena: Option<Publisher<TrackedFrame>>,
    states: Option<States>,
    /// Frames of the arena so far.
    frames: u32,
}

/// A topic for each robot, and one for the ball.
struct States {
    ball: Publisher<VisionStateBall>,
    robots: BTreeMap<RobotName, Publisher<VisionStateRobot>>,
}

/// The parameters of soccer, with what they are for the pucks of a scene.
pub fn parameters(pucks: &[Puck]) -> Vec<Parameter> {
    let text = |text: &str| ParameterValue::String(text.to_owned());
    let has_teams = pucks.iter().any(|puck| puck.member.is_some());
    let out = if has_teams { "detection_tracked" } else { "" };
    let size = |name, value, description| {
        Parameter::new(name, ParameterValue::Double(value), description)
            .within(limits::SIZE_MIN, limits::SIZE_MAX)
    };
    let Sizes { robot_radius, robot_mass, ball_radius, ball_mass } = Sizes::default();
    vec![
        Parameter::new(OUT, text(out), "Where the arena's robocup_ssl_msgs/TrackedFrame are told.")
            .only("empty = nowhere"),
        Parameter::new(IN, text(""), "A topic of tracked frames, whose things are circles.")
            .only("empty = none"),
        Parameter::new(
            CORRECTED,
            text("detection_tracked_corrected"),
            "Where these are told again with the velocities after their contacts.",
        ),
        Parameter::new(
            STATES,
            ParameterValue::Boolean(false),
            "Tell ateam_msgs/VisionStateRobot on blue_team/robotN, yellow_team/robotN, and ball.",
        ),
        size("tracked_robot_radius", robot_radius, "Radius of robots of tracked frames, m."),
        size("tracked_robot_mass", robot_mass, "Mass of robots of tracked frames, kg."),
        size("tracked_ball_radius", ball_radius, "Radius of balls of tracked frames, m."),
        size("tracked_ball_mass", ball_mass, "Mass of balls of tracked frames, kg."),
    ]
}

impl Soccer {
    /// Opens what the parameters ask for.
    pub fn open(ros: &mut Ros, parameters: &Parameters) -> Result<Self, DdsError> {
        let text = |name| match parameters.value(name) {
            ParameterValue::String(text) => Some(text).filter(|text| !text.is_empty()),
            _ => None,
        };
        let number = |name| match parameters.value(name) {
            ParameterValue::Double(number) => number,
            _ => f64::NAN,
        };
        let heard = text(IN);
        let mut publisher =
            |topic: Option<String>| topic.map(|topic| ros.publisher(&topic, DEPTH)).transpose();
        let corrected = publisher(text(CORRECTED).filter(|_| heard.is_some()))?;
        let arena = publisher(text(OUT))?;
        let sizes = Sizes {
            robot_radius: number("tracked_robot_radius"),
            robot_mass: number("tracked_robot_mass"),
            ball_radius: number("tracked_ball_radius"),
            ball_mass: number("tracked_ball_mass"),
        };
        let states = match parameters.value(STATES) {
            ParameterValue::Boolean(true) => {
                Some(States { ball: ros.publisher("ball", DEPTH)?, robots: BTreeMap::new() })
            }
            _ => None,
        };
        Ok(Self { sizes, heard, corrected, arena, states, frames: 0 })
    }

    /// A topic for every robot there has been: of one that is gone it says so.
    pub fn follow(&mut self, ros: &mut Ros, pucks: &[Puck]) -> Result<(), DdsError> {
        let Some(states) = &mut self.states else { return Ok(()) };
        for name in pucks.iter().filter_map(|puck| puck.member) {
            if let Entry::Vacant(place) = states.robots.entry(name) {
                place.insert(ros.publisher(&states::topic(name), DEPTH)?);
            }
        }
        Ok(())
    }

    /// The topic of a tracker, if one is heard.
    pub fn heard(&self) -> Option<&str> {
        self.heard.as_deref()
    }

    /// Opens anew what a subscriber has brought to a halt.
    pub fn free(&mut self, ros: &mut Ros) -> Result<(), DdsError> {
        let all = [&mut self.corrected, &mut self.arena];
        all.into_iter().flatten().try_for_each(|publisher| ros.free(publisher))?;
        let Some(states) = &mut self.states else { return Ok(()) };
        ros.free(&mut states.ball)?;
        states.robots.values_mut().try_for_each(|publisher| ros.free(publisher))
    }

    /// What a frame reports.
    pub fn report(&self, frame: &TrackedFrame, complaints: &mut Complaints) -> Report {
        let topic = self.heard.as_deref().unwrap_or_default();
        let (report, bad) = frames::report(frame, &self.sizes);
        for (name, why) in bad {
            let cause = match &why {
                Bad::Unknown => Cause::UnknownRobot,
                Bad::Twice => Cause::DuplicateId,
                Bad::Defect(defect) => Cause::from(defect),
            };
            complaints.refuse(topic, cause, &format_args!("{name}: {why}"));
        }
        report
    }

    /// Tells a frame again, as it must be after the contacts in it.
    pub fn correct(
        &self,
        frame: TrackedFrame,
        velocities: &[(DiscId, DVec2)],
        peers: &Peers,
        complaints: &mut Complaints,
    ) {
        if let Some(publisher) = &self.corrected {
            send(peers, publisher, complaints, || frames::corrected(frame, velocities));
        }
    }

    /// Tells the arena's frame, and its things one by one.
    pub fn tick(&mut self, stage: &Stage, peers: &Peers, complaints: &mut Complaints) {
        let view = || -> View { wire::view(stage, |_| 0.0) };
        if let Some(publisher) = &self.arena {
            self.frames = self.frames.wrapping_add(1);
            send(peers, publisher, complaints, || frames::of_view(&view(), self.frames));
        }
        let Some(States { ball, robots }) = &self.states else { return };
        let is_wanted = |publisher: &Publisher<VisionStateRobot>| {
            publisher.tap().is_some() || peers.hear(publisher.guid())
        };
        if !robots.values().any(is_wanted) && ball.tap().is_none() && !peers.hear(ball.guid()) {
            return;
        }
        let view = view();
        send(peers, ball, complaints, || states::of_ball(&view));
        for (name, publisher) in robots {
            send(peers, publisher, complaints, || states::of_robot(&view, *name));
        }
    }
}
