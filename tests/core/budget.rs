//! The budget: the rule, the words, and an error model that bounds what is measured afresh.

use carom::bench::budget::Budget;
use carom::bench::collision::{Encounter, arena, coefficients, meetings};
use carom::plan::budget::{
    Candidate, ErrorModel, Meetings, Way, Wish, decide, duration, parse_budget, parse_error,
};
use carom::plan::{Method, Plan};
use carom::scene::lattice::Lattice;
use carom::scene::{Scene, file};
use carom::world::{Contact, Disc, Owner, Partner, Periodic, Settings};
use glam::DVec2;

/// By how much a prediction may lie above what is measured: the margin, and what a scene differs
/// from one contact by itself.
const FACTOR: f64 = 4.0;

/// The same for methods without a step: all that they have is rounding.
const FACTOR_OF_ROUNDING: f64 = 40.0;

#[test]
fn the_model_is_what_its_command_measures() {
    let model = ErrorModel::measured();
    assert!(model.command.contains("--bench error_model"), "{}", model.command);
    let stored = [model.events, model.plain, model.ticks, model.steps, model.springs];
    let measured = coefficients().expect("every method does it");
    for (stored, measured) in stored.into_iter().zip(measured) {
        let ratio = stored / (model.margin * measured);
        println!("{stored:e}, measured {measured:e}");
        assert!((0.98..1.15).contains(&ratio), "{stored:e}, measured {measured:e}");
    }
}

#[test]
fn predictions_bound_contacts_that_they_were_not_made_from() {
    let model = ErrorModel::measured();
    let plain = Encounter::PLAIN;
    let others = [
        Encounter { radii: [0.1, 0.4], masses: [1.0, 7.0], ..plain },
        Encounter { radii: [30.0, 5.0], masses: [2.0, 2.0], speed: 0.4, ..plain },
        Encounter { speed: 250.0, masses: [0.01, 0.03], ..plain },
        Encounter { restitution: 0.7, ..plain },
        Encounter { restitution: 0.0, speed: 3.0, radii: [0.02, 0.05], ..plain },
        Encounter { at: 40.0, ..plain },
        Encounter { at: -3.0, radii: [1e-3, 1e-3], ..plain },
        Encounter { at: 1.0, radii: [1e-6, 1e-6], speed: 0.3, ..plain },
    ];
    for encounter in others {
        let meetings = encounter.meetings();
        let mut ways: Vec<Way> =
            [Method::Events, Method::Plain, Method::Ticks].map(Way::Exact).into();
        ways.extend([0.3, 0.05, 0.004].map(|way| Way::Steps(way / meetings.rate)));
        if encounter.restitution == 1.0 {
            ways.extend([0.1, 0.01].map(|way| Way::Springs((meetings.weighted / way).powi(2))));
        }
        for way in ways {
            let predicted = model.error(way, &meetings, encounter.restitution);
            let measured = encounter.error(way).expect("the method does it");
            println!("{encounter:?} {way}: {measured:e} {predicted:e}");
            let exact = matches!(way, Way::Exact(_));
            let factor = if exact { FACTOR_OF_ROUNDING } else { FACTOR };
            assert!(measured <= predicted, "{encounter:?} {way}: {measured:e} {predicted:e}");
            assert!(predicted <= factor * measured, "{way}: {measured:e} {predicted:e}");
        }
    }
}

/// Errors of the contacts of discs that have only one until then, root mean square; their number;
/// and how fast all meet.
fn errors(settings: &Settings, discs: &[Disc], way: Way, wait: f64) -> (f64, usize, Meetings) {
    let mut settings = *settings;
    settings.method = None;
    let exact = Way::Exact(Plan::of(&settings, discs).method);
    let mut judge = arena(exact, &settings, discs).expect("it suits");
    let mut contacts: Vec<Contact> = Vec::new();
    // Until every fifth disc or so has met another.
    let mut until = 0.0;
    while contacts.len() < discs.len() / 10 {
        until += wait;
        while judge.now() < until {
            judge.advance(until, &mut contacts).expect("no halt");
        }
    }
    let mut other = arena(way, &settings, discs).expect("it suits");
    while other.now() < until {
        other.pass(until).expect("no halt");
    }
    let of = |id: u32| contacts.iter().filter(|c| c.discs().any(|disc| disc == id)).count();
    let after = |arena: &carom::motion::arena::Arena| {
        let mut discs: Vec<Disc> = arena.discs(Owner::Simulated).collect();
        discs.sort_by_key(|disc| disc.id);
        discs
    };
    let (right, found) = (after(&judge), after(&other));
    let place = |id: u32| right.binary_search_by_key(&id, |disc| disc.id).expect("there");
    let (mut sum, mut count) = (0.0, 0);
    for contact in &contacts {
        let Partner::Disc(partner) = contact.b else { continue };
        // What is late must be over too.
        if contact.time > until - wait || of(contact.a) > 1 || of(partner) > 1 {
            continue;
        }
        let (a, b) = (place(contact.a), place(partner));
        let between = |discs: &[Disc]| discs[b].velocity - discs[a].velocity;
        let error = between(&found).distance(between(&right)) / between(discs).length();
        sum += error * error;
        count += 1;
    }
    ((sum / count as f64).sqrt(), count, meetings(&contacts, discs))
}

