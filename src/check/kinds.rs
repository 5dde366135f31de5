//! Which kind is run by what, and which needs are met.

use super::arena::Trouble;
use super::case::Field;
use super::finding::Finding;
use super::{Effort, collapse, detect, exact_solutions, impact, invalid, resolve};
use super::{penalty, periodic, statistics, stepped, trajectory};

/// Runs one case: all its sub-cases, or what is wrong.
pub type Runner = fn(&Field, Effort) -> Result<Vec<Finding>, Trouble>;

/// Needs of a case that the engine meets.
const MET: [&str; 4] = ["infinite_mass", "penalty", "gravity", "periodic_box"];

/// How to run a kind, or why it is skipped.
pub fn find(kind: &str, needs: &[String], effort: Effort) -> Result<Runner, String> {
    let runner = runner(kind).ok_or_else(|| format!("unknown kind {kind}"))?;
    if kind == "stats_pressure_periodic_long" && effort == Effort::Full {
        return Err("needs long_run of days: asked for by --only".to_owned());
    }
    for need in needs.iter().map(String::as_str).filter(|need| !MET.contains(need)) {
        match need {
            "long_run" if effort.is_full() => {}
            "long_run" => return Err("needs long_run: left out by --quick".to_owned()),
            _ => return Err(format!("needs {need}, which is unknown")),
        }
    }
    Ok(runner)
}

fn runner(kind: &str) -> Option<Runner> {
    Some(match kind {
        "resolve_pair" => resolve::pair,
        "resolve_pair_invariant" => resolve::pair_invariant,
        "resolve_wall" => resolve::wall,
        "resolve_corner" => resolve::corner,
        "resolve_cradle" => resolve::cradle,
        "resolve_symmetric" => resolve::symmetric,
        "toi_pair" => impact::pair,
        "toi_many" => impact::many,
        "predicate" => detect::predicate,
        "detect_generated" => detect::generated,
        "detect_hexagonal" => detect::hexagonal,
        "invalid" => invalid::invalid,
        "edmd_galperin" => exact_solutions::galperin,
        "edmd_tonks" => exact_solutions::tonks,
        "edmd_unfold" => exact_solutions::unfold,
        "edmd_closed_orbit" => exact_solutions::closed_orbit,
        "edmd_axis_orbit" => exact_solutions::axis_orbit,
        "edmd_cradle" => exact_solutions::cradle,
        "edmd_bouncing_ball" => collapse::bouncing_ball,
        "edmd_corner" => collapse::corner,
        "edmd_piston" => collapse::piston,
        "edmd_collapse" => collapse::collapse,
        "table_collapse_threshold" => collapse::threshold,
        "edmd_unstable_pair" => trajectory::unstable_pair,
        "edmd_trajectory" => trajectory::trajectory,
        "edmd_reverse" => trajectory::reverse,
        "edmd_mirror" => trajectory::mirror,
        "edmd_conservation" => trajectory::conservation,
        "penalty_restitution" => penalty::restitution,
        "penalty_stability" => penalty::stability,
        "penalty_cradle" => penalty::cradle,
        "penalty_hard_limit" => penalty::hard_limit,
        "stepped_head_on" => stepped::head_on,
        "stepped_tunnelling" => stepped::tunnelling,
        "stepped_overlap_energy" => stepped::overlap_energy,
        "stats_two_discs_in_box" => statistics::two_discs,
        "stats_discs_in_box" => statistics::discs_in_box,
        "stats_microcanonical_moments" => statistics::moments,
        "stats_caged_disc" => statistics::caged_disc,
        "stats_velocity_relaxation" => statistics::relaxation,
        "stats_sinai_lyapunov" => statistics::lyapunov,
        "stats_collision_rate_enskog" => periodic::enskog,
        "stats_cooling_haff" => periodic::haff,
        "stats_equation_of_state" => periodic::fluid,
        "stats_equation_of_state_crystal" => periodic::crystal,
        "stats_pressure_periodic" => periodic::pressure,
        "stats_pressure_periodic_long" => periodic::pressure_of_many,
        _ => return None,
    })
}
