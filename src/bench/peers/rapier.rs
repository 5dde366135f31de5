//! Rapier: the crate rapier2d, in f32 and with its default features.
//!
//! Its settings as they come, but for what keeps elastic discs elastic. It treats a contact at
//! restitution 1 as a bounce however slow it is, so there is no threshold to switch off. A contact
//! counts at a step at which it has an impulse.
//!
//! As it comes, it recycles contacts: where two discs have moved against each other by less than 5
//! cm since it last looked, it keeps the old line of centres, however short the step is.

use glam::DVec2;
use rapier2d::prelude::{
    ColliderBuilder, IntegrationParameters, PhysicsWorld, Real, RigidBodyBuilder, RigidBodyHandle,
    Vector,
};

use super::{Setup, Stepper};
use crate::world::{Disc, Walls};

/// Half the thickness of a wall, m.
const WALL: f64 = 1.0;

/// A world of Rapier, which recycles contacts (as it comes) or looks anew at each step.
pub(crate) struct Rapier<const RECYCLE: bool> {
    world: PhysicsWorld,
    bodies: Vec<RigidBodyHandle>,
    discs: Vec<Disc>,
}

impl<const RECYCLE: bool> Stepper for Rapier<RECYCLE> {
    fn new(setup: &Setup) -> Result<Self, String> {
        let integration_parameters = IntegrationParameters {
            dt: setup.step as Real,
            normalized_max_linear_velocity: Real::MAX,
            contact_recycling: RECYCLE,
            ..IntegrationParameters::default()
        };
        let gravity = Vector::ZERO;
        let mut world = PhysicsWorld { gravity, integration_parameters, ..PhysicsWorld::default() };
        if let Some(walls) = setup.walls {
            build(&mut world, &walls);
        }
        let bodies = setup.discs.iter().map(|disc| add(&mut world, disc)).collect();
        Ok(Self { world, bodies, discs: setup.discs.to_vec() })
    }

    fn step(&mut self) -> Result<(), String> {
        self.world.step();
        Ok(())
    }

    fn discs(&self) -> Vec<Disc> {
        let both = self.discs.iter().zip(&self.bodies);
        both.map(|(disc, &body)| {
            let body = &self.world.bodies[body];
            Disc { position: wide(body.translation()), velocity: wide(body.linvel()), ..*disc }
        })
        .collect()
    }

    fn contacts(&self) -> u64 {
        let pairs = self.world.narrow_phase.contact_pairs();
        pairs.filter(|pair| pair.total_impulse_magnitude() > 0.0).count() as u64
    }
}

/// A disc of 1 kg.
fn add(world: &mut PhysicsWorld, disc: &Disc) -> RigidBodyHandle {
    let body = RigidBodyBuilder::dynamic()
        .translation(narrow(disc.position))
        .linvel(narrow(disc.velocity))
        .can_sleep(false);
    let shape = elastic(ColliderBuilder::ball(disc.radius as Real)).mass(1.0);
    world.insert(body, shape).0
}

/// Four thick walls around the box.
fn build(world: &mut PhysicsWorld, walls: &Walls) {
    let half = 0.5 * (walls.max - walls.min) + WALL;
    let centre = 0.5 * (walls.min + walls.max);
    for normal in [DVec2::X, DVec2::NEG_X, DVec2::Y, DVec2::NEG_Y] {
        let body = RigidBodyBuilder::fixed().translation(narrow(centre + normal * half));
        // Along the wall it is as long as the box, with the corners.
        let size = narrow(normal.abs() * WALL + normal.perp().abs() * (half + WALL));
        world.insert(body, elastic(ColliderBuilder::cuboid(size.x, size.y)));
    }
}

fn elastic(shape: ColliderBuilder) -> ColliderBuilder {
    shape.friction(0.0).restitution(1.0)
}

fn narrow(vector: DVec2) -> Vector {
    Vector::new(vector.x as Real, vector.y as Real)
}

fn wide(vector: Vector) -> DVec2 {
    DVec2::new(f64::from(vector.x), f64::from(vector.y))
}
