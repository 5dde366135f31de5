//! Discs that come, go and are put elsewhere while an arena runs: what then happens is what happens
//! in an arena made anew from the same states, and what the plain method says.

use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::FRAC_PI_4;

use carom::motion::arena::Arena;
use carom::motion::events::Events;
use carom::motion::plain::{Laws, Plain};
use carom::plan::{Method, Plan};
use carom::scene::Scene;
use carom::scene::lattice::Lattice;
use carom::scene::spread;
use carom::world::{
    Command, Contact, Disc, DiscId, Instants, NotDone, Owner, Periodic, Segment, Segments,
    Settings, World,
};
use glam::DVec2;

use crate::common::{Random, box_settings, disc, gas, momentum};
use crate::events::is_same;

/// Something done to an arena.
#[derive(Clone, Debug)]
enum Edit {
    Add(Disc),
    Remove(DiscId),
    Place(DiscId, DVec2, DVec2),
    Turn(DiscId, DVec2),
    Observe(Disc),
    Forget(DiscId),
}

/// The same of both exact methods.
macro_rules! edit {
    ($arena:expr, $edit:expr) => {
        match $edit.clone() {
            Edit::Add(disc) => $arena.add(disc),
            Edit::Remove(id) => $arena.remove(id),
            Edit::Place(id, position, velocity) => $arena.place(id, position, velocity),
            Edit::Turn(id, velocity) => Ok($arena.set_velocity(id, velocity)),
            Edit::Observe(disc) => Ok($arena.observe(disc)),
            Edit::Forget(id) => Ok($arena.forget(&BTreeSet::from([id]))),
        }
    };
}

/// Edits of a square of this side, m, and discs like those that are there.
struct Editor {
    random: Random,
    side: f64,
    radius: (f64, f64),
    mass: (f64, f64),
    next: DiscId,
    /// Whether others own circles too.
    guests: bool,
}

impl Editor {
    fn disc(&mut self, id: DiscId) -> Disc {
        let ratio = self.radius.1 / self.radius.0;
        let radius = self.radius.0 * ratio.powf(self.random.uniform(0.0, 1.0));
        let place = |random: &mut Random| random.uniform(radius, self.side - radius);
        let position = [place(&mut self.random), place(&mut self.random)];
        let mass = self.random.uniform(self.mass.0, self.mass.1);
        disc(id, position, self.random.vector(1.0).to_array(), radius, mass)
    }

    fn edit(&mut self, known: &[Disc]) -> Edit {
        let kinds = if self.guests { 8 } else { 6 };
        let any = known[self.random.below(known.len())].id;
        match self.random.below(kinds) {
            0 | 1 => {
                self.next += 1;
                Edit::Add(self.disc(self.next))
            }
            2 | 3 => Edit::Remove(any),
            4 => {
                let Disc { position, velocity, .. } = self.disc(0);
                Edit::Place(any, position, velocity)
            }
            5 => Edit::Turn(any, self.random.vector(2.0)),
            6 => {
                let id = 900_000 + self.random.below(3) as u32;
                Edit::Observe(self.disc(id))
            }
            _ => Edit::Forget(900_000 + self.random.below(3) as u32),
        }
    }
}

fn by_id(arena: &Events, owner: Owner) -> BTreeMap<DiscId, Disc> {
    arena.discs(owner).map(|disc| (disc.id, disc)).collect()
}

/// What the judges say of the next stretch: a new arena of the same method, and the plain one, with
/// the same discs. Observed ones come after, in the order of ids.
fn judges(laws: Laws, epoch: f64, arena: &Events) -> (Events, Plain) {
    let simulated: Vec<Disc> = by_id(arena, Owner::Simulated).into_values().collect();
    let (mut events, mut plain) =
        (Events::new(laws, &simulated), Plain::new(laws, &simulated, epoch));
    for disc in by_id(arena, Owner::Observed).into_values() {
        events.observe(disc);
        plain.observe(disc);
    }
    (events, plain)
}

