//! What the main plot says, made from its numbers.
//!
//! Never a sentence that the numbers may contradict: each has its other outcome here.

use super::super::fit::power_law;
use super::super::items::short;
use super::super::mover::Mover;
use super::runs::{Row, SPRING_STEP};
use super::{Measured, Who, scene};

/// The text of the section.
pub fn text(all: &[Measured], repeats: usize) -> Vec<String> {
    let mut text = vec![
        "How wrong is each method after one second of a thousand discs, and what does less error \
         cost? A point is one method at one setting: how long it took, and how far the worst disc \
         then is from where it truly is."
            .to_owned(),
        scene(all, repeats),
        reference(all),
    ];
    text.extend(conclusion(all));
    text.push(omitted(all));
    text
}

fn scene(all: &[Measured], repeats: usize) -> String {
    let contacts: Vec<String> = all
        .iter()
        .map(|gas| {
            let each = gas.stretch.contacts_per_disc();
            format!("{each:.1} at area fraction {}", gas.stretch.area_fraction)
        })
        .collect();
    format!(
        "Equal discs (radius 0.5 m, 1 kg, 1 J each on average, restitution 1) between walls, \
         melted from a lattice for {} contacts a disc (seed {}). In the second a disc has so many \
         contacts: {}. Every method starts from the same doubles. Methods take turns; times are \
         the median and the least of {repeats} runs after one untimed run, from which the errors \
         are; building the arena is not timed, nor is any look at contacts.",
        scene::MELT,
        scene::SEED,
        contacts.join(", "),
    )
}

fn reference(all: &[Measured]) -> String {
    let each: Vec<String> = all
        .iter()
        .map(|gas| {
            let stretch = &gas.stretch;
            format!(
                "at {}: {} contacts, retold places differ from those of the plain method by {:.0e} \
                 radii at most, a perturbation grows by {}, so one rounding at the start becomes \
                 {:.0e} radii",
                stretch.area_fraction,
                stretch.truth.contacts,
                stretch.plain.worst,
                short(stretch.growth),
                stretch.one_rounding(),
            )
        })
        .collect();
    format!(
        "The true places are those of a judge that shares no line with any method: from the list \
         of who met whom (found by the plain method) it retells the run in 300 bits, and verifies \
         that each pair touches and approaches at its turn and that no two discs ever overlap; \
         there is one such path only. Here, {}. That is far below a radius: the second ends long \
         before the horizon beyond which no double knows where a disc is. Longer runs are judged \
         by energy and statistics only, further below.",
        each.join("; ")
    )
}

/// Five sentences: exact, peers, steps, springs, energy.
pub fn conclusion(all: &[Measured]) -> Vec<String> {
    let said = [exact(all), peers(all), steps(all), springs(all), energy(all)];
    (1..).zip(said).map(|(k, said)| format!("{k}. {said}")).collect()
}

/// Says something of each gas.
fn of_each(all: &[Measured], say: impl Fn(&Measured) -> Option<String>) -> String {
    let said = all.iter().filter_map(|gas| {
        say(gas).map(|said| format!("{said} at area fraction {}", gas.stretch.area_fraction))
    });
    said.collect::<Vec<_>>().join(", ")
}

fn events(gas: &Measured) -> Option<&Row> {
    gas.rows.iter().find(|row| row.who == Who::Own(Mover::Events))
}

fn ms(row: &Row) -> String {
    format!("{} ms", short(1e3 * row.timing.median_s))
}

fn exact(all: &[Measured]) -> String {
    let told = of_each(all, |gas| {
        let row = events(gas)?;
        let error = short(row.ended.error.worst);
        Some(format!("{} and leaves the worst disc {error} radii off", ms(row)))
    });
    let quickest = all.iter().all(|gas| {
        let time = |row: &&Row| row.timing.median_s;
        let first = gas.rows.iter().min_by(|a, b| time(a).total_cmp(&time(b)));
        first.is_some_and(|row| row.who == Who::Own(Mover::Events))
    });
    let quickest = if quickest {
        "no other point is quicker"
    } else {
        "rougher points that are quicker exist"
    };
    format!("events, the exact method, takes {told}; {quickest}.")
}

/// Points of other engines that events is not both below and left of.
#[cfg(feature = "peers")]
pub fn not_beaten(gas: &Measured) -> Vec<String> {
    let Some(ours) = events(gas) else { return vec!["events is missing".to_owned()] };
    let beats = |row: &&Row| {
        let error = ours.ended.error.worst < row.ended.error.worst || row.ended.lost > 0;
        error && ours.timing.median_s < row.timing.median_s
    };
    let peers = gas.rows.iter().filter(|row| !row.who.is_own());
    peers
        .filter(|row| !beats(row))
        .map(|row| format!("{} at {}", row.who.curve(), row.who.note()))
        .collect()
}

