//! Box2D and Rapier on the axes of the main plot: the same scene, the same error. Feature `peers`.
//!
//! Never with settings of their own: as `carom bench peers` sets them up.

use super::runs::Who;
use super::scene::Stretch;
use crate::bench::peers::{Box2d, Rapier, Setup, Stepper};
use crate::bench::seconds;
use crate::world::Disc;

/// An engine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Engine {
    /// Box2D.
    Box2d,
    /// Rapier.
    Rapier,
}

impl Engine {
    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Box2d => "Box2D",
            Self::Rapier => "Rapier",
        }
    }
}

/// An engine at a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Peer {
    /// Which.
    pub engine: Engine,
    /// Length of the step, s.
    pub step: f64,
}

impl Peer {
    /// Time of the stretch, s, and its discs at the end; building the world is not timed.
    ///
    /// # Errors
    /// What the engine says.
    pub fn run(self, stretch: &Stretch) -> Result<(f64, Vec<Disc>), String> {
        match self.engine {
            Engine::Box2d => self.step_through::<Box2d>(stretch),
            Engine::Rapier => self.step_through::<Rapier<true>>(stretch),
        }
    }

    fn step_through<S: Stepper>(self, stretch: &Stretch) -> Result<(f64, Vec<Disc>), String> {
        let (scene, step) = (&stretch.scene, self.step);
        let setup = Setup { discs: &scene.discs, walls: scene.settings.walls, step, count: false };
        let mut engine = S::new(&setup)?;
        let steps = (scene.until / step).round() as u64;
        let (time, passed) = seconds(|| (0..steps).try_for_each(|_| engine.step()));
        passed.map(|()| (time, engine.discs()))
    }
}

/// Both engines at these steps.
pub fn peers(steps: &[f64]) -> Vec<Who> {
    let at = |engine| steps.iter().map(move |&step| Who::Peer(Peer { engine, step }));
    [Engine::Box2d, Engine::Rapier].into_iter().flat_map(at).collect()
}