/// Random edits between advances; after each the stretch that follows is judged.
fn check(name: &str, settings: &Settings, discs: &[Disc], mut editor: Editor, rounds: u32) {
    let plan = Plan::of(settings, discs);
    let laws = plan.laws(settings);
    let mut arena = Events::new(laws, discs);
    let (mut done, mut refused, mut seen) = (0, 0, 0);
    for round in 1..=rounds {
        let known: Vec<Disc> = arena.discs(Owner::Simulated).collect();
        let edits: Vec<Edit> = (0..1 + round % 3).map(|_| editor.edit(&known)).collect();
        for edit in &edits {
            let (mut again, mut plain) = judges(laws, plan.epoch, &arena);
            let result = edit!(arena, edit);
            assert_eq!(result, edit!(plain, edit), "{name}: {edit:?}");
            assert_eq!(result, edit!(again, edit), "{name}: {edit:?}");
            if result.is_ok() { done += 1 } else { refused += 1 }
        }
        let (mut again, mut plain) = judges(laws, plan.epoch, &arena);
        let (now, span) = (arena.now(), 0.3);
        let mut told: [Vec<Contact>; 3] = Default::default();
        while arena.now() < now + span {
            arena.advance(now + span, &mut told[0]).expect("no stall");
        }
        again.advance(span, &mut told[1]).expect("no stall");
        plain.advance(span, &mut told[2]).expect("no stall");
        told[0].iter_mut().for_each(|contact| contact.time -= now);
        for judged in &told[1..] {
            let same = told[0].iter().zip(judged).take_while(is_same).count();
            assert_eq!((told[0].len(), judged.len()), (same, same), "{name} {round}: {edits:?}");
        }
        seen += told[0].len();
    }
    assert!(done > rounds / 2 && refused > 0, "{name}: {done} done, {refused} refused");
    assert!(seen > rounds as usize / 2, "{name}: {seen} contacts");
    let drift = arena.relative_energy_drift().abs();
    assert!(drift < 1e-12, "{name}: drift {drift}");
    if !editor.guests {
        let miss = arena.largest_overlap().max(arena.largest_gap());
        assert!(miss < 1e-10, "{name}: {miss} radii from contact");
    }
}

fn editor(seed: u64, side: f64, radius: (f64, f64), mass: (f64, f64), guests: bool) -> Editor {
    Editor { random: Random::new(seed), side, radius, mass, next: 10_000, guests }
}

fn periodic(side: f64) -> Settings {
    let periodic = Some(Periodic { min: DVec2::ZERO, max: DVec2::splat(side) });
    Settings { periodic, ..Settings::default() }
}

#[test]
fn edits_in_a_box_are_what_a_new_arena_and_the_plain_one_say() {
    for seed in 0..3 {
        let discs = gas(seed, 80, 14.0, (0.4, 0.4), (1.0, 1.0));
        let equal = editor(seed, 14.0, (0.4, 0.4), (1.0, 1.0), seed == 2);
        check("equal", &box_settings(14.0, 1.0), &discs, equal, 80);
        // Larger than any that was there at first.
        let mixed = editor(seed, 14.0, (0.2, 0.7), (0.5, 3.0), seed == 2);
        check("mixed", &box_settings(14.0, 0.9), &discs, mixed, 80);
    }
}

#[test]
fn edits_in_a_periodic_box_are_what_a_new_arena_and_the_plain_one_say() {
    for seed in 0..3 {
        let discs = gas(seed, 80, 14.0, (0.4, 0.4), (1.0, 1.0));
        let equal = editor(seed, 14.0, (0.4, 0.4), (1.0, 1.0), seed == 2);
        check("equal", &periodic(14.0), &discs, equal, 80);
        let mixed = editor(seed, 14.0, (0.2, 0.7), (0.5, 3.0), seed == 2);
        check("mixed", &periodic(14.0), &discs, mixed, 80);
    }
}

