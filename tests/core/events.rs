//! The event-driven method, judged by the plain one: the same contacts in the same order, until
//! rounding has grown.

use crate::common::{Random, box_settings, disc, energy, gas, momentum};
use carom::motion::events::{Events, Lanes};
use carom::motion::plain::{Laws, Plain};
use carom::plan::parts::Parts;
use carom::plan::{Method, Plan};
use carom::world::{Contact, Disc, Owner, Partner, Periodic, Settings};
use glam::DVec2;

pub fn laws(settings: &Settings, discs: &[Disc]) -> Laws {
    Plan::of(settings, discs).laws(settings)
}

fn periodic(side: f64) -> Settings {
    let periodic = Some(Periodic { min: DVec2::ZERO, max: DVec2::splat(side) });
    Settings { periodic, ..Settings::default() }
}

/// Both methods on one scene.
pub struct Twins {
    pub events: Events,
    pub plain: Plain,
}

impl Twins {
    pub fn new(settings: &Settings, discs: &[Disc]) -> Self {
        let plan = Plan::of(settings, discs);
        let laws = plan.laws(settings);
        Self { events: Events::new(laws, discs), plain: Plain::new(laws, discs, plan.epoch) }
    }

    /// Commands to discs 0 to 49; a wide observed circle that sweeps through, one that comes and
    /// goes.
    pub fn run_with_commands_and_guests(&mut self) -> (Vec<Contact>, Vec<Contact>) {
        let mut random = Random::new(9);
        let (mut ours, mut judged) = (Vec::new(), Vec::new());
        for k in 1..40 {
            let until = 0.05 * f64::from(k);
            self.events.advance(until, &mut ours).expect("no stall");
            self.plain.advance(until, &mut judged).expect("no stall");
            let (id, velocity) = (random.below(50) as u32, random.vector(2.0));
            self.events.set_velocity(id, velocity);
            self.plain.set_velocity(id, velocity);
            let x = 0.3 * f64::from(k);
            let guest = disc(900, [x, 6.0], [6.0, 0.0], 0.8, 50.0);
            let other = disc(901, [6.0, x], [0.0, 6.0], 0.3, f64::INFINITY);
            for guest in [Some(guest), (k % 10 < 5).then_some(other)].into_iter().flatten() {
                self.events.observe(guest);
                self.plain.observe(guest);
            }
            if k % 10 == 5 {
                self.events.forget(&[901].into());
                self.plain.forget(&[901].into());
            }
        }
        (ours, judged)
    }

    pub fn run(&mut self, until: f64) -> (Vec<Contact>, Vec<Contact>) {
        let (mut ours, mut judged) = (Vec::new(), Vec::new());
        while self.events.now() < until {
            self.events.advance(until, &mut ours).expect("no stall");
        }
        while self.plain.now() < until {
            self.plain.advance(until, &mut judged).expect("no stall");
        }
        (ours, judged)
    }
}

/// The two methods must agree for about as long as the plain one agrees with itself where every
/// disc is moved by a rounding error.
pub fn check(name: &str, settings: &Settings, discs: &[Disc], until: f64) {
    let (ours, judged) = Twins::new(settings, discs).run(until);
    let (same, of) = (ours.iter().zip(&judged).take_while(is_same).count(), judged.len());
    if same < of {
        println!("{name} {same} of {of}: {:?} {:?}", ours.get(same), judged[same]);
    }
    let mut moved = discs.to_vec();
    moved.iter_mut().for_each(|disc| disc.position += disc.position * f64::EPSILON);
    let mut twins = Twins::new(settings, discs);
    let judged = twins.run(until).1;
    let again = Twins::new(settings, &moved).run(until).1;
    let predictable = judged.iter().zip(&again).take_while(is_same).count();
    assert!(predictable > 5, "{name}: only {predictable} of {of} contacts can be predicted");
    let wanted = if predictable == of { of } else { predictable * 3 / 4 };
    assert!(same >= wanted, "{name}: {same} of {of} contacts, {predictable} are predictable");
}

/// Whether two records are of the same contact.
pub fn is_same((a, b): &(&Contact, &Contact)) -> bool {
    let near = |x: f64, y: f64| (x - y).abs() <= 1e-5 * (1.0 + b.impulse);
    (a.a, a.b) == (b.a, b.b)
        && (a.time - b.time).abs() < 1e-6
        && (a.point - b.point).length() < 1e-5
        && near(a.impulse, b.impulse)
        && near(a.energy_loss, b.energy_loss)
        && near(a.approach_speed, b.approach_speed)
}

