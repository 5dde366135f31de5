//! Kinds `penalty_*`: spring-dashpot contacts against their closed forms and stability limits.

use super::Effort;
use super::arena::Trouble;
use super::case::{Field, Read};
use super::finding::{Finding, Tally};
use super::formula;
use super::number;
use crate::exact::UNIT_ROUNDOFF;
use crate::motion::plain::{self, Plain};
use crate::motion::springs::integrators::spectral_radius;
use crate::motion::springs::{
    Ending, Explicit, Implicit, Laws, Refused, Scheme, Springs, Stepping,
};
use crate::plan::BroadPhase;
use crate::world::{Disc, Owner, Side, Walls};
use glam::DVec2;

type Findings = Result<Vec<Finding>, Trouble>;

/// The closed form is judged to rounding, in units of `u` times the size of the numbers.
const ROUNDING: f64 = 1024.0 * UNIT_ROUNDOFF;

const VERLET: Scheme = Scheme::Explicit(Explicit::VelocityVerlet);

fn positive(field: &Field) -> Read<f64> {
    let number = field.finite()?;
    if number > 0.0 { Ok(number) } else { Err(field.wrong("must be above 0")) }
}

fn stepping(step: f64, scheme: Scheme) -> Stepping {
    Stepping { step, scheme, refuse_unstable: true, broad_phase: BroadPhase::AllPairs }
}

fn elastic(stiffness: f64) -> Laws {
    Laws { stiffness, damping: 0.0, ending: Ending::OverlapGone, walls: None }
}

fn disc(id: u32, x: f64, v: f64, radius: f64, mass: f64) -> Disc {
    let (position, velocity) = (DVec2::new(x, 0.0), DVec2::new(v, 0.0));
    Disc { id, position, velocity, radius, mass }
}

/// The arena at a time: the discs, and the deepest overlap so far.
fn run(
    laws: Laws,
    discs: &[Disc],
    stepping: Stepping,
    until: f64,
    at: &Field,
) -> Read<(Vec<Disc>, f64)> {
    let refused = |error: Refused| at.wrong(error);
    let mut arena = Springs::new(laws, discs, stepping).map_err(refused)?;
    while arena.now() < until {
        arena.advance(until, &mut Vec::new()).map_err(refused)?;
    }
    Ok((arena.discs().collect(), arena.largest_overlap()))
}

/// Two discs of reduced mass `mu` meet head on. Semi-implicit Euler at the two stated parts of the
/// contact time is within the two stated bounds; the closed form, in steps longer than the contact,
/// has restitution, contact time and deepest overlap to rounding.
pub fn restitution(root: &Field, _: Effort) -> Findings {
    let value = root.get("tolerance")?.get("value")?;
    let coarse = (value.number_after("at dt=t_c/")?, 0.01 * value.number_after("expect <")?);
    let fine = value.words()?.split_once("Euler").map_or("", |(_, rest)| rest);
    let after = |marker: &str| {
        number::after(fine, marker).ok_or_else(|| value.wrong(format_args!("no `{marker}`")))
    };
    let fine = (after("at t_c/")?, after("<")?);
    let mut findings = Vec::new();
    for (label, input, expected) in root.subcases()? {
        let endings = [("full", Ending::OverlapGone), ("no_attraction", Ending::NoAttraction)];
        for (name, ending) in endings {
            let mut tally = Tally::new(format!("{label} {name}"));
            let blow = Blow::read(&input, ending)?;
            let e = expected.get(&format!("e_{name}"))?;
            match expected.find(&format!("t_{name}")) {
                None => blow.never_ends(&mut tally, &expected)?,
                Some(time) => {
                    let exact = (e.decimal()?, time.decimal()?);
                    for (parts, bound) in [coarse, fine] {
                        blow.judge_euler(&mut tally, exact.0.hi, positive(&time)? / parts, bound)?;
                    }
                    blow.judge_closed_form(&mut tally, exact, &expected)?;
                }
            }
            findings.push(tally.finish());
        }
    }
    Ok(findings)
}

