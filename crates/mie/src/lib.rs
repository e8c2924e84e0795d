//! Lorenz-Mie scattering by a homogeneous sphere, and its Debye series.
//!
//! Conventions of Bohren and Huffman: time factor exp(-i omega t), refractive index n + ik with
//! k >= 0 absorbing, S1 perpendicular and S2 parallel to the scattering plane, dsigma/dOmega =
//! |S|^2/(2 pi/lambda)^2 for light polarized so, theta = 0 forward. Sizes are x = 2 pi a/lambda
//! from 1e-6 to 1e5.
//! Bohren and Huffman, Absorption and Scattering of Light by Small Particles, Wiley (1983).
//!
//! ```
//! use niji_mie::{RefractiveIndex, ScatteringAngles, Sphere};
//!
//! let sphere = Sphere::new(1000.0, RefractiveIndex::from(1.333))?;
//! assert!((sphere.efficiencies().q_ext - 2.0228114332201634).abs() < 1e-11);
//!
//! let angles = ScatteringAngles::from_degrees(&[0.0, 138.0, 180.0])?;
//! let all_light = sphere.amplitudes(&angles);
//! let primary_bow = sphere.debye(2).amplitudes(&angles);
//! assert!(primary_bow.s1[1].norm_sqr() > 100.0 * primary_bow.s1[0].norm_sqr());
//! assert!(sphere.p11(&all_light)[0] > 1e5);
//! # Ok::<(), niji_mie::Error>(())
//! ```

mod amplitudes;
mod angles;
mod debye;
mod efficiencies;
mod error;
mod lorenz_mie;
mod partial_waves;
mod refractive_index;
mod riccati_bessel;
mod sphere;
mod wave_sum;

pub use crate::amplitudes::Amplitudes;
pub use crate::angles::ScatteringAngles;
pub use crate::debye::DebyeSeries;
pub use crate::efficiencies::Efficiencies;
pub use crate::error::Error;
pub use crate::partial_waves::PartialWaves;
pub use crate::partial_waves::cross_sections_of_each;
pub use crate::refractive_index::RefractiveIndex;
pub use crate::sphere::Sphere;
