//! The low parts of states: discs on a line against a simulation in 1500 bits, a gas against its
//! own mirror image, the search in plain doubles against the precise one.

use carom::detect::precise::{Doubt, Sight, pair_impact};
use carom::exact::{DoubleDouble, DoubleDoubleVec};
use carom::world::{Contact, Disc, Partner, Settings, Side, Walls};
use dashu_float::FBig;
use dashu_ratio::RBig;
use glam::DVec2;

use crate::common::{Random, arena, disc, run, states};

fn rational(x: f64) -> RBig {
    RBig::try_from(x).expect("finite")
}

fn big(x: f64) -> FBig {
    rational(x).to_float(1500).value()
}

fn double(x: &FBig) -> f64 {
    x.to_f64().value()
}

/// Who met whom (the wall as `None`), when, and how fast.
struct Event {
    pair: (u32, Option<u32>),
    time: f64,
    approach_speed: f64,
}

/// Discs on a line, by x, right of a wall if there is one: gaps and speeds carried on in 1500 bits.
/// The velocities after, too.
fn line(
    discs: &[Disc],
    restitution: f64,
    wall: Option<f64>,
    most: usize,
) -> (Vec<Event>, Vec<f64>) {
    let mut v: Vec<FBig> = discs.iter().map(|d| big(d.velocity.x)).collect();
    let mut gaps: Vec<FBig> = discs
        .windows(2)
        .map(|d| big(d[1].position.x) - big(d[0].position.x) - big(d[0].radius) - big(d[1].radius))
        .collect();
    let first = &discs[0];
    // The last gap is that to the wall, if there is one.
    gaps.extend(wall.map(|x| big(first.position.x) - big(first.radius) - big(x)));
    let mass: Vec<FBig> = discs.iter().map(|d| big(d.mass)).collect();
    let (e, mut time, mut events) = (big(restitution), big(0.0), Vec::new());
    while events.len() < most {
        let closing = |k: usize, v: &[FBig]| {
            if k + 1 < v.len() { &v[k] - &v[k + 1] } else { -v[0].clone() }
        };
        let waits = (0..gaps.len()).filter(|&k| closing(k, &v) > big(0.0));
        let waits = waits.map(|k| (&gaps[k] / closing(k, &v), k));
        let Some((wait, k)) = waits.min_by(|a, b| a.0.partial_cmp(&b.0).expect("ordered")) else {
            break;
        };
        time += &wait;
        for (l, gap) in gaps.iter_mut().enumerate() {
            *gap -= &wait * closing(l, &v);
        }
        let w = closing(k, &v);
        gaps[k] = big(0.0);
        let (approach_speed, time) = (double(&w), double(&time));
        if k + 1 < v.len() {
            let kick = (big(1.0) + &e) * &w / (&mass[k] + &mass[k + 1]);
            v[k] = &v[k] - &kick * &mass[k + 1];
            v[k + 1] = &v[k + 1] + &kick * &mass[k];
            let pair = (discs[k].id, Some(discs[k + 1].id));
            events.push(Event { pair, time, approach_speed });
        } else {
            v[0] = w;
            events.push(Event { pair: (first.id, None), time, approach_speed });
        }
    }
    (events, v.iter().map(double).collect())
}

/// Every contact is the judge's: who, when to a few u, how fast to so much of itself.
fn compare(contacts: &[Contact], judge: &[Event], relative: f64) {
    assert_eq!(contacts.len(), judge.len());
    for (k, (contact, event)) in contacts.iter().zip(judge).enumerate() {
        let with = match contact.b {
            Partner::Disc(b) => Some(b),
            Partner::Wall(side) => {
                assert_eq!(side, Side::Left);
                None
            }
            Partner::Segment(_) => panic!("no segments here"),
        };
        assert_eq!((contact.a, with), event.pair, "contact {k}");
        let late = contact.time - event.time;
        assert!(late.abs() <= 4.0 * f64::EPSILON * event.time, "contact {k}: {late:e} s late");
        let wrong = (contact.approach_speed / event.approach_speed - 1.0).abs();
        assert!(wrong <= relative, "contact {k} at {}: {wrong:e}", event.approach_speed);
    }
}