/// A head-on blow with speed 1.
struct Blow<'a> {
    at: &'a Field<'a>,
    laws: Laws,
    /// Reduced mass, kg.
    mu: f64,
}

impl<'a> Blow<'a> {
    fn read(input: &'a Field<'a>, ending: Ending) -> Read<Self> {
        let (stiffness, damping) = (positive(&input.get("k")?)?, input.get("gamma")?.finite()?);
        let laws = Laws { stiffness, damping, ending, walls: None };
        Ok(Self { at: input, laws, mu: positive(&input.get("mu")?)? })
    }

    /// Masses 3 mu and 1.5 mu, `gap` apart.
    fn discs(&self, gap: f64) -> [Disc; 2] {
        [disc(0, 0.0, 0.25, 1.0, 3.0 * self.mu), disc(1, 2.0 + gap, -0.75, 1.0, 1.5 * self.mu)]
    }

    fn judge_euler(&self, tally: &mut Tally, e: f64, step: f64, bound: f64) -> Read<()> {
        let stepping = stepping(step, Scheme::Explicit(Explicit::SemiImplicitEuler));
        let (after, _) = run(self.laws, &self.discs(0.0), stepping, 4e3 * step, self.at)?;
        let ours = after[1].velocity.x - after[0].velocity.x;
        let error = (ours - e).abs();
        tally.within(format!("e by semi-implicit Euler, dt = {step:.1e}"), error, bound);
        tally.note(format!("Euler {error:.1e}"));
        Ok(())
    }

    fn judge_closed_form(
        &self,
        tally: &mut Tally,
        (e, time): (crate::exact::DoubleDouble, crate::exact::DoubleDouble),
        expected: &Field,
    ) -> Read<()> {
        // The contact begins and ends within the third step.
        let (step, gap) = (4.0 * time.hi, 9.0 * time.hi);
        let until = 4.0 * step;
        let stepping = stepping(step, Scheme::ClosedForm);
        let (after, deepest) = run(self.laws, &self.discs(gap), stepping, until, self.at)?;
        let ours = after[1].velocity.x - after[0].velocity.x;
        // The gap at which it began is a rounded number near the reach.
        let noise = ROUNDING * (1.0 + 1.0 / time.hi);
        tally.near("e", ours, e, ROUNDING);
        let left = match self.laws.ending {
            Ending::OverlapGone => 0.0,
            // Where the force vanishes.
            Ending::NoAttraction => self.laws.damping * ours / self.laws.stiffness,
        };
        let flown = after[1].position.x - after[0].position.x - 2.0 + left;
        let lasts = until - gap - flown / ours;
        let error = number::error(lasts, time) / time.hi;
        tally.within("contact time, relative", error, noise / ours.min(1.0));
        if let Some(field) = expected.find("max_overlap_over_v") {
            let wanted = field.decimal()?;
            let error = number::error(deepest, wanted) / wanted.hi;
            tally.within("deepest overlap, relative", error, noise);
        }
        tally.note(format!("closed form {:.1e}", number::error(ours, e)));
        Ok(())
    }

    /// An overdamped contact that lasts until the overlap is 0 lasts for ever, and stands still.
    fn never_ends(&self, tally: &mut Tally, expected: &Field) -> Read<()> {
        let (beta, omega0) =
            (positive(&expected.get("beta")?)?, positive(&expected.get("omega0")?)?);
        let long = 100.0 * beta / (omega0 * omega0);
        let stepping = stepping(long, Scheme::ClosedForm);
        let (after, _) = run(self.laws, &self.discs(0.0), stepping, long, self.at)?;
        let speed = (after[1].velocity.x - after[0].velocity.x).abs();
        tally.within("e", speed, ROUNDING);
        Ok(())
    }
}

