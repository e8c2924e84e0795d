//! `niji eval air`: transmittance, optical depth and in-scattering along given rays.

mod flags;
mod rays;

use std::path::PathBuf;

use clap::Args;
use clap::ValueEnum;
use niji_atmosphere::AirSample;
use niji_atmosphere::InScattering;
use niji_atmosphere::ScatteringOrders;
use niji_atmosphere::evaluate_rays;
use niji_atmosphere::with_diffuse_light;
use niji_exchange::AtmosphereTable;
use niji_radiometry::Radians;
use niji_radiometry::WavelengthGrid;
use niji_scene::Body;
use niji_scene::Scene;
use niji_scene::Sun;

use super::csv::line;
use crate::failure::Failure;
use crate::flags::Common;
use crate::flags::numbers;
use crate::scene_file;
use flags::AirFlags;
use rays::AskedRay;
use rays::COLUMNS;
use rays::RayFlags;

/// Width of the bins around given wavelengths, nm.
const USUAL_BIN_NM: f64 = 1.0;
/// Relative error of the adaptive method.
const USUAL_ERROR: f64 = 1e-6;
const USUAL_NODES: usize = 16;
const USUAL_SUN_NODES: usize = 12;
const USUAL_STEPS: usize = 50;
const MAX_SAMPLES: usize = 2_000;
/// The sun where no scene says more of it.
const OVERHEAD: Sun = Sun {
    body: Body::Sun,
    phase_angle_deg: None,
    elevation_deg: 90.0,
    azimuth_deg: 0.0,
};

/// Air along rays: optical depth, transmittance, in-scattered light, the sun's beam.
///
/// The air is that of flags or of a scene. The observer stands at a height over a spherical planet;
/// without refraction.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  niji eval air --rayleigh nishita --view-zenith-deg 0,60,85 --sun-zenith-deg 60 \\
      --wavelengths-nm 450,550,650
  niji eval air --constituents rayleigh,ozone,aerosol --aerosol rural --visibility-km 10 \\
      --view-zenith-deg 90 --distance-m 100,1000,10000 --azimuth-deg 180 --sun-zenith-deg 80 \\
      --wavelengths-nm 550 --sun-irradiance g173
  niji eval air --scene data/scenes/rain-cell-8-km.toml --rays-file rays.csv

Columns, one row per ray and wavelength:
  height_m,view_zenith_deg,azimuth_deg,distance_m,sun_zenith_deg   the ray as asked for
  wavelength_nm        center of the bin
  optical_depth        of the ray, up to its end, the ground or the top of the air
  transmittance        exp(-optical_depth)
  in_scattering        sunlight scattered once into the ray and attenuated, 1/sr for a sun of 1
  radiance             that and, where the ray ends on the ground, the ground's light; with
                       --orders all also light that air and ground scattered before
  sun_optical_depth    from the observer to the center of the sun; inf behind the ground
  sun_transmittance    share of the sun's disc that arrives at the observer")]
