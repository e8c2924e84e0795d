//! Where a bow runs in a picture, and drawing it.
//!
//! d(phi) = cos(theta) s + sin(theta) (cos(phi) u + sin(phi) r)
//! `s` unit vector to the antisolar point, `theta` the bow angle, `u`, `r` up and right of s, `phi` the
//! clock angle from the top.

use std::f64::consts::TAU;

use glam::DVec3;
use niji_geometry::Camera;
use niji_radiometry::Radians;

use crate::bow_fit::across_and_up;
use crate::linear_picture::LinearPicture;

/// Steps around the circle: a quarter of a degree, straight to a hundredth of a pixel in 6000.
const N_STEPS: usize = 1440;

/// The bow as broken lines of points in pixels, where it runs through the picture.
#[must_use]
pub fn bow_path(camera: &Camera, antisolar: DVec3, bow_angle: Radians) -> Vec<Vec<[f64; 2]>> {
    let (right, up) = across_and_up(antisolar);
    let (sin, cos) = bow_angle.0.sin_cos();
    // From the bottom around to the bottom, where bows are cut anyway.
    let directions = (0..=N_STEPS).map(|step| {
        let clock = TAU * (step as f64 / N_STEPS as f64 - 0.5);
        let rim = clock.cos() * up + clock.sin() * right;
        cos * antisolar + sin * rim
    });
    broken_lines(camera, directions)
}

/// A line through directions as broken lines of points in pixels, where it runs through the picture.
pub fn broken_lines(
    camera: &Camera,
    directions: impl Iterator<Item = DVec3>,
) -> Vec<Vec<[f64; 2]>> {
    let (width, height) = (f64::from(camera.width_px()), f64::from(camera.height_px()));
    // Over the seam of a panorama.
    let leaps = |from: &[f64; 2], to: [f64; 2]| (to[0] - from[0]).abs() > 0.5 * width;
    let mut lines = Vec::new();
    let mut line: Vec<[f64; 2]> = Vec::new();
    for direction in directions {
        let point = camera.project(direction);
        let inside = point
            .filter(|(x, y)| (0.0..=width).contains(x) && (0.0..=height).contains(y))
            .map(|(x, y)| [x, y]);
        match inside {
            Some(point) => {
                if line.last().is_some_and(|last| leaps(last, point)) {
                    lines.push(std::mem::take(&mut line));
                }
                line.push(point);
            }
            None if line.is_empty() => {}
            None => lines.push(std::mem::take(&mut line)),
        }
    }
    if !line.is_empty() {
        lines.push(line);
    }
    lines.retain(|line| line.len() > 1);
    lines
}

/// Draws a broken line over a picture, with soft edges.
pub fn draw_line(picture: &mut LinearPicture, points: &[[f64; 2]], color: [f32; 3], width_px: f64) {
    let reach = 0.5 * width_px + 0.5;
    let (height, width) = picture.dim();
    for pair in points.windows(2) {
        let [a, b] = [pair[0], pair[1]];
        let span = |axis: usize, n: usize| {
            let low = (a[axis].min(b[axis]) - reach).floor().max(0.0) as usize;
            let high = (a[axis].max(b[axis]) + reach).ceil().max(0.0) as usize;
            low.min(n)..high.min(n)
        };
        for y in span(1, height) {
            for x in span(0, width) {
                let distance = distance_px([x as f64 + 0.5, y as f64 + 0.5], a, b);
                let cover = (reach - distance).clamp(0.0, 1.0) as f32;
                for (channel, value) in picture[[y, x]].iter_mut().enumerate() {
                    *value += cover * (color[channel] - *value);
                }
            }
        }
    }
}

fn distance_px(point: [f64; 2], a: [f64; 2], b: [f64; 2]) -> f64 {
    let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
    let (px, py) = (point[0] - a[0], point[1] - a[1]);
    let squared = dx * dx + dy * dy;
    let along = if squared > 0.0 {
        ((px * dx + py * dy) / squared).clamp(0.0, 1.0)
    } else {
        0.0
    };
    (px - along * dx).hypot(py - along * dy)
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::Array2;
    use niji_geometry::CameraPose;
    use niji_geometry::PanoramaCamera;
    use niji_geometry::PinholeCamera;
    use niji_geometry::PinholeRequest;

    fn camera() -> Camera {
        let pinhole = PinholeCamera::new(PinholeRequest {
            position: DVec3::ZERO,
            azimuth: Radians(0.0),
            elevation: Radians(0.0),
            roll: Radians(0.0),
            horizontal_fov: Radians::from_degrees(60.0),
            width_px: 600,
            height_px: 400,
        });
        pinhole.unwrap().into()
    }

    #[test]
    fn every_point_of_the_path_sees_the_bow_angle() {
        let antisolar = DVec3::new(0.1, -0.4, -1.0).normalize();
        let theta = Radians::from_degrees(42.0);
        let lines = bow_path(&camera(), antisolar, theta);
        assert_eq!(lines.len(), 1);
        for [x, y] in &lines[0] {
            let view = camera().ray(*x, *y).unwrap().direction;
            assert!((view.angle_between(antisolar) - theta.0).abs() < 1e-7);
        }
        assert!(
            bow_path(&camera(), DVec3::Z, theta).is_empty(),
            "behind the camera"
        );
    }

    #[test]
    fn a_circle_is_cut_at_the_seam_of_a_panorama() {
        let pose = CameraPose::looking(DVec3::ZERO, [Radians(0.0); 3]).unwrap();
        let camera = Camera::from(PanoramaCamera::new(pose, [720, 360]).unwrap());
        // Beside south, where the seam runs.
        let antisolar = DVec3::new(0.2, 0.0, 1.0).normalize();
        let lines = bow_path(&camera, antisolar, Radians::from_degrees(42.0));
        assert_eq!(lines.len(), 3);
        let is_short = |pair: &[[f64; 2]]| (pair[1][0] - pair[0][0]).abs() < 2.0;
        assert!(lines.iter().all(|line| line.windows(2).all(is_short)));
    }

    #[test]
    fn a_line_covers_its_width_and_nothing_outside_the_picture() {
        let mut picture = Array2::from_elem((20, 30), [0.0; 3]);
        draw_line(&mut picture, &[[-50.0, 10.0], [80.0, 10.0]], [1.0; 3], 2.0);
        let column: f32 = (0..20).map(|y| picture[[y, 15]][0]).sum();
        assert!((column - 2.0).abs() < 1e-6, "{column}");
        draw_line(&mut picture, &[[-9e9, -9e9], [-8e9, -8e9]], [1.0; 3], 2.0);
        draw_line(&mut picture, &[[5.0, 5.0], [5.0, 5.0]], [1.0; 3], 2.0);
        assert!(
            (picture[[4, 4]][1] - 0.792_893_2).abs() < 1e-3,
            "a dot is round"
        );
    }
}