#[test]
fn edits_between_segments_are_what_a_new_arena_and_the_plain_one_say() {
    for seed in 0..4 {
        let discs = gas(seed, 80, 14.0, (0.4, 0.4), (1.0, 1.0));
        // An octagon that cuts the corners of the square, without who lies there, and a bar.
        let corner = |k: u32| DVec2::from_angle(0.3 + f64::from(k) * FRAC_PI_4) * 8.8 + 7.0;
        let mut all: Vec<Segment> =
            (0..8).map(|k| Segment { from: corner(k), to: corner(k + 1) }).collect();
        let room = Segments::new(&all, 1.0).expect("segments");
        all.push(Segment { from: DVec2::new(5.0, 6.1), to: DVec2::new(9.3, 7.7) });
        let all = Segments::new(&all, if seed == 3 { 0.9 } else { 1.0 }).expect("segments");
        let free = |disc: &Disc| {
            let (at, radius) = (disc.position, disc.radius);
            room.contain(at, radius, false) && all.contain(at, radius, false)
        };
        let discs: Vec<Disc> = discs.into_iter().filter(free).collect();
        assert!(discs.len() > 48, "{}", discs.len());
        let settings = Settings { segments: Some(all), ..Settings::default() };
        let radius = if seed == 1 { (0.1, 0.8) } else { (0.4, 0.4) };
        let editor = editor(seed, 14.0, radius, (0.5, 2.0), seed == 2);
        check("segments", &settings, &discs, editor, 80);
    }
}

#[test]
fn edits_in_the_free_plane_are_what_a_new_arena_and_the_plain_one_say() {
    for seed in 0..3 {
        let mut discs = gas(seed, 60, 12.0, (0.4, 0.4), (1.0, 1.0));
        discs.iter_mut().for_each(|d| d.velocity *= 0.1);
        // Many of them outside of what the cells were made for.
        let wide = editor(seed, 12.0, (0.3, 0.5), (1.0, 2.0), true);
        check("free", &Settings::default(), &discs, wide, 60);
    }
}

#[test]
fn edits_under_gravity_are_what_a_new_arena_and_the_plain_one_say() {
    for seed in 0..3 {
        let discs = gas(seed, 60, 14.0, (0.4, 0.4), (1.0, 1.0));
        let settings = Settings { gravity: Some(DVec2::new(0.1, -0.8)), ..box_settings(14.0, 1.0) };
        let equal = editor(seed, 14.0, (0.3, 0.4), (1.0, 1.0), false);
        check("gravity", &settings, &discs, equal, 60);
    }
}

#[test]
fn edits_on_levels_of_cells_are_what_a_new_arena_and_the_plain_one_say() {
    for (seed, walled) in [(0, true), (1, false), (2, true)] {
        let (count, area_fraction, size_ratio) = (250, 0.4, 30.0);
        let lattice = Lattice { count, area_fraction, size_ratio, mass_max: 1.0, walled, seed };
        let (discs, side) = spread::discs(&lattice).expect("room");
        let settings = if walled { box_settings(side, 1.0) } else { periodic(side) };
        let laws = Plan::of(&settings, &discs).laws(&settings);
        assert!(Events::new(laws, &discs).levels() > 1);
        let small = discs.iter().map(|d| d.radius).fold(f64::INFINITY, f64::min);
        let sizes = (small, 8.0 * small);
        check("levels", &settings, &discs, editor(seed, side, sizes, (1.0, 1.0), seed == 2), 60);
    }
}

