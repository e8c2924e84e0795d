//! The bow as a color scale: one wavelength at each angle, as a published system paints it.
//!
//! n(β) = 1.343 − 0.012 (β − 40°)/3°,   λ(n) = 380 nm + 400 nm (1.343 − n)/0.012
//! t = C w/(Δλ ΔΩ) where λ(β) lies in the bin of width Δλ, 0 elsewhere   [1/sr],  t = (dσ/dΩ)/(π a²)
//! `β` = π − θ angle from the antisolar point, violet (380 nm) at 40 degrees, red (780 nm) at 43, no bow
//! outside. `w` is the part of the bin within 380 to 780 nm, `ΔΩ` the solid angle of the ring on which it
//! lies and `C` the light that geometric optics sends between 40 and 43 degrees at the middle index,
//! 1.337, in natural light: so a bin carries that light wherever it lies, and the bow as a whole has the
//! brightness of the primary. The system states hues and no brightness; this is ours. No polarisation
//! is known: both are the same. Nothing depends on the size of the drops.
//!
//! Against geometric optics the colors are pure, the order of the angles is right (43 degrees is some
//! 0.6 degrees too far for red) and there is no light inside the bow.

use std::f64::consts::PI;
use std::f64::consts::TAU;

use niji_radiometry::Nanometers;
use niji_radiometry::Radians;

use crate::geometric::GeometricOrder;

/// Angle from the antisolar point, index and wavelength at the violet end.
const VIOLET: (f64, f64, f64) = (40.0, 1.343, 380.0);
/// The same at the red end.
const RED: (f64, f64, f64) = (43.0, 1.331, 780.0);

/// The bow in one bin of wavelengths.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PublishedGeometricBow {
    /// Scattering angles between which the bin lies, in radians.
    ring_rad: (f64, f64),
    /// t on it, 1/sr.
    height: f64,
}

/// The scattering angle of a wavelength in radians.
fn theta_rad(wavelength_nm: f64) -> f64 {
    let part = (wavelength_nm - VIOLET.2) / (RED.2 - VIOLET.2);
    PI - (VIOLET.0 + part * (RED.0 - VIOLET.0)).to_radians()
}

/// Solid angle of a ring.
fn solid_angle((from_rad, to_rad): (f64, f64)) -> f64 {
    // cos θ1 − cos θ2 without cancellation.
    2.0 * TAU * (0.5 * (from_rad + to_rad)).sin() * (0.5 * (to_rad - from_rad)).sin()
}

impl PublishedGeometricBow {
    /// The bow in the bin about `center`; dark if the bin lies outside of 380 to 780 nm, `None` unless
    /// the width is positive and both are numbers.
    #[must_use]
    pub fn new(center: Nanometers, bin_width: Nanometers) -> Option<Self> {
        let (center_nm, width_nm) = (center.0, bin_width.0);
        if !(width_nm > 0.0 && width_nm.is_finite() && center_nm.is_finite()) {
            return None;
        }
        let from_nm = (center_nm - 0.5 * width_nm).max(VIOLET.2);
        let to_nm = (center_nm + 0.5 * width_nm).min(RED.2);
        // Long waves lie at small scattering angles.
        let ring_rad = (theta_rad(to_nm), theta_rad(from_nm));
        let height = if to_nm > from_nm {
            light_of_the_bow()? * (to_nm - from_nm) / width_nm / solid_angle(ring_rad)
        } else {
            0.0
        };
        Some(Self { ring_rad, height })
    }

    /// (dσ/dΩ)/(π a²) in 1/sr for the polarisations s and p, the mean over the bin.
    #[must_use]
    pub fn normalized_cross_section(&self, theta: Radians) -> [f64; 2] {
        let (from_rad, to_rad) = self.ring_rad;
        let is_lit = (from_rad..to_rad).contains(&theta.0);
        [if is_lit { self.height } else { 0.0 }; 2]
    }

    /// The same averaged over the solid angle of the ring between two scattering angles.
    #[must_use]
    pub fn mean_over_ring(&self, from: Radians, to: Radians) -> [f64; 2] {
        if to.0 <= from.0 {
            return self.normalized_cross_section(from);
        }
        let shared = (from.0.max(self.ring_rad.0), to.0.min(self.ring_rad.1));
        if shared.1 <= shared.0 {
            return [0.0; 2];
        }
        [self.height * solid_angle(shared) / solid_angle((from.0, to.0)); 2]
    }
}