fn sorted(mut discs: Vec<Disc>) -> Vec<Disc> {
    discs.sort_by_key(|disc| disc.id);
    discs
}

fn shipped(name: &str) -> (Settings, Vec<Disc>) {
    let scene = Scene::load(name).expect("shipped");
    (scene.settings, sorted(scene.pucks.iter().map(|puck| puck.disc).collect()))
}

fn periodic_gas(area_fraction: f64, size_ratio: f64) -> (Settings, Vec<Disc>) {
    let (mass_max, walled, seed) = (4.0 * size_ratio, false, 3);
    let lattice = Lattice { count: 3000, area_fraction, size_ratio, mass_max, walled, seed };
    let (discs, side) = lattice.discs().expect("room");
    let periodic = Periodic { min: DVec2::ZERO, max: DVec2::splat(side) };
    (Settings { periodic: Some(periodic), ..Settings::default() }, sorted(discs))
}

#[test]
fn predictions_bound_contacts_of_scenes() {
    let model = ErrorModel::measured();
    let scenes = [
        ("thousand", shipped("thousand")),
        ("arena", shipped("arena")),
        ("gas at 0.3", periodic_gas(0.3, 1.4)),
        ("gas at 0.6", periodic_gas(0.6, 1.0)),
    ];
    for (name, (settings, discs)) in scenes {
        let (_, _, meetings) = errors(&settings, &discs, Way::Exact(Method::Events), 1e-3);
        for way in [0.1, 0.02, 0.002] {
            let step = way / meetings.rate;
            let (measured, count, meetings) = errors(&settings, &discs, Way::Steps(step), step);
            let predicted = model.error(Way::Steps(step), &meetings, settings.restitution);
            println!(
                "{name}, steps of {way}: {measured:.2e} of {count}, predicted {predicted:.2e}"
            );
            // Of few contacts the mean is known badly.
            if count >= 20 {
                assert!(measured <= predicted, "{name} {way}: {measured:e} {predicted:e}");
                assert!(predicted <= FACTOR * measured, "{name}: {measured:e} {predicted:e}");
            }
        }
    }
}

#[test]
fn what_chaos_makes_of_it_is_not_in_it() {
    let (settings, discs) = shipped("thousand");
    let (measured, count, meetings) = errors(&settings, &discs, Way::Exact(Method::Events), 1e-3);
    let predicted = ErrorModel::measured().error(Way::Exact(Method::Events), &meetings, 1.0);
    assert!(count > 20 && measured <= predicted, "{measured:e} {predicted:e}");
}

fn candidate(way: Way, error: f64, time: f64) -> Candidate {
    Candidate { way, error, time: Ok(time) }
}

#[test]
fn the_error_is_kept_and_the_time_gives_way() {
    let mut candidates = vec![
        candidate(Way::Exact(Method::Plain), 1e-16, 5e-3),
        candidate(Way::Exact(Method::Events), 4e-16, 1e-3),
        candidate(Way::Steps(1e-2), 1e-2, 1e-4),
        candidate(Way::Steps(1e-4), 1e-4, 1e-2),
    ];
    candidates.push(Candidate {
        way: Way::Springs(1e5),
        error: 0.0,
        time: Err("it does not do drag".into()),
    });
    let decided = |error, budget| decide(&Wish { error, budget }, &candidates).expect("a choice");
    let cases = [
        (Some(1e-6), Some(2e-3), 1, "within error 1.0e-6 and budget 2 ms"),
        (Some(0.1), Some(2e-3), 2, "steps of 1.00e-2 s: error 1.0e-2, 100 us a publish period"),
        (Some(1e-6), None, 1, "within error 1.0e-6"),
        (Some(1e-6), Some(1e-4), 1, "the budget of 100 us gives way, by 10.000 times"),
        (Some(2e-17), Some(2e-3), 0, "the error of 2.0e-17 gives way, by 5.000 times and"),
        (None, Some(6e-3), 0, "within budget 6 ms"),
        (None, Some(2e-3), 1, "within budget 2 ms"),
        (None, Some(5e-4), 2, "within budget 500 us"),
        (None, Some(5e-5), 2, "the budget of 50 us gives way, by 2.000 times"),
    ];
    for (error, budget, index, words) in cases {
        let choice = decided(error, budget);
        assert_eq!(choice.index, index, "{error:?} {budget:?}: {}", choice.verdict);
        assert!(choice.verdict.contains(words), "{}", choice.verdict);
        assert_eq!(choice.verdict.lines().count(), 1);
    }
    assert_eq!(decide(&Wish { error: Some(1.0), budget: None }, &candidates[4..]), None);
}

