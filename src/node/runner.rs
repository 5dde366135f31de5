//! The loop: whatever arrives changes the stage between two steps; every tick the stage is told to
//! whoever listens.

use std::time::{Duration, Instant, SystemTime};

use futures::StreamExt;
use futures::stream::LocalBoxStream;
use glam::DVec2;
use ros2_client::ParameterValue;
use tokio::time::MissedTickBehavior;

use super::complaints::Complaints;
use super::dds::{DdsError, Received, Ros};
use super::inputs::{Input, Inputs};
use super::live::Live;
use super::outputs::Outputs;
use super::parameters::Parameters;
use super::parameters::declared::{self, Change};
use super::parameters::services::{self as parameter_services, Changed, ParameterEvent};
use super::recorder::Recorder;
use super::robots::Robots;
use super::rosout::Rosout;
use super::simulation::services::{self as simulation_services, Effect, Request};
use super::simulation::steps::{Steps, Telling};
use super::soccer::Soccer;
use super::stage::{Source, Stage};
use super::status::Status;
use super::timeline::Timeline;
use super::wire::{Batch, Wire};
use super::{NodeError, RunOptions, Stop};
use crate::messages::{CircleStates, Header, Odometry, Time, TrackedFrame};
use crate::motion::arena::{Arena, Halt};
use crate::publish::error_report::Totals;
use crate::receive::{self, Cause, Standing};
use crate::scene::Scene;
use crate::scene::league::Team;
use crate::world::{Command, DiscId, Instants, Outcome, Report};

/// A stalled arena tries to go on after this.
const STALL_RETRY: Duration = Duration::from_millis(100);
/// The clock is told so often where it stands still.
const CLOCK_PERIOD: Duration = Duration::from_millis(100);

/// The loop and all that it keeps.
pub struct Runner<'a> {
    ros: &'a mut Ros,
    inputs: Inputs,
    outputs: Outputs,
    rosout: Rosout,
    stage: Stage,
    steps: Steps,
    robots: Robots,
    soccer: Soccer,
    parameters: Parameters,
    /// The node's whole name.
    name: String,
    end: Option<f64>,
    start: Instant,
    /// The time by `/clock`, s, where that is to be used and was heard.
    sim_time: Option<f64>,
    stall: Option<Halt>,
    retry_at: Instant,
    /// When the last step ended.
    stepped_at: Instant,
    quit: bool,
    status: Status,
    complaints: Complaints,
    live: Live,
    wire: Option<Wire>,
    /// Messages that never reached the loop.
    dropped: u64,
    recorder: Option<Recorder>,
    /// That recording has failed was told.
    is_failure_told: bool,
    /// Messages that found no room in the bag's queue, as far as that was told.
    unrecorded_told: u64,
}

impl<'a> Runner<'a> {
    /// At the beginning of a scene.
    pub fn new(
        scene: Scene,
        parameters: Parameters,
        (mut inputs, outputs, rosout): (Inputs, Outputs, Rosout),
        ros: &'a mut Ros,
        options: &RunOptions,
    ) -> Result<Self, DdsError> {
        let start = Instant::now();
        let RunOptions { rate, seconds, .. } = *options;
        let time = Timeline::new(rate, scene.node.publish_rate_hz, seconds, start);
        let steps = Steps::open(ros)?;
        let robots = Robots::open(ros, &parameters)?;
        inputs.hear(ros, &robots)?;
        let mut soccer = Soccer::open(ros, &parameters)?;
        soccer.follow(ros, &scene.pucks)?;
        inputs.track(ros, soccer.heard())?;
        inputs.add(steps.requests().map(Input::Steps).boxed_local());
        Ok(Self {
            ros,
            inputs,
            outputs,
            rosout,
            live: Live::new(&scene, start),
            stage: Stage::new(scene, time),
            steps,
            robots,
            soccer,
            parameters,
            name: options.start.names.to_string(),
            end: seconds,
            start,
            sim_time: None,
            stall: None,
            retry_at: start,
            stepped_at: start,
            quit: false,
            status: Status::new(start),
            complaints: Complaints::new(start),
            wire: None,
            dropped: 0,
            recorder: None,
            is_failure_told: false,
            unrecorded_told: 0,
        })
    }

