//! Vision: what the cameras of a field see of the game, in the units of ssl-vision.
//!
//! Cameras share the field in equal parts and look straight down; a thing is seen by each camera
//! whose part, with the overlap, holds it. Their calibration is that of a pinhole without
//! distortion, and the pixels are what it makes of the places, so both agree.

use glam::DVec2;
use prost::Message;

use super::field::Field;
use super::proto::vision::{
    SslDetectionBall, SslDetectionFrame, SslDetectionRobot, SslGeometryCameraCalibration,
    SslGeometryData, SslWrapperPacket,
};
use super::realism::{Noise, Realism};
use super::{Seen, Team, View};

/// How many cameras a field may have.
pub const CAMERAS: [u32; 4] = [1, 2, 4, 8];

/// As the cameras of the league, roughly: height over the field, m; focal length, pixels.
const CAMERA_HEIGHT_M: f64 = 5.5;
const FOCAL_LENGTH: f64 = 800.0;
/// Width and height of an image, pixels.
const IMAGE: (u32, u32) = (2_448, 2_048);

/// A millimetre in metres, upside down.
const MILLIMETRES: f64 = 1_000.0;

/// The cameras over a field.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cameras {
    /// 1, 2, 4 or 8.
    count: u32,
    /// Half of the field with what is around it, m.
    half: DVec2,
}

/// The parts of a frame's time stamps.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Stamp {
    /// Frames before this one.
    pub number: u32,
    /// When it was seen, s since the Unix epoch.
    pub capture: f64,
    /// When it is sent, s since the Unix epoch.
    pub sent: f64,
}

impl Cameras {
    /// So many over a field; a number that is not in [`CAMERAS`] is brought down to one that is.
    pub fn new(count: u32, field: &Field) -> Self {
        let count = CAMERAS.into_iter().rev().find(|most| *most <= count).unwrap_or(1);
        let half = 0.5 * DVec2::new(field.marks.length, field.marks.width) + field.marks.margin;
        Self { count, half }
    }

    /// Columns and rows.
    fn grid(&self) -> (u32, u32) {
        match self.count {
            1 => (1, 1),
            2 => (2, 1),
            4 => (2, 2),
            _ => (4, 2),
        }
    }

    /// Half of a camera's part, m.
    fn part(&self) -> DVec2 {
        let (columns, rows) = self.grid();
        self.half / DVec2::new(f64::from(columns), f64::from(rows))
    }

    /// Where a camera hangs, m.
    fn place(&self, camera: u32) -> DVec2 {
        let (columns, _) = self.grid();
        let (column, row) = (camera % columns, camera / columns);
        let part = self.part();
        -self.half + part + 2.0 * part * DVec2::new(f64::from(column), f64::from(row))
    }

    /// The camera in whose part a place is; for one outside, the nearest.
    fn over(&self, at: DVec2) -> u32 {
        let (columns, rows) = self.grid();
        let most = DVec2::new(f64::from(columns - 1), f64::from(rows - 1));
        let cell = ((at + self.half) / (2.0 * self.part())).floor().clamp(DVec2::ZERO, most);
        cell.x as u32 + cell.y as u32 * columns
    }

    /// Whether a camera sees a place.
    fn sees(&self, camera: u32, at: DVec2, overlap: f64) -> bool {
        let is_near = || {
            let reach = self.part() + 0.5 * overlap;
            (at - self.place(camera)).abs().cmple(reach).all()
        };
        self.over(at) == camera || overlap > 0.0 && is_near()
    }

    /// Where a place is in the image of a camera, pixels.
    fn pixel(&self, camera: u32, at: DVec2, height: f64) -> (f32, f32) {
        let from = (at - self.place(camera)) * DVec2::new(1.0, -1.0);
        let principal = DVec2::new(f64::from(IMAGE.0), f64::from(IMAGE.1)) * 0.5;
        let pixel = principal + from * (FOCAL_LENGTH / (CAMERA_HEIGHT_M - height));
        (pixel.x as f32, pixel.y as f32)
    }

    /// How the cameras hang.
    pub fn calibrations(&self) -> Vec<SslGeometryCameraCalibration> {
        (0..self.count).map(|camera| self.calibration(camera)).collect()
    }

