//! Fog, which hides within metres what lies behind, against closed forms.
//!
//! In an even light of radiance L from everywhere, air that scatters all that it takes shines with L in every
//! direction, whatever its depth.

#![allow(clippy::unwrap_used, reason = "tests stop at what they did not expect")]

mod common;

use common::*;
use glam::DVec3;
use niji_exchange::AtmosphereTable;
use niji_render::AirPath;
use niji_render::LitDrops;
use niji_render::PictureLayer;
use niji_render::SkyModel;

/// Visibility of fogs, m.
const VISIBILITIES_M: [f64; 4] = [10.0, 30.0, 100.0, 1000.0];

/// Air up to 100 km that scatters all that it takes.
fn fog(visibility_m: f64) -> AtmosphereTable {
    let extinction_m1 = [3.912 / visibility_m; 3];
    let mut air = air(extinction_m1, extinction_m1);
    air.ground_albedo = vec![1.0; 3];
    air.diffuse = Some(uniform_light(0.25));
    air
}

#[test]
fn fog_in_an_even_light_is_bright_however_dense() {
    let (drops, table) = (LitDrops::none(), isotropic(1.0));
    let sun = sun_in_the_south(-30.0);
    for visibility_m in VISIBILITIES_M {
        let air = fog(visibility_m);
        for elevation_deg in [-60.0, -2.0, 0.0, 3.0, 90.0] {
            let eye = DVec3::new(0.0, 1.6, 0.0);
            let camera = camera(eye, (0.0, elevation_deg), 20.0, (4, 3));
            for path in [AirPath::Table, AirPath::Quadrature { n_nodes: 32 }] {
                let mut request = request(&camera, sun, &drops, &table);
                request.air = Some(&air);
                request.effects = with_air_light();
                request.levels.air_path = path;
                request.levels.sky_model = SkyModel::MultipleScattering;
                let picture = rendered(&request);
                for ((wavelength, ..), light) in picture.radiance.indexed_iter() {
                    // Measured 2e-4.
                    let error = relative(f64::from(*light), 0.25 * SUN[wavelength]);
                    assert!(error < 1e-3, "{visibility_m} m, {elevation_deg}: {light}");
                }
            }
        }
    }
}

#[test]
fn drops_in_a_fog_are_seen_as_far_as_it_lets_see() {
    // Black but for what the fog in front of them sends: L (1 - exp(-beta s)).
    let sun = sun_in_the_south(-30.0);
    let grid = niji_dropfield::GridBox {
        min: DVec3::new(-2.0, -2.0, -22.0),
        max: DVec3::new(2.0, 4.0, -18.0),
        voxel_m: 0.5,
    };
    let wall = bricks(&grid, |_| 1e3);
    let drops = LitDrops::new(vec![wall], sun, niji_render::SunPath::Ignore).unwrap();
    let table = isotropic(0.0);
    for visibility_m in VISIBILITIES_M {
        let air = fog(visibility_m);
        let camera = one_ray(DVec3::new(0.0, 1.6, 0.0));
        let mut request = request(&camera, sun, &drops, &table);
        request.air = Some(&air);
        request.effects = with_air_light();
        request.levels.sky_model = SkyModel::MultipleScattering;
        let picture = rendered(&request);
        let found = f64::from(picture.radiance[[0, 0, 0]]);
        // The wall begins within a voxel of 18 m.
        let shares = [17.75, 18.0].map(|s| -(-3.912 / visibility_m * s).exp_m1());
        let light = shares.map(|share| 0.25 * SUN[0] * share);
        assert!(
            found > 0.999 * light[0] && found < 1.001 * light[1],
            "{visibility_m} m: {found}, expected {light:?}"
        );
        assert!(
            picture[PictureLayer::Error]
                .iter()
                .all(|error| error.is_finite())
        );
    }
}