#[test]
fn an_edit_moves_nobody_else_by_a_bit() {
    let discs = gas(3, 120, 18.0, (0.4, 0.4), (1.0, 1.0));
    let settings = box_settings(18.0, 1.0);
    let mut arena = Events::new(Plan::of(&settings, &discs).laws(&settings), &discs);
    let mut editor = editor(5, 18.0, (0.4, 0.4), (1.0, 1.0), false);
    for round in 1..200u32 {
        let until = 0.05 * f64::from(round);
        arena.pass(until).expect("no stall");
        let before = by_id(&arena, Owner::Simulated);
        let known: Vec<Disc> = before.values().copied().collect();
        let edit = editor.edit(&known);
        let result = edit!(arena, &edit);
        let after = by_id(&arena, Owner::Simulated);
        let meant = match edit {
            Edit::Add(disc) => disc.id,
            Edit::Remove(id) | Edit::Place(id, ..) | Edit::Turn(id, _) => id,
            Edit::Observe(_) | Edit::Forget(_) => unreachable!("nobody owns circles here"),
        };
        let others = |discs: &BTreeMap<DiscId, Disc>| -> Vec<Disc> {
            discs.values().filter(|disc| result.is_err() || disc.id != meant).copied().collect()
        };
        assert_eq!(others(&before), others(&after), "{edit:?}");
    }
}

#[test]
fn an_arena_that_grows_a_hundredfold_and_shrinks_again_stays_exact() {
    let first = gas(1, 4, 40.0, (0.4, 0.4), (1.0, 1.0));
    for settings in [box_settings(40.0, 1.0), periodic(40.0)] {
        let mut arena = Events::new(Plan::of(&settings, &first).laws(&settings), &first);
        let mut random = Random::new(2);
        let mut added = 0;
        for id in 1000..3000 {
            let place = DVec2::new(random.uniform(0.5, 39.5), random.uniform(0.5, 39.5));
            let new = disc(id, place.to_array(), random.vector(1.0).to_array(), 0.4, 1.0);
            added += usize::from(arena.add(new).is_ok());
            if id % 20 == 0 {
                arena.pass(arena.now() + 0.05).expect("no stall");
            }
        }
        assert!(added > 400, "{added}");
        let goal = arena.contacts() + 20_000;
        while arena.contacts() < goal {
            arena.pass(f64::MAX).expect("no stall");
        }
        let ids: Vec<DiscId> = arena.discs(Owner::Simulated).map(|disc| disc.id).collect();
        for (k, &id) in ids.iter().enumerate().skip(3) {
            arena.remove(id).expect("it is there");
            if k % 7 == 0 {
                arena.pass(arena.now() + 0.1).expect("no stall");
            }
        }
        arena.pass(arena.now() + 100.0).expect("no stall");
        assert_eq!(arena.discs(Owner::Simulated).count(), 3);
        assert!(arena.relative_energy_drift().abs() < 1e-12);
        let miss = arena.largest_overlap().max(arena.largest_gap());
        assert!(miss < 1e-10, "{miss} radii from contact");
        for id in &ids[..3] {
            arena.remove(*id).expect("it is there");
        }
        arena.pass(arena.now() + 1.0).expect("no stall");
        assert_eq!(arena.kinetic_energy(), 0.0);
        arena.add(disc(7, [20.0, 20.0], [1.0, 0.0], 0.4, 1.0)).expect("room");
    }
}

#[test]
fn momentum_changes_by_what_comes_and_goes() {
    let discs = gas(4, 150, 22.0, (0.3, 0.5), (0.5, 2.0));
    let settings = periodic(22.0);
    let mut arena = Events::new(Plan::of(&settings, &discs).laws(&settings), &discs);
    let mut editor = editor(6, 22.0, (0.3, 0.5), (0.5, 2.0), false);
    let mut due = momentum(&discs);
    for _ in 0..400 {
        arena.pass(arena.now() + 0.1).expect("no stall");
        let before: Vec<Disc> = arena.discs(Owner::Simulated).collect();
        let edit = editor.edit(&before);
        if edit!(arena, &edit).is_ok() {
            let after: Vec<Disc> = arena.discs(Owner::Simulated).collect();
            due += momentum(&after) - momentum(&before);
        }
    }
    let now: Vec<Disc> = arena.discs(Owner::Simulated).collect();
    assert!((momentum(&now) - due).length() < 1e-11);
    assert!(arena.relative_energy_drift().abs() < 1e-12);
}