#[test]
fn slow_followers_keep_their_time() {
    // Cradles whose discs leave each contact nearly together: a gap rounded to u of the coordinate
    // would be met at the wrong time, by u over a small relative speed.
    let mut random = Random::new(201);
    let mut seen = 0;
    for _ in 0..40 {
        let restitution = random.uniform(0.4, 0.95);
        let mut x = random.uniform(-3.0, 3.0);
        let mut discs = vec![disc(0, [x, 1.0], [1.0, 0.0], 0.5, 1.0)];
        for id in 1..3 + random.below(5) as u32 {
            let radius = random.uniform(0.2, 0.6);
            x += discs[id as usize - 1].radius + radius + 10f64.powf(random.uniform(-6.0, -1.0));
            discs.push(disc(id, [x, 1.0], [0.0; 2], radius, random.uniform(0.5, 2.0)));
        }
        let (judge, _) = line(&discs, restitution, None, 1_000);
        let settings = Settings { restitution, ..Settings::default() };
        let until = 1.5 * judge.last().expect("a blow").time;
        compare(&run(&mut arena(&settings, &discs), until), &judge, 1e-12);
        seen += judge.len();
    }
    assert!(seen > 300, "{seen}");
}

#[test]
fn a_light_disc_between_a_wall_and_a_heavy_one_keeps_every_digit() {
    for (ratio, collisions) in [(1e4, 314), (1e8, 31_415)] {
        let discs =
            [disc(0, [1.5, 2.0], [0.0; 2], 0.5, 1.0), disc(1, [4.7, 2.0], [-0.9, 0.0], 0.7, ratio)];
        let (judge, velocities) = line(&discs, 1.0, Some(0.0), usize::MAX);
        assert_eq!(judge.len(), collisions);
        let walls = Walls { min: DVec2::ZERO, max: DVec2::new(1e4, 4.0), restitution: 1.0 };
        let settings = Settings { walls: Some(walls), ..Settings::default() };
        let mut arena = arena(&settings, &discs);
        let contacts = run(&mut arena, 2.0 * judge[collisions - 1].time);
        compare(&contacts, &judge, 1e-12);
        for (after, v) in states(&arena).iter().zip(velocities) {
            assert!((after.velocity.x / v - 1.0).abs() <= 2.0 * f64::EPSILON, "{ratio}");
        }
    }
}

#[test]
fn a_free_collapse_is_followed_to_its_end() {
    // Gaps and speeds shrink far below what any coordinates could tell. With the frame at rest and
    // with one that moves, in which the velocities do not shrink.
    for (restitution, frame, most) in [(0.05, 0.0, 150), (0.0717, 0.0, 300), (0.0717, 0.3, 300)] {
        let at = |id, x, v: f64| disc(id, [x, 1.0], [v + frame, 0.0], 0.5, 1.0);
        let discs = [at(0, 0.0, 1.0), at(1, 1.5, 0.0), at(2, 3.5, -1.0)];
        let (judge, _) = line(&discs, restitution, None, most);
        assert_eq!(judge.len(), most);
        let settings = Settings { restitution, ..Settings::default() };
        let mut arena = arena(&settings, &discs);
        let contacts = run(&mut arena, 4.0);
        assert!((most..1_000).contains(&contacts.len()), "{} contacts", contacts.len());
        // Close to the end clocks tell contacts apart no more, and groups are reflected together.
        let apart = |k: &usize| judge[*k].time - judge[k - 1].time > 1e-14;
        let known = (1..most).take_while(apart).count();
        compare(&contacts[..known], &judge[..known], 1e-9);
        let late = contacts.last().expect("contacts").time - judge[most - 1].time;
        assert!((0.0..1e-8).contains(&late), "{late:e}");
    }
}

