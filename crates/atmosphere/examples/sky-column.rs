//! Sky radiance of a Rayleigh atmosphere as CSV, for comparison with plane-parallel solvers:
//! `cargo run --release -p niji-atmosphere --example sky-column > sky.csv`.
//!
//! A planet of a million kilometres is plane to 1e-4 up to a zenith angle of 75 degrees. One row for
//! each wavelength, albedo, sun and direction, seen from the ground, per unit solar irradiance.

use std::io::Write;

use niji_atmosphere::AirComponent;
use niji_atmosphere::AirModel;
use niji_atmosphere::DiffuseLight;
use niji_atmosphere::InScattering;
use niji_atmosphere::ScatteringOrders;
use niji_atmosphere::SingleScattering;
use niji_atmosphere::USUAL_TOP_M;
use niji_atmosphere::ViewRay;
use niji_geometry::Planet;
use niji_radiometry::WavelengthGrid;

const ALBEDOS: [f64; 2] = [0.0, 0.3];
const SUN_ZENITHS_DEG: [f64; 4] = [0.0, 30.0, 45.0, 60.0];
const VIEW_ZENITHS_DEG: [f64; 6] = [0.0, 15.0, 30.0, 45.0, 60.0, 75.0];
const AZIMUTHS_DEG: [f64; 3] = [0.0, 90.0, 180.0];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let level = match std::env::args().nth(1).as_deref() {
        Some("draft") => ScatteringOrders::DRAFT,
        Some("fine") => ScatteringOrders::FINE,
        _ => ScatteringOrders::STANDARD,
    };
    let mut out = std::io::stdout().lock();
    writeln!(
        out,
        "wavelength_nm,optical_depth,albedo,sun_zenith_deg,view_zenith_deg,azimuth_deg,single,all"
    )?;
    for ground_albedo in ALBEDOS {
        let model = AirModel {
            planet: Planet { radius_m: 1e9 },
            top_height_m: USUAL_TOP_M,
            wavelengths: WavelengthGrid::new(450.0, 100.0, 3)?,
            sun_scale: 1.0,
            ground_albedo,
            components: vec![AirComponent::RayleighNishita],
        };
        let mut air = model.tabulate()?;
        air.sun_irradiance = vec![1.0; 3];
        let single = SingleScattering::new(&air, InScattering::STANDARD);
        let diffuse = DiffuseLight::new(&air, level);
        for sun_deg in SUN_ZENITHS_DEG {
            for view_deg in VIEW_ZENITHS_DEG {
                for azimuth_deg in AZIMUTHS_DEG {
                    let angles_deg = [90.0 - view_deg, 90.0 - sun_deg, azimuth_deg];
                    let angles_rad = angles_deg.map(f64::to_radians);
                    let ray = ViewRay::from_angles(0.0, angles_rad, f64::INFINITY);
                    let once = single.solve(&ray).radiance;
                    let more = diffuse.radiance_per_sun(&ray);
                    for (index, wavelength) in air.wavelengths.centers().enumerate() {
                        writeln!(
                            out,
                            "{},{},{ground_albedo},{sun_deg},{view_deg},{azimuth_deg},{},{}",
                            wavelength.0,
                            air.optical_depth_at(index, 0.0, 1.0),
                            once[index],
                            once[index] + more[index]
                        )?;
                    }
                }
            }
        }
    }
    Ok(())
}
