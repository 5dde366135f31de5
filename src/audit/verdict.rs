//! What happened to a group of discs between two samples.
//!
//! Two discs alone are read directly ([`super::judge`]). Several contacts are held against what the
//! law foretells from the earlier sample: agreement proves them all. Where it fails, each contact
//! in turn is taken for the only wrong one: the law leads to it from the earlier sample, and
//! backwards to it from the later one, and if both meet there, it is read like a collision of two
//! discs alone. What remains is judged by what no contact may change, or counted as ambiguous.

use std::collections::{HashMap, HashSet};

use glam::DVec2;

use super::findings::{Collision, Kind, Kinds, Met, Sight, Violation};
use super::flight::{Course, Flight, Span};
use super::groups::Groups;
use super::judge::{Encounter, JUDGED, Seen, VAGUE};
use super::law::{Law, Source};
use super::noise::Sigma;
use super::sequel::{Rules, Sequel, Touch};
use super::surroundings::Surroundings;
use crate::world::{Disc, Side, Walls};

/// Part of the fastest speed that a foretold velocity may be unsure by and still prove something.
const SURE: f64 = 0.02;

/// How often a group is widened before it is called unlawful.
const ROUNDS: usize = 4;

/// Contacts of a group that are each taken for the only wrong one, at most.
const SUSPECTS: usize = 24;

/// What became of a group.
#[derive(Clone, Debug)]
pub(super) enum Verdict {
    /// These collisions.
    Collisions(Vec<Collision>),
    /// These, and a violation that is no collision.
    Violated(Vec<Collision>, Violation),
    /// One disc met a segment, and nobody else was near.
    AtSegment(Collision),
    /// One disc changed its velocity without a partner.
    Alone(usize),
    /// One disc is a little elsewhere than its velocities say.
    Displaced,
    /// Cannot be told.
    Ambiguous,
}

impl Verdict {
    /// Whether an impulse from somebody else would explain what is wrong.
    fn is_doubtful(&self) -> bool {
        let by_others = |kind| !matches!(kind, Kind::Energy | Kind::Sticking | Kind::Late);
        match self {
            Self::Collisions(collisions) => collisions.iter().any(|each| {
                each.kinds.iter().any(by_others) || each.b == Met::Wall && !each.kinds.is_empty()
            }),
            Self::Violated(_, violation) => by_others(violation.kind) || violation.discs.len() > 2,
            _ => false,
        }
    }

    /// Whether nothing is wrong but that velocities changed when discs overlapped already.
    fn is_only_late(&self) -> bool {
        match self {
            Self::Collisions(collisions) => {
                collisions.iter().all(|each| each.kinds.is_empty() || only_late(each.kinds))
            }
            _ => false,
        }
    }

    /// Whether all that happened is as the law says.
    pub fn is_lawful(&self) -> bool {
        match self {
            Self::Collisions(collisions) => collisions.iter().all(|each| each.kinds.is_empty()),
            Self::AtSegment(collision) => collision.kinds.is_empty(),
            Self::Violated(..) | Self::Alone(_) | Self::Ambiguous => false,
            // Nobody is at fault for a hair.
            Self::Displaced => true,
        }
    }
}

/// Who judges the time between two samples.
#[derive(Clone, Copy)]
pub(super) struct Court<'a> {
    pub flights: &'a [Flight],
    pub span: &'a Span,
    pub law: &'a Law,
    pub surroundings: &'a Surroundings,
    /// Flights of discs to which anything may have happened.
    pub unbound: &'a [usize],
    pub tolerance: f64,
    /// Of the earlier sample, s.
    pub time: f64,
}

