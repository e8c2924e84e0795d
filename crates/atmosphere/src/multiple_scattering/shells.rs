//! Heights at which diffuse light is kept.
//!
//! g(h) = mean over constituents of  integral from 0 to h of sqrt(rho) dh / that up to the top
//! is cut into even steps. Light changes with the air that it crosses, as rho does, and interpolation
//! between heights a step apart errs as the square of the step times rho: the sum of errors is least
//! where steps are as 1/sqrt(rho).

use niji_exchange::AtmosphereTable;

/// Steps of the integral over each of the shells.
const STEPS_PER_LAYER: usize = 32;

/// `n_layers + 1` heights from the ground to the top, rising.
pub(crate) fn shells_m(air: &AtmosphereTable, n_layers: usize) -> Vec<f64> {
    let top_m = air.top_height_m;
    let n_steps = n_layers * STEPS_PER_LAYER;
    // Fine near the ground, where haze lies.
    let height_m = |i: usize| top_m * (i as f64 / n_steps as f64).powi(3);
    let mut g = vec![0.0; n_steps + 1];
    for constituent in &air.constituents {
        let mut sums = vec![0.0_f64];
        for i in 0..n_steps {
            let (low_m, high_m) = (height_m(i), height_m(i + 1));
            let density = constituent.density_at(0.5 * (low_m + high_m));
            sums.push(sums[i] + (high_m - low_m) * density.max(0.0).sqrt());
        }
        let whole = sums[n_steps];
        if whole > 0.0 {
            for (g, sum) in g.iter_mut().zip(sums) {
                *g += sum / whole;
            }
        }
    }
    let mut shells_m = vec![0.0];
    for layer in 1..n_layers {
        let wanted = g[n_steps] * layer as f64 / n_layers as f64;
        let above = g.partition_point(|&g| g <= wanted).clamp(1, n_steps);
        let (from, to) = (g[above - 1], g[above]);
        let share = if to > from {
            (wanted - from) / (to - from)
        } else {
            // No air at all: any heights will do.
            layer as f64 / n_layers as f64
        };
        let (low_m, high_m) = (height_m(above - 1), height_m(above));
        shells_m.push(low_m + (high_m - low_m) * share);
    }
    shells_m.push(top_m);
    shells_m
}

#[cfg(test)]
mod tests {
    use niji_geometry::EARTH;
    use niji_radiometry::Reflectance;
    use niji_radiometry::WavelengthGrid;

    use super::*;
    use crate::aerosol::AerosolKind;
    use crate::air_model::AirModel;
    use crate::constituent::Constituent;
    use crate::ozone::OzoneLayer;
    use crate::rayleigh_nishita::NishitaAir;

    fn grid() -> WavelengthGrid {
        WavelengthGrid::new(550.0, 10.0, 1).unwrap()
    }

    fn molecules() -> Constituent {
        NishitaAir::PUBLISHED.constituent(&grid()).unwrap()
    }

    fn air(constituents: Vec<Constituent>) -> AtmosphereTable {
        let model = AirModel {
            planet: EARTH,
            top_height_m: 1e5,
            wavelengths: grid(),
            sun_scale: 1.0,
            ground: Reflectance::Even(0.0),
            constituents,
        };
        model.tabulate().unwrap()
    }

    #[test]
    fn shells_rise_from_the_ground_to_the_top_whatever_the_air() {
        let haze = AerosolKind::Rural.aerosol().constituent(&grid()).unwrap();
        let ozone = OzoneLayer::of_column(300.0).constituent(&grid()).unwrap();
        for constituents in [
            vec![],
            vec![ozone.clone()],
            vec![molecules()],
            vec![molecules(), ozone, haze],
        ] {
            let table = air(constituents);
            for n_layers in [1, 2, 16, 40] {
                let shells_m = shells_m(&table, n_layers);
                assert_eq!(shells_m.len(), n_layers + 1);
                assert!(shells_m.is_sorted_by(|a, b| a < b), "{shells_m:?}");
                assert!(shells_m[0].abs() < 1e-9 && (shells_m[n_layers] - 1e5).abs() < 1e-9);
            }
        }
    }

    #[test]
    fn exponential_air_has_even_steps_of_the_root_of_its_density() {
        let table = air(vec![molecules()]);
        let scale_m = table.column_at(0, 0.0, 1.0);
        for (i, height_m) in shells_m(&table, 8).into_iter().enumerate().take(8) {
            let expected_m = -2.0 * scale_m * (1.0 - i as f64 / 8.0).ln();
            assert!((height_m - expected_m).abs() < 0.02 * expected_m + 1.0);
        }
    }
}
