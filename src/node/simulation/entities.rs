//! Pucks as simulation_interfaces sees them: entities with a state, a category, tags and bounds;
//! and the filters that pick some of them.
//!
//! Everything lies in the plane: heights are ignored, and bounds are taken by their shadow on it.

use glam::DVec2;
use regex_lite::Regex;

use super::wire::{
    Bounds, EntityCategory, EntityFilters, EntityInfo, EntityState, TagsFilter, bounds, category,
};
use crate::messages::{Header, Pose, Quaternion, Twist, Vector3};
use crate::node::stage::Stage;
use crate::scene::Puck;
use crate::world::Disc;

/// Longest filter, bytes.
const FILTER_BYTES: usize = 4_096;

/// What a puck is.
pub fn info(stage: &Stage, puck: &Puck) -> EntityInfo {
    let tags = [
        (puck.driven, "driven"),
        (puck.disc.mass.is_infinite(), "fixed"),
        (stage.was_spawned(puck), "spawned"),
    ];
    EntityInfo {
        category: EntityCategory { category: category_of(puck) },
        description: format!("puck of {} m and {} kg", puck.disc.radius, puck.disc.mass),
        tags: tags.iter().filter(|(is, _)| *is).map(|(_, tag)| (*tag).to_owned()).collect(),
    }
}

fn category_of(puck: &Puck) -> u8 {
    match (puck.driven, puck.disc.mass.is_infinite()) {
        (true, _) => category::ROBOT,
        (false, true) => category::STATIC_OBJECT,
        (false, false) => category::DYNAMIC_OBJECT,
    }
}

/// Where a puck is and how fast.
pub fn state(header: Header, disc: &Disc) -> EntityState {
    let flat = |vector: DVec2| Vector3 { x: vector.x, y: vector.y, z: 0.0 };
    EntityState {
        header,
        pose: Pose { position: flat(disc.position), orientation: Quaternion::UPRIGHT },
        twist: Twist { linear: flat(disc.velocity), ..Twist::default() },
        acceleration: Twist::default(),
    }
}

/// What a puck occupies, seen from its centre: exactly a sphere.
pub fn bounds_of(puck: &Puck) -> Bounds {
    let radius = Vector3 { x: puck.disc.radius, y: 0.0, z: 0.0 };
    Bounds { kind: bounds::SPHERE, points: vec![Vector3::default(), radius] }
}

/// The pucks that a filter lets through, by id, as they are now.
///
/// # Errors
/// What is wrong with the filter.
pub fn filtered<'a>(
    stage: &'a Stage,
    filters: &EntityFilters,
) -> Result<Vec<(&'a Puck, Disc)>, String> {
    let name = pattern(&filters.filter)?;
    let area = Area::of(&filters.bounds)?;
    if filters.tags.filter_mode > 1 {
        return Err(format!("filter_mode {} is none: 0 = any, 1 = all", filters.tags.filter_mode));
    }
    let kind = |puck: &Puck| {
        let wanted = |kind: &EntityCategory| kind.category == category_of(puck);
        filters.categories.is_empty() || filters.categories.iter().any(wanted)
    };
    let tags = |puck: &Puck| has_tags(&info(stage, puck).tags, &filters.tags);
    let mut found = stage.now();
    found.retain(|(puck, disc)| {
        name.as_ref().is_none_or(|name| name.is_match(&puck.name))
            && kind(puck)
            && tags(puck)
            && area.overlaps(disc)
    });
    Ok(found)
}

fn pattern(filter: &str) -> Result<Option<Regex>, String> {
    if filter.is_empty() {
        return Ok(None);
    }
    if filter.len() > FILTER_BYTES {
        return Err(format!("filter: longer than {FILTER_BYTES} bytes"));
    }
    let wrong = |error| format!("filter `{filter}`: {error}").replace('\n', " ");
    Regex::new(filter).map(Some).map_err(wrong)
}