/// What geometric optics sends between 40 and 43 degrees from the antisolar point in natural light, in
/// parts of the light that meets the drop.
fn light_of_the_bow() -> Option<f64> {
    let ring_rad = (theta_rad(RED.2), theta_rad(VIOLET.2));
    let primary = GeometricOrder::new(0.5 * (VIOLET.1 + RED.1), 2)?;
    let [s, p] = primary.mean_over_ring(Radians(ring_rad.0), Radians(ring_rad.1));
    Some(0.5 * (s + p) * solid_angle(ring_rad))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rainbow_ray::rainbow_ray;

    fn bins() -> impl Iterator<Item = PublishedGeometricBow> {
        let center = |index| Nanometers(380.0 + 10.0 * f64::from(index));
        (0..41)
            .map(move |index| PublishedGeometricBow::new(center(index), Nanometers(10.0)).unwrap())
    }

    /// The wavelength at an angle of the bow from the antisolar point, by way of the index as published.
    fn published_nm(bow_deg: f64) -> f64 {
        let part = (bow_deg - VIOLET.0) / (RED.0 - VIOLET.0);
        let index = VIOLET.1 + part * (RED.1 - VIOLET.1);
        VIOLET.2 + (RED.2 - VIOLET.2) * (VIOLET.1 - index) / (VIOLET.1 - RED.1)
    }

    #[test]
    fn the_scale_runs_from_violet_inside_to_red_outside() {
        for (deg, expected_nm) in [(40.000_001, 380.0), (41.5, 580.0), (42.999_999, 780.0)] {
            let found_nm = published_nm(deg);
            assert!((found_nm - expected_nm).abs() < 1e-3);
            assert!((theta_rad(found_nm).to_degrees() - (180.0 - deg)).abs() < 1e-9);
        }
    }

    #[test]
    fn every_angle_of_the_bow_is_lit_by_one_bin_and_no_other_angle_by_any() {
        for step in 0..1000 {
            let bow_deg = 38.0 + 0.007 * f64::from(step);
            let theta = Radians::from_degrees(180.0 - bow_deg);
            let n_lit = bins()
                .filter(|bin| bin.normalized_cross_section(theta)[0] > 0.0)
                .count();
            let expected = usize::from((40.0..43.0).contains(&bow_deg));
            assert_eq!(n_lit, expected, "{bow_deg} deg");
        }
    }

    #[test]
    fn a_bin_has_the_light_of_the_primary_bow_between_40_and_43_degrees() {
        let primary = GeometricOrder::new(1.337, 2).unwrap();
        let edge = |deg: f64| Radians::from_degrees(deg);
        let [s, p] = primary.mean_over_ring(edge(137.0), edge(140.0));
        for (index, bin) in bins().enumerate() {
            // The first and the last bin are half outside.
            let inside = if index == 0 || index == 40 { 0.5 } else { 1.0 };
            let [mean, _] = bin.mean_over_ring(edge(137.0), edge(140.0));
            assert!((mean / (0.5 * (s + p) * inside) - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn rings_share_out_the_light_of_a_bin() {
        let bin = PublishedGeometricBow::new(Nanometers(550.0), Nanometers(10.0)).unwrap();
        let edge = |ring: i32| Radians::from_degrees(0.05 * f64::from(ring));
        let light: f64 = (0..3600)
            .map(|ring| {
                let mean = bin.mean_over_ring(edge(ring), edge(ring + 1))[0];
                mean * solid_angle((edge(ring).0, edge(ring + 1).0))
            })
            .sum();
        assert!((light / light_of_the_bow().unwrap() - 1.0).abs() < 1e-12);
    }

    #[test]
    fn the_ends_of_the_scale_are_within_a_degree_of_descartes_rays() {
        for (bow_deg, index, _) in [VIOLET, RED] {
            let ray = rainbow_ray(index, 2).unwrap();
            let off = 180.0 - ray.theta_rad().to_degrees() - bow_deg;
            assert!(off.abs() < 1.0, "{bow_deg} deg: {off}");
        }
    }

    #[test]
    fn light_outside_of_the_scale_is_dark_and_a_bin_without_width_is_none() {
        let dark = PublishedGeometricBow::new(Nanometers(900.0), Nanometers(10.0)).unwrap();
        let theta = Radians::from_degrees(138.0);
        assert_eq!(dark.normalized_cross_section(theta), [0.0; 2]);
        assert_eq!(dark.mean_over_ring(Radians(0.0), Radians(PI)), [0.0; 2]);
        assert_eq!(dark.normalized_cross_section(Radians(f64::NAN)), [0.0; 2]);
        for (center_nm, width_nm) in [
            (550.0, 0.0),
            (550.0, -1.0),
            (f64::NAN, 10.0),
            (550.0, f64::NAN),
        ] {
            assert_eq!(
                PublishedGeometricBow::new(Nanometers(center_nm), Nanometers(width_nm)),
                None
            );
        }
    }
}
