//! Lists of near pairs: judged by all pairs, whatever happens to the discs; the wide loops by the
//! plain ones, to the last bit.

use carom::motion::near::Near;
use carom::motion::near::cells::Cells;
use carom::motion::near::lanes::{Centre, Entries, Flight, Look, Pairs};
use carom::world::Periodic;
use glam::DVec2;

use crate::common::Random;

fn around(side: f64) -> Periodic {
    Periodic { min: DVec2::splat(-1.0), max: DVec2::splat(side - 1.0) }
}

fn difference(places: &[DVec2], i: usize, j: usize, periodic: Option<&Periodic>) -> DVec2 {
    let d = places[j] - places[i];
    periodic.map_or(d, |periodic| d + periodic.shift(d))
}

fn sorted(pairs: &Pairs) -> Vec<(usize, usize)> {
    let mut sorted: Vec<_> = pairs.iter().collect();
    sorted.sort_unstable();
    sorted
}

/// Pairs with a gap up to a margin; those whose gap is that to rounding may be missing.
fn due(
    places: &[DVec2],
    radii: &[f64],
    margin: f64,
    box_: Option<&Periodic>,
) -> Vec<(usize, usize)> {
    let all = (0..places.len()).flat_map(|i| (i + 1..places.len()).map(move |j| (i, j)));
    let near = |&(i, j): &(usize, usize)| {
        let reach = radii[i] + radii[j] + margin;
        difference(places, i, j, box_).length() <= reach * (1.0 - 1e-12)
    };
    all.filter(near).collect()
}

fn crowd(random: &mut Random, count: usize, side: f64, equal: bool) -> (Vec<DVec2>, Vec<f64>) {
    let places =
        (0..count).map(|_| DVec2::new(random.uniform(-1.0, side), random.uniform(-1.0, side)));
    let places: Vec<DVec2> = places.collect();
    let radius = |k: usize| if k % 40 == 7 { 1.9 } else { 0.2 + 0.01 * (k % 20) as f64 };
    (places, (0..count).map(|k| if equal { 0.25 } else { radius(k) }).collect())
}

#[test]
fn cells_list_each_near_pair_once() {
    let mut random = Random::new(91);
    for count in [0, 1, 2, 20, 30, 200, 700] {
        for side in [9.0, 30.0, 1e4] {
            for (equal, box_) in [(true, None), (false, None), (true, Some(around(side)))] {
                let (places, radii) = crowd(&mut random, count, side, equal);
                let (mut cells, mut pairs) = (Cells::new(box_), Pairs::default());
                for margin in [0.0, 0.3, 2.0] {
                    cells.list(&places, &radii, margin, &mut pairs).expect("few");
                    let found = sorted(&pairs);
                    assert!(found.windows(2).all(|two| two[0] != two[1]), "each once");
                    for pair in due(&places, &radii, margin, box_.as_ref()) {
                        assert!(found.binary_search(&pair).is_ok(), "{pair:?} of {count}");
                    }
                }
            }
        }
    }
}

#[test]
fn lists_leave_nobody_out_while_discs_fly_and_jump() {
    let mut random = Random::new(92);
    for (equal, box_) in
        [(true, None), (false, None), (true, Some(around(20.0))), (false, Some(around(20.0)))]
    {
        let (mut places, radii) = crowd(&mut random, 150, 20.0, equal);
        let mut near = Near::new(box_);
        let mut pairs = Pairs::default();
        let mut velocities: Vec<DVec2> = places.iter().map(|_| random.vector(1.0)).collect();
        for step in 0..1_500 {
            let speed = if (600..700).contains(&step) { 30.0 } else { 1.0 };
            let mut ways = [0.0, 0.0];
            for (place, velocity) in places.iter_mut().zip(&mut velocities) {
                let way = *velocity * (0.01 * speed);
                *place += way;
                ways = [
                    f64::max(ways[0], way.length()),
                    f64::max(ways[1], f64::min(ways[0], way.length())),
                ];
                if random.below(40) == 0 {
                    *velocity = random.vector(1.0);
                }
            }
            let closer = if step % 300 == 299 { f64::INFINITY } else { 2.0 * ways[0] };
            if step % 300 == 299 {
                places[step % 150] = DVec2::splat(3.0);
            }
            let margin = 0.05 * (step % 3) as f64;
            let none: Option<fn(usize, usize) -> bool> = None;
            near.within(&places, &radii, (margin, closer), none, &mut pairs).expect("few");
            let found = sorted(&pairs);
            for pair in due(&places, &radii, margin, box_.as_ref()) {
                assert!(found.binary_search(&pair).is_ok(), "{pair:?} at {step}");
            }
        }
    }
}

