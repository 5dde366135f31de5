//! Small chaotic scenes whose true ends are known: reference cases, as they are in the project.
//!
//! Their checkpoints were computed in 700 and 950 bits by a program that is not carom's; growths of
//! a perturbation come with them. Each is retold by the report's own judge too, and the two must
//! agree. The head-on pair has a closed form, which is what the judge computes.

use serde_json::Value;

use super::super::mover::{self, Mover, Scene};
use crate::check::arena::Setup;
use crate::check::case::{Field, Read};
use crate::exact::DoubleDouble;
use crate::report::ReportError;
use crate::report::judge::{self, Truth};

/// The files.
const FILES: [(&str, &str); 6] = [
    ("E20_chaos_N10", include_str!("../../../../tests/cases/E20_chaos_N10.json")),
    ("E20_chaos_N3", include_str!("../../../../tests/cases/E20_chaos_N3.json")),
    ("E21_chaos_e09", include_str!("../../../../tests/cases/E21_chaos_e09.json")),
    ("E22_mass_1e6", include_str!("../../../../tests/cases/E22_mass_1e6.json")),
    ("E25_dense_hex16", include_str!("../../../../tests/cases/E25_dense_hex16.json")),
    ("W01_stepped_head_on", include_str!("../../../../tests/cases/W01_stepped_head_on.json")),
];

/// A scene ends at its last checkpoint at which a perturbation has grown by no more than this.
const GROWTH_MOST: f64 = 400.0;

/// By how much the two references may differ, m: they are given to 40 digits, and two doubles hold
/// 32.
const AGREEMENT_M: f64 = 1e-28;

/// A time at which the truth is known.
#[derive(Clone, Debug)]
pub struct Checkpoint {
    /// s
    pub time: f64,
    /// Where the discs are.
    pub truth: Truth,
    /// What a perturbation of the start has been multiplied by.
    pub growth: f64,
}

/// A scene with its truth.
#[derive(Clone, Debug)]
pub struct Known {
    /// Name of the case.
    pub name: &'static str,
    /// The scene up to its end in this figure.
    pub scene: Scene,
    /// All that is known, in order.
    pub checkpoints: Vec<Checkpoint>,
    /// Which of them is the end.
    pub last: usize,
}

impl Known {
    /// The end in this figure.
    pub fn end(&self) -> &Checkpoint {
        &self.checkpoints[self.last]
    }
}

/// All scenes.
///
/// # Errors
/// [`ReportError::Wrong`] where the two references differ.
pub fn all() -> Result<Vec<Known>, ReportError> {
    let known = |(name, text): (&'static str, &str)| {
        let wrong = |what: String| ReportError::Wrong(format!("{name}: {what}"));
        let document: Value = serde_json::from_str(text).map_err(|e| wrong(e.to_string()))?;
        let root = Field::root(&document);
        let known = if root.get("expected").and_then(|e| e.get("checkpoints")).is_ok() {
            read(name, &root).map_err(|error| error.to_string())
        } else {
            head_on(name, &root)
        };
        let known = known.map_err(wrong)?;
        agree(&known).map_err(wrong)?;
        Ok(known)
    };
    FILES.into_iter().map(known).collect()
}

fn read(name: &'static str, root: &Field) -> Read<Known> {
    let (setup, expected) = (Setup::read(&root.get("inputs")?)?, root.get("expected")?);
    let growths = expected.get("amplification_of_initial_perturbation")?;
    let checkpoint = |(k, field): (usize, Field)| {
        let place = |state: Field| Ok([state.item(0)?.decimal()?, state.item(1)?.decimal()?]);
        let states = field.get("state_x_y_vx_vy")?.items()?;
        let places: Read<Vec<[DoubleDouble; 2]>> = states.into_iter().map(place).collect();
        let contacts = field.get("n_events")?.count(1 << 20)? as usize;
        let truth = Truth { places: places?, contacts, time_error_s: 0.0 };
        let growth = growths.item(k)?.number()?;
        Ok(Checkpoint { time: field.get("t")?.finite()?, truth, growth })
    };
    let fields = expected.get("checkpoints")?.items()?;
    let checkpoints: Vec<Checkpoint> =
        fields.into_iter().enumerate().map(checkpoint).collect::<Read<_>>()?;
    let small = |checkpoint: &Checkpoint| checkpoint.growth <= GROWTH_MOST;
    let last = checkpoints.iter().rposition(small);
    let last = last.ok_or_else(|| expected.wrong("no checkpoint before chaos"))?;
    let until = checkpoints[last].time;
    let scene = Scene { settings: setup.settings, discs: setup.discs, until };
    Ok(Known { name, scene, checkpoints, last })
}

/// Two equal discs head on: they exchange their velocities, so nothing grows.
fn head_on(name: &'static str, root: &Field) -> Result<Known, String> {
    let read = || {
        let contact = root.get("expected")?.get("t_contact")?.finite()?;
        Ok::<_, crate::check::case::Malformed>((Setup::read(&root.get("inputs")?)?, contact))
    };
    let (setup, contact) = read().map_err(|error| error.to_string())?;
    // A multiple of all steps.
    let time = (2.0 * contact).ceil();
    let scene = Scene { settings: setup.settings, discs: setup.discs, until: time };
    let truth = retold(&scene)?;
    let checkpoints = vec![Checkpoint { time, truth, growth: 1.0 }];
    Ok(Known { name, scene, checkpoints, last: 0 })
}

fn retold(scene: &Scene) -> Result<Truth, String> {
    let mut arena = Mover::Plain.arena(scene)?;
    let contacts = mover::contacts(&mut arena, scene.until)?;
    judge::retell(&scene.settings, &scene.discs, &contacts, scene.until)
}

/// Whether the file and the report's own judge know the same end.
fn agree(known: &Known) -> Result<(), String> {
    let (ours, theirs) = (retold(&known.scene)?, &known.end().truth);
    if ours.contacts != theirs.contacts {
        return Err(format!("{} contacts retold, known are {}", ours.contacts, theirs.contacts));
    }
    let both = ours.places.iter().flatten().zip(theirs.places.iter().flatten());
    let apart = both.map(|(a, b)| a.minus(*b).value().abs()).fold(0.0, f64::max);
    if apart > AGREEMENT_M {
        return Err(format!("the two references differ by {apart:e} m"));
    }
    Ok(())
}
