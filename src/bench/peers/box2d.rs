//! Box2D 3: the C library, through the crate boxdd.
//!
//! Its settings as they come, but for what keeps elastic discs elastic. Its contacts reach 2 cm
//! beyond the discs; which of them collided is told by its hit events, which only a counting run
//! switches on.

use boxdd::{
    BodyBuilder, BodyId, BodyType, ShapeDef, SurfaceMaterial, Vec2, World, WorldDef, shapes,
};
use glam::DVec2;

use super::{Setup, Stepper};
use crate::world::{Disc, Walls};

/// Sub-steps of a step, as its manual recommends.
const SUB_STEPS: i32 = 4;

/// Beyond every speed: the limit is off.
const SPEED_MAX: f32 = 1e6;

/// Half the thickness of a wall, m.
const WALL: f64 = 1.0;

/// A world of Box2D.
pub(crate) struct Box2d {
    world: World,
    bodies: Vec<BodyId>,
    discs: Vec<Disc>,
    step: f32,
}

impl Stepper for Box2d {
    fn new(setup: &Setup) -> Result<Self, String> {
        let settings = WorldDef::builder()
            .gravity([0.0, 0.0])
            .restitution_threshold(0.0)
            .hit_event_threshold(0.0)
            .maximum_linear_speed(SPEED_MAX)
            .enable_sleep(false)
            .build();
        let mut world = World::new(settings).map_err(|error| format!("Box2D: {error}"))?;
        if let Some(walls) = setup.walls {
            build(&mut world, &walls);
        }
        let bodies = setup.discs.iter().map(|disc| add(&mut world, disc, setup.count)).collect();
        Ok(Self { world, bodies, discs: setup.discs.to_vec(), step: setup.step as f32 })
    }

    fn step(&mut self) -> Result<(), String> {
        self.world.step(self.step, SUB_STEPS);
        Ok(())
    }

    fn discs(&self) -> Vec<Disc> {
        let both = self.discs.iter().zip(&self.bodies);
        both.map(|(disc, &body)| Disc {
            position: wide(self.world.body_position(body)),
            velocity: wide(self.world.body_linear_velocity(body)),
            ..*disc
        })
        .collect()
    }

    fn contacts(&self) -> u64 {
        self.world.with_contact_events_view(|_, _, hits| hits.count() as u64)
    }
}

/// A disc of 1 kg.
fn add(world: &mut World, disc: &Disc, hits: bool) -> BodyId {
    let body = BodyBuilder::new()
        .body_type(BodyType::Dynamic)
        .position(narrow(disc.position))
        .linear_velocity(narrow(disc.velocity))
        .enable_sleep(false)
        .build();
    let body = world.create_body_id(body);
    let radius = disc.radius as f32;
    let density = 1.0 / (std::f32::consts::PI * radius * radius);
    let shape =
        ShapeDef::builder().material(elastic()).density(density).enable_hit_events(hits).build();
    world.create_circle_shape_for(body, &shape, &shapes::circle([0.0, 0.0], radius));
    body
}

/// Four thick walls around the box.
fn build(world: &mut World, walls: &Walls) {
    let half = 0.5 * (walls.max - walls.min) + WALL;
    let centre = 0.5 * (walls.min + walls.max);
    let shape = ShapeDef::builder().material(elastic()).build();
    for normal in [DVec2::X, DVec2::NEG_X, DVec2::Y, DVec2::NEG_Y] {
        let body = BodyBuilder::new().position(narrow(centre + normal * half)).build();
        let body = world.create_body_id(body);
        // Along the wall it is as long as the box, with the corners.
        let size = normal.abs() * WALL + normal.perp().abs() * (half + WALL);
        let size = narrow(size);
        world.create_polygon_shape_for(body, &shape, &shapes::box_polygon(size.x, size.y));
    }
}

fn elastic() -> SurfaceMaterial {
    SurfaceMaterial::default().with_friction(0.0).with_restitution(1.0)
}

fn narrow(vector: DVec2) -> Vec2 {
    Vec2::new(vector.x as f32, vector.y as f32)
}

fn wide(vector: Vec2) -> DVec2 {
    DVec2::new(f64::from(vector.x), f64::from(vector.y))
}
