//! One contact by itself over a step, whatever the step: free flight to it, the closed form, free
//! flight from it.
//!
//! Along the line of centres the spring-dashpot runs in closed form; the turning of that line is
//! split off around it (half a turn, the contact, half a turn: Strang), with the angular momentum
//! kept. So a central blow and a wall are exact, and an oblique contact is of second order in the
//! angle turned, at any stiffness.
//!
//! Never look at a third body here.

use glam::DVec2;

use super::Laws;
use super::links::{Link, Other};
use super::oscillator::{Ending, Oscillator};
use crate::detect::impact::pair_impact_at_any_scale;
use crate::resolve::pair::MassFractions;
use crate::world::{Disc, limits};

/// What a contact did within a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Work {
    /// Between whom.
    pub link: Link,
    /// When it began, or the start of the step, s from there.
    pub begins: f64,
    /// Speed of approach then, m/s.
    pub approach_speed: f64,
    /// Normal then.
    pub normal: DVec2,
    /// Centre of the first disc then, m.
    pub centre: DVec2,
    /// Along the normal, N s.
    pub impulse: f64,
    /// Energy that motion and spring have lost, J.
    pub loss: f64,
    /// Deepest overlap, m.
    pub deepest: f64,
}

/// Largest angle turned at a time, rad.
const TURN: f64 = 0.02;

/// Two discs as one: where the second is seen from the first, and how it moves.
#[derive(Clone, Copy, Debug)]
struct Relative {
    d: DVec2,
    w: DVec2,
}

/// How the contact of a step went.
struct Course {
    begins: f64,
    approach_speed: f64,
    normal: DVec2,
    deepest: f64,
}

/// Moves the discs of one link by `h` (s); `None` when they do not touch on the way.
pub fn fly(discs: &mut [Disc], link: Link, laws: &Laws, h: f64) -> Option<Work> {
    let before = discs[link.a];
    let (velocity, stored) = (link.velocity(discs), link.stored(discs, laws));
    let Outcome { course, change } = match link.b {
        Other::Disc(b) => fly_pair(discs, link.a, b, laws, h),
        Other::Wall(_) => fly_to_wall(discs, link, laws, h),
    }?;
    let (a, b) = link.inverse_masses(discs);
    let change_squared = velocity.length_squared() - link.velocity(discs).length_squared();
    Some(Work {
        link,
        begins: course.begins,
        approach_speed: course.approach_speed,
        normal: course.normal,
        centre: before.position + before.velocity * course.begins,
        impulse: change / (a + b),
        loss: 0.5 * change_squared / (a + b) + stored - link.stored(discs, laws),
        deepest: course.deepest,
    })
}

/// A course and the change of relative velocity that it brought, along its normal.
struct Outcome {
    course: Course,
    change: f64,
}

fn fly_pair(discs: &mut [Disc], a: usize, b: usize, laws: &Laws, h: f64) -> Option<Outcome> {
    let (first, second) = (discs[a], discs[b]);
    let start =
        Relative { d: second.position - first.position, w: second.velocity - first.velocity };
    let inverse_mass = 1.0 / first.mass + 1.0 / second.mass;
    let spring = Oscillator::new(laws.stiffness, laws.damping, inverse_mass);
    let reach = first.radius + second.radius;
    let (end, course) = start.flow(reach, &spring, laws.ending, h);
    let fractions = MassFractions::of(first.mass, second.mass);
    let (d, w) = (end.d - (start.d + start.w * h), end.w - start.w);
    discs[a].position += first.velocity * h - d * fractions.a.hi;
    discs[a].velocity -= w * fractions.a.hi;
    discs[b].position += second.velocity * h + d * fractions.b.hi;
    discs[b].velocity += w * fractions.b.hi;
    course.map(|course| Outcome { change: w.dot(course.normal), course })
}

fn fly_to_wall(discs: &mut [Disc], link: Link, laws: &Laws, h: f64) -> Option<Outcome> {
    let normal = link.normal(discs);
    let (overlap, speed) = (link.overlap(discs, laws), discs[link.a].velocity.dot(normal));
    let disc = &mut discs[link.a];
    let spring = Oscillator::new(laws.stiffness, laws.damping, 1.0 / disc.mass);
    let begins = if overlap >= 0.0 { 0.0 } else { -overlap / speed };
    let free = disc.position + disc.velocity * h;
    let x = overlap.max(0.0);
    if !(begins >= 0.0 && begins < h) || ended(&spring, x, speed, laws.ending) {
        disc.position = free;
        return None;
    }
    let lasts = spring.end(x, speed, laws.ending).min(h - begins);
    let (x_end, v_end) = spring.after(x, speed, lasts);
    let travel = (x_end - overlap) + v_end * (h - begins - lasts);
    disc.position = free + normal * (travel - speed * h);
    disc.velocity += normal * (v_end - speed);
    let deepest = deepest(&spring, x, speed, lasts);
    let course = Course { begins, approach_speed: speed, normal, deepest };
    Some(Outcome { change: speed - v_end, course })
}

