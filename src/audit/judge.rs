//! One collision of two discs alone, read from a sample before it and a sample after it.
//!
//! The flight from the earlier sample, with its velocities, says when and along which line of
//! centres the two had to meet; the bend of their relative path says when and where the velocities
//! did change. Between them lie the laws: momentum, the direction of the impulse, restitution.
//! Every number has a deviation, from those of positions and velocities by the derivatives of the
//! same formulas.
//!
//! Never look for contacts here, and never name a violation that the deviation allows.

use glam::DVec2;

use super::findings::{Kind, Kinds};
use super::flight::Flight;
use super::law::Law;
use super::noise::Sigma;
use crate::detect::impact::pair_impact;
use crate::resolve::pair::MassFractions;

/// Standard deviations that no violation may be within.
pub(super) const JUDGED: f64 = 5.0;

/// Restitution up to which a contact counts as none.
const STUCK: f64 = 0.02;

/// A restitution with a larger deviation says nothing.
pub(super) const VAGUE: f64 = 0.3;

/// Two discs at two samples.
#[derive(Clone, Copy, Debug)]
pub(super) struct Encounter<'a> {
    pub a: &'a Flight,
    pub b: &'a Flight,
    /// Time between the samples, s.
    pub length: f64,
    /// From the second disc to its image nearest to the first, m.
    pub shift: DVec2,
}

/// What can be said of a collision without a law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Seen {
    /// Whether the earlier velocities lead to contact in time.
    pub reached: bool,
    /// Whether they lead to contact in twice the time.
    pub soon: bool,
    /// When they touch, or else when the velocities changed; s after the earlier sample.
    pub instant: f64,
    /// Unit normal from a to b then.
    pub normal: DVec2,
    /// Relative velocity before and after, m/s.
    pub w: [DVec2; 2],
    /// Speed of approach, m/s.
    pub approach: f64,
    /// Distance of the surfaces when the velocities changed, m, and its deviation.
    pub gap: (f64, f64),
    /// Implied restitution and its deviation.
    pub restitution: (f64, f64),
    /// From the line of centres to the impulse, rad, and its deviation.
    pub angle: (f64, f64),
    /// Sum of the momenta gained, kg m/s, and the deviation of its size.
    pub momentum: (f64, f64),
    /// Momentum exchanged, kg m/s.
    pub impulse: f64,
    /// Kinetic energy gained, J.
    pub energy: f64,
    /// Reduced mass, kg.
    pub reduced_mass: f64,
    /// Gap at the later sample, m, and at the earlier one.
    pub gaps: [f64; 2],
}

impl<'a> Encounter<'a> {
    /// Two discs at two samples, so many seconds apart.
    pub fn new(a: &'a Flight, b: &'a Flight, length: f64, law: &Law) -> Self {
        Self { a, b, length, shift: law.shift_of(a, b) }
    }

    fn reach(&self) -> f64 {
        self.a.before.radius + self.b.before.radius
    }

    /// Relative position and velocity before, and after.
    fn relative(&self) -> [(DVec2, DVec2); 2] {
        let Self { a, b, shift, .. } = self;
        [(&a.before, &b.before), (&a.after, &b.after)]
            .map(|(a, b)| (b.position - a.position + shift, b.velocity - a.velocity))
    }

    /// The deviations of relative position and velocity.
    fn sigma(&self) -> Sigma {
        let (a, b) = (self.a.sigma, self.b.sigma);
        Sigma { position: a.position.hypot(b.position), velocity: a.velocity.hypot(b.velocity) }
    }

    /// When the relative velocity changed, if it did suddenly, s.
    fn bend(&self) -> f64 {
        let [(d, w), (d2, w2)] = self.relative();
        let (change, rest) = (w2 - w, d2 - d - w * self.length);
        let size2 = change.length_squared();
        if size2 == 0.0 {
            return 0.0;
        }
        (self.length - rest.dot(change) / size2).clamp(0.0, self.length)
    }