    fn calibration(&self, camera: u32) -> SslGeometryCameraCalibration {
        let place = self.place(camera) * MILLIMETRES;
        let height = (CAMERA_HEIGHT_M * MILLIMETRES) as f32;
        let (x, y) = (place.x as f32, place.y as f32);
        SslGeometryCameraCalibration {
            camera_id: camera,
            focal_length: FOCAL_LENGTH as f32,
            principal_point_x: IMAGE.0 as f32 * 0.5,
            principal_point_y: IMAGE.1 as f32 * 0.5,
            distortion: 0.0,
            // Half a turn about x: x stays, y and z are upside down.
            q0: 1.0,
            q1: 0.0,
            q2: 0.0,
            q3: 0.0,
            tx: -x,
            ty: y,
            tz: height,
            derived_camera_world_tx: Some(x),
            derived_camera_world_ty: Some(y),
            derived_camera_world_tz: Some(height),
            pixel_image_width: Some(IMAGE.0),
            pixel_image_height: Some(IMAGE.1),
        }
    }

    /// What all cameras see, one frame each.
    pub fn look(
        &self,
        view: &View,
        stamp: Stamp,
        realism: &Realism,
        noise: &mut Noise,
    ) -> Vec<SslDetectionFrame> {
        (0..self.count).map(|camera| self.frame(camera, view, stamp, realism, noise)).collect()
    }

    fn frame(
        &self,
        camera: u32,
        view: &View,
        stamp: Stamp,
        realism: &Realism,
        noise: &mut Noise,
    ) -> SslDetectionFrame {
        let mut frame = SslDetectionFrame {
            frame_number: stamp.number,
            t_capture: stamp.capture,
            t_sent: stamp.sent,
            camera_id: camera,
            ..SslDetectionFrame::default()
        };
        let overlap = realism.camera_overlap_m;
        let ball = view.ball.filter(|(at, _)| self.sees(camera, *at, overlap));
        if let Some((at, _)) = ball {
            let is_missed = realism.missing_balls > 0.0 && noise.uniform() < realism.missing_balls;
            let at = at + blur(noise, realism.ball_deviation_m);
            frame.balls.extend((!is_missed).then(|| self.ball(camera, at)));
        }
        for robot in view.robots.iter().filter(|it| self.sees(camera, it.position, overlap)) {
            let position = robot.position + blur(noise, realism.robot_deviation_m);
            let heading = robot.heading + blur(noise, realism.heading_deviation_rad).x;
            let detected = self.robot(camera, &Seen { position, heading, ..*robot });
            match robot.name.team {
                Team::Blue => frame.robots_blue.push(detected),
                Team::Yellow => frame.robots_yellow.push(detected),
            }
        }
        frame
    }

    fn ball(&self, camera: u32, at: DVec2) -> SslDetectionBall {
        let (pixel_x, pixel_y) = self.pixel(camera, at, 0.0);
        let (x, y) = ((at.x * MILLIMETRES) as f32, (at.y * MILLIMETRES) as f32);
        SslDetectionBall { confidence: 1.0, area: None, x, y, z: Some(0.0), pixel_x, pixel_y }
    }

    fn robot(&self, camera: u32, robot: &Seen) -> SslDetectionRobot {
        let (pixel_x, pixel_y) = self.pixel(camera, robot.position, robot.height);
        SslDetectionRobot {
            confidence: 1.0,
            robot_id: Some(robot.name.number),
            x: (robot.position.x * MILLIMETRES) as f32,
            y: (robot.position.y * MILLIMETRES) as f32,
            orientation: Some(robot.heading as f32),
            pixel_x,
            pixel_y,
            height: Some((robot.height * MILLIMETRES) as f32),
        }
    }
}

/// Two independent errors of this deviation; without one nothing is drawn.
fn blur(noise: &mut Noise, deviation: f64) -> DVec2 {
    if deviation > 0.0 { noise.normal() * deviation } else { DVec2::ZERO }
}

/// A frame as a datagram.
pub fn detection(frame: SslDetectionFrame) -> Vec<u8> {
    SslWrapperPacket { detection: Some(frame), geometry: None }.encode_to_vec()
}

