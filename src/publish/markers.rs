//! `markers`: what RViz and Foxglove draw. A cylinder a puck up to some hundred, beyond that lists
//! of spheres of nearly the same size; walls and segments as lines; what is gone is deleted by its
//! name.
//!
//! Nothing here decides whether anybody looks.

use std::collections::BTreeSet;

use glam::DVec2;

use crate::messages::{
    ColorRgba, Header, Marker, MarkerArray, Pose, Quaternion, Vector3, marker_action, marker_type,
};
use crate::scene::Puck;
use crate::world::{Disc, Periodic, Segments, Walls};

/// Up to so many circles each is a marker of its own.
const CYLINDERS_UP_TO: usize = 300;
/// Spheres of one list are drawn with one size, at most this part of their own too large or small.
const SIZE_ERROR: f64 = 0.01;
/// Height of a puck in its radii.
const HEIGHT: f64 = 1.0;
/// Width of the walls in the shorter side of their box.
const LINE: f64 = 0.005;
/// Observed circles: light and translucent.
const OBSERVED: [u8; 4] = [200, 200, 200, 160];

const PUCKS: &str = "pucks";
const OBSERVED_NAME: &str = "observed";
const WALLS: &str = "walls";
const SEGMENTS: &str = "segments";

/// What was drawn last, so that what is gone can be deleted.
#[derive(Clone, Debug, Default)]
pub struct Drawn(BTreeSet<(&'static str, i32)>);

/// All that is to be drawn.
#[derive(Clone, Debug)]
pub struct Picture<'a> {
    /// The pucks as they are now.
    pub pucks: Vec<(&'a Puck, Disc)>,
    /// The observed circles as they were last reported.
    pub observed: &'a [Disc],
    /// The box around them.
    pub walls: Option<Walls>,
    /// The segments of the boundary.
    pub segments: Option<Segments>,
    /// The box that repeats.
    pub periodic: Option<Periodic>,
}

impl Drawn {
    /// The markers of a picture, and deletions of what is in it no more.
    pub fn draw(&mut self, header: &Header, picture: &Picture) -> MarkerArray {
        let coloured = picture.pucks.iter().map(|(puck, disc)| (*disc, puck.colour)).collect();
        let observed = picture.observed.iter().map(|disc| (*disc, OBSERVED)).collect();
        let mut markers = circles(header, PUCKS, coloured);
        markers.extend(circles(header, OBSERVED_NAME, observed));
        let border = picture.walls.map(|walls| (walls.min, walls.max));
        let border = border.or(picture.periodic.map(|periodic| (periodic.min, periodic.max)));
        markers.extend(border.map(|(min, max)| frame(header, min, max)));
        markers.extend(picture.segments.map(|segments| lines(header, &segments)));
        let now: BTreeSet<_> = markers.iter().map(|(name, marker)| (*name, marker.id)).collect();
        let gone = self.0.difference(&now).map(|&(name, id)| Marker {
            action: marker_action::DELETE,
            ..marker(header, name, id)
        });
        let markers = gone.chain(markers.into_iter().map(|(_, marker)| marker)).collect();
        self.0 = now;
        MarkerArray { markers }
    }
}

type Named = (&'static str, Marker);

fn circles(header: &Header, name: &'static str, discs: Vec<(Disc, [u8; 4])>) -> Vec<Named> {
    if discs.len() <= CYLINDERS_UP_TO {
        return discs
            .iter()
            .map(|(disc, rgba)| (name, cylinder(header, name, disc, *rgba)))
            .collect();
    }
    let class = |disc: &Disc| (disc.radius.ln() / (2.0 * SIZE_ERROR)).round() as i32;
    let classes: BTreeSet<i32> = discs.iter().map(|(disc, _)| class(disc)).collect();
    let list = |of: i32| {
        let radius = (f64::from(of) * 2.0 * SIZE_ERROR).exp();
        let of_it = discs.iter().filter(|(disc, _)| class(disc) == of);
        let marker = Marker {
            kind: marker_type::SPHERE_LIST,
            scale: Vector3 { x: 2.0 * radius, y: 2.0 * radius, z: 2.0 * radius },
            color: colour([255; 4]),
            points: of_it.clone().map(|(disc, _)| point(disc.position, radius)).collect(),
            colors: of_it.map(|(_, rgba)| colour(*rgba)).collect(),
            ..marker(header, name, of)
        };
        (name, marker)
    };
    classes.into_iter().map(list).collect()
}

fn cylinder(header: &Header, name: &str, disc: &Disc, rgba: [u8; 4]) -> Marker {
    let (wide, high) = (2.0 * disc.radius, HEIGHT * disc.radius);
    // Ids above 2^31 go round to negative ones, each its own.
    let id = disc.id.cast_signed();
    Marker {
        kind: marker_type::CYLINDER,
        pose: Pose { position: point(disc.position, high / 2.0), orientation: Quaternion::UPRIGHT },
        scale: Vector3 { x: wide, y: wide, z: high },
        color: colour(rgba),
        ..marker(header, name, id)
    }
}

fn frame(header: &Header, min: DVec2, max: DVec2) -> Named {
    let corners = [min, DVec2::new(max.x, min.y), max, DVec2::new(min.x, max.y), min];
    let width = LINE * (max - min).min_element();
    let marker = Marker {
        kind: marker_type::LINE_STRIP,
        scale: Vector3 { x: width, y: 0.0, z: 0.0 },
        color: colour([230, 230, 230, 255]),
        points: corners.iter().map(|corner| point(*corner, 0.0)).collect(),
        ..marker(header, WALLS, 0)
    };
    (WALLS, marker)
}

fn lines(header: &Header, segments: &Segments) -> Named {
    let ends = || segments.all().iter().flat_map(|segment| [segment.from, segment.to]);
    let min = ends().fold(DVec2::INFINITY, DVec2::min);
    let size = ends().fold(DVec2::NEG_INFINITY, DVec2::max) - min;
    let marker = Marker {
        kind: marker_type::LINE_LIST,
        scale: Vector3 { x: LINE * size.max_element(), y: 0.0, z: 0.0 },
        color: colour([230, 230, 230, 255]),
        points: ends().map(|end| point(end, 0.0)).collect(),
        ..marker(header, SEGMENTS, 0)
    };
    (SEGMENTS, marker)
}

fn marker(header: &Header, name: &str, id: i32) -> Marker {
    Marker {
        header: header.clone(),
        ns: name.to_owned(),
        id,
        pose: Pose { position: Vector3::default(), orientation: Quaternion::UPRIGHT },
        ..Marker::default()
    }
}

fn point(at: DVec2, height: f64) -> Vector3 {
    Vector3 { x: at.x, y: at.y, z: height }
}

fn colour([r, g, b, a]: [u8; 4]) -> ColorRgba {
    let part = |value: u8| f32::from(value) / 255.0;
    ColorRgba { r: part(r), g: part(g), b: part(b), a: part(a) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn puck(id: u32, radius: f64) -> Puck {
        let disc = Disc { id, position: DVec2::ONE, velocity: DVec2::ZERO, radius, mass: 1.0 };
        let (name, namespace) = (format!("p{id}"), String::new());
        Puck { name, namespace, disc, colour: [255, 0, 0, 255], ..Puck::default() }
    }

    fn picture(pucks: &[Puck]) -> Picture<'_> {
        let pucks = pucks.iter().map(|puck| (puck, puck.disc)).collect();
        let (min, max) = (DVec2::ZERO, DVec2::splat(2.0));
        let walls = Some(Walls { min, max, restitution: 1.0 });
        Picture { pucks, observed: &[], walls, segments: None, periodic: None }
    }

    #[test]
    fn what_is_gone_is_deleted_once() {
        let (both, one) = (vec![puck(1, 0.1), puck(2, 0.1)], vec![puck(1, 0.1)]);
        let (mut drawn, header) = (Drawn::default(), Header::default());
        assert_eq!(drawn.draw(&header, &picture(&both)).markers.len(), 3);
        let after = drawn.draw(&header, &picture(&one)).markers;
        let deleted: Vec<i32> = after
            .iter()
            .filter(|marker| marker.action == marker_action::DELETE)
            .map(|marker| marker.id)
            .collect();
        assert_eq!((deleted, after.len()), (vec![2], 3));
        assert_eq!(drawn.draw(&header, &picture(&one)).markers.len(), 2);
    }

    #[test]
    fn segments_are_a_list_of_their_ends() {
        let segment = crate::world::Segment { from: DVec2::ZERO, to: DVec2::ONE };
        // One segment of some length is within every limit.
        let segments = Some(Segments::new(&[segment; 2], 1.0).expect("segments"));
        let markers = Drawn::default()
            .draw(&Header::default(), &Picture { segments, ..picture(&[]) })
            .markers;
        let list: Vec<&Marker> =
            markers.iter().filter(|marker| marker.kind == marker_type::LINE_LIST).collect();
        assert!(list.len() == 1 && list[0].points.len() == 4, "{list:?}");
    }

    #[test]
    fn many_are_lists_of_nearly_their_own_size() {
        let pucks: Vec<Puck> =
            (0..1000).map(|k| puck(k, 0.1 * 1.001f64.powi(k.cast_signed() % 700))).collect();
        let markers = Drawn::default().draw(&Header::default(), &picture(&pucks)).markers;
        assert!(markers.len() < 50, "{}", markers.len());
        let drawn: usize = markers
            .iter()
            .filter(|marker| marker.kind == marker_type::SPHERE_LIST)
            .map(|marker| {
                assert_eq!(marker.points.len(), marker.colors.len());
                marker.points.len()
            })
            .sum();
        assert_eq!(drawn, 1000);
        for puck in &pucks {
            let near =
                |marker: &&Marker| (marker.scale.x / 2.0 / puck.disc.radius - 1.0).abs() < 0.0101;
            assert!(markers.iter().find(near).is_some(), "{}", puck.disc.radius);
        }
    }
}