    /// What is to be seen of it. Where the velocities changed off the place of contact by more than
    /// `tolerance` (in smaller radii), the line of centres is that of the change.
    pub fn look(&self, tolerance: f64) -> Seen {
        let [(d, w), (d2, w2)] = self.relative();
        let (s, sigma, bend) = (self.reach(), self.sigma(), self.bend());
        let ahead = pair_impact(d, w, s);
        let hit = ahead.filter(|t| *t <= self.length * (1.0 + 1e-6));
        let reached = hit.is_some() && d.length() > s;
        let gap = self.gap(bend, hit);
        let smaller = self.a.before.radius.min(self.b.before.radius);
        let timely = reached && gap.0.abs() <= (JUDGED * gap.1).max(tolerance * smaller);
        let instant = hit.filter(|_| timely).unwrap_or(bend);
        let measure = |d: DVec2, w: DVec2, w2: DVec2| -> Option<[f64; 2]> {
            let instant = if timely { pair_impact(d, w, s)? } else { bend };
            let n = (d + w * instant).normalize_or_zero();
            let change = w2 - w;
            Some([-w2.dot(n) / w.dot(n), n.perp_dot(change).atan2(n.dot(change))])
        };
        let n = (d + w * instant).normalize_or_zero();
        let [restitution, angle] = measure(d, w, w2).unwrap_or([f64::NAN, f64::NAN]);
        let [restitution_sigma, angle_sigma] = spread(&measure, (d, w, w2), sigma);
        let change = (w2 - w).length();
        Seen {
            reached,
            soon: ahead.is_some_and(|time| time <= 2.0 * self.length),
            instant,
            normal: n,
            w: [w, w2],
            approach: -w.dot(n),
            gap,
            restitution: (restitution, restitution_sigma),
            angle: (angle, angle_sigma),
            momentum: self.momentum(),
            impulse: self.reduced_mass() * change,
            energy: self.energy(),
            reduced_mass: self.reduced_mass(),
            gaps: [d.length() - s, d2.length() - s],
        }
    }

    /// Distance of the surfaces when the velocities changed, m, and its deviation.
    fn gap(&self, bend: f64, hit: Option<f64>) -> (f64, f64) {
        let [(d, w), (d2, w2)] = self.relative();
        let sigma = self.sigma();
        let at_bend = 0.5 * ((d + w * bend) + (d2 - w2 * (self.length - bend)));
        let n = (d + w * hit.unwrap_or(bend)).normalize_or_zero();
        let change = (w2 - w).length().max(f64::MIN_POSITIVE);
        let blur = w.dot(n).abs() * sigma.of_rest(self.length) / change;
        (at_bend.length() - self.reach(), sigma.position + sigma.velocity * self.length + blur)
    }

    fn reduced_mass(&self) -> f64 {
        let (a, b) = (self.a.before.mass, self.b.before.mass);
        match (a.is_finite(), b.is_finite()) {
            (true, true) => a / (a / b + 1.0),
            (true, false) => a,
            (false, true) => b,
            (false, false) => 0.0,
        }
    }

    /// Momentum gained by both; a disc of infinite mass must not change at all.
    fn momentum(&self) -> (f64, f64) {
        let (a, b) = (self.a, self.b);
        let finite = [a, b].map(|flight| flight.before.mass.is_finite());
        match finite {
            [true, true] => {
                let gained = a.before.mass * a.change + b.before.mass * b.change;
                let sigma = (a.before.mass * a.sigma.of_change())
                    .hypot(b.before.mass * b.sigma.of_change());
                (gained.length(), sigma)
            }
            [true, false] => {
                let mass = a.before.mass;
                (mass * b.change.length(), mass * b.sigma.of_change())
            }
            [false, true] => {
                let mass = b.before.mass;
                (mass * a.change.length(), mass * a.sigma.of_change())
            }
            [false, false] => (0.0, 0.0),
        }
    }

    fn energy(&self) -> f64 {
        let gain = |flight: &Flight| flight.after.kinetic_energy() - flight.before.kinetic_energy();
        gain(self.a) + gain(self.b)
    }

    /// Size of what the later velocities differ from the law's by, over the relative speed.
    fn wrong(&self, seen: &Seen, restitution: f64) -> f64 {
        let (a, b) = (&self.a.before, &self.b.before);
        let shares = if a.mass.is_infinite() && b.mass.is_infinite() {
            MassFractions::EQUAL
        } else {
            MassFractions::of(a.mass, b.mass)
        };
        // Of two that did not approach there is no restitution.
        let met = seen.approach > 0.0 && restitution.is_finite();
        let jump =
            if met { (1.0 + restitution) * seen.approach * seen.normal } else { DVec2::ZERO };
        let off_a = self.a.change + shares.a.hi * jump;
        let off_b = self.b.change - shares.b.hi * jump;
        // Of two that were at rest to each other, what they got is all there is to compare with.
        let got = 0.5 * self.a.change.length().max(self.b.change.length());
        let scale = seen.w[0].length().max(got).max(f64::MIN_POSITIVE);
        off_a.length().max(off_b.length()) / scale
    }

