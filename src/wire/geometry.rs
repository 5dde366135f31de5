//! The geometry of a field as ssl-vision tells it: sizes, lines and arcs, in millimetres.
//!
//! Lines and arcs have the names that teams look for. They are generated from the sizes, so that
//! none can disagree with them.

use std::f64::consts::TAU;

use super::fault::{Code, Fault};
use super::field::Field;
use super::proto::vision::{
    SslBallModelStraightTwoPhase, SslFieldCircularArc, SslFieldLineSegment, SslFieldShapeType,
    SslGeometryData, SslGeometryFieldSize, SslGeometryModels, Vector2f,
};
use super::vision::Cameras;

/// What a field's things measure, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Things {
    /// Radius of the ball.
    pub ball_radius: f64,
    /// Radius of the largest robot.
    pub robot_radius: f64,
}

/// All of it.
pub fn data(
    field: &Field,
    cameras: &Cameras,
    things: Things,
    ball: Option<SslBallModelStraightTwoPhase>,
) -> SslGeometryData {
    SslGeometryData {
        field: size(field, things),
        calib: cameras.calibrations(),
        models: ball.map(|ball| SslGeometryModels { straight_two_phase: Some(ball) }),
    }
}

fn size(field: &Field, things: Things) -> SslGeometryFieldSize {
    SslGeometryFieldSize {
        field_length: millimetres(field.marks.length),
        field_width: millimetres(field.marks.width),
        goal_width: millimetres(field.marks.goal_width),
        goal_depth: millimetres(field.marks.goal_depth),
        boundary_width: millimetres(field.marks.margin),
        field_lines: lines(field),
        field_arcs: vec![centre_circle(field)],
        penalty_area_depth: Some(millimetres(field.marks.penalty_depth)),
        penalty_area_width: Some(millimetres(field.marks.penalty_width)),
        center_circle_radius: Some(millimetres(field.marks.centre_radius)),
        line_thickness: Some(millimetres(field.line_m)),
        goal_center_to_penalty_mark: Some(millimetres(field.penalty_mark_m)),
        goal_height: None,
        ball_radius: Some((things.ball_radius * 1e3) as f32),
        max_robot_radius: Some((things.robot_radius * 1e3) as f32),
    }
}

/// What of a geometry that is asked for is not so in the one that is told; nothing = it is the
/// same field, as far as it says. Lines follow from the sizes, and cameras are carom's: neither is
/// looked at.
pub fn differences(asked: &SslGeometryData, told: &SslGeometryData) -> Option<Fault> {
    let (field, own) = (&asked.field, &told.field);
    let required = [
        ("field_length", field.field_length, own.field_length),
        ("field_width", field.field_width, own.field_width),
        ("goal_width", field.goal_width, own.goal_width),
        ("goal_depth", field.goal_depth, own.goal_depth),
        ("boundary_width", field.boundary_width, own.boundary_width),
    ];
    let optional = [
        ("penalty_area_depth", field.penalty_area_depth, own.penalty_area_depth),
        ("penalty_area_width", field.penalty_area_width, own.penalty_area_width),
        ("center_circle_radius", field.center_circle_radius, own.center_circle_radius),
    ];
    let optional = optional.into_iter().filter_map(|(name, a, b)| Some((name, a?, b?)));
    let differs = |(_, a, b): &(&str, i32, i32)| a != b;
    let line = |(name, a, b)| format!("{name} {a}, here {b} mm");
    let mut lines: Vec<String> =
        required.into_iter().chain(optional).filter(differs).map(line).collect();
    let model = |data: &SslGeometryData| data.models.and_then(|models| models.straight_two_phase);
    if let (Some(a), Some(b)) = (model(asked), model(told)) {
        let rows = [
            ("acc_slide", a.acc_slide, b.acc_slide),
            ("acc_roll", a.acc_roll, b.acc_roll),
            ("k_switch", a.k_switch, b.k_switch),
        ];
        let differs = rows.into_iter().filter(|(_, a, b)| (a - b).abs() > 1e-6);
        lines.extend(differs.map(|(name, a, b)| format!("{name} {a}, here {b}")));
    }
    let how = "the field is that of the scene; run or load another scene";
    let message = format!("config.geometry: {}: {how}", lines.join("; "));
    (!lines.is_empty()).then(|| Fault::new(Code::Unsupported, message))
}

fn millimetres(metres: f64) -> i32 {
    (metres * 1e3).round() as i32
}

