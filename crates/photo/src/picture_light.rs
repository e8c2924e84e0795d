//! How bright a picture is where a bow would be.
//!
//! Luminance is that of linear Rec.709. Inside a bow is the ring from 6 to 2 degrees within the bow
//! angle, outside the ring from 1 to 5 degrees beyond it, as far as they lie in the picture.

use glam::DVec3;
use ndarray::Array2;
use niji_geometry::PinholeCamera;
use niji_radiometry::Radians;

use crate::circle_through_picks::angle_between;
use crate::compositing::AddedLight;
use crate::compositing::check_size;
use crate::error::Error;
use crate::exposure::luminance;
use crate::linear_picture::LinearPicture;

/// The ring inside, degrees from the bow.
const INSIDE_DEG: (f64, f64) = (-6.0, -2.0);
/// The ring outside.
const OUTSIDE_DEG: (f64, f64) = (1.0, 5.0);
/// Samples along each side of the picture.
const N_SAMPLES: usize = 300;
/// Luminance below which a photograph is black.
const BLACK: f64 = 1e-3;

/// A bow as a camera sees it.
#[derive(Clone, Copy, Debug)]
pub struct SeenBow<'a> {
    /// What sees it.
    pub camera: &'a PinholeCamera,
    /// Unit vector away from the sun.
    pub antisolar: DVec3,
    /// Half its opening angle.
    pub bow_angle: Radians,
}

/// Mean luminance inside and outside of a bow, of the sky where that is known, by row and column in the size of the
/// photograph; NaN for a ring that is not in the picture.
#[must_use]
pub fn luminance_around_bow(
    photo: &LinearPicture,
    bow: &SeenBow,
    is_sky: Option<&Array2<bool>>,
) -> [f64; 2] {
    let mut sums = [[0.0; 2]; 2];
    let (height, width) = photo.dim();
    for y in (0..height).step_by(height.div_ceil(N_SAMPLES).max(1)) {
        for x in (0..width).step_by(width.div_ceil(N_SAMPLES).max(1)) {
            if is_sky.is_some_and(|it| it.get((y, x)) != Some(&true)) {
                continue;
            }
            let view = bow.camera.ray(x as f64 + 0.5, y as f64 + 0.5).direction;
            let beyond_deg = (angle_between(view, bow.antisolar) - bow.bow_angle.0).to_degrees();
            for (sum, (low, high)) in sums.iter_mut().zip([INSIDE_DEG, OUTSIDE_DEG]) {
                if beyond_deg >= low && beyond_deg < high {
                    sum[0] += luminance(photo[[y, x]]);
                    sum[1] += 1.0;
                }
            }
        }
    }
    sums.map(|[sum, n]| sum / n)
}

/// Largest luminance of the added light over that of the photograph, where the light has at least half of
/// its peak.
///
/// # Errors
/// Pictures of other sizes.
pub fn peak_contrast(photo: &LinearPicture, added: &AddedLight, gain: f64) -> Result<f64, Error> {
    check_size("the light", photo.dim(), added.light.dim())?;
    let lights: Array2<f64> = added.light.mapv(luminance);
    let peak = lights.iter().copied().fold(0.0, f64::max);
    let contrasts = lights.iter().zip(photo).map(|(light, pixel)| {
        if *light < 0.5 * peak {
            return 0.0;
        }
        gain * light / luminance(*pixel).max(BLACK)
    });
    Ok(contrasts.fold(0.0, f64::max))
}

/// Part of the points of a bow whose surface is nearer than the drops; NaN without points.
#[must_use]
pub fn hidden_share(points_px: &[[f64; 2]], depth_m: &Array2<f32>, drops_m: f64) -> f64 {
    let (height, width) = depth_m.dim();
    let hidden = points_px.iter().filter(|[x, y]| {
        let at = [
            (*y as usize).min(height.saturating_sub(1)),
            (*x as usize).min(width.saturating_sub(1)),
        ];
        f64::from(depth_m[at]) < drops_m
    });
    hidden.count() as f64 / points_px.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use niji_geometry::PinholeRequest;

    #[test]
    fn rings_inside_and_outside_are_told_apart() {
        let camera = PinholeCamera::new(PinholeRequest {
            position: DVec3::ZERO,
            azimuth: Radians(0.0),
            elevation: Radians(0.0),
            roll: Radians(0.0),
            horizontal_fov: Radians::from_degrees(100.0),
            width_px: 200,
            height_px: 150,
        })
        .unwrap();
        let bow_angle = Radians::from_degrees(30.0);
        let photo = Array2::from_shape_fn((150, 200), |(y, x)| {
            let view = camera.ray(x as f64 + 0.5, y as f64 + 0.5).direction;
            let is_inside = view.angle_between(DVec3::NEG_Z) < bow_angle.0;
            [if is_inside { 0.75 } else { 0.25 }; 3]
        });
        let bow = SeenBow {
            camera: &camera,
            antisolar: DVec3::NEG_Z,
            bow_angle,
        };
        let [inside, outside] = luminance_around_bow(&photo, &bow, None);
        assert!((inside - 0.75).abs() < 1e-6 && (outside - 0.25).abs() < 1e-6);
        let behind = SeenBow {
            antisolar: DVec3::Z,
            ..bow
        };
        assert!(luminance_around_bow(&photo, &behind, None)[0].is_nan());

        // A dark foreground inside of the bow is none of its light.
        let is_sky = Array2::from_shape_fn((150, 200), |(y, _)| y < 75);
        let mut photo = photo;
        photo.zip_mut_with(&is_sky, |pixel, is_sky| {
            if !is_sky {
                *pixel = [0.0; 3];
            }
        });
        let [inside, outside] = luminance_around_bow(&photo, &bow, Some(&is_sky));
        assert!((inside - 0.75).abs() < 1e-6 && (outside - 0.25).abs() < 1e-6);
    }

    #[test]
    fn contrast_is_that_of_the_peak_and_hidden_points_are_counted() {
        let photo = Array2::from_elem((2, 2), [0.5; 3]);
        let mut light = Array2::from_elem((2, 2), [0.0; 3]);
        light[[0, 1]] = [0.02; 3];
        let added = AddedLight {
            light,
            transmittance: Array2::ones((2, 2)),
        };
        let contrast = peak_contrast(&photo, &added, 2.0).unwrap();
        assert!((contrast - 0.08).abs() < 1e-6);
        let depth = ndarray::array![[10.0, f32::INFINITY]];
        let points = [[0.5, 0.5], [1.5, 0.5], [1.9, 0.9], [0.1, 0.1]];
        assert!((hidden_share(&points, &depth, 100.0) - 0.5).abs() < 1e-12);
        assert!(hidden_share(&[], &depth, 100.0).is_nan());
    }
}