#[test]
fn what_cannot_be_done_is_refused_by_every_method_and_changes_nothing() {
    let discs = gas(2, 30, 12.0, (0.4, 0.4), (1.0, 1.0));
    let settings = box_settings(12.0, 1.0);
    for method in Method::ALL {
        let mut plan = Plan::of(&settings, &discs);
        plan.choose(Some(method), &settings, &discs).expect("suits");
        let mut arena = Arena::new(&plan, plan.laws(&settings), &discs);
        let new = disc(500, [6.0, 6.0], [0.0; 2], 0.4, 1.0);
        let at = |place: DVec2| Disc { position: place, ..new };
        let before: Vec<Disc> = arena.discs(Owner::Simulated).collect();
        let on_first = discs[0].position + DVec2::new(0.1, 0.0);
        assert_eq!(arena.add(at(on_first)), Err(NotDone::Overlaps(0)), "{method}");
        assert_eq!(arena.add(at(DVec2::new(0.1, 6.0))), Err(NotDone::OutsideWalls));
        assert_eq!(arena.add(Disc { id: 3, ..new }), Err(NotDone::Taken(3)));
        let odd = [at(DVec2::NAN), Disc { radius: 0.0, ..new }, Disc { mass: -1.0, ..new }];
        for odd in odd.into_iter().chain([Disc { velocity: DVec2::INFINITY, ..new }]) {
            assert!(matches!(arena.add(odd), Err(NotDone::Defect(_))), "{method} {odd:?}");
        }
        assert_eq!(arena.remove(77), Err(NotDone::Unknown(77)));
        assert_eq!(arena.place(77, DVec2::ONE, DVec2::ZERO), Err(NotDone::Unknown(77)));
        assert_eq!(arena.place(5, on_first, DVec2::ZERO), Err(NotDone::Overlaps(0)));
        let tiny = DVec2::splat(0.5);
        assert_eq!(arena.move_walls(DVec2::ZERO, tiny), Err(NotDone::NoRoom));
        for k in 0..4 {
            let mut corners = [0.0, 0.0, 12.0, 12.0];
            corners[k] = f64::NAN;
            let [min, max] = [&corners[..2], &corners[2..]].map(DVec2::from_slice);
            assert_eq!(arena.move_walls(min, max), Err(NotDone::NoRoom), "{method} {corners:?}");
        }
        assert_eq!(arena.discs(Owner::Simulated).collect::<Vec<_>>(), before);
    }
}

#[test]
fn every_method_adds_places_and_removes() {
    let mut discs = gas(2, 30, 12.0, (0.4, 0.4), (1.0, 1.0));
    discs.retain(|d| d.position.x < 6.0);
    let settings = box_settings(12.0, 1.0);
    for method in Method::ALL {
        let mut plan = Plan::of(&settings, &discs);
        plan.choose(Some(method), &settings, &discs).expect("suits");
        let mut arena = Arena::new(&plan, plan.laws(&settings), &discs);
        let mut contacts = Vec::new();
        let go = |arena: &mut Arena, until: f64, contacts: &mut Vec<Contact>| {
            while arena.now() < until {
                arena.advance(until, contacts).expect("goes on");
            }
        };
        go(&mut arena, 0.01, &mut contacts);
        let light = disc(500, [9.0, 6.0], [-9.0, 0.0], 0.4, 1.0);
        arena.add(light).expect("room");
        go(&mut arena, 2.0, &mut contacts);
        let hit = contacts.iter().any(|contact| contact.discs().any(|id| id == 500));
        assert!(hit, "{method}: it passed through");
        let there =
            |arena: &Arena, id: DiscId| arena.discs(Owner::Simulated).find(|disc| disc.id == id);
        let error = arena.relative_energy_drift().abs();
        arena.remove(500).expect("it is there");
        assert!(there(&arena, 500).is_none());
        let (place, velocity) = (DVec2::new(11.0, 11.0), DVec2::new(0.1, 0.2));
        if arena.place(discs[0].id, place, velocity).is_ok() {
            let placed = there(&arena, discs[0].id).expect("it");
            assert_eq!((placed.position, placed.velocity), (place, velocity));
        }
        arena.move_walls(DVec2::ZERO, DVec2::new(10.0, 12.0)).expect("room");
        let drift = arena.relative_energy_drift().abs();
        assert!(drift <= error + 1e-13, "{method}: edits are taken for error, {error} {drift}");
        let inside = |disc: &Disc| disc.position.x <= 10.0 - disc.radius;
        assert!(arena.discs(Owner::Simulated).all(|disc| inside(&disc)), "{method}");
        go(&mut arena, 4.0, &mut contacts);
        if method.is_exact() {
            let slack = |disc: Disc| disc.position.x <= 10.0 - disc.radius + 1e-9;
            assert!(arena.discs(Owner::Simulated).all(slack), "{method}");
        }
        let drift = arena.relative_energy_drift().abs();
        let most = if method == Method::Springs { 1e-4 } else { 1e-12 };
        assert!(drift < most, "{method}: drift {drift}");
    }
}

