//! Sky radiance of clear and hazy air as CSV, for comparison with plane-parallel solvers:
//! `cargo run --release -p niji-atmosphere --example sky-column > sky.csv`.
//!
//! A planet of a million kilometres is plane to 1e-4 up to a zenith angle of 75 degrees. One row for
//! each air, wavelength, albedo, sun and direction, seen from the ground, per unit solar irradiance.
//! An argument `draft` or `fine` chooses another level.

use std::io::Write;

use niji_atmosphere::Aerosol;
use niji_atmosphere::AerosolKind;
use niji_atmosphere::AerosolLobe;
use niji_atmosphere::AirModel;
use niji_atmosphere::BodhaineAir;
use niji_atmosphere::Constituent;
use niji_atmosphere::DiffuseSky;
use niji_atmosphere::InScattering;
use niji_atmosphere::STANDARD_PRESSURE_PA;
use niji_atmosphere::ScatteringOrders;
use niji_atmosphere::SingleScattering;
use niji_atmosphere::USUAL_TOP_M;
use niji_atmosphere::ViewRay;
use niji_atmosphere::king_factor;
use niji_atmosphere::with_diffuse_light;
use niji_geometry::Planet;
use niji_radiometry::Reflectance;
use niji_radiometry::WavelengthGrid;

const ALBEDOS: [f64; 3] = [0.0, 0.3, 0.8];
const SUN_ZENITHS_DEG: [f64; 3] = [0.0, 40.0, 60.0];
const VIEW_ZENITHS_DEG: [f64; 5] = [0.0, 20.0, 45.0, 60.0, 75.0];
const AZIMUTHS_DEG: [f64; 4] = [0.0, 40.0, 90.0, 180.0];
const HEADER: &str = "air,wavelength_nm,molecules_depth,molecules_height_m,king_factor,haze_depth,\
                      haze_height_m,haze_albedo,haze_parameter,albedo,sun_zenith_deg,\
                      view_zenith_deg,azimuth_deg,single,all";

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let level = match std::env::args().nth(1).as_deref() {
        Some("draft") => ScatteringOrders::DRAFT,
        Some("fine") => ScatteringOrders::FINE,
        _ => ScatteringOrders::STANDARD,
    };
    let mut out = std::io::stdout().lock();
    writeln!(out, "{HEADER}")?;
    for (name, haze) in airs()? {
        for albedo in ALBEDOS {
            write_skies(&mut out, (&name, haze), albedo, level)?;
        }
    }
    Ok(())
}

/// Air without haze and with rural and maritime haze of 23 and 10 km of visibility.
fn airs() -> Result<Vec<(String, Option<Aerosol>)>, niji_atmosphere::Error> {
    let mut airs = vec![("molecules".to_owned(), None)];
    for kind in [AerosolKind::Rural, AerosolKind::Maritime] {
        for visibility_km in [23.0, 10.0] {
            let haze = kind.aerosol().with_visibility_m(1e3 * visibility_km)?;
            airs.push((format!("{} {visibility_km}", kind.name()), Some(haze)));
        }
    }
    Ok(airs)
}

fn write_skies(
    out: &mut impl Write,
    (name, haze): (&str, Option<Aerosol>),
    ground_albedo: f64,
    level: ScatteringOrders,
) -> Result<(), Box<dyn std::error::Error>> {
    let wavelengths = WavelengthGrid::new(450.0, 200.0, 2)?;
    let molecules = BodhaineAir::at_pressure(STANDARD_PRESSURE_PA);
    let mut constituents = vec![molecules.constituent(&wavelengths)?];
    if let Some(haze) = haze {
        constituents.push(haze.constituent(&wavelengths)?);
    }
    let model = AirModel {
        planet: Planet { radius_m: 1e9 },
        top_height_m: USUAL_TOP_M,
        wavelengths,
        sun_scale: 1.0,
        ground: Reflectance::Even(ground_albedo),
        constituents,
    };
    let mut air = model.tabulate()?;
    air.sun_irradiance = vec![1.0; air.wavelengths.len()];
    let air = with_diffuse_light(air, level);
    let single = SingleScattering::new(&air, InScattering::STANDARD);
    let diffuse = DiffuseSky::new(&air)?;
    for (index, wavelength) in air.wavelengths.centers().enumerate() {
        let king_factor = king_factor(wavelength);
        let column = column(&model, haze, index);
        for sun_deg in SUN_ZENITHS_DEG {
            for view_deg in VIEW_ZENITHS_DEG {
                for azimuth_deg in AZIMUTHS_DEG {
                    let angles_deg = [90.0 - view_deg, 90.0 - sun_deg, azimuth_deg];
                    let angles_rad = angles_deg.map(f64::to_radians);
                    let ray = ViewRay::from_angles(0.0, angles_rad, f64::INFINITY);
                    let once = single.solve(&ray).radiance[index];
                    let all = once + diffuse.radiance_per_sun(&ray)[index];
                    let [depth, height_m, haze_depth, haze_m, haze_albedo, parameter] = column;
                    writeln!(
                        out,
                        "{name},{},{depth},{height_m},{king_factor},{haze_depth},{haze_m},\
                         {haze_albedo},{parameter},{ground_albedo},{sun_deg},{view_deg},\
                         {azimuth_deg},{once},{all}",
                        wavelength.0
                    )?;
                }
            }
        }
    }
    Ok(())
}

/// Optical depth and scale height of molecules and haze, albedo and parameter of the haze.
fn column(model: &AirModel, haze: Option<Aerosol>, index: usize) -> [f64; 6] {
    let depth = |constituent: &Constituent| {
        let depth = constituent.vertical_optical_depth()[index];
        [depth, constituent.profile.vertical_length_m()]
    };
    let [molecules, height_m] = depth(&model.constituents[0]);
    let Some(haze) = haze else {
        return [molecules, height_m, 0.0, 1e3, 1.0, 0.0];
    };
    let [haze_depth, haze_m] = depth(&model.constituents[1]);
    let (AerosolLobe::HenyeyGreenstein { asymmetry: g }
    | AerosolLobe::CornetteShanks { parameter: g }) = haze.lobe;
    let albedo = haze.single_scattering_albedo;
    [molecules, height_m, haze_depth, haze_m, albedo, g]
}
