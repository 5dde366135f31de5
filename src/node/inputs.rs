//! All that arrives, as one stream: it only hands over. Topics of driven pucks come and go with
//! them.

use std::collections::HashMap;

use futures::stream::{AbortHandle, LocalBoxStream, SelectAll, StreamExt, abortable};

use super::dds::{DdsError, Received, Ros};
use super::parameters::services as parameters;
use super::robots::Robots;
use super::simulation::{services as simulation, steps};
use super::wire::Batch;
use crate::messages::{CircleStates, Clock, Odometry, TrackedFrame, Twist};
use crate::scene::{Puck, Scene};
use crate::world::DiscId;

/// Messages kept for the loop on each topic, 0.1 s at 1 kHz; older ones are dropped. DDS holds as
/// many payloads in memory, read or not.
const DEPTH: usize = 100;

/// Something that arrived.
pub enum Input {
    /// Circles that somebody else owns.
    Circles { topic: String, received: Received<CircleStates> },
    /// Where a robot says that it is.
    Odometry { topic: String, id: DiscId, received: Box<Received<Odometry>> },
    /// What a tracker of robot soccer sees.
    Tracked(Box<Received<TrackedFrame>>),
    /// Where a driven puck shall go.
    Velocity { topic: String, id: DiscId, received: Received<Twist> },
    /// Datagrams of teams.
    Wire(Batch),
    /// Somebody's time.
    Clock(Received<Clock>),
    /// Something about parameters.
    Parameters(Result<parameters::Request, DdsError>),
    /// Something about the simulation.
    Simulation(Result<simulation::Request, DdsError>),
    /// Something about steps of it.
    Steps(Result<steps::Request, DdsError>),
}

/// All subscriptions and services.
pub struct Inputs {
    streams: SelectAll<LocalBoxStream<'static, Input>>,
    /// Topics of driven pucks, and how to end them: another scene gives the same id to another one.
    driven: HashMap<DiscId, (String, AbortHandle)>,
}

impl Inputs {
    /// Opens those that a scene has from the beginning.
    pub fn open(ros: &mut Ros, scene: &Scene) -> Result<Self, DdsError> {
        let mut inputs = Self { streams: SelectAll::new(), driven: HashMap::new() };
        for topic in &scene.node.circle_topics {
            let messages = ros.subscription::<CircleStates>(topic, DEPTH)?.into_stream();
            let topic = topic.clone();
            let input = move |received| Input::Circles { topic: topic.clone(), received };
            inputs.add(messages.map(input).boxed_local());
        }
        if scene.pucks.is_empty() {
            let clock = ros.subscription::<Clock>("/clock", 1)?.into_stream();
            inputs.add(clock.map(Input::Clock).boxed_local());
        }
        inputs.add(parameters::open(ros)?.map(Input::Parameters).boxed_local());
        inputs.add(simulation::open(ros)?.map(Input::Simulation).boxed_local());
        inputs.follow(ros, &scene.pucks)?;
        Ok(inputs)
    }

    /// An `odom` for every robot that tells its own.
    pub fn hear(&mut self, ros: &mut Ros, robots: &Robots) -> Result<(), DdsError> {
        for (id, name) in robots.names() {
            let topic = format!("{name}/odom");
            let messages = ros.subscription::<Odometry>(&topic, DEPTH)?.into_stream();
            let input = move |received| {
                let received = Box::new(received);
                Input::Odometry { topic: topic.clone(), id, received }
            };
            self.add(messages.map(input).boxed_local());
        }
        Ok(())
    }

    /// The frames of a tracker, if there is one.
    pub fn track(&mut self, ros: &mut Ros, topic: Option<&str>) -> Result<(), DdsError> {
        let Some(topic) = topic else { return Ok(()) };
        let messages = ros.subscription::<TrackedFrame>(topic, DEPTH)?.into_stream();
        self.add(messages.map(|received| Input::Tracked(Box::new(received))).boxed_local());
        Ok(())
    }

    /// One more stream.
    pub fn add(&mut self, stream: LocalBoxStream<'static, Input>) {
        self.streams.push(stream);
    }

    /// A `cmd_vel` for every driven puck, and for no other.
    pub fn follow(&mut self, ros: &mut Ros, pucks: &[Puck]) -> Result<(), DdsError> {
        self.driven.retain(|id, (topic, handle)| {
            let is_of = |puck: &Puck| puck.disc.id == *id && puck.topic("cmd_vel") == *topic;
            let stays = pucks.iter().any(|puck| puck.driven && is_of(puck));
            if !stays {
                handle.abort();
            }
            stays
        });
        for puck in pucks.iter().filter(|puck| puck.driven) {
            let id = puck.disc.id;
            if self.driven.contains_key(&id) {
                continue;
            }
            let topic = puck.topic("cmd_vel");
            let messages = ros.subscription::<Twist>(&topic, 1)?.into_stream();
            let own = topic.clone();
            let input = move |received| Input::Velocity { topic: own.clone(), id, received };
            let (messages, handle) = abortable(messages.map(input).boxed_local());
            self.driven.insert(id, (topic, handle));
            self.add(messages.boxed_local());
        }
        Ok(())
    }

    /// The next thing that arrives.
    pub async fn next(&mut self) -> Option<Input> {
        self.streams.next().await
    }
}