    /// Keeps a journal in the bag of a recorder.
    pub fn record(mut self, recorder: Option<Recorder>) -> Self {
        if recorder.is_some() {
            self.stage.keep_journal();
        }
        self.recorder = recorder;
        self
    }

    /// Speaks to teams too, from the beginning.
    pub fn speak(mut self, wire: Option<(Wire, Vec<LocalBoxStream<'static, Batch>>)>) -> Self {
        let Some((wire, streams)) = wire else { return self };
        for stream in streams {
            self.inputs.add(stream.map(Input::Wire).boxed_local());
        }
        self.wire = Some(wire);
        self
    }

    /// Until the end, or until it is asked to stop.
    pub async fn run(mut self, mut stop: Stop) -> Result<(), NodeError> {
        let mut status = tokio::time::interval(self.status.period());
        status.set_missed_tick_behavior(MissedTickBehavior::Delay);
        status.tick().await;
        let mut clock = tokio::time::interval(CLOCK_PERIOD);
        clock.set_missed_tick_behavior(MissedTickBehavior::Delay);
        let scene = self.stage.scene();
        tracing::info!("{}: {} pucks", scene.name, scene.pucks.len());
        self.tell_parameters(self.parameters.all().collect(), Vec::new());
        while !self.is_over() {
            let wake = self.next_wake();
            tokio::select! {
                biased;
                () = stop.asked() => break,
                _ = status.tick() => self.status.write(self.stage.world().arena(), Instant::now()),
                Some(input) = self.inputs.next() => self.handle(input),
                () = self.ros.peers().change() => {}
                _ = clock.tick(), if self.stands_still() => self.tell_time(),
                () = wake_at(wake) => {}
            }
            let now = Instant::now();
            self.tick_if_due(now);
            self.report_if_due(now);
            self.ros.prompt(now);
            self.outputs.send_waiting(now, &mut self.complaints);
            self.rosout.tell(&mut self.complaints);
            self.recorder.iter().for_each(|recorder| recorder.hand_over_if_due(now));
            // Signals and timers are seen when this task waits, which in a flood it never does.
            tokio::task::yield_now().await;
        }
        self.complaints.settle();
        self.status.finish(self.stage.world().arena(), Instant::now());
        match (self.stall, self.end) {
            (Some(stall), Some(_)) => Err(stall.into()),
            _ => Ok(()),
        }
    }

    fn arena(&self) -> Option<&Arena> {
        self.stage.world().arena()
    }

    fn is_over(&self) -> bool {
        let at_end = |end: f64| match self.arena() {
            Some(arena) => arena.now() >= end || self.stall.is_some(),
            None => self.start.elapsed().as_secs_f64() >= end,
        };
        self.quit || self.end.is_some_and(at_end)
    }

    fn stands_still(&self) -> bool {
        self.stall.is_some() || self.stage.time.is_paused()
    }

    /// When the loop has something to do without a message.
    fn next_wake(&self) -> Instant {
        let now = Instant::now();
        let wake = match self.arena() {
            Some(_) if self.stall.is_none() => {
                let time = &self.stage.time;
                let seen = self.wire.as_ref().map(|wire| time.wake_for(wire.due(), now));
                seen.map_or(time.wake(now), |seen| seen.min(time.wake(now)))
            }
            Some(_) => now + STALL_RETRY,
            None => {
                let end = self.end.unwrap_or(f64::INFINITY);
                let left = (end - self.start.elapsed().as_secs_f64()).clamp(0.0, 3_600.0);
                now + Duration::from_secs_f64(left)
            }
        };
        let wake = wake.min(self.live.due()).min(self.ros.peers().due().unwrap_or(wake));
        let recorder = self.recorder.as_ref().and_then(Recorder::due);
        [self.outputs.due(), recorder].into_iter().flatten().fold(wake, Instant::min)
    }

    /// Advances the arena to its next tick when that is due, and publishes its state there.
    fn tick_if_due(&mut self, now: Instant) {
        self.see(now);
        let tick = self.stage.time.next_tick();
        let due = self.stage.time.due(now);
        if self.arena().is_none() || due < tick || now < self.retry_at {
            return;
        }
        let mut outcome = self.step(None, tick);
        self.arena_outcome(&mut outcome);
        let reached = self.arena().map_or(0.0, |arena| arena.now());
        if self.stage.time.reach(reached, self.stepped_at) {
            self.outputs.tick(&mut self.stage, &mut self.complaints);
            self.soccer.tick(&self.stage, self.outputs.peers(), &mut self.complaints);
            self.stall = None;
            let told = self.steps.made_one();
            self.tell(told);
        }
    }

    /// Takes the frames of vision that are due, each at its own instant.
    fn see(&mut self, now: Instant) {
        let due = self.stage.time.due(now);
        while let Some(frame) = self.wire.as_ref().map(Wire::due)
            && self.arena().is_some()
            && frame <= due
            && now >= self.retry_at
        {
            if self.arena().is_some_and(|arena| arena.now() < frame) {
                let mut outcome = self.step(None, frame);
                self.arena_outcome(&mut outcome);
            }
            if self.arena().is_none_or(|arena| arena.now() < frame) {
                // It takes more than one step to get there.
                break;
            }
            if let Some(wire) = &mut self.wire {
                wire.look(&self.stage, &mut self.complaints);
            }
        }
    }

    /// Does what datagrams ask.
    fn play(&mut self, batch: &Batch) {
        self.catch_up();
        let Some(wire) = &mut self.wire else { return };
        let wanted = wire.receive(batch, &mut self.stage, &mut self.complaints);
        if let Some(speed) = wanted.speed {
            self.set_speed(speed);
        }
        self.follow(&Effect { pucks: wanted.pucks, ..Effect::default() });
    }

    /// A speed of 0 is a pause, and any other ends it.
    fn set_speed(&mut self, speed: f64) {
        let now = Instant::now();
        if speed == 0.0 {
            self.stage.pause();
        } else {
            self.stage.time.set_rate(speed, now);
            self.stage.play(now);
            let rate = ParameterValue::Double(speed);
            self.parameters.put("rate", rate.clone());
            self.tell_parameters(Vec::new(), vec![("rate".to_owned(), rate)]);
        }
    }

    /// Says how the last second went, if somebody listens.
    fn report_if_due(&mut self, now: Instant) {
        if now < self.live.due() {
            return;
        }
        let arena = self.stage.world().arena();
        let totals = Totals {
            simulated: arena.map_or(0.0, Arena::now),
            contacts: self.status.contacts(arena),
            refused: self.complaints.refused(),
            dropped_in: self.dropped,
            dropped_out: self.complaints.unsent_count()
                + self.outputs.dropped()
                + self.recorder.as_ref().map_or(0, Recorder::dropped),
        };
        self.watch_recorder();
        let asked = if self.stage.time.is_paused() { 0.0 } else { self.stage.time.rate() };
        let wanted = (self.outputs.reports_are_heard(), self.recorder.is_some());
        for line in self.outputs.peers().news() {
            self.complaints.say("types", &line);
        }
        let freed = self.outputs.free(self.ros).and_then(|()| self.robots.free(self.ros));
        let freed = freed.and_then(|()| self.soccer.free(self.ros));
        if let Err(error) = freed {
            self.complaints.say("publishers", &error);
        }
        let told = self.live.tell(wanted, (totals, asked), &mut self.stage, now);
        told.iter().for_each(|told| self.outputs.report(told, &mut self.complaints));
    }

    fn handle(&mut self, input: Input) {
        match input {
            Input::Circles { topic, received } => {
                if let Some(message) = self.read(&topic, received) {
                    self.observe(&topic, message);
                }
            }
            Input::Odometry { topic, id, received } => {
                let Some(odom) = self.read(&topic, *received) else { return };
                match receive::standing(&odom) {
                    Ok(standing) => self.hear_robot(&topic, id, (odom, standing)),
                    Err(error) => self.complaints.refuse(&topic, Cause::from(&error), &error),
                }
            }
            Input::Tracked(received) => {
                let topic = self.soccer.heard().unwrap_or_default().to_owned();
                if let Some(frame) = self.read(&topic, *received) {
                    self.hear_tracker(&topic, frame);
                }
            }
            Input::Velocity { topic, id, received } => {
                let Some(twist) = self.read(&topic, received) else { return };
                match receive::wanted(&twist) {
                    Ok(wanted) => drop(self.command(Command::Drive { id, wanted }, None)),
                    Err(error) => self.complaints.refuse(&topic, Cause::from(&error), &error),
                }
            }
            Input::Wire(batch) => self.play(&batch),
            Input::Clock(received) => {
                if let Some(clock) = self.read("/clock", received) {
                    self.hear_clock(clock.clock);
                }
            }
            Input::Parameters(Ok(request)) => self.serve_parameters(&request),
            Input::Simulation(Ok(request)) => self.serve_simulation(request),
            Input::Steps(Ok(request)) => {
                let told = self.steps.act(request, &mut self.stage);
                self.tell(Ok(told));
            }
            Input::Parameters(Err(error))
            | Input::Simulation(Err(error))
            | Input::Steps(Err(error)) => {
                self.complaints.refuse("services", Cause::Undecodable, &error);
            }
        }
    }

    /// The message, if it can be read.
    fn read<M>(&mut self, topic: &str, received: Received<M>) -> Option<M> {
        self.dropped += received.dropped;
        let complaints = &mut self.complaints;
        let refuse = |error| match error {
            // Said once, when its publisher was found.
            DdsError::WrongType => complaints.count(Cause::Undecodable),
            error => complaints.refuse(topic, Cause::Undecodable, &error),
        };
        received.message.map_err(refuse).ok()
    }

    fn observe(&mut self, topic: &str, message: CircleStates) {
        let (report, bad) = match receive::report(&message) {
            Ok(read) => read,
            Err(error) => return self.complaints.refuse(topic, Cause::from(&error), &error),
        };
        for (id, reason) in bad {
            let what = format_args!("circle {id}: {reason}");
            self.complaints.refuse(topic, Cause::from(&reason), &what);
        }
        let source = match (&self.recorder, self.ros.topic_name(topic)) {
            (Some(_), Ok(name)) => Some(Source::Topic(name)),
            _ => None,
        };
        self.answer(topic, &message.header, report, source);
    }

    /// A robot is a circle that its own odometry reports.
    fn hear_robot(&mut self, topic: &str, id: DiscId, (odom, standing): (Odometry, Standing)) {
        let header = odom.header.clone();
        let Some(disc) = self.robots.report(id, odom, standing) else { return };
        if let Some(defect) = disc.refusal() {
            return self.complaints.refuse(topic, Cause::from(&defect), &defect);
        }
        let report = Report { discs: vec![disc], time: header.stamp.as_seconds() };
        self.answer(topic, &header, report, Some(Source::Made(header.clone())));
    }

    /// Everything that a tracker sees is a circle that somebody else owns.
    fn hear_tracker(&mut self, topic: &str, frame: TrackedFrame) {
        if !frame.timestamp.is_finite() {
            let what = format_args!("timestamp is {}: must be finite", frame.timestamp);
            return self.complaints.refuse(topic, Cause::NotFinite, &what);
        }
        let report = self.soccer.report(&frame, &mut self.complaints);
        let (stamp, frame_id) =
            (Time::from_seconds(report.time), self.stage.scene().node.frame_id.clone());
        let header = Header { stamp, frame_id };
        let source = Some(Source::Made(header.clone()));
        let velocities = self.answer(topic, &header, report, source);
        let Self { soccer, outputs, complaints, .. } = self;
        outputs.update_peers();
        soccer.correct(frame, &velocities, outputs.peers(), complaints);
    }

    /// Answers a report; the velocities of those that touched.
    fn answer(
        &mut self,
        topic: &str,
        header: &Header,
        report: Report,
        source: Option<Source>,
    ) -> Vec<(DiscId, DVec2)> {
        let mut velocities = Vec::new();
        for answer in self.command(Command::Observe(report), source).answers {
            for (id, reason) in &answer.refused {
                let what = format_args!("circle {id}: {reason}");
                self.complaints.refuse(topic, Cause::from(reason), &what);
            }
            if let Some(error) = &answer.unresolved {
                self.complaints.refuse(topic, Cause::from(error), error);
            }
            self.status.count_message(answer.contacts.len());
            if !answer.contacts.is_empty() {
                self.outputs.answer(header, &answer, &mut self.complaints);
                self.correct_robots(header, &answer.velocities);
                velocities.extend(answer.velocities);
            }
        }
        velocities
    }

    fn correct_robots(&mut self, header: &Header, velocities: &[(DiscId, DVec2)]) {
        let Self { robots, outputs, complaints, .. } = self;
        robots.correct(header, velocities, outputs.peers(), complaints);
    }

    /// Time that jumps back is that of another run: what was reported in the old one is over.
    fn hear_clock(&mut self, clock: Time) {
        if self.parameters.value("use_sim_time") != ParameterValue::Boolean(true) {
            return;
        }
        let now = clock.as_seconds();
        if self.sim_time.is_some_and(|before| now < before) {
            self.stage.forget_observed();
        }
        self.sim_time = Some(now);
        self.step(None, 0.0);
    }

    fn serve_parameters(&mut self, request: &parameter_services::Request) {
        let there = (self.stage.world().walls(), self.stage.pucks());
        let scene = self.stage.scene();
        let veto = |name: &str, value: &ParameterValue| declared::veto(scene, there, name, value);
        let (changed, answered) = parameter_services::answer(request, &mut self.parameters, &veto);
        if let Err(error) = answered {
            self.complaints.unsent("parameters", &error);
        }
        if changed.is_empty() {
            return;
        }
        for change in changed.iter().filter_map(|(name, value)| Change::of(name, value)) {
            self.change(change);
        }
        self.write_journal();
        self.tell_parameters(Vec::new(), changed);
    }

    fn change(&mut self, change: Change) {
        let now = Instant::now();
        match change {
            Change::Rate(rate) => self.stage.time.set_rate(rate, now),
            Change::PublishRate(rate) => self.stage.time.set_publish_rate(rate),
            Change::StaleAfter(time) => self.stage.set_stale_after(time),
            Change::ContactMargin(margin) => self.stage.set_contact_margin(margin),
            Change::CommandTimeout(time) => self.stage.set_command_timeout(time),
            Change::Walls(min, max) => {
                let outcome = self.command(Command::MoveWalls { min, max }, None);
                if let Some((_, why)) = outcome.not_done.first() {
                    self.complaints.say("walls", why);
                    self.follow_walls();
                }
            }
            Change::UseSimTime(_) => {
                // Two clocks tell nothing about each other.
                self.stage.forget_observed();
                self.sim_time = None;
            }
        }
    }

    fn tell_parameters(&mut self, new: Changed, changed: Changed) {
        let since = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default();
        let stamp = Time::from_seconds(since.as_secs_f64());
        let event = ParameterEvent::new(stamp, &self.name, new, changed);
        self.outputs.update_peers();
        self.outputs.parameter_event(event, &mut self.complaints);
    }

    fn serve_simulation(&mut self, request: Request) {
        let (effect, answered) = match request {
            Request::StepSimulation(asked) => {
                (Effect::default(), self.steps.ask(asked, &mut self.stage))
            }
            request => simulation_services::answer(&request, &mut self.stage),
        };
        if let Err(error) = answered {
            self.complaints.unsent("simulation services", &error);
        }
        self.follow(&effect);
    }

    /// Topics, clocks and counts follow what was done to the stage.
    fn follow(&mut self, effect: &Effect) {
        self.write_journal();
        self.quit |= effect.quit;
        if effect.pucks {
            let pucks = self.stage.pucks();
            let followed = self
                .inputs
                .follow(self.ros, pucks)
                .and_then(|()| self.outputs.follow(self.ros, pucks))
                .and_then(|()| self.soccer.follow(self.ros, pucks));
            if let Err(error) = followed {
                self.complaints.say("pucks", &error);
            }
        }
        if effect.time {
            let told = self.steps.interrupt();
            self.tell(told);
            self.stage.time.cancel_steps();
            self.stall = None;
            self.live.restart();
            self.outputs.restart();
            let Self { wire, stage, complaints, .. } = self;
            wire.iter_mut().for_each(|wire| wire.follow(stage, effect.pucks, complaints));
            self.status.restart(self.stage.world().arena(), Instant::now());
            self.tell_time();
        }
        self.follow_walls();
    }

    /// The walls may have been moved by another than the parameter: a reset, another scene.
    fn follow_walls(&mut self) {
        let is = declared::sides(self.stage.world().walls());
        if self.parameters.value("walls") != is {
            self.parameters.put("walls", is.clone());
            self.tell_parameters(Vec::new(), vec![("walls".to_owned(), is)]);
        }
    }

    /// Lets a client be told, when it comes for it.
    fn tell(&mut self, told: Result<Option<Telling>, DdsError>) {
        match told {
            Ok(Some(telling)) => {
                self.inputs.add(telling.map(|told| Input::Steps(Ok(told))).boxed_local());
            }
            Ok(None) => {}
            Err(error) => self.complaints.unsent("step_simulation", &error),
        }
    }

    fn tell_time(&mut self) {
        self.outputs.update_peers();
        self.outputs.clock(&self.stage, &mut self.complaints);
    }

    /// Brings the arena to the present and gives it the command there.
    fn command(&mut self, command: Command, source: Option<Source>) -> Outcome {
        let present = self.catch_up();
        let mut outcome = self.step(Some((command, source)), present);
        self.arena_outcome(&mut outcome);
        outcome
    }

    /// Brings the arena to the present, which is returned, s.
    fn catch_up(&mut self) -> f64 {
        let now = Instant::now();
        self.see(now);
        let present = self.stage.time.due(now);
        if self.arena().is_some() {
            let mut outcome = self.step(None, present);
            self.arena_outcome(&mut outcome);
        }
        present
    }

    fn step(&mut self, command: Option<(Command, Option<Source>)>, advance_to: f64) -> Outcome {
        let begin = Instant::now();
        let heard_at = self.sim_time.unwrap_or_else(|| (begin - self.start).as_secs_f64());
        let outcome = self.stage.step(command, Instants { heard_at, advance_to });
        self.stepped_at = Instant::now();
        self.live.note(begin, self.stepped_at);
        self.write_journal();
        if let Some(arena) = self.stage.world().arena() {
            let reached = arena.now();
            self.stage.time.pass(reached);
        }
        if let Some(stall) = outcome.stall {
            if self.stall.is_none() {
                self.complaints.say("arena_states", &stall);
            }
            // It ends when discs are moved, or leave: that is tried now and then.
            self.stall = Some(stall);
            self.retry_at = Instant::now() + STALL_RETRY;
        }
        outcome
    }

    /// What was done to the world goes into the bag before what came of it.
    fn write_journal(&mut self) {
        if let Some(recorder) = &self.recorder {
            self.stage.take_journal().for_each(|entry| recorder.journal(entry));
        }
    }

    fn watch_recorder(&mut self) {
        let Some(recorder) = &self.recorder else { return };
        let dropped = recorder.dropped();
        if let (Some(why), false) = (recorder.failure(), self.is_failure_told) {
            self.is_failure_told = true;
            self.complaints.say("record", &format_args!("nothing is recorded any more: {why}"));
        } else if dropped > self.unrecorded_told && !self.is_failure_told {
            let more = dropped - self.unrecorded_told;
            let what = "messages were not recorded: the run is quicker than the disk";
            self.complaints.say("record", &format_args!("{more} {what}"));
        }
        self.unrecorded_told = dropped;
    }

    fn arena_outcome(&mut self, outcome: &mut Outcome) {
        let Some(arena) = self.stage.world().arena() else { return };
        self.outputs.arena_outcome(arena, outcome, &mut self.complaints);
        for goal in &outcome.goals {
            let team = if goal.team == Team::Blue as u8 { "blue" } else { "yellow" };
            let [blue, yellow] = goal.score;
            tracing::info!("goal for {team} at {:.3} s: blue {blue}, yellow {yellow}", goal.time);
        }
        if !outcome.corrections.is_empty() {
            let header = self.outputs.header(arena);
            self.correct_robots(&header, &outcome.corrections);
        }
    }
}

/// Sleeps until an instant; what is past costs no turn of the timer wheel, which is a millisecond.
async fn wake_at(instant: Instant) {
    if instant <= Instant::now() {
        tokio::task::yield_now().await;
    } else {
        tokio::time::sleep_until(instant.into()).await;
    }
}
