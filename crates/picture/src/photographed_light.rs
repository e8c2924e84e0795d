//! The light of a photograph that the drops set into it scatter.
//!
//! p = sum_j (p_s + p_p)/2 of rays that were reflected j - 1 times inside of a drop, j = 0 to 3: all but half a
//! percent of what a large drop scatters beside diffraction, which leaves light where it went. One color tells all,
//! as water's refractive index changes the angles by a degree.

use std::f64::consts::PI;

use glam::DVec3;
use niji_airy::GeometricOrder;
use niji_exchange::SpectralImage;
use niji_photo::AddedLight;
use niji_photo::LinearPicture;
use niji_photo::Surroundings;
use niji_radiometry::Nanometers;
use niji_radiometry::Radians;
use niji_radiometry::water_refractive_index;

use crate::background::Background;
use crate::error::Error;
use crate::image_camera::camera_of;

/// Orders of the rays.
const ORDERS: std::ops::RangeInclusive<u32> = 0..=3;
/// Cells of the scattering angle, and points averaged over each.
const N_CELLS: usize = 360;
const PER_CELL: usize = 16;
/// Transmittance from which on no drops are taken to be before a surface.
const NO_DROPS: f32 = 0.999;

/// What the drops of an image scatter of the light of what they are set into, in its values.
///
/// What stands above the horizon and before the drops hides what they see there; what is below it is ground to them,
/// whatever it is.
///
/// # Errors
/// An image whose camera cannot be.
pub(crate) fn photographed_light(
    background: &Background,
    (image, added): (&SpectralImage, &AddedLight),
) -> Result<LinearPicture, Error> {
    let camera = camera_of(image)?;
    let windows = background.frame.windows;
    let of_frame = [camera.width_px(), camera.height_px()];
    let [across, down] = [
        f64::from(of_frame[0]) / f64::from(windows.display.width_px),
        f64::from(of_frame[1]) / f64::from(windows.display.height_px),
    ];
    let corner = [
        f64::from(windows.data.x_px - windows.display.x_px),
        f64::from(windows.data.y_px - windows.display.y_px),
    ];
    let phase = phase_of_rays();
    let surroundings = Surroundings {
        light: &background.light,
        alpha: background.alpha.as_ref(),
        direction: |x: f64, y: f64| {
            let ray = camera.ray((x + corner[0]) * across, (y + corner[1]) * down);
            ray.map(|ray| ray.direction)
        },
        is_seen: |at: [usize; 2], direction: DVec3| {
            let surface_m = background.surface_m.as_ref().map(|it| it[at]);
            let is_behind = surface_m.is_none_or(f32::is_infinite);
            direction.y < 0.0 || is_behind || added.transmittance[at] < NO_DROPS
        },
        phase: |cosine: f64| {
            let angle = cosine.clamp(-1.0, 1.0).acos() / PI;
            phase[((angle * N_CELLS as f64) as usize).min(N_CELLS - 1)]
        },
    };
    surroundings.scattered().map_err(Error::Photo)
}

/// What large drops scatter beside diffraction, by the cells of the angle [1/sr].
fn phase_of_rays() -> Vec<f64> {
    let n = water_refractive_index(Nanometers(550.0), 20.0);
    let orders: Vec<_> = ORDERS.filter_map(|p| GeometricOrder::new(n, p)).collect();
    let at = |theta_rad: f64| -> f64 {
        let light = |order: &GeometricOrder| {
            let [s, p] = order.normalized_cross_section(Radians(theta_rad));
            0.5 * (s + p)
        };
        orders.iter().map(light).sum()
    };
    let points = (0..N_CELLS).map(|cell| {
        let point = |index: usize| {
            let part = (index as f64 + 0.5) / PER_CELL as f64;
            at(PI * (cell as f64 + part) / N_CELLS as f64)
        };
        (0..PER_CELL).map(point).sum::<f64>() / PER_CELL as f64
    });
    points.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn drops_scatter_all_that_meets_them_and_most_of_it_forward() {
        let (mut all, mut forward) = (0.0, 0.0);
        for (cell, phase) in phase_of_rays().into_iter().enumerate() {
            let edge = |cell: usize| (PI * cell as f64 / N_CELLS as f64).cos();
            let (from, to) = (edge(cell), edge(cell + 1));
            all += 2.0 * PI * phase * (from - to);
            forward += PI * phase * (from * from - to * to);
        }
        assert!((all - 1.0).abs() < 0.01, "{all}");
        // Rays of random impact parameters and Fresnel's reflectances, followed one by one: 0.765 at n = 1.333.
        assert!((forward / all - 0.765).abs() < 0.005, "{}", forward / all);
    }
}