/// The field and its cameras as a datagram.
pub fn geometry(data: SslGeometryData) -> Vec<u8> {
    SslWrapperPacket { detection: None, geometry: Some(data) }.encode_to_vec()
}

#[cfg(test)]
mod tests {
    use super::super::RobotName;
    use super::super::field::division_b;
    use super::*;

    fn view() -> View {
        let name = RobotName { team: Team::Blue, number: 4 };
        let (position, velocity) = (DVec2::new(-2.0, 1.25), DVec2::ZERO);
        let (heading, turn, radius, height) = (0.5, 0.0, 0.09, 0.15);
        let robot = Seen { name, position, velocity, heading, turn, radius, height };
        let ball = Some((DVec2::new(0.1, -0.2), DVec2::X));
        View { time: 1.0, ball, robots: vec![robot], ..View::default() }
    }

    #[test]
    fn without_realism_vision_is_exact() {
        let frames = Cameras::new(1, &division_b()).look(
            &view(),
            Stamp { number: 3, capture: 10.0, sent: 10.5 },
            &Realism::default(),
            &mut Noise::new(0),
        );
        let [frame] = frames.as_slice() else { panic!("one camera") };
        assert_eq!((frame.frame_number, frame.t_capture, frame.t_sent), (3, 10.0, 10.5));
        let (ball, robot) = (frame.balls[0], frame.robots_blue[0]);
        assert_eq!((ball.x, ball.y, frame.robots_yellow.len()), (100.0, -200.0, 0));
        assert_eq!((robot.robot_id, robot.x, robot.y), (Some(4), -2000.0, 1250.0));
        assert_eq!((robot.orientation, robot.height), (Some(0.5), Some(150.0)));
    }

    #[test]
    fn every_place_is_seen_by_one_camera_and_more_where_they_overlap() {
        for count in CAMERAS {
            let cameras = Cameras::new(count, &division_b());
            let see = |at: DVec2, overlap| {
                (0..count).filter(|camera| cameras.sees(*camera, at, overlap)).count()
            };
            for (x, y) in [(0.3, 0.2), (-4.4, 2.9), (4.0, -3.1), (2.0, 0.7), (-90.0, 70.0)] {
                assert_eq!(see(DVec2::new(x, y), 0.0), 1, "{count} cameras, {x} {y}");
            }
            let expected = [1, 2, 4, 4][CAMERAS.iter().position(|it| *it == count).unwrap_or(0)];
            assert_eq!(see(DVec2::new(0.05, -0.05), 0.2), expected, "{count} cameras");
        }
    }

    #[test]
    fn pixels_and_calibration_agree() {
        let cameras = Cameras::new(4, &division_b());
        for (camera, calib) in cameras.calibrations().iter().enumerate() {
            let at = DVec2::new(1.5, -0.7);
            // Into the camera's frame by its own numbers, and through its pinhole.
            let x = at.x * MILLIMETRES + f64::from(calib.tx);
            let y = -at.y * MILLIMETRES + f64::from(calib.ty);
            let z = f64::from(calib.tz);
            let focal = f64::from(calib.focal_length);
            let pixel = cameras.pixel(camera as u32, at, 0.0);
            assert!((x / z * focal + 1_224.0 - f64::from(pixel.0)).abs() < 1e-3);
            assert!((y / z * focal + 1_024.0 - f64::from(pixel.1)).abs() < 1e-3);
        }
    }

    #[test]
    fn the_same_seed_makes_the_same_packets() {
        let realism = Realism {
            ball_deviation_m: 0.003,
            robot_deviation_m: 0.002,
            heading_deviation_rad: 0.01,
            missing_balls: 0.5,
            camera_overlap_m: 0.2,
            delay_s: 0.0,
        };
        let packets = |seed| {
            let (mut noise, cameras) = (Noise::new(seed), Cameras::new(4, &division_b()));
            let look = |k| {
                let stamp = Stamp { number: k, ..Stamp::default() };
                cameras.look(&view(), stamp, &realism, &mut noise)
            };
            (0..50).flat_map(look).map(detection).collect::<Vec<_>>()
        };
        assert_eq!(packets(5), packets(5));
        assert_ne!(packets(5), packets(6));
    }
}