/// Whether some, or all, of the tags asked for are there.
pub fn has_tags(tags: &[String], wanted: &TagsFilter) -> bool {
    let has = |tag: &String| tags.contains(tag);
    match (wanted.tags.is_empty(), wanted.filter_mode) {
        (true, _) => true,
        (false, 0) => wanted.tags.iter().any(has),
        (false, _) => wanted.tags.iter().all(has),
    }
}

/// Part of the plane.
enum Area {
    Everywhere,
    Circle(DVec2, f64),
    /// Convex, its corners against the clock.
    Polygon(Vec<DVec2>),
}

impl Area {
    fn of(bounds: &Bounds) -> Result<Self, String> {
        let points: Vec<DVec2> = bounds.points.iter().map(|p| DVec2::new(p.x, p.y)).collect();
        if !points.iter().all(|point| point.is_finite()) {
            return Err("bounds: every number must be finite".to_owned());
        }
        match (bounds.kind, &points[..]) {
            (bounds::EMPTY, _) => Ok(Self::Everywhere),
            (bounds::SPHERE, [centre, radius]) if radius.x >= 0.0 => {
                Ok(Self::Circle(*centre, radius.x))
            }
            (bounds::BOX, [high, low]) => {
                let (min, max) = (high.min(*low), high.max(*low));
                let corners = [min, DVec2::new(max.x, min.y), max, DVec2::new(min.x, max.y)];
                Ok(Self::Polygon(corners.to_vec()))
            }
            (bounds::CONVEX_HULL, [_, _, _, ..]) => Ok(Self::Polygon(hull(points))),
            (bounds::SPHERE | bounds::BOX | bounds::CONVEX_HULL, _) => {
                Err("bounds: a sphere is a centre and a point with the radius as its x, a box two \
                 corners, a hull three points or more"
                    .to_owned())
            }
            (kind, _) => Err(format!("bounds: there is no type {kind}")),
        }
    }

    fn overlaps(&self, disc: &Disc) -> bool {
        match self {
            Self::Everywhere => true,
            Self::Circle(centre, radius) => disc.position.distance(*centre) <= radius + disc.radius,
            Self::Polygon(corners) => distance(corners, disc.position) <= disc.radius,
        }
    }
}

/// The corners of the convex hull against the clock (Andrew's monotone chain).
fn hull(mut points: Vec<DVec2>) -> Vec<DVec2> {
    points.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    points.dedup();
    if points.len() == 1 {
        return points;
    }
    let chain = |points: &mut dyn Iterator<Item = &DVec2>| {
        let mut corners: Vec<DVec2> = Vec::new();
        for &point in points {
            while let [.., a, b] = corners[..]
                && (b - a).perp_dot(point - b) <= 0.0
            {
                corners.pop();
            }
            corners.push(point);
        }
        // The last one begins the other chain.
        corners.pop();
        corners
    };
    let mut corners = chain(&mut points.iter());
    corners.extend(chain(&mut points.iter().rev()));
    corners
}