impl Court<'_> {
    /// Judges all groups. One that is not lawful is judged again together with the disturbed discs
    /// around it: contacts in quick succession may have looked like one.
    pub fn judge_all(&self, found: &Groups) -> Vec<(Vec<usize>, Verdict)> {
        let mut judged: Vec<(Vec<usize>, Verdict)> = Vec::new();
        for group in &found.groups {
            judged.push((group.clone(), self.judge(group)));
        }
        if judged.iter().all(|(_, verdict)| verdict.is_lawful()) {
            return judged;
        }
        let around = Around::new(found, self.flights);
        let mut k = 0;
        while k < judged.len() {
            if !judged[k].1.is_lawful() && self.law.restitution.is_some() {
                self.judge_with_others(&mut judged, k, &around);
            }
            k += 1;
        }
        for k in 0..judged.len() {
            // Whose neighbours cannot be told apart either may have met them.
            if judged[k].1.is_doubtful() && !around.unlawful_near(&judged, k).is_empty() {
                judged[k].1 = Verdict::Ambiguous;
            }
        }
        for k in 0..judged.len() {
            if matches!(judged[k].1, Verdict::Alone(_)) && self.is_beside_unlawful(&judged, k) {
                judged[k].1 = Verdict::Ambiguous;
            }
        }
        judged.retain(|(group, _)| !group.is_empty());
        judged
    }

    /// Whether a disc that changed alone is beside a group that is not lawful: some engines answer
    /// contacts before they are there.
    fn is_beside_unlawful(&self, judged: &[(Vec<usize>, Verdict)], k: usize) -> bool {
        let others = judged.iter().enumerate().filter(|(m, (_, verdict))| {
            *m != k && !verdict.is_lawful() && !matches!(verdict, Verdict::Alone(_))
        });
        let alone = &judged[k].0;
        others.flat_map(|(_, (group, _))| group).any(|&other| {
            alone.iter().any(|&disc| {
                let (a, b) = (&self.flights[disc], &self.flights[other]);
                let way = 2.0 * self.fastest(&[disc, other]) * self.span.length;
                self.law.apart(a, b).length() <= a.before.radius + b.before.radius + way
            })
        })
    }

    /// Judges a group with more and more of those around it, until all is lawful; else it stays.
    fn judge_with_others(&self, judged: &mut [(Vec<usize>, Verdict)], k: usize, around: &Around) {
        let mut members = vec![k];
        for round in 0..=ROUNDS {
            if round == 0 && self.joins(judged, &members, k, around) {
                return;
            }
            let others = around.groups_near(judged, &members);
            let alone = |m: &usize| [members.as_slice(), &[*m]].concat();
            let mut wider: Vec<Vec<usize>> = others.iter().map(alone).collect();
            if others.is_empty() {
                return;
            }
            members.extend(others);
            wider.push(members.clone());
            if wider.iter().any(|members| self.joins(judged, members, k, around)) {
                return;
            }
        }
    }

    /// Makes one group of several if that is lawful, in the place of `k`; or if it is late, and
    /// what was said of `k` alone is worse than that.
    fn joins(
        &self,
        judged: &mut [(Vec<usize>, Verdict)],
        members: &[usize],
        k: usize,
        around: &Around,
    ) -> bool {
        let mut group: Vec<usize> =
            members.iter().flat_map(|&m| judged[m].0.iter().copied()).collect();
        group.sort_unstable();
        // Whoever was hit too weakly to be seen may have hit others.
        for group in [around.with_quiet(&group), group] {
            let sequel = self.follow(&group, None).filter(|each| self.agrees(each, &group));
            if let Some(sequel) = sequel {
                let verdict = Verdict::Collisions(self.foretold(&sequel, &group));
                if !verdict.is_lawful() && judged[k].1.is_only_late() {
                    continue;
                }
                members.iter().for_each(|&m| judged[m].0.clear());
                judged[k] = (group, verdict);
                return true;
            }
        }
        false
    }

    /// Judges a group.
    fn judge(&self, group: &[usize]) -> Verdict {
        match *group {
            [k] => self.single(k),
            [i, j] => self.pair(i, j),
            _ => self.several(group).unwrap_or(Verdict::Ambiguous),
        }
    }

    fn walls_are_known(&self) -> bool {
        self.law.walls_source != Source::Unknown
    }

    pub(super) fn place(&self, flight: &Flight, instant: f64) -> DVec2 {
        let fall = flight.fall(self.law);
        flight.before.position + (flight.before.velocity + 0.5 * fall * instant) * instant
    }

    /// Two discs.
    fn pair(&self, i: usize, j: usize) -> Verdict {
        let (a, b) = (&self.flights[i], &self.flights[j]);
        let encounter = Encounter::new(a, b, self.span.length, self.law);
        let seen = encounter.look(self.tolerance);
        let (kinds, wrong) = encounter.judge(&seen, self.law.restitution, self.tolerance);
        let tangled = [a, b].into_iter().any(|flight| flight.course == Course::Tangled);
        let collision = || self.collision((a, b), &seen, kinds, wrong, Sight::Alone);
        if kinds.is_empty() && !tangled {
            return Verdict::Collisions(vec![collision()]);
        }
        match self.several(&[i, j]) {
            Some(lawful) if lawful.is_lawful() => lawful,
            Some(late) if late.is_only_late() && (tangled || !only_late(kinds)) => late,
            _ if tangled && !self.walls_are_known() => Verdict::Ambiguous,
            // A wall may have taken what is missing.
            _ if kinds.iter().any(Kind::is_of_momentum) && self.walls_may_have_given(&[i, j]) => {
                Verdict::Ambiguous
            }
            _ => Verdict::Collisions(vec![collision()]),
        }
    }

    /// Whether walls that these discs may have touched can have given all the momentum that came
    /// in: each only inwards along its normal.
    fn walls_may_have_given(&self, group: &[usize]) -> bool {
        let Some(walls) = &self.law.walls else { return false };
        let flights = || group.iter().map(|&k| &self.flights[k]);
        let reach = self.fastest(group) * self.span.length;
        let mut left: DVec2 = flights().map(|f| f.before.mass * f.change).sum();
        for side in [Side::Left, Side::Right, Side::Bottom, Side::Top] {
            let near = |f: &Flight| walls.gap(side, &f.before) <= 0.05 * f.before.radius + reach;
            let given = left.dot(-side.normal());
            if flights().any(near) && given > 0.0 {
                left += given * side.normal();
            }
        }
        let sigma: f64 = flights().map(|f| f.before.mass * f.sigma.of_change()).sum();
        let moved: f64 = flights().map(|f| f.before.mass * f.change.length()).sum();
        left.length() <= JUDGED * sigma + self.tolerance * moved
    }

    /// A collision of two discs as it was seen.
    pub fn collision(
        &self,
        (a, b): (&Flight, &Flight),
        seen: &Seen,
        kinds: Kinds,
        wrong: f64,
        sight: Sight,
    ) -> Collision {
        let law = self.law.restitution.unwrap_or(f64::NAN);
        let place = self.place(a, seen.instant) + seen.normal * a.before.radius;
        let squared = 0.5 * seen.reduced_mass * seen.approach * seen.approach;
        let moved = |Flight { before, change, .. }: &Flight| {
            if before.mass.is_finite() { before.mass * change.length() } else { 0.0 }
        };
        let exchanged = seen.impulse.max(moved(a)).max(moved(b));
        Collision {
            time: self.time + self.span.seconds_at(seen.instant, self.law.drag),
            a: a.before.id,
            b: Met::Disc(b.before.id),
            place,
            normal: seen.normal,
            before: [a.before.velocity, b.before.velocity],
            approach: seen.approach,
            gap: seen.gap.0,
            momentum: seen.momentum.0 / exchanged.max(f64::MIN_POSITIVE),
            energy: seen.energy,
            energy_law: (law * law - 1.0) * squared,
            restitution: seen.restitution,
            angle: seen.angle,
            wrong,
            smaller_radius: a.before.radius.min(b.before.radius),
            window: self.span.seconds,
            sight,
            kinds,
        }
    }

    /// Several discs with several contacts; `None` where nothing can be told.
    fn several(&self, group: &[usize]) -> Option<Verdict> {
        self.law.restitution?;
        let sequel = self.follow(group, None)?;
        if self.agrees(&sequel, group) {
            return Some(Verdict::Collisions(self.foretold(&sequel, group)));
        }
        self.single_out(group, &sequel).or_else(|| self.conserved(group, &sequel))
    }

    fn rules(&self) -> Rules<'_> {
        let walls: Option<&Walls> = self.law.walls.as_ref();
        Rules {
            restitution: self.law.restitution.unwrap_or(1.0),
            walls,
            wall_restitution: walls.map_or(1.0, |walls| walls.restitution),
            walls_sigma: self.law.walls_sigma,
            periodic: self.law.periodic.as_ref(),
            gravity: self.law.gravity,
            blind: None,
            until_contact: usize::MAX,
        }
    }

    fn start(&self, group: &[usize]) -> Sequel {
        let discs = group.iter().map(|&k| self.flights[k].before).collect();
        Sequel::new(discs, group.iter().map(|&k| self.flights[k].sigma).collect())
    }

    /// What the law foretells; two discs may be blind for each other.
    pub(super) fn follow(&self, group: &[usize], blind: Option<(usize, usize)>) -> Option<Sequel> {
        self.start(group).follow(self.span.length, &Rules { blind, ..self.rules() })
    }

    fn fastest(&self, group: &[usize]) -> f64 {
        let speed = |k: &usize| {
            let Flight { before, after, .. } = &self.flights[*k];
            before.velocity.length().max(after.velocity.length())
        };
        group.iter().map(speed).fold(0.0, f64::max)
    }

    /// Whether the later sample is what was foretold.
    pub(super) fn agrees(&self, sequel: &Sequel, group: &[usize]) -> bool {
        let recorded = |k: &usize| (self.flights[*k].after, self.flights[*k].sigma);
        let later: Vec<(Disc, Sigma)> = group.iter().map(recorded).collect();
        let both = sequel.discs.iter().zip(&sequel.errors).zip(&later);
        both.into_iter().all(|((disc, error), (after, sigma))| {
            self.is_same((disc, error), (after, sigma), self.fastest(group))
        })
    }

    fn is_same(&self, a: (&Disc, &Sigma), b: (&Disc, &Sigma), fastest: f64) -> bool {
        let allowed = |x: f64, y: f64| JUDGED * (x + y);
        let slack = self.tolerance * fastest + self.law.driven(self.span.length);
        let speed = allowed(a.1.velocity, b.1.velocity) + slack;
        let place = allowed(a.1.position, b.1.position) + slack * self.span.length;
        a.0.velocity.distance(b.0.velocity) <= speed && a.0.position.distance(b.0.position) <= place
    }

    /// The collisions on the way, all lawful but for those of discs that overlapped already.
    pub(super) fn foretold(&self, sequel: &Sequel, group: &[usize]) -> Vec<Collision> {
        let touches = sequel.touches.iter();
        touches.map(|touch| self.foretold_one(touch, group)).collect()
    }

    fn foretold_one(&self, touch: &Touch, group: &[usize]) -> Collision {
        let id = |k: usize| self.flights[group[k]].before.id;
        let restitution = match touch.b {
            Some(_) => self.law.restitution,
            None => self.law.walls.map(|walls| walls.restitution),
        };
        let mut collision = Collision {
            time: self.time + self.span.seconds_at(touch.time, self.law.drag),
            a: id(touch.a),
            b: touch.b.map_or(Met::Wall, |b| Met::Disc(id(b))),
            place: touch.place,
            normal: touch.normal,
            before: touch.before,
            approach: touch.approach,
            gap: -touch.depth,
            momentum: 0.0,
            energy: touch.energy,
            energy_law: touch.energy,
            restitution: (restitution.unwrap_or(f64::NAN), f64::NAN),
            angle: (0.0, f64::NAN),
            wrong: 0.0,
            smaller_radius: self.smaller_radius(touch, group),
            window: self.span.seconds,
            sight: Sight::Foretold,
            kinds: Kinds::default(),
        };
        if self.is_late(touch, group) {
            // No flight leads there, so it is not foretold: it was told by what came of it.
            let sigma = (1.0 + collision.restitution.0) * touch.errors.velocity / touch.approach;
            collision.restitution.1 = sigma;
            collision.sight = Sight::Singled;
            collision.kinds.add(Kind::Late);
        }
        collision
    }

    /// Whether two discs overlapped when they answered, by more than what is no violation.
    fn is_late(&self, touch: &Touch, group: &[usize]) -> bool {
        let allowed = self.tolerance * self.smaller_radius(touch, group);
        touch.depth > allowed.max(JUDGED * touch.errors.position)
    }

    fn smaller_radius(&self, touch: &Touch, group: &[usize]) -> f64 {
        let radius = |k: usize| self.flights[group[k]].before.radius;
        touch.b.map_or(f64::INFINITY, radius).min(radius(touch.a))
    }

    /// The one contact that is not lawful, if all others are.
    fn single_out(&self, group: &[usize], sequel: &Sequel) -> Option<Verdict> {
        if sequel.touches.len() > SUSPECTS {
            return None;
        }
        let suspects = sequel.touches.iter().enumerate();
        let pairs = suspects.filter_map(|(k, touch)| Some((k, touch, touch.b?)));
        for (k, touch, b) in pairs {
            let found =
                self.unseen(group, touch, b).or_else(|| self.wrong_one(group, k, (touch.a, b)));
            if found.is_some() {
                return found;
            }
        }
        None
    }

    /// The verdict that two discs did not see each other, if that explains the later sample.
    fn unseen(&self, group: &[usize], touch: &Touch, b: usize) -> Option<Verdict> {
        let blind = (touch.a.min(b), touch.a.max(b));
        let sequel = self.follow(group, Some(blind))?;
        if !self.agrees(&sequel, group) {
            return None;
        }
        let (first, second) = (&self.flights[group[touch.a]], &self.flights[group[b]]);
        let apart = self.law.apart_after(first, second).length();
        let through = apart >= first.before.radius + second.before.radius;
        let violation = Violation {
            kind: if through { Kind::Tunnelling } else { Kind::Missed },
            also: Vec::new(),
            time_s: self.time + self.span.seconds_at(touch.time, self.law.drag),
            discs: vec![first.before.id, second.before.id],
            wall: false,
            place_m: touch.place.to_array(),
            approach_speed_mps: touch.approach,
            severity: 1.0,
            detail: "one of several collisions between two samples".to_owned(),
        };
        Some(Verdict::Violated(self.foretold(&sequel, group), violation))
    }

    /// The verdict on a contact, if the law leads to it from both sides.
    fn wrong_one(&self, group: &[usize], k: usize, (a, b): (usize, usize)) -> Option<Verdict> {
        let rules = Rules { until_contact: k, ..self.rules() };
        let early = self.start(group).follow(self.span.length, &rules)?;
        let instant = self.until(&early, group, k)?;
        let length = self.span.length - instant;
        let blind = Some((a.min(b), a.max(b)));
        let late = self
            .backwards(group, length, 0.0, blind)
            .filter(|late| self.meet(group, &early, late, (a, b)));
        // The two may have met again after it: then only the last hair of time is flown freely.
        let hair = (1e-6 * self.span.length + 4e-9).min(length);
        let late = late.or_else(|| {
            let late = self.backwards(group, length - hair, hair, None)?;
            self.meet(group, &early, &late, (a, b)).then_some(late)
        })?;
        Some(self.singled(group, (a, b), instant, (&early, &late)))
    }

    /// Whether both ways lead to the same place, and to the same velocities but of two discs.
    fn meet(&self, group: &[usize], early: &Sequel, late: &Sequel, pair: (usize, usize)) -> bool {
        let fastest = self.fastest(group);
        if early.unsure().max(late.unsure()) > SURE * fastest {
            return false;
        }
        early.discs.iter().zip(&late.discs).enumerate().all(|(place, (x, y))| {
            let met = place == pair.0 || place == pair.1;
            let y = if met { Disc { velocity: x.velocity, ..*y } } else { *y };
            self.is_same((x, &early.errors[place]), (&y, &late.errors[place]), fastest)
        })
    }

    /// The contact between both ways, and the others on them.
    fn singled(
        &self,
        group: &[usize],
        (a, b): (usize, usize),
        instant: f64,
        (early, late): (&Sequel, &Sequel),
    ) -> Verdict {
        let flight = |place: usize| Flight {
            before: early.discs[place],
            after: Disc { velocity: late.discs[place].velocity, ..early.discs[place] },
            change: late.discs[place].velocity - early.discs[place].velocity,
            rest: DVec2::ZERO,
            course: Course::Bent(0.0),
            sigma: wider(early.errors[place], late.errors[place]),
        };
        let (first, second) = (flight(a), flight(b));
        let encounter = Encounter::new(&first, &second, 0.0, self.law);
        let seen = encounter.look(self.tolerance);
        let (kinds, wrong) = encounter.judge(&seen, self.law.restitution, self.tolerance);
        let mut collision = self.collision((&first, &second), &seen, kinds, wrong, Sight::Singled);
        collision.time = self.time + self.span.seconds_at(instant, self.law.drag);
        let touches = early.touches.iter().chain(&late.touches);
        let others = touches.map(|touch| self.foretold_one(touch, group));
        Verdict::Collisions(others.chain([collision]).collect())
    }

    /// When the contact comes before which the law was followed, s after the earlier sample.
    fn until(&self, early: &Sequel, group: &[usize], k: usize) -> Option<f64> {
        let whole = self.follow(group, None)?;
        let touch = whole.touches.get(k)?;
        (early.touches.len() == k).then_some(touch.time)
    }

    /// The group from the later sample backwards by `length`, then by `hair` without any contact;
    /// its velocities forwards again. Two discs may be blind for each other.
    fn backwards(
        &self,
        group: &[usize],
        length: f64,
        hair: f64,
        blind: Option<(usize, usize)>,
    ) -> Option<Sequel> {
        let (pairs, walls) = (self.rules().restitution, self.rules().wall_restitution);
        if pairs <= 0.0 || walls <= 0.0 {
            return None;
        }
        let reversed = |k: &usize| {
            let after = &self.flights[*k].after;
            Disc { velocity: -after.velocity, ..*after }
        };
        let errors = group.iter().map(|&k| self.flights[k].sigma).collect();
        let start = Sequel::new(group.iter().map(reversed).collect(), errors);
        let rules = Rules {
            restitution: pairs.recip(),
            wall_restitution: walls.recip(),
            blind,
            ..self.rules()
        };
        let mut late = start.follow(length, &rules)?;
        for disc in &mut late.discs {
            disc.position += disc.velocity * hair;
            disc.velocity = -disc.velocity;
        }
        for touch in &mut late.touches {
            let factor = if touch.b.is_some() { pairs } else { walls };
            touch.time = self.span.length - touch.time;
            touch.approach /= factor;
            touch.energy = -touch.energy;
        }
        Some(late)
    }

    /// Whether the same discs meet if they are larger or smaller by what their places are unsure.
    fn is_clear(&self, group: &[usize], sequel: &Sequel) -> bool {
        let place = sequel.errors.iter().map(|error| error.position).fold(0.0, f64::max);
        [-JUDGED * place, JUDGED * place].into_iter().all(|by| {
            let mut start = self.start(group);
            start.discs.iter_mut().for_each(|disc| disc.radius = (disc.radius + by).max(0.0));
            let other = start.follow(self.span.length, &self.rules());
            other.is_some_and(|other| other.touches.len() == sequel.touches.len())
        })
    }

    /// What no contact may change: the momentum of all, energy that only shrinks, and at last the
    /// law itself, where the foretelling is sure.
    fn conserved(&self, group: &[usize], sequel: &Sequel) -> Option<Verdict> {
        let flights = || group.iter().map(|&k| &self.flights[k]);
        let walled = sequel.touches.iter().any(|touch| touch.b.is_none())
            || self.walls_may_have_given(group);
        let fixed = flights().any(|flight| flight.before.mass.is_infinite());
        if !self.walls_are_known() {
            return None;
        }
        let gained: DVec2 = flights().map(|f| f.before.mass * f.change).sum();
        let moved: f64 = flights().map(|f| f.before.mass * f.change.length()).sum();
        let sigma: f64 = flights().map(|f| f.before.mass * f.sigma.of_change()).sum();
        let momentum = gained.length() > JUDGED * sigma + self.tolerance * moved;
        let energy: f64 = flights().map(gain).sum();
        let speed = self.fastest(group);
        let slack: f64 = flights().map(|f| f.before.mass * speed * f.sigma.of_change()).sum();
        let all: f64 = flights().map(|f| f.before.kinetic_energy()).sum();
        let gains = energy > JUDGED * slack + self.tolerance * all;
        let unsure = sequel.unsure();
        let kind = match (momentum && !walled && !fixed, gains) {
            (true, _) => Kind::Momentum,
            (false, true) => Kind::Energy,
            _ if unsure <= SURE * speed && self.is_clear(group, sequel) => Kind::Cluster,
            _ => return None,
        };
        let wrong = sequel.discs.iter().zip(flights());
        let wrong = wrong.map(|(disc, f)| disc.velocity.distance(f.after.velocity));
        let foretold = sequel.discs.iter().map(|disc| disc.velocity.length()).fold(speed, f64::max);
        let severity = wrong.fold(0.0, f64::max) / foretold.max(f64::MIN_POSITIVE);
        let violation = Violation {
            kind,
            also: Vec::new(),
            time_s: self.time,
            discs: flights().map(|flight| flight.before.id).collect(),
            wall: walled,
            place_m: flights().next().map_or([0.0; 2], |f| f.before.position.to_array()),
            approach_speed_mps: sequel.touches.first().map_or(0.0, |touch| touch.approach),
            severity,
            detail: format!(
                "{} collisions between two samples; energy {energy:+.3e} J",
                sequel.touches.len()
            ),
        };
        Some(Verdict::Violated(Vec::new(), violation))
    }
}

