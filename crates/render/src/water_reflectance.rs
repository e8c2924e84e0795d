//! Fresnel's reflectance of water for the two polarizations.
//!
//! R_s = [(c - g)/(c + g)]²,   R_p = [(n² c - g)/(n² c + g)]²,   g = (n² - 1 + c²)^½
//! `c` cosine of the angle of incidence, of the sun over still water the sine of its elevation, `n`
//! refractive index of the water relative to the air. `s` is across the plane of incidence: horizontal.
//! Water absorbs too little in the visible for it to matter: its imaginary index stays below 1e-7.
//! [BW99] Born and Wolf, Principles of Optics (1999), section 1.5.2, eq. 21a.

/// R_s and R_p.
pub(crate) fn water_reflectance(index: f64, cos_incidence: f64) -> [f64; 2] {
    let (n2, c) = (index * index, cos_incidence);
    let g = (n2 - 1.0 + c * c).sqrt();
    [(c - g) / (c + g), (n2 * c - g) / (n2 * c + g)].map(|amplitude| amplitude * amplitude)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Index of water in green light.
    const INDEX: f64 = 1.3347;

    fn natural_and_degree(elevation_deg: f64) -> (f64, f64) {
        let [s, p] = water_reflectance(INDEX, elevation_deg.to_radians().sin());
        (0.5 * (s + p), (s - p) / (s + p))
    }

    #[test]
    fn grazing_light_is_mirrored_whole_and_steep_light_as_the_textbook_says() {
        assert_eq!(water_reflectance(INDEX, 0.0), [1.0; 2]);
        let textbook = ((INDEX - 1.0) / (INDEX + 1.0)).powi(2);
        for found in water_reflectance(INDEX, 1.0) {
            assert!((found - textbook).abs() < 1e-15);
        }
    }

    #[test]
    fn at_brewsters_angle_all_light_is_horizontal() {
        let cos_incidence = INDEX.atan().cos();
        let [s, p] = water_reflectance(INDEX, cos_incidence);
        assert!(p < 1e-30);
        // [(n² - 1)/(n² + 1)]².
        let expected = ((INDEX * INDEX - 1.0) / (INDEX * INDEX + 1.0)).powi(2);
        assert!((s - expected).abs() < 1e-15);
    }

    #[test]
    fn steady_light_is_what_amplitudes_of_refracted_rays_make_it() {
        for elevation_deg in [1.0, 10.0, 37.0, 80.0_f64] {
            let incidence = (90.0 - elevation_deg).to_radians();
            let refraction = (incidence.sin() / INDEX).asin();
            // Fresnel's sine and tangent laws.
            let s = ((incidence - refraction).sin() / (incidence + refraction).sin()).powi(2);
            let p = ((incidence - refraction).tan() / (incidence + refraction).tan()).powi(2);
            let found = water_reflectance(INDEX, elevation_deg.to_radians().sin());
            assert!((found[0] - s).abs() < 1e-12 && (found[1] - p).abs() < 1e-12);
        }
    }

    #[test]
    fn the_sun_in_water_fades_and_polarizes_as_it_rises() {
        // To three and two digits.
        for (elevation_deg, reflectance, degree) in [
            (3.0, 0.722, 0.09),
            (5.0, 0.584, 0.16),
            (10.0, 0.349, 0.31),
            (20.0, 0.134, 0.65),
            (30.0, 0.060, 0.93),
            (40.0, 0.034, 0.98),
        ] {
            let (natural, polarized) = natural_and_degree(elevation_deg);
            assert!((natural - reflectance).abs() < 6e-4, "{elevation_deg}");
            assert!((polarized - degree).abs() < 6e-3, "{elevation_deg}");
        }
    }
}