#[test]
fn agrees_with_the_plain_method_in_a_box() {
    for seed in 0..6 {
        let discs = gas(seed, 60, 12.0, (0.4, 0.4), (1.0, 1.0));
        check("equal", &box_settings(12.0, 1.0), &discs, 8.0);
        let discs = gas(seed, 60, 12.0, (0.2, 0.5), (0.1, 10.0));
        check("mixed", &box_settings(12.0, 1.0), &discs, 8.0);
        check("lossy", &box_settings(12.0, 0.8), &discs, 8.0);
    }
}

#[test]
fn agrees_with_the_plain_method_in_a_periodic_box() {
    for seed in 0..6 {
        let discs = gas(seed, 80, 14.0, (0.5, 0.5), (1.0, 1.0));
        check("equal", &periodic(14.0), &discs, 8.0);
        let discs = gas(seed, 80, 14.0, (0.3, 0.5), (0.5, 2.0));
        let settings = Settings { restitution: 0.9, ..periodic(14.0) };
        check("mixed", &settings, &discs, 8.0);
    }
}

/// Discs that fly past half the box between two looks must meet the image that they come to.
#[test]
fn discs_of_dilute_gases_meet_the_right_image() {
    for (count, side, height) in
        [(9, 19.0, 19.0), (20, 40.0, 40.0), (30, 34.0, 34.0), (60, 20.0, 300.0)]
    {
        for seed in 0..2 {
            let mut discs = gas(seed, count, side, (0.5, 0.5), (1.0, 1.0));
            discs.iter_mut().for_each(|disc| disc.position.y *= height / side);
            let periodic = Periodic { min: DVec2::ZERO, max: DVec2::new(side, height) };
            let settings = Settings { periodic: Some(periodic), ..Settings::default() };
            let laws = laws(&settings, &discs);
            let mut arena = Events::new(laws, &discs);
            let mut whole = Events::with(
                laws,
                &discs,
                Parts::needed(&laws, &discs).and(Parts::that_can_be_forced(Method::Events, &laws)),
            );
            while arena.contacts() < 60_000 {
                let until = arena.now() + 100.0;
                arena.pass(until).expect("no stall");
                whole.pass(until).expect("no stall");
            }
            assert!(arena.largest_overlap() < 1e-9, "{count} {side} {}", arena.largest_overlap());
            assert!(arena.discs(Owner::Simulated).eq(whole.discs(Owner::Simulated)), "{count}");
        }
        let discs = gas(7, count, side, (0.3, 0.5), (0.5, 2.0));
        check("dilute", &periodic(side), &discs, 40.0 * side);
    }
}

#[test]
fn agrees_with_the_plain_method_in_the_free_plane() {
    for seed in 0..6 {
        let mut discs = gas(seed, 60, 12.0, (0.3, 0.5), (1.0, 3.0));
        for disc in &mut discs {
            disc.velocity = (DVec2::splat(6.0) - disc.position) * 0.3 + disc.velocity * 0.5;
        }
        check("free", &Settings::default(), &discs, 100.0);
    }
}

#[test]
fn agrees_with_the_plain_method_around_fixed_discs() {
    for seed in 0..6 {
        let mut discs = gas(seed, 60, 12.0, (0.4, 0.4), (1.0, 1.0));
        for disc in discs.iter_mut().step_by(7) {
            (disc.mass, disc.velocity) = (f64::INFINITY, DVec2::ZERO);
        }
        check("fixed", &box_settings(12.0, 1.0), &discs, 8.0);
    }
}

#[test]
fn contacts_at_one_instant_are_resolved_together() {
    // A striker meets two touching discs: generalised reflections give it -1/5 of its velocity.
    let (c, s) = (30f64.to_radians().cos(), 30f64.to_radians().sin());
    let mut discs = vec![
        disc(0, [0.0, 0.0], [1.0, 0.0], 0.5, 1.0),
        disc(1, [1.0 + c, s], [0.0, 0.0], 0.5, 1.0),
        disc(2, [1.0 + c, -s], [0.0, 0.0], 0.5, 1.0),
    ];
    let far = gas(5, 20, 10.0, (0.3, 0.3), (1.0, 1.0)).into_iter();
    let far = far.map(|d| Disc { id: d.id + 10, position: d.position + 30.0, ..d });
    discs.extend(far);
    let mut twins = Twins::new(&Settings::default(), &discs);
    twins.run(1.5);
    let striker = twins.events.discs(Owner::Simulated).next().expect("a striker");
    assert!((striker.velocity.x + 0.2).abs() < 1e-12 && striker.velocity.y.abs() < 1e-12);
}