#[cfg(feature = "peers")]
fn peers(all: &[Measured]) -> String {
    let bad: Vec<String> = all.iter().flat_map(not_beaten).collect();
    if !bad.is_empty() {
        return format!(
            "events is NOT below and left of every point of Box2D and Rapier: {}.",
            bad.join(", ")
        );
    }
    let told = of_each(all, |gas| {
        let peers = || gas.rows.iter().filter(|row| !row.who.is_own() && row.ended.lost == 0);
        let quickest = peers().min_by(|a, b| a.timing.median_s.total_cmp(&b.timing.median_s))?;
        let least = peers().map(|row| row.ended.error.worst).fold(f64::INFINITY, f64::min);
        Some(format!(
            "{} ({} at {}) and {} radii",
            ms(quickest),
            quickest.who.curve(),
            quickest.who.note(),
            short(least)
        ))
    });
    format!(
        "events is below and left of every point of Box2D 3.2 (boxdd 0.5.0) and Rapier 0.36.1: \
         their least time and least error are {told}."
    )
}

#[cfg(not(feature = "peers"))]
fn peers(_: &[Measured]) -> String {
    "Box2D and Rapier are not in this report: it was made by a build without them. To have them \
     measured on this machine, build with `cargo build --release --features peers`."
        .to_owned()
}

/// The law of a curve: error of root mean square against something, as far as it is a law.
fn law(gas: &Measured, of: impl Fn(Mover) -> Option<f64>) -> Option<f64> {
    let points: Vec<(f64, f64)> = gas
        .rows
        .iter()
        .filter_map(|row| match row.who {
            Who::Own(mover) => of(mover).map(|x| (x, row.ended.error.rms)),
            #[cfg(feature = "peers")]
            Who::Peer(_) => None,
        })
        // Above that order of contacts is lost, not digits.
        .filter(|(_, rms)| *rms < 0.1)
        .collect();
    (points.len() >= 3).then(|| power_law(&points).0)
}

fn law_of_steps(gas: &Measured) -> Option<f64> {
    law(gas, |mover| if let Mover::Steps(step) = mover { Some(step) } else { None })
}

fn law_of_springs(gas: &Measured) -> Option<f64> {
    law(gas, |mover| match mover {
        Mover::Springs { stiffness, step: SPRING_STEP } => Some(stiffness),
        _ => None,
    })
}

fn steps(all: &[Measured]) -> String {
    let told = of_each(all, |gas| {
        let rows: Vec<&Row> = gas.curve("steps").collect();
        let best = rows.iter().min_by(|a, b| a.ended.error.rms.total_cmp(&b.ended.error.rms))?;
        let order = law_of_steps(gas).map_or_else(
            || "no law (its worst disc is lost at every step)".to_owned(),
            |power| format!("an error that falls as step^{power:.2}"),
        );
        Some(format!(
            "{order}, at best {} radii root mean square for {} ({})",
            short(best.ended.error.rms),
            ms(best),
            best.who.note()
        ))
    });
    format!("steps has {told}.")
}

fn springs(all: &[Measured]) -> String {
    let told = of_each(all, |gas| {
        let rows: Vec<&Row> = gas.curve("springs, by stiffness").collect();
        let best = rows.iter().min_by(|a, b| a.ended.error.rms.total_cmp(&b.ended.error.rms))?;
        let order = law_of_springs(gas).map_or_else(
            || "no law (its worst disc is lost at every stiffness)".to_owned(),
            |power| format!("an error that falls as stiffness^{power:.2}"),
        );
        Some(format!(
            "{order}, at best {} radii root mean square for {} ({})",
            short(best.ended.error.rms),
            ms(best),
            best.who.note()
        ))
    });
    format!("springs has {told}.")
}

fn energy(all: &[Measured]) -> String {
    let largest = |of: &dyn Fn(&Row) -> bool| {
        let rows = all.iter().flat_map(|gas| &gas.rows).filter(|row| of(row));
        rows.map(|row| row.ended.energy.abs()).fold(0.0, f64::max)
    };
    let kept = largest(&|row| row.who.is_exact());
    let steps = largest(&|row| matches!(row.who, Who::Own(Mover::Steps(_))));
    let springs = largest(&|row| matches!(row.who, Who::Own(Mover::Springs { .. })));
    let mut said = format!(
        "Energy at the end is off by at most {kept:.0e} with the exact methods, {steps:.0e} with \
         steps, {springs:.0e} with springs"
    );
    let peers = largest(&|row| !row.who.is_own());
    if peers > 0.0 {
        said += &format!(", {:.0} % with the other engines", 100.0 * peers);
    }
    said + "."
}

fn omitted(all: &[Measured]) -> String {
    let mut said = "Left out: Chipmunk, matter.js and planck (no crate of theirs); more than one \
                    thread (carom's methods use one)."
        .to_owned();
    let lost = all.iter().flat_map(|gas| &gas.rows).filter(|row| row.ended.lost > 0).count();
    if lost > 0 {
        said += &format!(" {lost} runs lost discs and are in the tables only.");
    }
    if cfg!(not(feature = "peers")) {
        said += " Box2D and Rapier: not in this build.";
    }
    said
}
