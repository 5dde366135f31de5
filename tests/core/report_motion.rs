//! The report's figures of motion: what they say of errors could be wrong; it is held here, and
//! that a wrong method would be found out.

use carom::report::figures::fit::power_law;
use carom::report::figures::gas::{self, Measured, Stretch, Who};
use carom::report::figures::mover::{self, Mover, Scene};
use carom::report::judge::retell;
use carom::world::{Contact, Partner};

/// A small gas, so that errors are small before order is lost.
fn stretch() -> Stretch {
    Stretch::new(60, 0.3, 1.0).expect("a gas that the judge agrees with")
}

fn contacts(scene: &Scene) -> Vec<Contact> {
    let mut arena = Mover::Plain.arena(scene).expect("an arena");
    mover::contacts(&mut arena, scene.until).expect("a run")
}

fn measured(movers: &[Mover]) -> Measured {
    let movers: Vec<Who> = movers.iter().copied().map(Who::Own).collect();
    Measured::new((60, 0.3, 1.0), &movers, 1, |_| ()).expect("a measured gas")
}

#[test]
fn the_judge_agrees_with_the_plain_method_and_with_no_other_story() {
    let stretch = stretch();
    let scene = &stretch.scene;
    assert!(stretch.plain.worst < 1e-14, "{:?}", stretch.plain);
    assert!(stretch.growth > 10.0 && stretch.growth < 1e6, "{}", stretch.growth);
    let truth = contacts(scene);
    let tell = |contacts: &[Contact]| {
        retell(&scene.settings, &scene.discs, contacts, scene.until).map(|_| ())
    };
    assert_eq!(tell(&truth), Ok(()));
    // Without any one contact, the two overlap later, or something else does not come about.
    for k in [0, 1, truth.len() / 2, truth.len() - 1] {
        let mut missing = truth.clone();
        missing.remove(k);
        assert!(tell(&missing).is_err(), "without contact {k}");
    }
    let mut turned = truth.clone();
    turned.swap(0, 1);
    assert!(tell(&turned).is_err());
    let mut other = truth.clone();
    let pair = other.iter().position(|contact| matches!(contact.b, Partner::Disc(_)));
    let pair = pair.expect("a pair");
    other[pair].b = Partner::Disc((other[pair].a + 1) % 60);
    assert!(tell(&other).is_err());
}

#[test]
fn a_rough_method_that_calls_itself_exact_is_found_out() {
    let stretch = stretch();
    let mut arena = Mover::Steps(1.0 / 64e3).arena(&stretch.scene).expect("an arena");
    mover::pass(&mut arena, 1.0).expect("a run");
    let ended = gas::ended(&stretch, &mover::discs(&arena));
    let events = Who::Own(Mover::Events);
    let error = gas::judge(events, &ended, &stretch).expect_err("steps are not exact");
    assert!(error.contains("events"), "{error}");
    // Nor is one that is so in place, but not in energy.
    let energy = 1e-9;
    let right = gas::Ended { error: stretch.plain, energy, ..ended };
    assert!(gas::judge(events, &right, &stretch).is_err());
    assert!(gas::judge(events, &gas::Ended { energy: 0.0, ..right }, &stretch).is_ok());
}

#[test]
fn steps_are_of_first_order_and_springs_of_the_half() {
    let rates = [4e3, 16e3, 64e3, 256e3];
    let stiff = [1e8, 1e10, 1e12];
    let springs = |stiffness| Mover::Springs { stiffness, step: 1.0 / 240.0 };
    let steps = rates.map(|rate| Mover::Steps(1.0 / rate));
    let gas = measured(&[&steps[..], &stiff.map(springs)].concat());
    let errors: Vec<f64> = gas.rows.iter().map(|row| row.ended.error.rms).collect();
    let points =
        |x: &[f64], y: &[f64]| x.iter().copied().zip(y.iter().copied()).collect::<Vec<_>>();
    let (order, _) = power_law(&points(&rates, &errors[..4]));
    assert!((-1.2..-0.8).contains(&order), "{order}: {errors:?}");
    let (order, _) = power_law(&points(&stiff, &errors[4..]));
    assert!((-0.6..-0.4).contains(&order), "{order}: {errors:?}");
}

#[test]
fn errors_of_the_gas_are_the_same_bits_in_every_run() {
    let movers = [
        Mover::Events,
        Mover::Ticks(1.0 / 60.0),
        Mover::Steps(1.0 / 240.0),
        Mover::Springs { stiffness: 1e6, step: 1.0 / 240.0 },
    ];
    let ended = |gas: &Measured| gas.rows.iter().map(|row| row.ended).collect::<Vec<_>>();
    assert_eq!(ended(&measured(&movers)), ended(&measured(&movers)));
}