#[test]
fn mirror_images_in_a_box_off_the_origin_stay_so() {
    // Mirrored places round differently there: in doubles the images part after some ten
    // collisions of each disc.
    let mut random = Random::new(203);
    for _ in 0..4 {
        let (height, mut discs) = (8.0, Vec::new());
        let coarse = |x: f64| (x * f64::from(1 << 20)).round() / f64::from(1 << 20);
        while discs.len() < 16 {
            let [x, y] =
                [(0.5, 7.5), (0.5, 3.5)].map(|(low, high)| coarse(random.uniform(low, high)));
            let v = [(); 2].map(|()| coarse(random.uniform(-1.0, 1.0)));
            let id = discs.len() as u32;
            let pair = [
                disc(id, [x, y], v, 0.5, 1.0),
                disc(id + 1, [x, height - y], [v[0], -v[1]], 0.5, 1.0),
            ];
            if discs.iter().all(|d: &Disc| d.position.distance(pair[0].position) > 1.01) {
                discs.extend(pair);
            }
        }
        let walls = Walls { min: DVec2::ZERO, max: DVec2::splat(height), restitution: 1.0 };
        let settings = Settings { walls: Some(walls), ..Settings::default() };
        let mut arena = arena(&settings, &discs);
        while arena.contacts() < 160 {
            let until = arena.now() + 0.1;
            run(&mut arena, until);
        }
        for pair in states(&arena).chunks_exact(2) {
            let (a, b) = (pair[0].position, pair[1].position);
            let apart = (a.x - b.x).abs().max((a.y + b.y - height).abs());
            assert!(apart <= 1e-14, "{apart:e} after {} contacts", arena.contacts());
        }
    }
}

#[test]
fn the_search_in_doubles_misses_nobody() {
    let mut random = Random::new(205);
    let mut met = 0;
    for _ in 0..200_000 {
        let s = random.uniform(0.2, 2.0);
        let far = 10f64.powf(random.uniform(-15.0, 3.0));
        let d = random.direction() * (s + far * s);
        // Towards it, at any impact parameter up to and around grazing.
        let aside = (s / d.length()) * (1.0 + random.wide(16.0).clamp(-1.0, 1e-3));
        let speed = random.wide(6.0).abs();
        let w = -(d.normalize() + d.perp().normalize() * aside) * speed;
        let doubt = Doubt {
            position: 10f64.powf(random.uniform(-17.0, -9.0)),
            velocity: speed * 10f64.powf(random.uniform(-17.0, -9.0)),
        };
        let sight = Sight { d: d.into(), w: w.into(), reach: DoubleDouble::from(s) };
        let Some(time) = pair_impact(&sight) else { continue };
        met += 1;
        // As plain doubles may see it, within the doubt.
        let mut off = |size: f64| random.vector(0.99 * size);
        let (d, w) = (d + off(doubt.position), w + off(doubt.velocity));
        assert!(doubt.may_meet_within(d, w, s, time), "{d} {w} {s} {time}");
    }
    assert!(met > 50_000, "{met}");
}

#[test]
fn low_parts_are_kept_by_sums_products_and_quotients() {
    let mut random = Random::new(206);
    let exact = |x: DoubleDouble| rational(x.hi) + rational(x.lo);
    for _ in 0..20_000 {
        let mut any = || {
            let hi = random.wide(10.0);
            DoubleDouble::sum(hi, hi * random.uniform(-1.1e-16, 1.1e-16))
        };
        let (a, b, c, d) = (any(), any(), any(), any());
        let near = |found: DoubleDouble, wanted: RBig, of: RBig| {
            let error = (exact(found) - wanted).to_f64().value().abs();
            let bound = 16.0 * 2f64.powi(-106) * of.to_f64().value().abs();
            assert!(error <= bound, "{error:e} > {bound:e}");
        };
        let absolute = |x: RBig| if x < RBig::ZERO { -x } else { x };
        near(a.times_double(b.hi), exact(a) * rational(b.hi), exact(a) * rational(b.hi));
        near(a.squared(), exact(a) * exact(a), exact(a) * exact(a));
        near(a.over(b), exact(a) / exact(b), exact(a) / exact(b));
        near(a.minus(b), exact(a) - exact(b), absolute(exact(a)) + absolute(exact(b)));
        let (p, q) = (DoubleDoubleVec { x: a, y: b }, DoubleDoubleVec { x: c, y: d });
        let terms = absolute(exact(a) * exact(c)) + absolute(exact(b) * exact(d));
        near(p.dot(q), exact(a) * exact(c) + exact(b) * exact(d), terms);
        let terms = absolute(exact(a) * exact(d)) + absolute(exact(b) * exact(c));
        near(p.cross(q), exact(a) * exact(d) - exact(b) * exact(c), terms);
        assert_eq!(exact(a.scaled(0.25)) * rational(4.0), exact(a));
    }
}
