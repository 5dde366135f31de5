//! Scenes whose rates are known exactly, and how a method runs them: the reference cases S01, S08
//! and S11, made by the code that checks them.
//!
//! Never a trajectory: what counts is how often something happens.

use serde_json::Value;

use super::super::mover::{self, Mover, Scene};
use crate::bench::seconds;
use crate::check::arena::walls;
use crate::check::case::{Field, Malformed, Read};
use crate::check::statistics::{billiard_scene, cage, caged, gas, positive};
use crate::motion::arena::Arena;
use crate::world::{Contact, Partner, Settings};

const TWO_DISCS: &str = include_str!("../../../../tests/cases/S01_two_discs_in_box.json");
const CAGED: &str = include_str!("../../../../tests/cases/S08_caged_disc.json");
const BILLIARD: &str = include_str!("../../../../tests/cases/S11_sinai_lyapunov.json");

/// A scene and the mean that it must have.
#[derive(Clone, Debug)]
pub struct Known {
    /// What it is.
    pub name: String,
    /// What is measured.
    pub what: &'static str,
    /// Its exact value.
    pub exact: f64,
    /// Contacts of pairs and walls in a second.
    pub contacts_per_s: f64,
    /// Beginnings; each part of a run takes the next, or goes on where there is one only.
    starts: Vec<Scene>,
}

/// Means of equally long parts of a run.
#[derive(Clone, Debug)]
pub struct Parts {
    /// Of each part.
    pub means: Vec<f64>,
    /// Run time of each, s.
    pub times: Vec<f64>,
}

impl Known {
    /// Runs so many parts of so many contacts of pairs and walls each.
    ///
    /// # Errors
    /// Why it does not go on.
    pub fn parts(&self, mover: Mover, parts: usize, contacts: f64) -> Result<Parts, String> {
        let length = contacts / self.contacts_per_s;
        let mut told = Parts { means: Vec::new(), times: Vec::new() };
        let mut arena = mover.arena(&self.starts[0])?;
        let goes_on = self.starts.len() == 1;
        if goes_on {
            // It forgets its start.
            part(&mut arena, length)?;
        }
        for k in 0..parts {
            if !goes_on {
                arena = mover.arena(&self.starts[k % self.starts.len()])?;
            }
            let (time, mean) = seconds(|| part(&mut arena, length));
            told.means.push(mean?);
            told.times.push(time);
        }
        Ok(told)
    }
}

/// Goes on for so long (s); contacts of pairs in a second of that part.
fn part(arena: &mut Arena, length: f64) -> Result<f64, String> {
    let (began, mut pairs) = (arena.now(), 0u64);
    let until = began + length;
    let mut contacts = Vec::new();
    while arena.now() < until {
        arena.advance(until, &mut contacts).map_err(|halt| halt.to_string())?;
        let pair = |contact: &Contact| matches!(contact.b, Partner::Disc(_));
        pairs += contacts.drain(..).filter(pair).count() as u64;
    }
    Ok(pairs as f64 / (arena.now() - began))
}

fn document(text: &str) -> Result<Value, String> {
    serde_json::from_str(text).map_err(|error| error.to_string())
}

fn said(error: Malformed) -> String {
    error.to_string()
}

/// Two discs in a box, so many seeds of each box.
///
/// # Errors
/// What is wrong with the case.
pub fn two_discs(seeds: u64) -> Result<Vec<Known>, String> {
    let document = document(TWO_DISCS)?;
    read_two_discs(&Field::root(&document), seeds).map_err(said)
}

fn read_two_discs(root: &Field, seeds: u64) -> Read<Vec<Known>> {
    let mut all = Vec::new();
    for (k, (_, input, expected)) in root.subcases()?.into_iter().enumerate() {
        let walls = walls(&input, 1.0)?;
        let body = |field: &Field| Ok((positive(&field.get("m")?)?, positive(&field.get("r")?)?));
        let bodies: Vec<_> = input.get("bodies")?.items()?.iter().map(body).collect::<Read<_>>()?;
        let energy = positive(&input.get("energy")?)?;
        let pair = positive(&expected.get("pair_collision_rate")?)?;
        let wall = positive(&expected.get("wall_collision_rate")?)?;
        let settings = Settings { walls: Some(walls), ..Settings::default() };
        for seed in 1..=seeds {
            let discs = gas(&bodies, walls, energy, seed, &input)?;
            all.push(Known {
                name: format!("two discs, box {}", k + 1),
                what: "pair contacts per s",
                exact: pair,
                contacts_per_s: pair + wall,
                starts: vec![Scene { settings, discs, until: 0.0 }],
            });
        }
    }
    Ok(all)
}

/// A disc in a cage, so many random starts of each gap.
///
/// # Errors
/// As [`two_discs`].
pub fn caged_discs(starts: u64) -> Result<Vec<Known>, String> {
    let document = document(CAGED)?;
    read_caged(&Field::root(&document), starts).map_err(said)
}

fn read_caged(root: &Field, starts: u64) -> Read<Vec<Known>> {
    let known = |field: Field| {
        let delta = positive(&field)?;
        let wanted = root.get("expected")?.entry_with_number(delta)?.get("rate")?;
        let (rate, cage) = (positive(&wanted)?, cage(delta));
        let start = |seed| {
            let mut discs = vec![caged(&cage, delta, seed, &field)?];
            discs.extend(&cage);
            Ok(Scene { settings: Settings::default(), discs, until: 0.0 })
        };
        Ok(Known {
            name: format!("caged disc, gap {}", mover::power(delta)),
            what: "contacts per s",
            exact: rate,
            contacts_per_s: rate,
            starts: (0..starts).map(start).collect::<Read<_>>()?,
        })
    };
    root.get("inputs")?.get("delta")?.items()?.into_iter().map(known).collect()
}

/// Sinai's billiard: at speed 1, the rate is the inverse of the mean free path. Free paths have no
/// variance, they may be too long; the rate does not mind.
///
/// # Errors
/// As [`two_discs`].
pub fn billiards() -> Result<Vec<Known>, String> {
    let document = document(BILLIARD)?;
    read_billiards(&Field::root(&document)).map_err(said)
}

fn read_billiards(root: &Field) -> Read<Vec<Known>> {
    let known = |field: Field| {
        let reach = positive(&field)?;
        let expected = root.get("expected")?.entry_with_number(reach)?;
        let path = positive(&expected.get("mean_free_path")?)?;
        let setup = billiard_scene(reach);
        let scene = Scene { settings: setup.settings, discs: setup.discs, until: 0.0 };
        Ok(Known {
            name: format!("Sinai's billiard, R = {reach}"),
            what: "disc contacts per s",
            exact: 1.0 / path,
            // Four wall contacts in pi units of length.
            contacts_per_s: 4.0 / std::f64::consts::PI + 1.0 / path,
            starts: vec![scene],
        })
    };
    root.get("inputs")?.get("R")?.items()?.into_iter().map(known).collect()
}