#[test]
fn a_touching_row_passes_the_blow_on() {
    let mut discs = vec![disc(0, [0.0, 0.0], [1.0, 0.0], 0.5, 1.0)];
    discs.extend((1..40).map(|k| disc(k, [1.0 + f64::from(k), 0.0], [0.0; 2], 0.5, 1.0)));
    let mut arena = Events::new(Laws::FREE, &discs);
    let mut contacts = Vec::new();
    arena.advance(5.0, &mut contacts).expect("no stall");
    let last = arena.discs(Owner::Simulated).last().expect("a last one");
    assert_eq!(contacts.len(), 39);
    assert_eq!(last.velocity, DVec2::X);
    assert!((last.position.x - 44.0).abs() < 1e-12, "{}", last.position.x);
}

#[test]
fn energy_and_momentum_are_kept_over_a_million_contacts() {
    let mut discs = gas(3, 400, 60.0, (0.5, 0.9), (0.1, 10.0));
    let drift = momentum(&discs) / discs.iter().map(|d| d.mass).sum::<f64>();
    discs.iter_mut().for_each(|d| d.velocity -= drift);
    let mut arena = Events::new(laws(&periodic(60.0), &discs), &discs);
    while arena.contacts() < 1_000_000 {
        arena.pass(f64::MAX).expect("no stall");
    }
    let after: Vec<Disc> = arena.discs(Owner::Simulated).collect();
    let scale = discs.iter().map(|d| d.mass * d.velocity.length()).sum::<f64>();
    assert!((energy(&after) / energy(&discs) - 1.0).abs() < 1e-13);
    assert!(arena.relative_energy_drift().abs() < 1e-13);
    assert!((momentum(&after) - momentum(&discs)).length() < 1e-13 * scale);
    let largest = arena.largest_overlap().max(arena.largest_gap());
    assert!(largest < 1e-11, "contact distance off by {largest} radii");
}

#[test]
fn looking_between_events_changes_nothing() {
    let discs = gas(8, 200, 25.0, (0.4, 0.4), (1.0, 2.0));
    let laws = laws(&box_settings(25.0, 0.95), &discs);
    let run = |steps: u32| {
        let mut arena = Events::new(laws, &discs);
        for k in 1..=steps {
            let until = 20.0 * f64::from(k) / f64::from(steps);
            while arena.now() < until {
                arena.pass(until).expect("no stall");
            }
        }
        arena.discs(Owner::Simulated).map(|d| (d.velocity, d.position)).collect::<Vec<_>>()
    };
    let (once, often) = (run(1), run(997));
    for (a, b) in once.iter().zip(&often) {
        assert_eq!(a.0, b.0);
        assert_eq!(a.1, b.1);
    }
}

#[test]
fn looking_at_discs_that_hardly_move_changes_nothing() {
    // Nothing happens in many an epoch of the calendar, which was made for faster discs.
    let discs = gas(8, 60, 12.0, (0.3, 0.4), (1.0, 2.0));
    let laws = laws(&box_settings(12.0, 1.0), &discs);
    let run = |frames: u32| {
        let mut arena = Events::new(laws, &discs);
        arena.pass(3.0).expect("no stall");
        for disc in &discs {
            arena.set_velocity(disc.id, 1e-5 * disc.velocity);
        }
        for frame in 1..=frames {
            let time = 3.0 + 900.0 * f64::from(frame) / f64::from(frames);
            arena.pass(time).expect("no stall");
        }
        arena.discs(Owner::Simulated).collect::<Vec<Disc>>()
    };
    let once = run(1);
    for frames in [7, 100, 9_000] {
        assert!(run(frames) == once, "{frames}");
    }
}

#[test]
fn commands_and_observed_discs_act_at_once() {
    let discs = gas(4, 50, 12.0, (0.3, 0.3), (1.0, 1.0));
    let settings = box_settings(12.0, 1.0);
    let mut twins = Twins::new(&settings, &discs);
    let (ours, judged) = twins.run_with_commands_and_guests();
    let partners = |contacts: &[Contact]| -> Vec<(u32, Partner)> {
        contacts.iter().map(|contact| (contact.a, contact.b)).collect()
    };
    assert!(judged.len() > 100, "{}", judged.len());
    assert_eq!(partners(&ours), partners(&judged));
    let states = |discs: Vec<Disc>| discs.into_iter().map(|d| d.velocity).collect::<Vec<_>>();
    for owner in [Owner::Simulated, Owner::Observed] {
        let ours = states(twins.events.discs(owner).collect());
        let judged = states(twins.plain.discs(owner).collect());
        for (a, b) in ours.iter().zip(&judged) {
            assert!((*a - *b).length() < 1e-6, "{a} {b}");
        }
    }
    assert!(twins.events.relative_energy_drift().abs() < 1e-12);
}

