//! The two times of motion under drag: the real one, and the one in which it is straight.
//!
//! With `v' = -drag v` and `s = (1 - exp(-drag t)) / drag` a disc moves at constant velocity in s,
//! and stops at `s = 1 / drag`. So much does s saturate that after `36 / drag` no double tells one
//! instant from the next. So time goes in stages: at the end of each the speeds have fallen to
//! one half, all velocities are halved, which is exact, and s begins again at 0.
//!
//! Halving doubles an error of what is left until the stop, from stage to stage: that is kept in
//! double-double, so a late contact is told as rightly as an early one, to a few ulp of its time.

use std::f64::consts::LN_2;

use crate::exact::DoubleDouble;

/// Logarithm of 2, and what the double leaves out.
const LN2: DoubleDouble = DoubleDouble { hi: LN_2, lo: 2.319_046_813_846_299_6e-17 };

/// In units of `1 / drag`: so late that doubles hardly tell one stage from the next.
const LATE: f64 = (1u64 << 52) as f64;

/// How real time and straight time belong together, from one stage to the next.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slowing {
    drag: f64,
    /// `1 / drag`, s; infinite without drag.
    span: DoubleDouble,
    /// The stage: how often the velocities were halved; infinite at the end of time.
    stage: f64,
    /// Straight time from the start of the stage to the stop, s: `span` to rounding.
    left: DoubleDouble,
}

/// An instant of the real time.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Moment {
    stage: f64,
    /// What part of the way left at the start of the stage is done, from 0 to 1/2.
    done: f64,
}

impl Slowing {
    /// Both times 0, for a drag, 1/s; 0 = the two are the same.
    pub fn new(drag: f64) -> Self {
        let span = if drag == 0.0 {
            f64::INFINITY.into()
        } else {
            DoubleDouble::from(1.0).over(drag.into())
        };
        Self { drag, span, stage: 0.0, left: span }
    }

    /// When the stage ends, s of straight time; infinite without drag.
    pub fn end(&self) -> f64 {
        0.5 * self.left.hi
    }

    /// When all stops, s of straight time in this stage; infinite without drag.
    pub fn stop(&self) -> f64 {
        self.left.hi
    }

    /// Whether a real time, s, comes after this stage.
    pub fn is_later(&self, time: f64) -> bool {
        self.moment(time).stage > self.stage
    }

    /// Goes over to the next stage, at the end of this one: velocities are halved.
    pub fn begin_next(&mut self) {
        self.stage += 1.0;
        self.left = DoubleDouble::sum(self.left.hi, 2.0 * self.left.lo);
    }

    /// Goes over to the stage of a real time, s. Returns the straight time there, s, and by how
    /// much slower velocities are in it.
    pub fn begin_at(&mut self, time: f64) -> (f64, f64) {
        let Moment { stage, done } = self.moment(time);
        let slowed = halved(stage - self.stage);
        (self.stage, self.left) = (stage, self.span);
        (self.span.hi * done, slowed)
    }

    /// The straight time of a real one, s, as this stage counts it: if that is over, beyond its
    /// end, for a motion in which nothing happens any more.
    pub fn straight(&self, time: f64) -> f64 {
        if self.drag == 0.0 {
            return time;
        }
        let moment = self.moment(time);
        if moment.stage < self.stage {
            return 0.0;
        }
        let shift = self.shift();
        if moment.stage == self.stage {
            return (self.span.hi * moment.done + shift).min(self.end());
        }
        (self.span.hi * (1.0 - self.speed_in(&moment)) + shift).min(self.stop())
    }

    /// The real time of a straight one in this stage, s.
    pub fn time(&self, straight: f64) -> f64 {
        if self.drag == 0.0 {
            return straight;
        }
        let age = -libm::log1p(-(straight - self.shift()) / self.span.hi);
        LN2.times_double(self.stage).plus(age.into()).value() / self.drag
    }

    /// The speed of a disc at a real time, s, in units of that at the start of the stage.
    pub fn speed(&self, time: f64) -> f64 {
        let moment = self.moment(time);
        if moment.stage < self.stage { 1.0 } else { self.speed_in(&moment) }
    }

    /// The same at a straight time, s.
    pub fn speed_at(&self, straight: f64) -> f64 {
        if self.drag == 0.0 { 1.0 } else { 1.0 - (straight - self.shift()) / self.span.hi }
    }

    /// The same at a moment of this stage or a later one.
    fn speed_in(&self, moment: &Moment) -> f64 {
        // At the end of time, where a difference would be no number.
        let stages = if moment.stage == self.stage { 0.0 } else { moment.stage - self.stage };
        (1.0 - moment.done) * halved(stages)
    }

    /// By how much this stage began early in straight time, s: rounding of the ends of stages.
    fn shift(&self) -> f64 {
        self.left.minus(self.span).value()
    }

    /// Where a real time, s, lies. Its product with the drag and the division into stages are kept
    /// in double-double, so late times are as right as early ones.
    fn moment(&self, time: f64) -> Moment {
        if self.drag == 0.0 {
            return Moment { stage: 0.0, done: 0.0 };
        }
        let age = DoubleDouble::product(self.drag, time.max(0.0));
        let mut stage = (age.hi / LN_2).floor();
        if age.hi >= LATE {
            return Moment { stage, done: 0.0 };
        }
        let mut rest = age.minus(LN2.times_double(stage));
        // The quotient may have rounded across the border of two stages.
        if rest.hi < 0.0 {
            (stage, rest) = (stage - 1.0, rest.plus(LN2));
        } else if rest.minus(LN2).hi >= 0.0 {
            (stage, rest) = (stage + 1.0, rest.minus(LN2));
        }
        Moment { stage, done: (-libm::expm1(-rest.value())).min(0.5) }
    }
}

/// A span of real time in straight time, both in s, from an instant of that on.
pub fn straight_span(drag: f64, straight: f64, span: f64) -> f64 {
    (drag.recip() - straight) * -libm::expm1(-drag * span)
}

/// One, halved so many times; 0 if that cannot be counted.
fn halved(times: f64) -> f64 {
    if times < 1100.0 { 0.5f64.powi(times as i32) } else { 0.0 }
}