/// The rules that a name in the file stands for.
fn schemes(name: &Field, key: &str) -> Read<Vec<Scheme>> {
    let explicit = |rules: &[Explicit]| rules.iter().map(|&rule| Scheme::Explicit(rule)).collect();
    Ok(match key {
        "forward_euler" => explicit(&[Explicit::ForwardEuler]),
        "rk2" => explicit(&[Explicit::Rk2]),
        "rk3" => explicit(&[Explicit::Rk3]),
        "rk4" => explicit(&[Explicit::Rk4]),
        "semi_implicit_euler_and_verlet" | "verlet_semi_implicit" => {
            explicit(&[Explicit::SemiImplicitEuler, Explicit::VelocityVerlet])
        }
        "backward_euler" => vec![Scheme::Implicit(Implicit::BackwardEuler)],
        "implicit_midpoint" => vec![Scheme::Implicit(Implicit::Midpoint)],
        _ => return Err(name.wrong("unknown rule")),
    })
}

/// A disc squeezed between two fixed ones, so that it stays in contact: `omega = 1`.
fn squeezed(x: f64, v: f64) -> [Disc; 3] {
    let fixed = |id: u32, x: f64| disc(id, x, 0.0, 64.0, f64::INFINITY);
    [disc(0, x, v, 64.0, 1.0), fixed(1, -96.0), fixed(2, 96.0)]
}

/// Growth of a deviation in one step, from what a step does to two of them.
fn growth(scheme: Scheme, h: f64, at: &Field) -> Read<f64> {
    let column = |x: f64, v: f64| -> Read<[f64; 2]> {
        let stepping = Stepping { refuse_unstable: false, ..stepping(h, scheme) };
        let (after, _) = run(elastic(0.5), &squeezed(x, v), stepping, h, at)?;
        Ok([after[0].position.x, after[0].velocity.x])
    };
    Ok(spectral_radius(column(1.0, 0.0)?, column(0.0, 1.0)?))
}

/// The largest stable step that the arena names when it refuses this one.
fn largest_step(laws: Laws, discs: &[Disc], scheme: Scheme, step: f64) -> Option<f64> {
    match Springs::new(laws, discs, stepping(step, scheme)) {
        Err(Refused::StepTooLong { largest, .. }) => Some(largest),
        _ => None,
    }
}

/// Growth in one step to the first number of the tolerance; 1 % within each limit a step is taken
/// and does not grow, 1 % beyond it is refused and would; the frequencies of the arrangements.
pub fn stability(root: &Field, _: Effort) -> Findings {
    let expected = root.get("expected")?;
    let value = root.get("tolerance")?.get("value")?;
    let bound = value.number_after("")?;
    let percent = 0.01 * value.number_after("within")?;
    let mut findings = Vec::new();
    for row in expected.get("rows")?.items()? {
        let h = positive(&row.get("h_omega")?)?;
        let mut tally = Tally::new(format!("h omega = {h}"));
        for (key, wanted) in row.entries()?.iter().filter(|(key, _)| *key != "h_omega") {
            for scheme in schemes(wanted, key)? {
                let wanted_growth = wanted.decimal()?;
                tally.near(
                    key,
                    growth(scheme, h, wanted)?,
                    wanted_growth,
                    bound * wanted_growth.hi,
                );
            }
        }
        findings.push(tally.finish());
    }
    for (key, limit) in expected.get("limits")?.entries()? {
        let mut tally = Tally::new(format!("limit {key}"));
        for scheme in schemes(&limit, key)? {
            judge_limit(&mut tally, scheme, &limit, bound, percent)?;
        }
        findings.push(tally.finish());
    }
    findings.push(frequencies(&expected.get("omega_max")?, bound)?);
    Ok(findings)
}