fn lines(field: &Field) -> Vec<SslFieldLineSegment> {
    use SslFieldShapeType as Shape;
    let (x, y) = (field.marks.length / 2.0, field.marks.width / 2.0);
    let (edge, side) = (x - field.marks.penalty_depth, field.marks.penalty_width / 2.0);
    // Left and right of a penalty area: as its keeper sees it.
    [
        ("TopTouchLine", Shape::TopTouchLine, (-x, y), (x, y)),
        ("BottomTouchLine", Shape::BottomTouchLine, (-x, -y), (x, -y)),
        ("LeftGoalLine", Shape::LeftGoalLine, (-x, -y), (-x, y)),
        ("RightGoalLine", Shape::RightGoalLine, (x, -y), (x, y)),
        ("HalfwayLine", Shape::HalfwayLine, (0.0, -y), (0.0, y)),
        ("CenterLine", Shape::CenterLine, (-x, 0.0), (x, 0.0)),
        ("LeftPenaltyStretch", Shape::LeftPenaltyStretch, (-edge, -side), (-edge, side)),
        ("RightPenaltyStretch", Shape::RightPenaltyStretch, (edge, -side), (edge, side)),
        (
            "LeftFieldLeftPenaltyStretch",
            Shape::LeftFieldLeftPenaltyStretch,
            (-x, side),
            (-edge, side),
        ),
        (
            "LeftFieldRightPenaltyStretch",
            Shape::LeftFieldRightPenaltyStretch,
            (-x, -side),
            (-edge, -side),
        ),
        (
            "RightFieldLeftPenaltyStretch",
            Shape::RightFieldLeftPenaltyStretch,
            (x, -side),
            (edge, -side),
        ),
        (
            "RightFieldRightPenaltyStretch",
            Shape::RightFieldRightPenaltyStretch,
            (x, side),
            (edge, side),
        ),
    ]
    .map(|(name, shape, p1, p2)| SslFieldLineSegment {
        name: name.to_owned(),
        p1: point(p1),
        p2: point(p2),
        thickness: (field.line_m * 1e3) as f32,
        r#type: Some(shape as i32),
    })
    .to_vec()
}

fn centre_circle(field: &Field) -> SslFieldCircularArc {
    SslFieldCircularArc {
        name: "CenterCircle".to_owned(),
        center: point((0.0, 0.0)),
        radius: (field.marks.centre_radius * 1e3) as f32,
        a1: 0.0,
        a2: TAU as f32,
        thickness: (field.line_m * 1e3) as f32,
        r#type: Some(SslFieldShapeType::CenterCircle as i32),
    }
}

fn point((x, y): (f64, f64)) -> Vector2f {
    Vector2f { x: (x * 1e3) as f32, y: (y * 1e3) as f32 }
}

#[cfg(test)]
mod tests {
    use super::super::field::division_b;
    use super::*;

    #[test]
    fn the_lines_of_division_b_are_where_the_rules_have_them() {
        let things = Things { ball_radius: 0.0215, robot_radius: 0.09 };
        let data = data(&division_b(), &Cameras::new(4, &division_b()), things, None);
        let size = &data.field;
        assert_eq!((size.field_length, size.field_width), (9_000, 6_000));
        assert_eq!((size.goal_width, size.goal_depth), (1_000, 180));
        assert_eq!((size.field_lines.len(), size.field_arcs.len()), (12, 1));
        let line = |name: &str| {
            // The names are those that are generated.
            let line = size.field_lines.iter().find(|line| line.name == name).expect("a line");
            (line.p1.x, line.p1.y, line.p2.x, line.p2.y)
        };
        assert_eq!(line("RightPenaltyStretch"), (3_500.0, -1_000.0, 3_500.0, 1_000.0));
        assert_eq!(line("LeftFieldLeftPenaltyStretch"), (-4_500.0, 1_000.0, -3_500.0, 1_000.0));
        assert_eq!(size.field_arcs[0].radius, 500.0);
        assert_eq!((size.ball_radius, data.calib.len()), (Some(21.5), 4));
    }
    #[test]
    fn a_geometry_that_is_asked_for_is_the_same_or_is_told_how_it_differs() {
        let things = Things { ball_radius: 0.0215, robot_radius: 0.09 };
        let ball =
            SslBallModelStraightTwoPhase { acc_slide: -3.0, acc_roll: -0.26, k_switch: 0.64 };
        let told = data(&division_b(), &Cameras::new(1, &division_b()), things, Some(ball));
        assert_eq!(differences(&told, &told), None);
        let mut asked = told.clone();
        (asked.calib, asked.models, asked.field.center_circle_radius) = (Vec::new(), None, None);
        asked.field.field_lines.clear();
        assert_eq!(differences(&asked, &told), None, "what it does not say is no difference");
        (asked.field.field_length, asked.field.goal_width) = (12_000, 1_800);
        let model = SslBallModelStraightTwoPhase { acc_roll: -0.3, ..ball };
        asked.models = Some(SslGeometryModels { straight_two_phase: Some(model) });
        // Two sizes are other ones.
        let fault = differences(&asked, &told).expect("they differ");
        assert_eq!(fault.code, Code::Unsupported);
        for part in ["field_length 12000, here 9000 mm", "goal_width 1800", "acc_roll -0.3, here"] {
            assert!(fault.message.contains(part), "{fault}");
        }
        assert!(!fault.message.contains("field_width"), "{fault}");
    }
}
