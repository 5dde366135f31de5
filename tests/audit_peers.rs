//! The audit on recordings of other engines: it finds the energy that they lose.

#[path = "core/common.rs"]
#[allow(dead_code, reason = "other tests use the rest")]
mod common;

#[path = "audit/recordings.rs"]
#[allow(dead_code, reason = "other tests use the rest")]
mod recordings;

use boxdd::{BodyBuilder, BodyType, ShapeDef, SurfaceMaterial, Vec2, World, WorldDef, shapes};
use carom::audit::findings::{Findings, Kind};
use carom::audit::{Audit, Bounds, Frame, Options};
use carom::world::{Disc, Owner, Walls};
use glam::DVec2;
use rapier2d::prelude::{
    ColliderBuilder, IntegrationParameters, PhysicsWorld, Real, RigidBodyBuilder, Vector,
};
use recordings::Gas;

/// Half the thickness of a wall, m.
const WALL: f64 = 1.0;

/// Steps of a second, each of which is recorded.
const RATE: f64 = 60.0;

fn start() -> (Vec<Disc>, Walls) {
    // At a metre's size, as these engines like it.
    let (arena, settings) = Gas { diameter: 1.0, ..Gas::new(100, 0.5) }.arena();
    (arena.discs(Owner::Simulated).collect(), settings.walls.expect("walls"))
}

/// Places and sizes of four thick walls, half of each side.
fn walls(walls: &Walls) -> [(DVec2, DVec2); 4] {
    let half = 0.5 * (walls.max - walls.min) + WALL;
    let centre = 0.5 * (walls.min + walls.max);
    [DVec2::X, DVec2::NEG_X, DVec2::Y, DVec2::NEG_Y].map(|normal| {
        (centre + normal * half, normal.abs() * WALL + normal.perp().abs() * (half + WALL))
    })
}

fn recorded(discs: &[Disc], states: impl Fn(usize) -> (DVec2, DVec2), k: usize) -> Frame {
    let now = |(place, disc): (usize, &Disc)| {
        let (position, velocity) = states(place);
        Disc { position, velocity, ..*disc }
    };
    let discs = discs.iter().enumerate().map(now).collect();
    Frame { time_ns: (1e9 * k as f64 / RATE).round() as i64, discs }
}

fn rapier(discs: &[Disc], around: &Walls, frames: usize) -> Vec<Frame> {
    let narrow = |v: DVec2| Vector::new(v.x as Real, v.y as Real);
    let wide = |v: Vector| DVec2::new(f64::from(v.x), f64::from(v.y));
    let elastic = |shape: ColliderBuilder| shape.friction(0.0).restitution(1.0);
    let integration_parameters = IntegrationParameters {
        dt: (1.0 / RATE) as Real,
        normalized_max_linear_velocity: Real::MAX,
        ..IntegrationParameters::default()
    };
    let gravity = Vector::ZERO;
    let mut world = PhysicsWorld { gravity, integration_parameters, ..PhysicsWorld::default() };
    for (place, half) in walls(around) {
        let (body, half) = (RigidBodyBuilder::fixed().translation(narrow(place)), narrow(half));
        world.insert(body, elastic(ColliderBuilder::cuboid(half.x, half.y)));
    }
    let add = |disc: &Disc| {
        let body = RigidBodyBuilder::dynamic()
            .translation(narrow(disc.position))
            .linvel(narrow(disc.velocity))
            .can_sleep(false);
        let shape = elastic(ColliderBuilder::ball(disc.radius as Real)).mass(disc.mass as Real);
        world.insert(body, shape).0
    };
    let bodies: Vec<_> = discs.iter().map(add).collect();
    let mut all = Vec::new();
    for k in 0..frames {
        let state = |place: usize| {
            let body = &world.bodies[bodies[place]];
            (wide(body.translation()), wide(body.linvel()))
        };
        all.push(recorded(discs, state, k));
        world.step();
    }
    all
}

fn box2d(discs: &[Disc], around: &Walls, frames: usize) -> Vec<Frame> {
    let narrow = |v: DVec2| Vec2::new(v.x as f32, v.y as f32);
    let wide = |v: Vec2| DVec2::new(f64::from(v.x), f64::from(v.y));
    let elastic = || SurfaceMaterial::default().with_friction(0.0).with_restitution(1.0);
    let settings = WorldDef::builder()
        .gravity([0.0, 0.0])
        .restitution_threshold(0.0)
        .maximum_linear_speed(1e6)
        .enable_sleep(false)
        .build();
    let mut world = World::new(settings).expect("a world");
    for (place, half) in walls(around) {
        let body = BodyBuilder::new().position(narrow(place)).build();
        let body = world.create_body_id(body);
        let shape = ShapeDef::builder().material(elastic()).build();
        let half = narrow(half);
        world.create_polygon_shape_for(body, &shape, &shapes::box_polygon(half.x, half.y));
    }
    let add = |disc: &Disc| {
        let body = BodyBuilder::new()
            .body_type(BodyType::Dynamic)
            .position(narrow(disc.position))
            .linear_velocity(narrow(disc.velocity))
            .enable_sleep(false)
            .build();
        let body = world.create_body_id(body);
        let radius = disc.radius as f32;
        let density = disc.mass as f32 / (std::f32::consts::PI * radius * radius);
        let shape = ShapeDef::builder().material(elastic()).density(density).build();
        world.create_circle_shape_for(body, &shape, &shapes::circle([0.0, 0.0], radius));
        body
    };
    let bodies: Vec<_> = discs.iter().map(add).collect();
    let mut all = Vec::new();
    for k in 0..frames {
        let state = |place: usize| {
            let body = bodies[place];
            (wide(world.body_position(body)), wide(world.body_linear_velocity(body)))
        };
        all.push(recorded(discs, state, k));
        world.step((1.0 / RATE) as f32, 4);
    }
    all
}

fn energy(frame: &Frame) -> f64 {
    frame.discs.iter().map(Disc::kinetic_energy).sum()
}

fn audited(frames: Vec<Frame>, around: &Walls) -> Findings {
    let bounds = Bounds { min: around.min, max: around.max, restitution: None };
    let options = Options { restitution: Some(1.0), walls: Some(bounds), ..Options::default() };
    let mut audit = Audit::new(options, Box::new(|_| {}));
    frames.into_iter().for_each(|frame| audit.hear(frame));
    audit.finish()
}

#[test]
fn the_energy_that_engines_lose_is_found() {
    let (discs, around) = start();
    for (name, record) in
        [("Rapier", rapier as fn(&[Disc], &Walls, usize) -> Vec<Frame>), ("Box2D", box2d)]
    {
        let frames = record(&discs, &around, 600);
        let (first, last) = (energy(&frames[0]), energy(frames.last().expect("frames")));
        let findings = audited(frames, &around);
        let ledger = findings.ledger;
        let found = ledger.pairs_j + ledger.clusters_j + ledger.walls_j;
        println!(
            "{name}: {first} J to {last} J; {ledger:?} {:?} {:?}",
            findings.counts,
            findings.by_kind.iter().filter(|(_, count)| *count > 0).collect::<Vec<_>>()
        );
        let lost = last - first;
        assert!(lost < -1e-3 * first, "{name} loses energy: {lost}");
        assert!((found / lost - 1.0).abs() < 0.05, "{name}: {found} of {lost}");
        assert!(findings.of_kind(Kind::Energy) + findings.of_kind(Kind::Normal) > 0, "{name}");
    }
}