#[test]
fn discs_at_rest_and_empty_arenas_wait() {
    let mut empty = Events::new(Laws::FREE, &[]);
    empty.pass(1e9).expect("no stall");
    assert_eq!(empty.now(), 1e9);
    let mut discs = gas(1, 100, 20.0, (0.4, 0.4), (1.0, 1.0));
    discs.iter_mut().for_each(|d| d.velocity = DVec2::ZERO);
    let mut arena = Events::new(laws(&box_settings(20.0, 1.0), &discs), &discs);
    arena.pass(1e6).expect("no stall");
    assert_eq!((arena.now(), arena.contacts()), (1e6, 0));
    arena.set_velocity(7, DVec2::new(3.0, 1.0));
    while arena.now() < 1e6 + 50.0 {
        arena.pass(1e6 + 50.0).expect("no stall");
    }
    assert!(arena.contacts() > 20);
    assert!(arena.relative_energy_drift().abs() < 1e-13);
}

#[test]
fn a_gas_that_cools_a_thousandfold_goes_on() {
    let mut discs = gas(2, 500, 60.0, (0.5, 0.5), (1.0, 1.0));
    let drift = momentum(&discs) / 500.0;
    discs.iter_mut().for_each(|disc| disc.velocity -= drift);
    let settings = Settings { restitution: 0.8, ..periodic(60.0) };
    let mut arena = Events::new(laws(&settings, &discs), &discs);
    let before = arena.kinetic_energy();
    while arena.now() < 3000.0 {
        arena.pass(3000.0).expect("no stall");
    }
    let left = arena.kinetic_energy() / before;
    assert!(left < 1e-3, "{left} after {} contacts", arena.contacts());
    assert!(arena.relative_energy_drift().abs() < 1e-13);
}

#[test]
fn one_hot_disc_among_cold_ones_is_no_storm() {
    let mut discs = gas(6, 300, 40.0, (0.5, 0.5), (1.0, 1.0));
    for disc in &mut discs {
        disc.velocity *= 1e-6;
    }
    discs[150].velocity = DVec2::new(1e3, 7e2);
    check("hot", &box_settings(40.0, 1.0), &discs, 0.02);
    let mut arena = Events::new(laws(&box_settings(40.0, 1.0), &discs), &discs);
    while arena.contacts() < 20_000 {
        arena.pass(f64::MAX).expect("no stall");
    }
}

#[test]
fn every_processor_gives_the_same_bits() {
    let lossy = Settings { restitution: 0.9, ..periodic(25.0) };
    for (settings, radius) in
        [(periodic(25.0), (0.4, 0.4)), (lossy, (0.2, 0.5)), (box_settings(25.0, 0.95), (0.3, 0.5))]
    {
        let discs = gas(8, 200, 25.0, radius, (1.0, 2.0));
        let [mut four, mut one] = [(); 2].map(|()| Events::new(laws(&settings, &discs), &discs));
        one.use_lanes(Lanes::portable());
        while four.now() < 20.0 {
            four.pass(20.0).expect("no stall");
            one.pass(20.0).expect("no stall");
        }
        assert!(four.contacts() > 400, "{}", four.contacts());
        assert_eq!(four.contacts(), one.contacts());
        let states = |arena: &Events| arena.discs(Owner::Simulated).collect::<Vec<Disc>>();
        assert_eq!(states(&four), states(&one));
    }
}

#[test]
fn a_disc_that_flies_as_before_elsewhere_is_not_hit_from_afar() {
    // The second disc stops where it is not expected, with the velocity that it had before.
    let (c, s) = (30f64.to_radians().cos(), 0.5);
    let mut discs = vec![
        disc(0, [0.0, 0.0], [1.0, 0.0], 0.5, 1.0),
        disc(1, [2.0 + c, s], [0.0, 0.0], 0.5, 1.0),
        disc(2, [2.0 + c, -s], [0.0, 0.0], 0.5, 1.0),
    ];
    let far = gas(5, 60, 12.0, (0.3, 0.3), (1.0, 1.0)).into_iter();
    discs.extend(far.map(|d| Disc {
        id: d.id + 10,
        position: d.position + 60.0,
        velocity: DVec2::ZERO,
        ..d
    }));
    let mut twins = Twins::new(&Settings::default(), &discs);
    for (until, velocity) in [(0.1, [0.0, 10.0]), (0.6, [0.0, 0.0])] {
        twins.run(until);
        twins.events.set_velocity(1, velocity.into());
        twins.plain.set_velocity(1, velocity.into());
    }
    let (ours, judged) = twins.run(5.0);
    assert_eq!(ours.len(), judged.len());
    assert!(ours.iter().zip(&judged).all(|pair| is_same(&pair)));
    assert!(twins.events.largest_gap() < 1e-12);
}

