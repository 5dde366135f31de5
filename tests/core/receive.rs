//! Receiving: good circles pass, bad ones are named.

use carom::messages::{CircleState, CircleStates, Contact, Header, Time, Twist};
use carom::receive::{BadCircle, report, wanted};

fn circle(id: u32) -> CircleState {
    CircleState { id, x: 1.0, y: 2.0, vx: 3.0, vy: 4.0, radius: 0.5, mass: 1.0 }
}

fn message(circles: Vec<CircleState>) -> CircleStates {
    let stamp = Time { sec: 7, nanosec: 500_000_000 };
    CircleStates { header: Header { stamp, frame_id: "map".into() }, circles, ..Default::default() }
}

/// The error text for one changed circle among two good ones.
fn refusal(change: impl Fn(&mut CircleState)) -> String {
    let mut bad = circle(2);
    change(&mut bad);
    let (report, refused) = report(&message(vec![circle(1), bad, circle(3)])).expect("few");
    assert_eq!(report.discs.iter().map(|d| d.id).collect::<Vec<_>>(), [1, 3]);
    assert_eq!(refused.len(), 1);
    assert_eq!(refused[0].0, bad.id);
    refused[0].1.to_string()
}

#[test]
fn bad_numbers_are_named_and_the_others_kept() {
    assert_eq!(refusal(|c| c.x = f64::NAN), "x = NaN, must be a finite number");
    assert_eq!(refusal(|c| c.y = f64::INFINITY), "y = inf, must be a finite number");
    assert_eq!(refusal(|c| c.vx = f64::NEG_INFINITY), "vx = -inf, must be a finite number");
    assert_eq!(refusal(|c| c.vy = f64::NAN), "vy = NaN, must be a finite number");
    assert_eq!(refusal(|c| c.radius = f64::INFINITY), "radius = inf, must be a finite number");
    assert_eq!(refusal(|c| c.radius = 0.0), "radius = 0, must be above 0 m");
    assert_eq!(refusal(|c| c.radius = -1.0), "radius = -1, must be above 0 m");
    for mass in [0.0, -0.0, -2.0, f64::NAN, f64::NEG_INFINITY] {
        assert!(refusal(|c| c.mass = mass).ends_with("must be above 0 kg (inf = fixed)"));
    }
    assert!(refusal(|c| c.id = Contact::WALL).contains("wall"));
    assert_eq!(refusal(|c| c.vy = -1e61), "vy = -1e61, must be 1e60 at most");
    assert!(refusal(|c| c.mass = 1e61).ends_with("must be 1e60 at most"));
    assert!(refusal(|c| c.radius = 1e-61).ends_with("must be 1e-60 at least"));
}

#[test]
fn an_infinite_mass_is_a_fixed_circle() {
    let (report, refused) =
        report(&message(vec![CircleState { mass: f64::INFINITY, ..circle(1) }])).expect("few");
    assert!(refused.is_empty() && report.discs[0].mass.is_infinite() && report.time == 7.5);
}

#[test]
fn of_duplicates_none_is_taken() {
    let twin = CircleState { x: 9.0, ..circle(4) };
    let (report, refused) = report(&message(vec![circle(4), circle(1), twin, twin])).expect("few");
    assert_eq!(report.discs.iter().map(|d| d.id).collect::<Vec<_>>(), [1]);
    assert_eq!(refused, [(4, BadCircle::Duplicate { count: 3 })]);
}

#[test]
fn oversized_messages_are_refused_whole() {
    let error = report(&message(vec![circle(1); 200_001])).expect_err("too many");
    assert!(error.to_string().contains("200001 circles"));
}

#[test]
fn commands_must_be_finite() {
    let mut twist = Twist::default();
    twist.linear.x = 1.5;
    assert_eq!(wanted(&twist).expect("finite").linear.x, 1.5);
    twist.linear.y = f64::NAN;
    assert_eq!(wanted(&twist).expect_err("NaN").field, "linear.y");
}

#[test]
fn stamps_round_to_the_nearest_nanosecond() {
    assert_eq!(Time::from_seconds(1.25), Time { sec: 1, nanosec: 250_000_000 });
    assert_eq!(Time::from_seconds(0.999_999_999_9), Time { sec: 1, nanosec: 0 });
    assert_eq!(Time::from_seconds(1e300), Time { sec: i32::MAX, nanosec: 0 });
}