#[test]
fn bounds_are_read_with_their_units() {
    let budgets = [("2ms", 2e-3), ("500 us", 5e-4), ("7ns", 7e-9), ("0.1s", 0.1), ("0.002", 2e-3)];
    for (text, seconds) in budgets {
        let found = parse_budget(text).expect(text);
        assert!((found / seconds - 1.0).abs() < 1e-15, "{text}: {found}");
    }
    for text in ["", "ms", "0", "-1ms", "inf", "2 hours", "nan", "1e400s"] {
        assert!(parse_budget(text).is_err_and(|why| why.contains("2ms")), "{text}");
        assert!(parse_error(text).is_err_and(|why| why.contains("1e-6")), "{text}");
    }
    assert_eq!(parse_error("1e-6"), Ok(1e-6));
    let words =
        [(3e-9, "3 ns"), (1.5e-6, "1.5 us"), (2e-3, "2 ms"), (0.25, "250 ms"), (9.0, "9 s")];
    words.iter().for_each(|(seconds, words)| assert_eq!(duration(*seconds), *words));
}

#[test]
fn a_scene_may_ask_for_it() {
    let scene = |node: &str| file::parse(&format!("pucks: []\nnode: {{{node}}}\n"), "a.yaml");
    let wish = |node: &str| scene(node).expect(node).node.wish;
    assert_eq!(wish(""), Wish::default());
    assert_eq!(wish("error: 1e-6"), Wish { error: Some(1e-6), budget: None });
    assert_eq!(wish("budget: 2ms, error: 0.1"), Wish { error: Some(0.1), budget: Some(2e-3) });
    assert_eq!(wish("budget: 0.5"), Wish { error: None, budget: Some(0.5) });
    for (node, words) in [
        ("error: 0", "a.yaml:2:15: error = 0, must be above 0"),
        ("budget: 2 hours", "budget: must be a time above 0, such as 2ms"),
        ("budget: -1", "budget: must be a time above 0"),
    ] {
        let error = scene(node).expect_err(node).to_string();
        assert!(error.contains(words), "{error}");
    }
}

#[test]
fn a_scene_gets_the_method_that_was_chosen() {
    let mut scene = Scene::load("thousand").expect("shipped");
    assert!(Budget::of(&scene, Wish::default()).is_none());
    let wish = Wish { error: Some(1e-6), budget: Some(1.0) };
    let budget = Budget::of(&scene, wish).expect("a decision");
    budget.apply(&mut scene);
    // The steps that would keep it take thousands of times as long.
    assert_eq!(scene.settings.method, Some(Method::Events), "{}", budget.verdict());
    let refused = |method| {
        let found = budget.candidates.iter().find(|candidate| candidate.way.method() == method);
        found.expect("listed").time.clone().expect_err("no time")
    };
    assert!(refused(Method::Plain).contains("400 pucks"));
    assert!(refused(Method::Springs).contains("observed circles"));
    // Who names a method has it, with the step that keeps the error.
    let mut scene = Scene::load("teams").expect("shipped");
    scene.settings.method = Some(Method::Steps);
    let budget = Budget::of(&scene, Wish { error: Some(0.01), budget: None }).expect("a decision");
    budget.apply(&mut scene);
    assert_eq!((budget.candidates.len(), scene.settings.method), (1, Some(Method::Steps)));
    assert!(scene.settings.pace.step < 1.0 / 60.0, "{:?}", scene.settings.pace);
    assert!(budget.candidates[0].error <= 0.01 * (1.0 + 1e-12));
    assert!(Budget::of(&Scene::load("resolver").expect("shipped"), wish).is_none());
}
