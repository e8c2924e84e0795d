//! The cheapest level: one chord for all light.
//!
//! L = (1/pi) E exp(-alpha 4V/S),   E mean irradiance of the surface from outside
//! for all light that gets in. Cauchy's mean chord holds for isotropic light in convex bodies.

use niji_geometry::Ray;

use crate::directions::cosine_about;
use crate::radiance_sum::CarriedWavelengths;
use crate::radiance_sum::RadianceSum;
use crate::sampler::Sampler;
use crate::transmittance_table::TransmittanceTable;
use crate::walk::World;

/// Points of the surface at which the irradiance is found: below the noise of any picture.
const N_POINTS: u32 = 4096;

/// The radiance with which light comes out, W m^-2 sr^-1 nm^-1.
///
/// Light that reaches the surface by way of the ice itself is left out.
pub(crate) fn mean_chord_light(world: &mut World, absorption_per_m: &[f64], seed: u32) -> Vec<f64> {
    let n_wavelengths = absorption_per_m.len();
    let mut radiance = vec![0.0; n_wavelengths];
    // While the mean is found, what goes into the ice stays there.
    world.mean_chord_light = Some(vec![0.0; n_wavelengths]);
    let mut sum = RadianceSum {
        table: &TransmittanceTable::new(absorption_per_m),
        light: world.light,
        carried: CarriedWavelengths::All,
        radiance: &mut radiance,
        scratch: &mut vec![0.0; n_wavelengths],
    };
    for index in 0..N_POINTS {
        let sampler = Sampler::new(seed, index);
        let [part, u, v] = sampler.coordinates(0, [4, 5, 6]);
        let (point, normal) = world.body.surface_point([part, u, v]);
        world.add_sun_on(point, normal, &mut sum);
        let direction = cosine_about(normal, sampler.coordinates(0, [2, 3]));
        let outwards = Ray {
            origin: point,
            direction,
        };
        world.follow(outwards, 0, sampler, &mut sum);
    }
    let chord_m = world.body.mean_chord_m();
    let mean =
        |(value, alpha): (&f64, &f64)| value / f64::from(N_POINTS) * (-alpha * chord_m).exp();
    radiance.iter().zip(absorption_per_m).map(mean).collect()
}