#[test]
fn pairs_that_do_not_count_are_left_out() {
    let places = vec![DVec2::ZERO; 6];
    let (mut near, mut pairs) = (Near::new(None), Pairs::default());
    let even = Some(|i: usize, j: usize| (i + j).is_multiple_of(2));
    near.within(&places, &[1.0; 6], (0.0, 0.0), even, &mut pairs).expect("few");
    assert_eq!(sorted(&pairs), [(0, 2), (0, 4), (1, 3), (1, 5), (2, 4), (3, 5)]);
}

#[test]
fn wide_loops_have_the_bits_of_plain_ones() {
    let mut random = Random::new(93);
    for round in 0..200 {
        let count = 2 + random.below(60);
        let scale = if round % 10 == 9 { 1e-150 } else { 1.0 };
        let (mut places, radii) = crowd(&mut random, count, 6.0, false);
        places.iter_mut().for_each(|place| *place *= scale);
        let wrap = (round % 3 == 0).then_some(DVec2::new(7.0, 6.5));
        let radii_of_look = if round % 2 == 0 { &radii[..] } else { &[] };
        let look = Look { places: &places, radii: radii_of_look, reach: 0.8, margin: 0.3, wrap };
        let mut all = Pairs::default();
        for i in 0..count as u32 {
            (i + 1..count as u32).for_each(|j| all.push(i, j));
        }
        all.seal(count);
        let (mut wide, mut plain) = (Pairs::default(), Pairs::default());
        all.select(&look, &mut wide);
        all.select_one_by_one(&look, &mut plain);
        assert!(wide.iter().eq(plain.iter()));
        let mut entries = Entries::default();
        entries.resize(count);
        (0..count).for_each(|k| entries.set(k, places[k], radii[k], (count - k) as u32));
        let centre = Centre { place: places[0], reach: 0.9, disc: 1, wrap };
        let (mut wide, mut plain) = (Pairs::default(), Pairs::default());
        entries.scan(&centre, 1..count, &mut wide);
        entries.scan_one_by_one(&centre, 1..count, &mut plain);
        assert!(wide.iter().eq(plain.iter()));
        let velocities: Vec<DVec2> = places.iter().map(|_| random.vector(1.0)).collect();
        let began: Vec<f64> = places.iter().map(|_| random.uniform(0.0, 9.0)).collect();
        let inside = (DVec2::ZERO, DVec2::splat(4.0));
        let (starts, velocities, began) = (&places, &velocities, &began);
        let flight = Flight { starts, velocities, began, now: 9.0, step: 0.3, inside };
        let (mut there, mut outside) = (vec![DVec2::ZERO; count], Vec::new());
        flight.fly(&mut there, &mut outside);
        let (mut there_plain, mut outside_plain) = (vec![DVec2::ZERO; count], Vec::new());
        flight.fly_one_by_one(0, &mut there_plain, &mut outside_plain);
        assert_eq!((there, outside), (there_plain, outside_plain));
    }
}

#[test]
#[should_panic = "indices of discs"]
fn a_list_of_others_is_no_list() {
    let mut pairs = Pairs::default();
    pairs.push(0, 7);
    pairs.seal(7);
}