fn judge_limit(
    tally: &mut Tally,
    scheme: Scheme,
    limit: &Field,
    bound: f64,
    percent: f64,
) -> Read<()> {
    let refused = |step: f64| largest_step(elastic(0.5), &squeezed(0.0, 0.0), scheme, step);
    let number = limit.words()?.rsplit('=').next().and_then(|text| number::after(text, ""));
    let Some(number) = number else {
        // No limit: steps as long as those of the table do not grow.
        for h in [1.0, 3.0] {
            tally.exact("refused", refused(h), None);
            tally.within("growth", growth(scheme, h, limit)? - 1.0, bound);
        }
        return Ok(());
    };
    let named = refused(number.max(1e-3) * (1.0 + percent));
    tally.within("step named", (named.unwrap_or(f64::NAN) - number).abs(), bound * number);
    let beyond = growth(scheme, number.max(0.1) * (1.0 + percent), limit)?;
    tally.exact("grows beyond", beyond > 1.0, true);
    if number > 0.0 {
        let within = number * (1.0 - percent);
        tally.exact("refused within", refused(within), None);
        tally.within("growth within", growth(scheme, within, limit)? - 1.0, bound);
    }
    Ok(())
}

/// `omega_max` of the arrangements, from the step that Verlet's limit allows there. That of a
/// lattice is a bound: never too low.
fn frequencies(wanted: &Field, bound: f64) -> Read<Finding> {
    let (k, m, heavy) = (3.0, 2.0, 50.0);
    let names = [("k", k), ("m", m), ("M", heavy)];
    let mut tally = Tally::new("omega_max");
    for (key, field) in wanted.entries()? {
        let text = field.words()?.rsplit('=').next().unwrap_or("");
        let omega = formula::evaluate(text, &names).map_err(|error| field.wrong(error))?;
        let Some((discs, walls)) = arrangement(key, m, heavy) else {
            return Err(field.wrong("unknown arrangement"));
        };
        let laws = Laws { walls, ..elastic(k) };
        let largest = largest_step(laws, &discs, VERLET, 1e3);
        let ours = largest.map_or(f64::NAN, |step| 2.0 / step);
        if key.contains("lattice") {
            tally.exact("the bound of a lattice holds", ours >= omega * (1.0 - bound), true);
            tally.note(format!("{key} bound {:.3} of it", ours / omega));
        } else {
            tally.within(format!("omega of {key}"), (ours - omega).abs(), bound * omega);
        }
    }
    Ok(tally.finish())
}

fn arrangement(key: &str, m: f64, heavy: f64) -> Option<(Vec<Disc>, Option<Walls>)> {
    let row = |masses: &[f64]| -> Vec<Disc> {
        let place = |(k, mass): (usize, &f64)| disc(k as u32, k as f64, 0.0, 0.5, *mass);
        masses.iter().enumerate().map(place).collect()
    };
    let fixed = f64::INFINITY;
    let discs = match key {
        "pair" => row(&[m, m]),
        "disc_between_two_fixed" => row(&[fixed, m, fixed]),
        "long_chain" => row(&[m; 20]),
        "light_m_heavy_M" => row(&[m, heavy]),
        "disc_on_fixed_wall" => {
            let walls = Walls { min: DVec2::splat(-0.5), max: DVec2::splat(9.0), restitution: 1.0 };
            debug_assert!(walls.gap(Side::Left, &row(&[m])[0]) == 0.0);
            return Some((row(&[m]), Some(walls)));
        }
        "triangular_lattice" => {
            let place = |k: u32| {
                let (r, c) = (f64::from(k / 9), f64::from(k % 9));
                DVec2::new(c + 0.5 * (r % 2.0), r * 0.75f64.sqrt()) * (1.0 - 1e-9)
            };
            let at = |k: u32| Disc { position: place(k), ..disc(k, 0.0, 0.0, 0.5, m) };
            (0..81).map(at).collect()
        }
        _ => return None,
    };
    Some((discs, None))
}

