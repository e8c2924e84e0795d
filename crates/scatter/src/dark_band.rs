//! Where Alexander's dark band lies.
//!
//! θ_2 and θ_3 are the scattering angles of the rainbow rays of the primary and the secondary bow in green
//! light; between them no ray of either order leaves a sphere. Their middle divides the light of a picture
//! into that of both bows.

use std::f64::consts::PI;

use niji_airy::rainbow_ray;
use niji_radiometry::Nanometers;
use niji_radiometry::Water;

/// Wavelength that decides where the two bows are split.
const SPLIT_WAVELENGTH: Nanometers = Nanometers(560.0);
/// Where no bow is.
const SOMEWHERE_RAD: f64 = 0.75 * PI;

/// θ_2 and θ_3 in radians.
///
/// ```
/// use niji_radiometry::Water;
///
/// let [primary_rad, secondary_rad] = niji_scatter::dark_band_rad(Water::pure(15.0));
/// let bow_deg = |theta_rad: f64| 180.0 - theta_rad.to_degrees();
/// assert!((bow_deg(primary_rad) - 41.9).abs() < 0.1);
/// assert!((bow_deg(secondary_rad) - 51.2).abs() < 0.1);
/// ```
pub fn dark_band_rad(water: Water) -> [f64; 2] {
    let index = water.refractive_index(SPLIT_WAVELENGTH);
    [2, 3].map(|p| rainbow_ray(index, p).map_or(SOMEWHERE_RAD, |ray| ray.theta_rad()))
}