    /// What is wrong with it, the first the name that fits best, and how much of the relative
    /// velocity is wrong. `tolerance`: relative, what is no violation though it can be seen.
    pub fn judge(&self, seen: &Seen, restitution: Option<f64>, tolerance: f64) -> (Kinds, f64) {
        let mut kinds = Kinds::default();
        let beyond = |(value, sigma): (f64, f64), floor: f64| {
            value.abs() > (JUDGED * sigma).max(floor) && sigma.is_finite()
        };
        // Of a law that is not known, it is known that it only takes energy.
        let nearest = seen.restitution.0.clamp(0.0, 1.0);
        let wrong = self.wrong(seen, restitution.unwrap_or(nearest));
        let smaller = self.a.before.radius.min(self.b.before.radius);
        let out_of_reach = !seen.reached && beyond(seen.gap, tolerance * smaller);
        let blur = JUDGED * self.sigma().velocity;
        let parting = seen.approach < -blur && seen.gaps[0] > -tolerance * smaller;
        // What would have touched within the next interval was only answered early.
        let never = out_of_reach && seen.gap.0 > 0.0 && !seen.soon;
        if never || parting {
            kinds.add(Kind::Phantom);
        }
        let scale = tolerance * seen.impulse;
        if beyond(seen.momentum, scale) {
            kinds.add(if self.is_scaled() {
                Kind::ScaledVelocities
            } else if self.is_swapped(scale) {
                Kind::SwappedMasses
            } else {
                Kind::Momentum
            });
        }
        if seen.approach <= blur {
            return (kinds, wrong);
        }
        if beyond(seen.angle, tolerance) {
            kinds.add(if self.is_scaled() { Kind::ScaledVelocities } else { Kind::Normal });
        }
        self.judge_restitution(seen, restitution, tolerance, &mut kinds);
        if beyond(seen.gap, tolerance * smaller) && !kinds.has(Kind::Phantom) {
            kinds.add(if seen.gap.0 > 0.0 { Kind::Early } else { Kind::Late });
        }
        (kinds, wrong)
    }

    fn judge_restitution(&self, seen: &Seen, law: Option<f64>, tolerance: f64, kinds: &mut Kinds) {
        let (value, sigma) = seen.restitution;
        if sigma.is_nan() || sigma > VAGUE {
            return;
        }
        let allowed = (JUDGED * sigma).max(tolerance);
        let wrong = match law {
            Some(law) => (value - law).abs() > allowed,
            None => value > 1.0 + allowed || value < -allowed,
        };
        if !wrong {
            return;
        }
        let sticks = value.abs() <= STUCK.max(JUDGED * sigma) && law.is_none_or(|e| e > STUCK);
        let stays = seen.gaps[1] <= STUCK * self.a.before.radius.min(self.b.before.radius);
        kinds.add(if sticks && stays { Kind::Sticking } else { Kind::Energy });
    }

    /// Whether both velocities are the earlier ones times one number.
    fn is_scaled(&self) -> bool {
        let (a, b) = (self.a, self.b);
        let allowed = |flight: &Flight| {
            JUDGED * flight.sigma.of_change() + 1e-6 * flight.before.velocity.length()
        };
        let faster = if a.before.velocity.length() < b.before.velocity.length() { b } else { a };
        let square = faster.before.velocity.length_squared();
        let factor = faster.after.velocity.dot(faster.before.velocity) / square;
        let clear = faster.before.velocity.length() > 20.0 * allowed(faster);
        let fits = |flight: &Flight| {
            let off = flight.after.velocity - factor * flight.before.velocity;
            off.length() <= allowed(flight)
        };
        clear && (factor - 1.0).abs() > 1e-3 && [a, b].into_iter().all(fits)
    }

    /// Whether the momentum would be right if the masses were exchanged.
    fn is_swapped(&self, scale: f64) -> bool {
        let (a, b) = (self.a, self.b);
        let (ma, mb) = (a.before.mass, b.before.mass);
        if ma == mb || !ma.is_finite() || !mb.is_finite() {
            return false;
        }
        let sigma = (mb * a.sigma.of_change()).hypot(ma * b.sigma.of_change());
        (mb * a.change + ma * b.change).length() <= (JUDGED * sigma).max(scale)
    }
}

/// Deviations of the two numbers by those of what they are computed from: half the difference
/// between both ends of what is judged, and what is curved between them.
fn spread(
    measure: &impl Fn(DVec2, DVec2, DVec2) -> Option<[f64; 2]>,
    (d, w, w2): (DVec2, DVec2, DVec2),
    sigma: Sigma,
) -> [f64; 2] {
    let (p, v) = (JUDGED * sigma.position, JUDGED * sigma.velocity);
    let Some(middle) = measure(d, w, w2) else { return [f64::INFINITY; 2] };
    let mut squares = [0.0; 2];
    for axis in [DVec2::X, DVec2::Y] {
        let each = [
            [measure(d + p * axis, w, w2), measure(d - p * axis, w, w2)],
            [measure(d, w + v * axis, w2), measure(d, w - v * axis, w2)],
            [measure(d, w, w2 + v * axis), measure(d, w, w2 - v * axis)],
        ];
        for ends in each {
            let [Some(up), Some(down)] = ends else { return [f64::INFINITY; 2] };
            for k in 0..2 {
                let (straight, curved) = (up[k] - down[k], up[k] + down[k] - 2.0 * middle[k]);
                squares[k] += (0.5 * straight).powi(2) + (0.5 * curved).powi(2);
            }
        }
    }
    squares.map(|square| square.sqrt() / JUDGED)
}