pub(super) struct AirArguments {
    #[command(flatten)]
    rays: RayFlags,
    /// Wavelengths, 300 to 1000 nm [default: those of the scene, or 380 to 780 by 10 nm].
    #[arg(long, value_name = "NM,NM,…")]
    wavelengths_nm: Option<String>,
    /// Width of the bin around each given wavelength, for ozone, bands and g173 [default: 1].
    #[arg(long, value_name = "NM", requires = "wavelengths_nm")]
    bin_nm: Option<f64>,
    /// Irradiance by the sun above the air: a number, or g173 in W/(m2 nm).
    #[arg(long, value_name = "E|g173", default_value = "1", value_parser = irradiance)]
    sun_irradiance: Irradiance,
    /// Radius of the sun's disc, 0 for a point; for the beam only.
    #[arg(long, value_name = "DEG", default_value_t = 0.0)]
    sun_disc_radius_deg: f64,
    /// How light is gathered along the ray.
    #[arg(long, value_name = "NAME", default_value = "adaptive")]
    method: Method,
    /// Nodes on each leg of the ray, or steps on the ray and on every sun ray
    /// [default: quadrature 16, nested 16, midpoint 50].
    #[arg(long, value_name = "N")]
    samples: Option<usize>,
    /// Nodes on each leg of a sun ray, for nested [default: 12].
    #[arg(long, value_name = "N")]
    sun_samples: Option<usize>,
    /// Relative error, for adaptive [default: 1e-6].
    #[arg(long, value_name = "T")]
    relative_error: Option<f64>,
    /// Orders of scattering that count as radiance; all of them take seconds for each wavelength.
    #[arg(long, value_name = "WHICH", default_value = "one")]
    orders: Orders,
    /// Take the air, the ground and the wavelengths of a scene.
    #[arg(long, value_name = "TOML")]
    scene: Option<PathBuf>,
    #[command(flatten)]
    air: AirFlags,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Method {
    /// Gauss-Legendre on panels that are halved until they agree, the sun's path from the table.
    Adaptive,
    /// Gauss-Legendre with a number of nodes on every leg, the sun's path from the table.
    Quadrature,
    /// Gauss-Legendre on the ray and on every sun ray.
    Nested,
    /// The published sum of equal steps on either ray.
    Midpoint,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Orders {
    /// Light that is scattered once.
    One,
    /// Light that is scattered any number of times.
    All,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Irradiance {
    G173,
    Constant(f64),
}

fn irradiance(text: &str) -> Result<Irradiance, String> {
    if text.eq_ignore_ascii_case("g173") {
        return Ok(Irradiance::G173);
    }
    match text.parse::<f64>() {
        Ok(value) if value >= 0.0 && value.is_finite() => Ok(Irradiance::Constant(value)),
        _ => Err(format!("found {text}, expected a number or g173")),
    }
}

pub(super) fn csv(arguments: &AirArguments, common: &Common) -> Result<String, Failure> {
    let rays = arguments.rays.rays()?;
    let request = Request::new(arguments, common)?;
    let mut csv = COLUMNS.join(",")
        + ",wavelength_nm,optical_depth,transmittance,in_scattering,radiance,sun_optical_depth,\
           sun_transmittance\n";
    // Bands depend on the sun: one air for each of its heights, kept while it stays.
    let mut under_sun: Option<(f64, Vec<AtmosphereTable>)> = None;
    for ray in rays {
        let zenith_deg = ray.sun_zenith_deg();
        // Compared with a value that was stored.
        let airs = match under_sun.take() {
            Some((stored_deg, airs)) if stored_deg == zenith_deg => airs,
            _ => request.airs(zenith_deg)?,
        };
        for air in &airs {
            for sample in request.evaluate(air, ray) {
                csv += &row(ray, &sample);
            }
        }
        under_sun = Some((zenith_deg, airs));
    }
    Ok(csv)
}

fn row(ray: AskedRay, sample: &AirSample) -> String {
    let found = [
        sample.wavelength_nm,
        sample.optical_depth,
        sample.transmittance,
        sample.in_scattering,
        sample.radiance,
        sample.sun_optical_depth,
        sample.sun_transmittance,
    ];
    line(&[&ray.0[..], &found[..]].concat())
}

/// The checked request.
struct Request<'a> {
    arguments: &'a AirArguments,
    scene: Option<Scene>,
    grids: Vec<WavelengthGrid>,
    method: InScattering,
    sun_disc_radius: Radians,
}

impl<'a> Request<'a> {
    fn new(arguments: &'a AirArguments, common: &Common) -> Result<Self, Failure> {
        let scene = arguments.scene.as_ref();
        let scene = scene
            .map(|path| scene_file::read(path, common))
            .transpose()?;
        let radius_deg = arguments.sun_disc_radius_deg;
        if !(0.0..=5.0).contains(&radius_deg) {
            let message = format!("found a sun of radius {radius_deg} degrees, expected 0 to 5");
            return Err(Failure::Usage(message));
        }
        Ok(Self {
            arguments,
            grids: grids(arguments, scene.as_ref())?,
            scene,
            method: in_scattering(arguments)?,
            sun_disc_radius: Radians::from_degrees(radius_deg),
        })
    }

    /// The air for every grid of wavelengths.
    fn airs(&self, sun_zenith_deg: f64) -> Result<Vec<AtmosphereTable>, Failure> {
        let sun_elevation = Radians::from_degrees(90.0 - sun_zenith_deg);
        self.grids
            .iter()
            .map(|grid| self.air(*grid, sun_elevation))
            .collect()
    }

    fn air(
        &self,
        grid: WavelengthGrid,
        sun_elevation: Radians,
    ) -> Result<AtmosphereTable, Failure> {
        let usage = |error: niji_atmosphere::Error| Failure::Usage(error.to_string());
        let of_scene = self.scene.as_ref();
        let sun = Sun {
            elevation_deg: sun_elevation.to_degrees(),
            ..of_scene.map_or(OVERHEAD, |scene| scene.sun)
        };
        let model = match of_scene {
            None => self.arguments.air.model(grid, &sun)?,
            Some(scene) => {
                let vacuum =
                    || Failure::Usage("the scene has no section [air]: a vacuum".to_owned());
                let air = scene.air.as_ref().ok_or_else(vacuum)?;
                air.model(grid, scene.ground.albedo.reflectance(), &sun)
                    .map_err(usage)?
            }
        };
        let mut table = model.tabulate().map_err(usage)?;
        if let Irradiance::Constant(value) = self.arguments.sun_irradiance {
            table.sun_irradiance = vec![value; grid.len()];
        }
        Ok(match self.arguments.orders {
            Orders::One => table,
            Orders::All => with_diffuse_light(table, ScatteringOrders::STANDARD),
        })
    }

    fn evaluate(&self, air: &AtmosphereTable, ray: AskedRay) -> Vec<AirSample> {
        evaluate_rays(air, &[ray.view_ray()], self.method, self.sun_disc_radius)
    }
}

fn in_scattering(arguments: &AirArguments) -> Result<InScattering, Failure> {
    let (method, given) = (arguments.method, arguments);
    let counts = method != Method::Adaptive;
    for (flag, is_idle) in [
        ("samples", given.samples.is_some() && !counts),
        (
            "sun-samples",
            given.sun_samples.is_some() && method != Method::Nested,
        ),
        ("relative-error", given.relative_error.is_some() && counts),
    ] {
        if is_idle {
            let message = format!("--{flag} has no effect on this --method");
            return Err(Failure::Usage(message));
        }
    }
    let checked = |n: usize| {
        let message = || format!("found {n} samples, expected 1 to {MAX_SAMPLES}");
        let is_good = (1..=MAX_SAMPLES).contains(&n);
        is_good
            .then_some(n)
            .ok_or_else(|| Failure::Usage(message()))
    };
    let samples = |usual: usize| checked(given.samples.unwrap_or(usual));
    Ok(match method {
        Method::Adaptive => {
            let tolerance = given.relative_error.unwrap_or(USUAL_ERROR);
            if !(1e-12..=0.1).contains(&tolerance) {
                let message = format!("found an error of {tolerance}, expected 1e-12 to 0.1");
                return Err(Failure::Usage(message));
            }
            InScattering::Adaptive { tolerance }
        }
        Method::Quadrature => InScattering::Quadrature {
            n_nodes: samples(USUAL_NODES)?,
        },
        Method::Nested => InScattering::Nested {
            n_nodes: samples(USUAL_NODES)?,
            n_sun_nodes: checked(given.sun_samples.unwrap_or(USUAL_SUN_NODES))?,
        },
        Method::Midpoint => InScattering::Midpoint {
            n_steps: samples(USUAL_STEPS)?,
        },
    })
}

/// One grid for each given wavelength, or one for all of the scene's.
fn grids(arguments: &AirArguments, scene: Option<&Scene>) -> Result<Vec<WavelengthGrid>, Failure> {
    let usage = |error: niji_radiometry::Error| Failure::Usage(error.to_string());
    match (&arguments.wavelengths_nm, scene) {
        (Some(text), _) => {
            let bin_nm = arguments.bin_nm.unwrap_or(USUAL_BIN_NM);
            let one = |nm| WavelengthGrid::new(nm, bin_nm, 1).map_err(usage);
            numbers(text)
                .map_err(Failure::Usage)?
                .into_iter()
                .map(one)
                .collect()
        }
        (None, Some(scene)) => Ok(vec![scene.spectrum]),
        (None, None) => Ok(vec![WavelengthGrid::visible()]),
    }
}