/// Which discs came near a disturbed one.
struct Around {
    disturbed: HashMap<usize, Vec<usize>>,
    quiet: HashMap<usize, Vec<usize>>,
}

impl Around {
    fn new(found: &Groups, flights: &[Flight]) -> Self {
        let [mut disturbed, mut quiet] = [(); 2].map(|()| HashMap::<usize, Vec<usize>>::new());
        for &(i, j) in &found.near {
            for (one, other) in [(i, j), (j, i)] {
                match (flights[one].course, flights[other].is_disturbed()) {
                    (Course::Bent(_) | Course::Tangled, true) => &mut disturbed,
                    (Course::Quiet, true) => &mut quiet,
                    _ => continue,
                }
                .entry(other)
                .or_default()
                .push(one);
            }
        }
        Self { disturbed, quiet }
    }

    /// These and the undisturbed ones around them, in ascending order.
    fn with_quiet(&self, group: &[usize]) -> Vec<usize> {
        let quiet = group.iter().filter_map(|disc| self.quiet.get(disc)).flatten();
        let mut all: Vec<usize> = group.iter().chain(quiet).copied().collect();
        all.sort_unstable();
        all.dedup();
        all
    }

    /// Groups beside these with a disc near one of theirs.
    fn groups_near(&self, judged: &[(Vec<usize>, Verdict)], members: &[usize]) -> Vec<usize> {
        let discs = members.iter().flat_map(|&m| &judged[m].0);
        let near: HashSet<usize> =
            discs.filter_map(|disc| self.disturbed.get(disc)).flatten().copied().collect();
        let near = |group: &[usize]| group.iter().any(|disc| near.contains(disc));
        (0..judged.len()).filter(|m| !members.contains(m) && near(&judged[*m].0)).collect()
    }

    /// Groups beside this one that are not lawful either.
    fn unlawful_near(&self, judged: &[(Vec<usize>, Verdict)], k: usize) -> Vec<usize> {
        let mut beside = self.groups_near(judged, &[k]);
        beside.retain(|&m| !judged[m].1.is_lawful());
        beside
    }
}

fn only_late(kinds: Kinds) -> bool {
    kinds == Kinds::only(Kind::Late)
}

/// Whether a collision says nothing about restitution.
pub(super) fn is_vague(collision: &Collision) -> bool {
    let sigma = collision.restitution.1;
    collision.sight != Sight::Foretold && (sigma.is_nan() || sigma > VAGUE)
}

/// Kinetic energy gained, J.
pub(super) fn gain(flight: &Flight) -> f64 {
    flight.after.kinetic_energy() - flight.before.kinetic_energy()
}

fn wider(a: Sigma, b: Sigma) -> Sigma {
    Sigma { position: a.position + b.position, velocity: a.velocity + b.velocity }
}