/// Whether a contact with this overlap and rate exerts nothing any more, or nothing yet.
fn ended(spring: &Oscillator, x: f64, v: f64, ending: Ending) -> bool {
    let push = match ending {
        Ending::OverlapGone => x,
        Ending::NoAttraction => spring.push(x, v).min(x.max(v)),
    };
    push < 0.0 || (push == 0.0 && v <= 0.0)
}

fn deepest(spring: &Oscillator, x: f64, v: f64, lasts: f64) -> f64 {
    spring.after(x, v, spring.deepest(x, v).min(lasts)).0.max(x)
}

impl Relative {
    /// The state `h` later, and the contact on the way.
    fn flow(
        mut self,
        reach: f64,
        spring: &Oscillator,
        ending: Ending,
        h: f64,
    ) -> (Self, Option<Course>) {
        let mut left = h;
        let mut overlap = reach - self.d.length();
        if overlap < 0.0 {
            let impact = pair_impact_at_any_scale(self.d, self.w, reach);
            let Some(time) = impact.filter(|&time| time < left) else { return self.free(h) };
            self.d += self.w * time;
            left -= time;
            overlap = 0.0;
        }
        let mut course: Option<Course> = None;
        for _ in 0..4 * limits::TURNS_PER_STEP {
            let normal = self.normal();
            let v = -self.w.dot(normal);
            if left <= 0.0 || ended(spring, overlap, v, ending) {
                break;
            }
            let begins = h - left;
            course.get_or_insert(Course { begins, approach_speed: v, normal, deepest: 0.0 });
            let lasts = self.part(normal, left, h).min(spring.end(overlap, v, ending));
            let deep = deepest(spring, overlap, v, lasts);
            course.iter_mut().for_each(|course| course.deepest = course.deepest.max(deep));
            overlap = self.press(normal, overlap, spring, lasts, reach);
            left -= lasts;
            if lasts == 0.0 {
                break;
            }
        }
        self.d += self.w * left;
        (self, course)
    }

    fn free(self, h: f64) -> (Self, Option<Course>) {
        (Self { d: self.d + self.w * h, ..self }, None)
    }

    /// Unit vector between the centres; coincident ones move apart as they move.
    fn normal(&self) -> DVec2 {
        let along = self.d.try_normalize().or(self.w.try_normalize());
        along.unwrap_or(DVec2::X)
    }

    /// How much of what is left goes at a time.
    fn part(&self, normal: DVec2, left: f64, h: f64) -> f64 {
        let turn = self.w.dot(normal.perp()).abs() / self.d.length();
        let time = (TURN / turn).max(h / limits::TURNS_PER_STEP as f64);
        if time < left { time } else { left }
    }

    /// Turns half, runs the contact along the line of centres, turns half; returns the overlap.
    fn press(
        &mut self,
        normal: DVec2,
        overlap: f64,
        spring: &Oscillator,
        time: f64,
        reach: f64,
    ) -> f64 {
        let (r, across) = (reach - overlap, self.w.dot(normal.perp()));
        let v = -self.w.dot(normal);
        if across == 0.0 || r <= 0.0 {
            let (x, v_end) = spring.after(overlap, v, time);
            self.d = normal * (reach - x);
            self.w += normal * (v - v_end);
            return x;
        }
        // The centrifugal part of the motion widens r; angular momentum r * across stays.
        let half = 0.5 * time;
        let (x, v_end) = spring.after(overlap, v - across * across / r * half, time);
        let r_end = reach - x;
        let across_end = if r_end > 0.0 { across * (r / r_end) } else { across };
        let turned = (across / r + if r_end > 0.0 { across_end / r_end } else { 0.0 }) * half;
        let v_end = v_end - if r_end > 0.0 { across_end * across_end / r_end * half } else { 0.0 };
        let normal = DVec2::from_angle(turned).rotate(normal);
        self.d = normal * r_end;
        self.w = normal * -v_end + normal.perp() * across_end;
        x
    }
}