/// A row of touching discs, the speeds of the first as given: velocities after to the first number
/// of the tolerance, with steps of the stated part of `sqrt(m/k)`.
pub fn cradle(root: &Field, _: Effort) -> Findings {
    let (inputs, expected) = (root.get("inputs")?, root.get("expected")?);
    let value = root.get("tolerance")?.get("value")?;
    let (bound, part) = (value.number_after("")?, value.number_after("dt=")?);
    let (k, m) = (positive(&inputs.get("k")?)?, positive(&inputs.get("m")?)?);
    let speeds: Vec<f64> =
        inputs.get("v0")?.items()?.iter().map(Field::finite).collect::<Read<_>>()?;
    let unit = (m / k).sqrt();
    // So large that the overlaps are small beside it, and powers of two.
    let radius = 64.0;
    let discs: Vec<Disc> = speeds
        .iter()
        .enumerate()
        .map(|(k, &v)| disc(k as u32, 2.0 * radius * k as f64, v, radius, m))
        .collect();
    let parted = positive(&expected.get("t_last_separation")?)?;
    let schemes = [("closed form", Scheme::ClosedForm), ("velocity Verlet", VERLET)];
    let mut findings = Vec::new();
    for (name, scheme) in schemes {
        let mut tally = Tally::new(name);
        let stepping = stepping(part * unit, scheme);
        let (after, _) = run(elastic(k), &discs, stepping, 1.5 * parted, &inputs)?;
        for (k, disc) in after.iter().enumerate() {
            let wanted = expected.get("v_final")?.item(k)?.decimal()?;
            tally.near(&format!("v of {k}"), disc.velocity.x, wanted, bound);
        }
        let overlaps = |time: f64| -> Read<bool> {
            let (now, _) = run(elastic(k), &discs, stepping, time, &inputs)?;
            let pairs = now.windows(2);
            Ok(pairs.into_iter().any(|p| crate::detect::touching::overlap(&p[0], &p[1])))
        };
        let slack = stepping.step;
        tally.exact("still in contact", overlaps(parted - slack)?, true);
        tally.exact("in contact after", overlaps(parted + slack)?, false);
        findings.push(tally.finish());
    }
    Ok(findings)
}

/// Head on at speed 2, ever stiffer: velocities as hard discs have them, late by the contact time.
/// Verlet at the stated part of the contact time is within the first number of the tolerance,
/// relative; so is the closed form, in steps longer than the contact.
pub fn hard_limit(root: &Field, _: Effort) -> Findings {
    let value = root.get("tolerance")?.get("value")?;
    let (bound, parts) = (value.number_after("")?, value.number_after("t_c/")?);
    let mut findings = Vec::new();
    for row in root.get("expected")?.get("rows")?.items()? {
        let (k, lasts) = (positive(&row.get("k")?)?, positive(&row.get("contact_time")?)?);
        for (name, step, scheme) in
            [("Verlet", lasts / parts, VERLET), ("closed form", 2.0 * lasts, Scheme::ClosedForm)]
        {
            let mut tally = Tally::new(format!("k = {k} {name}"));
            let until = 5.0 * lasts;
            let discs = [disc(0, 0.0, 1.0, 1.0, 1.0), disc(1, 2.0 + 2.0 * lasts, -1.0, 1.0, 1.0)];
            let (soft, deepest) = run(elastic(k), &discs, stepping(step, scheme), until, &row)?;
            let laws = plain::Laws::default();
            let mut judge = Plain::new(laws, &discs, 1.0);
            judge.advance(until, &mut Vec::new())?;
            let delay = row.get("delay_vs_hard_positions")?.decimal()?;
            for (soft, hard) in soft.iter().zip(judge.discs(Owner::Simulated)) {
                tally.within("velocity", soft.velocity.distance(hard.velocity), bound);
                let behind = soft.position.distance(hard.position);
                tally.near("delay", behind, delay, bound * delay.hi);
            }
            let wanted = row.get("max_overlap")?.decimal()?;
            tally.near("deepest overlap", deepest, wanted, bound * wanted.hi);
            let wanted = row.get("dt_max_verlet")?.decimal()?;
            let named = largest_step(elastic(k), &discs, VERLET, 1e3).unwrap_or(f64::NAN);
            tally.near("largest step of Verlet", named, wanted, bound * wanted.hi);
            findings.push(tally.finish());
        }
    }
    Ok(findings)
}
