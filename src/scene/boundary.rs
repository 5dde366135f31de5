//! The boundary of a scene, and what acts everywhere in it: walls, segments, a periodic box,
//! gravity, drag; with what excludes what.
//!
//! Never read a puck here.

use glam::DVec2;
use serde::Deserialize;
use serde_saphyr::Spanned;

use super::file::{Checked, Reader, SceneFile};
use crate::world::{BadSegment, Periodic, Segment, Segments, Walls, limits};

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct WallsFile {
    pub(super) x: [f64; 2],
    pub(super) y: [f64; 2],
    pub(super) restitution: Option<Spanned<f64>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SegmentsFile {
    restitution: Option<Spanned<f64>>,
    lines: Vec<Spanned<LineFile>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct LineFile {
    name: Spanned<String>,
    points: Vec<[f64; 2]>,
    #[serde(default)]
    closed: bool,
}

impl Reader<'_> {
    /// The segments, each with its name: that of its line and its place there.
    pub(super) fn segments(
        &self,
        scene: &SceneFile,
        restitution: f64,
    ) -> Checked<Option<(Segments, Vec<String>)>> {
        let Some(Spanned { value: file, referenced, .. }) = &scene.segments else {
            return Ok(None);
        };
        if scene.gravity.is_some() || scene.drag.is_some() || scene.periodic.is_some() {
            let message = "segments: not with gravity, drag or a periodic box".to_owned();
            return Err(self.error(Some(*referenced), message));
        }
        let restitution = self.fraction("restitution", &file.restitution, restitution)?;
        let (mut all, mut names) = (Vec::new(), Vec::new());
        for line in &file.lines {
            let (place, LineFile { name, points, closed }) = (Some(line.referenced), &line.value);
            let enough = if *closed { 3 } else { 2 };
            if points.len() < enough {
                let message = format!("line `{}`: needs {enough} points or more", name.value);
                return Err(self.error(place, message));
            }
            let corners = points.iter().chain(points.first().filter(|_| *closed));
            let corners: Vec<DVec2> = corners.map(|point| DVec2::from_array(*point)).collect();
            let of_line = corners.windows(2).map(|two| Segment { from: two[0], to: two[1] });
            let of_line: Vec<Segment> = of_line.collect();
            all.extend_from_slice(&of_line);
            names.extend((0..of_line.len()).map(|k| format!("{}_{k}", name.value)));
            if let Err(BadSegment::NoLine(bad)) = Segments::new(&of_line, restitution) {
                let message = format!("line `{}`: {}", name.value, BadSegment::NoLine(bad));
                return Err(self.error(place, message));
            }
        }
        let segments = Segments::new(&all, restitution);
        let segments = segments.map_err(|bad| self.error(Some(*referenced), bad.to_string()))?;
        Ok(Some((segments, names)))
    }

    pub(super) fn walls(
        &self,
        key: &str,
        walls: &Spanned<WallsFile>,
        restitution: f64,
    ) -> Checked<Walls> {
        let WallsFile { x, y, restitution: own } = &walls.value;
        let in_range = |bound: f64| bound.abs() <= limits::SIZE_MAX;
        let ordered = |[low, high]: [f64; 2]| low < high && in_range(low) && in_range(high);
        if !ordered(*x) || !ordered(*y) {
            let message = format!(
                "{key}: x and y must be [low, high] with low below high, within {:e} m",
                limits::SIZE_MAX
            );
            return Err(self.error(Some(walls.referenced), message));
        }
        Ok(Walls {
            min: DVec2::new(x[0], y[0]),
            max: DVec2::new(x[1], y[1]),
            restitution: self.fraction("restitution", own, restitution)?,
        })
    }

    /// The periodic box, which excludes walls and gravity.
    pub(super) fn periodic(&self, scene: &SceneFile) -> Checked<Option<Periodic>> {
        let Some(file) = &scene.periodic else { return Ok(None) };
        if scene.walls.is_some() || scene.gravity.is_some() || file.value.restitution.is_some() {
            let message = "periodic: x and y only, without walls and without gravity".to_owned();
            return Err(self.error(Some(file.referenced), message));
        }
        let Walls { min, max, .. } = self.walls("periodic", file, 1.0)?;
        Ok(Some(Periodic { min, max }))
    }

    /// Refuses a periodic box in which a pair could touch in two images at once.
    pub(super) fn fits(&self, periodic: Option<Periodic>, scene: &SceneFile) -> Checked<()> {
        let Some(periodic) = periodic else { return Ok(()) };
        let radius = self.pucks.iter().map(|puck| puck.disc.radius).fold(0.0, f64::max);
        let (radii, least) =
            (limits::RADII_IN_PERIODIC_BOX, limits::RADII_IN_PERIODIC_BOX * radius);
        if periodic.size().min_element() > least {
            return Ok(());
        }
        let message = format!("periodic: must be wider than {radii} radii, {least} m");
        Err(self.error(scene.periodic.as_ref().map(|file| file.referenced), message))
    }

    pub(super) fn gravity(&self, gravity: &Option<Spanned<[f64; 2]>>) -> Checked<Option<DVec2>> {
        let Some(gravity) = gravity else { return Ok(None) };
        let acceleration = DVec2::from_array(gravity.value);
        // Squares of squares, over any length that a puck has, must stay in range.
        let usual = |size: f64| size == 0.0 || (1e-30..=1e30).contains(&size);
        if usual(acceleration.x.abs()) && usual(acceleration.y.abs()) {
            return Ok(Some(acceleration));
        }
        let message = "gravity: [x, y] in m/s^2, each 0 or of a size from 1e-30 to 1e30".to_owned();
        Err(self.error(Some(gravity.referenced), message))
    }

    /// The drag, which excludes gravity.
    pub(super) fn drag(&self, scene: &SceneFile) -> Checked<f64> {
        let usual = |drag: f64| drag == 0.0 || (1e-30..=1e30).contains(&drag);
        let drag = self.number("drag", &scene.drag, 0.0, usual, "0, or from 1e-30 to 1e30 1/s")?;
        if drag != 0.0 && scene.gravity.is_some() {
            let message = "drag: not with gravity; leave one of them out".to_owned();
            return Err(self.error(scene.drag.as_ref().map(|drag| drag.referenced), message));
        }
        Ok(drag)
    }
}
