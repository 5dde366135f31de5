//! Live: how exact and how fast the node is, once a second, for whoever listens.
//!
//! While nobody does, and no log asks (`RUST_LOG=carom=debug`), nothing is timed, no account of
//! momentum is kept and no report is made. Steps are timed between two looks at the clock that the
//! loop takes anyway; that is all that a step pays.

use std::time::{Duration, Instant};

use super::stage::Stage;
use crate::plan::why::{self, Verdict};
use crate::publish::error_report::{Facts, Interval, Told, Totals};
use crate::scene::Scene;
use crate::world::Disc;

/// Wall time between two reports.
const PERIOD: Duration = Duration::from_secs(1);

/// The interval that is being measured, if one is.
#[derive(Debug)]
pub struct Live {
    interval: Interval,
    /// When it began.
    since: Option<Instant>,
    /// Whether the account of momentum is kept in it: for listeners, not for a bag alone.
    accounted: bool,
    /// When to look who listens.
    due: Instant,
    facts: Facts,
}

impl Live {
    /// Nobody listens yet.
    pub fn new(scene: &Scene, now: Instant) -> Self {
        let facts = Facts { frame_id: scene.node.frame_id.clone(), ..Facts::default() };
        let interval = Interval::default();
        Self { interval, since: None, accounted: false, due: now + PERIOD, facts }
    }

    /// When there is something to do here.
    pub fn due(&self) -> Instant {
        self.due
    }

    /// Takes note of a step.
    #[inline]
    pub fn note(&mut self, begin: Instant, end: Instant) {
        if self.since.is_some() {
            self.interval.durations.note(end - begin);
        }
    }

    /// Ends an interval, and tells how it went if somebody has been listening all the while, or
    /// it is recorded.
    pub fn tell(
        &mut self,
        (is_heard, is_recorded): (bool, bool),
        (totals, real_time_factor_asked): (Totals, f64),
        stage: &mut Stage,
        now: Instant,
    ) -> Option<Told> {
        self.facts.real_time_factor_asked = real_time_factor_asked;
        // As regular as a clock, but for what it slept through.
        let next = self.due + PERIOD;
        self.due = if next > now { next } else { now + PERIOD };
        let is_heard = is_heard || tracing::enabled!(tracing::Level::DEBUG);
        if !is_heard && !is_recorded || is_heard && !self.accounted {
            self.since = None;
        }
        if !is_heard && !is_recorded {
            return None;
        }
        let Some(since) = self.since.replace(now) else {
            // It costs the loop more than recording does.
            self.accounted = is_heard;
            if is_heard {
                stage.keep_account();
            }
            self.state_facts(stage);
            self.interval.begin(totals);
            return None;
        };
        let wall = (now - since).as_secs_f64();
        let told = self.interval.end(totals, wall, &self.facts, stage.world().arena());
        tracing::debug!("{:?}", told.report);
        Some(told)
    }

    /// Begins a new interval: the world is another.
    pub fn restart(&mut self) {
        self.since = None;
    }

    fn state_facts(&mut self, stage: &Stage) {
        let pucks: Vec<Disc> = stage.pucks().iter().map(|puck| puck.disc).collect();
        let plan = stage.world().plan();
        let rows = why::Told { plan, settings: &stage.scene().settings, pucks: &pucks }.rows();
        let left_out = rows.into_iter().filter(|row| row.verdict == Verdict::LeftOut);
        self.facts.left_out = left_out.map(|row| row.part.name().to_owned()).collect();
        let moves = !pucks.is_empty();
        self.facts.method = if moves { plan.method.name() } else { "none" }.to_owned();
    }
}
