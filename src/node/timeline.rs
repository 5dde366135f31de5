//! The timeline: which simulated time is due, when it is published, and when it stands still.
//!
//! Ticks are the instants at which the arena is published; they change nothing about its motion. A
//! step of a paused simulation is one tick.

use std::time::{Duration, Instant};

use super::pace::Pace;

/// As good as never, for a loop that is woken by what arrives.
const LATER: Duration = Duration::from_secs(3_600);

/// Simulated time and its ticks.
#[derive(Clone, Debug)]
pub struct Timeline {
    pace: Pace,
    rate: f64,
    publish_rate_hz: f64,
    /// Simulated time of tick 0, s.
    first_tick: f64,
    /// Ticks reached so far.
    ticks: u64,
    /// Simulated time that was reached, s.
    reached: f64,
    end: Option<f64>,
    paused: bool,
    steps_left: u64,
}

impl Timeline {
    /// From time 0 on, which is now; `rate` 0 = as fast as possible.
    pub fn new(rate: f64, publish_rate_hz: f64, end: Option<f64>, now: Instant) -> Self {
        Self {
            pace: Pace::new(rate, now),
            rate,
            publish_rate_hz,
            first_tick: 0.0,
            ticks: 0,
            reached: 0.0,
            end,
            paused: false,
            steps_left: 0,
        }
    }

    /// Time is 0 again, and passes or stands still as before.
    pub fn restart(&mut self, now: Instant) {
        let (paused, steps_left) = (self.paused, self.steps_left);
        *self = Self::new(self.rate, self.publish_rate_hz, self.end, now);
        (self.paused, self.steps_left) = (paused, steps_left);
    }

    /// Simulated seconds in a second of wall time that are asked for; 0 = as many as possible.
    pub fn rate(&self) -> f64 {
        self.rate
    }

    /// The next tick, s.
    pub fn next_tick(&self) -> f64 {
        let tick = self.first_tick + self.ticks as f64 / self.publish_rate_hz;
        self.end.map_or(tick, |end| tick.min(end))
    }

    /// The simulated time to be at now, at most the next tick, s.
    pub fn due(&self, now: Instant) -> f64 {
        match (self.paused, self.steps_left) {
            (false, _) => self.pace.due(now).min(self.next_tick()),
            (true, 0) => self.reached,
            (true, _) => self.next_tick(),
        }
    }

    /// When the next tick is due.
    pub fn wake(&self, now: Instant) -> Instant {
        match (self.paused, self.steps_left) {
            (false, _) => self.pace.instant_of(self.next_tick()),
            (true, 0) => now + LATER,
            (true, _) => now,
        }
    }

    /// When a simulated time is due that lies ahead; far away while time stands still.
    pub fn wake_for(&self, simulated: f64, now: Instant) -> Instant {
        match (self.paused, self.steps_left) {
            (true, 0) => now + LATER,
            (true, _) => now,
            (false, _) => self.pace.instant_of(simulated),
        }
    }

    /// Tells how far the simulation has come; whether that is a tick, which is then over.
    pub fn reach(&mut self, simulated: f64, now: Instant) -> bool {
        self.reached = simulated;
        let is_tick = simulated >= self.next_tick();
        if is_tick {
            // Not before: on the way to a tick the arena is behind by as much as ticks are apart.
            if !self.paused {
                self.pace.reached(simulated, now);
            }
            self.ticks += 1;
            self.steps_left = self.steps_left.saturating_sub(1);
        }
        is_tick
    }

    /// Tells how far the simulation has come between two ticks.
    pub fn pass(&mut self, simulated: f64) {
        self.reached = simulated;
    }

    /// From now on at another rate.
    pub fn set_rate(&mut self, rate: f64, now: Instant) {
        self.rate = rate;
        self.pace.change(rate, self.reached, now);
    }

    /// From now on ticks at another rate.
    pub fn set_publish_rate(&mut self, publish_rate_hz: f64) {
        (self.first_tick, self.ticks) = (self.reached, 1);
        self.publish_rate_hz = publish_rate_hz;
    }

    /// Time stands still.
    pub fn pause(&mut self) {
        (self.paused, self.steps_left) = (true, 0);
    }

    /// Time passes.
    pub fn resume(&mut self, now: Instant) {
        (self.paused, self.steps_left) = (false, 0);
        self.pace.change(self.rate, self.reached, now);
    }

    /// Whether time stands still, but for steps.
    pub fn is_paused(&self) -> bool {
        self.paused
    }

    /// So many more ticks, as fast as possible, though time stands still.
    pub fn step(&mut self, ticks: u64) {
        self.steps_left = self.steps_left.saturating_add(ticks);
    }

    /// No more steps.
    pub fn cancel_steps(&mut self) {
        self.steps_left = 0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn after(seconds: f64, start: Instant) -> Instant {
        start + Duration::from_secs_f64(seconds)
    }

    #[test]
    fn time_stands_still_but_for_steps() {
        let start = Instant::now();
        let mut time = Timeline::new(1.0, 10.0, None, start);
        assert!(time.reach(0.0, start));
        assert_eq!(time.due(after(9.0, start)), 0.1);
        time.pause();
        assert_eq!(time.due(after(9.0, start)), 0.0);
        time.step(2);
        for tick in [0.1, 0.2] {
            assert_eq!(time.due(start), tick);
            assert_eq!(time.wake(start), start);
            assert!(time.reach(tick, start));
        }
        assert_eq!(time.due(start), 0.2);
        // What passed meanwhile is not made up for.
        time.resume(after(100.0, start));
        assert_eq!(time.due(after(100.05, start)).max(0.25), 0.25);
        assert!((time.due(after(100.05, start)) - 0.25).abs() < 1e-9);
    }

    #[test]
    fn rates_change_from_now_on() {
        let start = Instant::now();
        let mut time = Timeline::new(1.0, 10.0, None, start);
        assert!(time.reach(0.0, start));
        assert!(!time.reach(0.05, after(0.05, start)));
        time.set_rate(2.0, after(0.05, start));
        assert!((time.due(after(0.06, start)) - 0.07).abs() < 1e-9);
        time.set_publish_rate(100.0);
        assert!((time.next_tick() - 0.06).abs() < 1e-12);
        time.restart(after(1.0, start));
        assert_eq!((time.next_tick(), time.rate()), (0.0, 2.0));
    }

    #[test]
    fn a_tick_that_takes_several_steps_costs_no_time() {
        let start = Instant::now();
        let mut time = Timeline::new(1.0, 1.0, None, start);
        assert!(time.reach(0.0, start));
        assert!(!time.reach(0.3, after(1.0, start)));
        assert_eq!(time.due(after(1.001, start)), 1.0);
        assert!(time.reach(1.0, after(1.002, start)));
        assert_eq!(time.wake(start), after(2.0, start));
        // A tick that comes half a second late does: what is lost is not made up for.
        assert!(time.reach(2.0, after(2.5, start)));
        assert_eq!(time.wake(start), after(3.5, start));
    }

    #[test]
    fn the_end_is_a_tick() {
        let start = Instant::now();
        let mut time = Timeline::new(0.0, 10.0, Some(0.15), start);
        for tick in [0.0, 0.1, 0.15] {
            assert_eq!(time.due(start), tick);
            assert!(time.reach(tick, start));
        }
    }
}