/// Distance of a point from a convex polygon; 0 inside.
fn distance(corners: &[DVec2], point: DVec2) -> f64 {
    let next = corners.iter().cycle().skip(1);
    let edges: Vec<(DVec2, DVec2)> = corners.iter().copied().zip(next.copied()).collect();
    let left_of = |&(a, b): &(DVec2, DVec2)| (b - a).perp_dot(point - a) >= 0.0;
    if corners.len() > 2 && edges.iter().all(left_of) {
        return 0.0;
    }
    let to_edge = |(a, b): (DVec2, DVec2)| {
        let along = b - a;
        let part = (point - a).dot(along) / along.length_squared();
        // A point is an edge too.
        let part = if part.is_finite() { part.clamp(0.0, 1.0) } else { 0.0 };
        point.distance(a + along * part)
    };
    edges.into_iter().map(to_edge).fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area(kind: u8, points: &[[f64; 2]]) -> Result<Area, String> {
        let points = points.iter().map(|[x, y]| Vector3 { x: *x, y: *y, z: 7.0 }).collect();
        Area::of(&Bounds { kind, points })
    }

    fn disc(x: f64, y: f64, radius: f64) -> Disc {
        Disc { id: 1, position: DVec2::new(x, y), velocity: DVec2::ZERO, radius, mass: 1.0 }
    }

    #[test]
    fn bounds_overlap_discs() {
        let square = area(bounds::BOX, &[[1.0, 1.0], [-1.0, -1.0]])
            .unwrap_or_else(|error| panic!("{error:?}"));
        assert!(square.overlaps(&disc(0.0, 0.0, 0.1)));
        assert!(square.overlaps(&disc(1.5, 0.0, 0.5)));
        assert!(!square.overlaps(&disc(1.5, 1.5, 0.7)));
        assert!(square.overlaps(&disc(1.5, 1.5, 0.8)));
        let circle = area(bounds::SPHERE, &[[1.0, 0.0], [2.0, 9.0]])
            .unwrap_or_else(|error| panic!("{error:?}"));
        assert!(circle.overlaps(&disc(4.0, 0.0, 1.0)) && !circle.overlaps(&disc(4.1, 0.0, 1.0)));
        // Corners in any order, and one inside.
        let corners = [[0.0, 0.0], [2.0, 2.0], [2.0, 0.0], [1.5, 0.5], [1.0, 0.2]];
        let triangle =
            area(bounds::CONVEX_HULL, &corners).unwrap_or_else(|error| panic!("{error:?}"));
        assert!(triangle.overlaps(&disc(1.8, 0.3, 0.01)));
        assert!(!triangle.overlaps(&disc(0.0, 2.0, 1.4)));
        assert!(triangle.overlaps(&disc(0.0, 2.0, 1.42)));
        assert!(
            area(bounds::EMPTY, &[])
                .unwrap_or_else(|error| panic!("{error:?}"))
                .overlaps(&disc(9.0, 9.0, 1.0))
        );
    }

    #[test]
    fn bounds_that_are_none_are_refused() {
        for (kind, points) in [
            (bounds::SPHERE, &[[0.0, 0.0]][..]),
            (bounds::SPHERE, &[[0.0, 0.0], [-1.0, 0.0]]),
            (bounds::BOX, &[[0.0, 0.0]]),
            (bounds::CONVEX_HULL, &[[0.0, 0.0], [1.0, 0.0]]),
            (bounds::BOX, &[[f64::NAN, 0.0], [1.0, 0.0]]),
            (9, &[]),
        ] {
            assert!(area(kind, points).is_err(), "{kind} {points:?}");
        }
        // Points on a line, and all the same, are as thin as they are.
        let line = area(bounds::CONVEX_HULL, &[[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]])
            .unwrap_or_else(|error| panic!("{error:?}"));
        assert!(line.overlaps(&disc(1.0, 0.5, 0.5)) && !line.overlaps(&disc(1.0, 0.6, 0.5)));
        let point =
            area(bounds::CONVEX_HULL, &[[1.0, 1.0]; 3]).unwrap_or_else(|error| panic!("{error:?}"));
        assert!(point.overlaps(&disc(1.0, 1.0, 0.1)) && !point.overlaps(&disc(9.0, 1.0, 0.1)));
    }

    #[test]
    fn tags_are_wanted_all_or_any() {
        let tags = ["driven".to_owned(), "spawned".to_owned()];
        let wanted = |tags: &[&str], filter_mode| TagsFilter {
            tags: tags.iter().map(|tag| (*tag).to_owned()).collect(),
            filter_mode,
        };
        assert!(has_tags(&tags, &wanted(&[], 1)));
        assert!(has_tags(&tags, &wanted(&["driven", "fixed"], 0)));
        assert!(!has_tags(&tags, &wanted(&["driven", "fixed"], 1)));
    }
}