#[test]
fn discs_pushed_onto_each_other_by_walls_go_on_colliding() {
    let scene = Scene::load("thousand").expect("shipped");
    let discs: Vec<Disc> = scene.pucks.iter().map(|puck| puck.disc).collect();
    let plan = Plan::of(&scene.settings, &discs);
    let (mut arena, mut contacts) = (Events::new(plan.laws(&scene.settings), &discs), Vec::new());
    while arena.now() < 0.42 {
        arena.advance(0.42, &mut contacts).expect("no stall");
    }
    // Hundreds of thousands of contacts at one instant.
    arena.move_walls(DVec2::ZERO, DVec2::new(3.5, 5.0)).expect("room");
    while arena.now() < 1.0 {
        arena.advance(1.0, &mut contacts).expect("no stall");
    }
    assert!(contacts.iter().any(|contact| contact.time > 0.99), "nobody meets any more");
    let is_inside = |disc: Disc| {
        let (low, high) = (disc.position - disc.radius, disc.position + disc.radius);
        low.min_element() > -1e-9 && high.x < 3.5 + 1e-9 && high.y < 5.0 + 1e-9
    };
    assert!(arena.discs(Owner::Simulated).all(is_inside));
}

#[test]
fn both_exact_methods_agree_on_walls_that_move() {
    for seed in 0..3 {
        let discs = gas(seed, 50, 14.0, (0.4, 0.4), (1.0, 1.0));
        let settings = box_settings(14.0, 1.0);
        let plan = Plan::of(&settings, &discs);
        let laws = plan.laws(&settings);
        let mut arena = Events::new(laws, &discs);
        for round in 1..6 {
            let (min, max) = (DVec2::splat(0.2 * f64::from(round)), DVec2::splat(14.0));
            let simulated: Vec<Disc> = by_id(&arena, Owner::Simulated).into_values().collect();
            let now_laws = Laws { walls: arena_walls(laws, round - 1), ..laws };
            let mut plain = Plain::new(now_laws, &simulated, plan.epoch);
            arena.move_walls(min, max).expect("room");
            plain.move_walls(min, max).expect("room");
            let (now, mut ours, mut judged) = (arena.now(), Vec::new(), Vec::new());
            arena.advance(now + 0.4, &mut ours).expect("no stall");
            plain.advance(0.4, &mut judged).expect("no stall");
            ours.iter_mut().for_each(|contact: &mut Contact| contact.time -= now);
            let same = ours.iter().zip(&judged).take_while(is_same).count();
            assert_eq!((ours.len(), judged.len()), (same, same), "{seed} {round}");
        }
        assert!(arena.relative_energy_drift().abs() < 1e-12);
    }
}