#[test]
fn a_command_after_slow_times_moves_no_disc() {
    for (slow, fast) in [(1e-3, 1e3), (1e-6, 1e3), (1e-9, 1e6), (1e-12, 1e6), (0.0, 1e6)] {
        let mut discs = gas(1, 60, 20.0, (0.4, 0.4), (1.0, 1.0));
        discs.iter_mut().for_each(|d| d.velocity *= slow);
        let mut arena = Events::new(laws(&box_settings(20.0, 1.0), &discs), &discs);
        let until = 3.0 / f64::max(slow, 1e-9);
        for frame in 1..=100 {
            let until = until * f64::from(frame) / 100.0;
            while arena.now() < until {
                arena.pass(until).expect("no stall");
            }
        }
        let place = |arena: &Events| arena.discs(Owner::Simulated).nth(3).expect("it").position;
        let before = place(&arena);
        arena.set_velocity(3, DVec2::new(fast, 0.7 * fast));
        let moved = place(&arena).distance(before);
        assert!(moved < 1e-12, "{slow} {fast}: moved by {moved}");
        let until = arena.now() + 100.0 / fast;
        while arena.now() < until {
            arena.pass(until).expect("no stall");
        }
        let miss = arena.largest_overlap().max(arena.largest_gap());
        assert!(miss < 1e-9, "{slow} {fast}: {miss} radii from contact");
    }
}

#[test]
fn odd_ends_of_time_do_no_harm() {
    let mut discs = gas(1, 60, 20.0, (0.4, 0.4), (1.0, 1.0));
    let settings = box_settings(20.0, 1.0);
    let mut moving = Events::new(laws(&settings, &discs), &discs);
    discs.iter_mut().for_each(|d| d.velocity = DVec2::ZERO);
    for until in [f64::NAN, f64::NEG_INFINITY, -1.0, 0.0] {
        moving.pass(until).expect("no stall");
        assert_eq!((moving.now(), moving.contacts()), (0.0, 0));
    }
    for until in [f64::INFINITY, f64::MAX, 1e300, 1e20] {
        let mut resting = Events::new(laws(&settings, &discs), &discs);
        resting.pass(until).expect("no stall");
        assert_eq!((resting.now(), resting.contacts()), (until, 0));
        resting.set_velocity(7, DVec2::X);
        resting.pass(until * 1.5).expect("no stall");
    }
}

#[test]
fn distances_keep_their_unit_when_another_radius_comes() {
    let discs = gas(1, 60, 20.0, (0.4, 0.4), (1.0, 1.0));
    let mut arena = Events::new(laws(&box_settings(20.0, 1.0), &discs), &discs);
    arena.pass(5.0).expect("no stall");
    let before = (arena.largest_overlap(), arena.largest_gap());
    arena.observe(disc(900, [-50.0, -50.0], [0.0; 2], 0.7, 1.0));
    assert_eq!((arena.largest_overlap(), arena.largest_gap()), before);
}

#[test]
fn discs_that_come_and_go_before_a_fast_command_stay_in_place() {
    let discs = gas(1, 60, 20.0, (0.2, 0.2), (1.0, 1.0));
    let mut arena = Events::new(laws(&box_settings(20.0, 1.0), &discs), &discs);
    arena.observe(disc(900, [-5.0, -5.0], [0.0; 2], 0.2, 1.0));
    while arena.now() < 3.0 {
        arena.pass(3.0).expect("no stall");
    }
    let before: Vec<Disc> = arena.discs(Owner::Simulated).collect();
    arena.forget(&[900].into());
    let come = [901, 902, 903].map(|id| disc(id, [-5.0, -5.0], [1.0, 0.0], 0.2, 1.0));
    come.iter().for_each(|disc| arena.observe(*disc));
    arena.set_velocity(0, DVec2::new(1e6, 0.0));
    for (was, is) in before.iter().zip(arena.discs(Owner::Simulated)) {
        assert!(is.position.distance(was.position) < 1e-9);
    }
    for guest in arena.discs(Owner::Observed) {
        assert!(guest.position.distance(DVec2::splat(-5.0)) < 1e-9, "{guest:?}");
    }
}