fn arena_walls(laws: Laws, round: i32) -> Option<carom::world::Walls> {
    laws.walls
        .map(|walls| carom::world::Walls { min: DVec2::splat(0.2 * f64::from(round)), ..walls })
}

#[test]
fn under_drag_edits_act_in_real_time() {
    let discs = gas(2, 60, 14.0, (0.4, 0.4), (1.0, 1.0));
    let settings = Settings { drag: 0.7, ..box_settings(14.0, 1.0) };
    for method in [Method::Plain, Method::Events] {
        let mut plan = Plan::of(&settings, &discs);
        plan.choose(Some(method), &settings, &discs).expect("suits");
        let mut arena = Arena::new(&plan, plan.laws(&settings), &discs);
        while arena.now() < 5.0 {
            arena.pass(5.0).expect("no stall");
        }
        arena.remove(discs[0].id).expect("it is there");
        let place = DVec2::new(discs[0].position.x, discs[0].position.y);
        let mut added = Disc { id: 700, position: place, velocity: DVec2::X, ..discs[0] };
        while arena.add(added).is_err() {
            added.position = DVec2::new(0.5 + 0.1 * added.position.y, added.position.x);
        }
        let there = arena.discs(Owner::Simulated).find(|disc| disc.id == 700).expect("it");
        assert!((there.velocity - DVec2::X).length() < 1e-15, "{method}");
        while arena.now() < 50.0 {
            arena.pass(50.0).expect("no stall");
        }
        assert!(arena.relative_energy_drift().abs() < 1e-12, "{method}");
    }
}

#[test]
fn the_world_says_which_commands_it_did_not_do() {
    let pucks = gas(2, 60, 14.0, (0.4, 0.4), (1.0, 1.0));
    let mut world = World::new(box_settings(14.0, 1.0), &pucks);
    let at = |time: f64| Instants { heard_at: time, advance_to: time };
    let twice = Disc { id: 900, ..pucks[3] };
    let commands = [
        Command::RemovePuck { id: 3 },
        Command::RemovePuck { id: 3 },
        Command::AddPuck(twice),
        Command::AddPuck(Disc { id: 901, ..twice }),
        Command::PlacePuck { id: 900, position: DVec2::NAN, velocity: DVec2::ZERO },
        Command::SetVelocity { id: 900, velocity: DVec2::X },
        Command::MoveWalls { min: DVec2::splat(-1.0), max: DVec2::splat(14.0) },
    ];
    let outcome = world.step(&commands, at(0.0));
    let places: Vec<usize> = outcome.not_done.iter().map(|(place, _)| *place).collect();
    assert_eq!(places, [1, 3, 4], "{:?}", outcome.not_done);
    let arena = world.arena().expect("an arena");
    let ids: BTreeSet<DiscId> = arena.discs(Owner::Simulated).map(|disc| disc.id).collect();
    assert!(ids.contains(&900) && !ids.contains(&3) && ids.len() == 60);
    // An id that is free again may be that of an observed circle, and one that is taken not.
    let report = |id: DiscId| {
        let discs = vec![disc(id, [-30.0, 0.0], [0.0; 2], 0.1, 1.0)];
        Command::Observe(carom::world::Report { discs, time: 0.0 })
    };
    let answers = world.step(&[report(3), report(900)], at(0.1)).answers;
    assert!(answers[0].refused.is_empty() && answers[1].refused.len() == 1);
    let new = Disc { id: 3, position: DVec2::splat(-0.5), radius: 0.1, ..twice };
    let outcome = world.step(&[Command::AddPuck(new)], at(0.2));
    assert_eq!(outcome.not_done, [(0, NotDone::Taken(3))]);
    let mut resolver = World::new(Settings::default(), &[]);
    let outcome = resolver.step(&[Command::AddPuck(new)], at(0.0));
    assert_eq!(outcome.not_done, [(0, NotDone::NoArena)]);
}
