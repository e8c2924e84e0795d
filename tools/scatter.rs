//! `niji scatter`: the scattering table of a scene, or of flags.

use std::path::PathBuf;

use clap::Args;
use clap::ValueEnum;
use niji_radiometry::WavelengthGrid;
use niji_scatter::Theory;
use niji_scatter::radius_axis;
use niji_scatter::variance_axis;
use niji_scene::ScatteringNeed;

use crate::cli::Common;
use crate::cli::numbers;
use crate::failure::Failure;
use crate::scene_file;
use crate::stages;

/// Tabulate how drops scatter (EXR).
///
/// From a scene: the orders, angles, sizes and accuracy that its plan needs. From flags: whatever
/// you ask for. Values are (dsigma/dOmega)/(pi <r^2>) in 1/sr, averaged over sizes and the sun's disc.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  niji airy -o airy.exr && niji scatter --scene scene.toml --airy airy.exr -o scatter.exr
  niji scatter --theory mie --effective-radius-um 10 --effective-variance 0.1 -o fog.exr
  niji scatter --theory airy --effective-radius-um 100,1000 --theta-deg 120,180 -o rain.exr")]
pub(crate) struct ScatterCommand {
    /// The scene whose plan says what is needed.
    #[arg(long, value_name = "TOML", conflicts_with_all = ["theory", "effective_radius_um"])]
    scene: Option<PathBuf>,
    /// The table of f(z), for airy and airy-published; without it every value is computed.
    #[arg(long, value_name = "EXR")]
    airy: Option<PathBuf>,
    /// How a drop scatters.
    #[arg(long, required_unless_present = "scene")]
    theory: Option<TheoryName>,
    /// Orders with a bow: 2 primary, 3 secondary, to 7.
    #[arg(long, value_name = "P,P", default_value = "2,3")]
    orders: String,
    /// Effective radius, or the smallest and largest of a range.
    #[arg(long, value_name = "UM[,UM]", required_unless_present = "scene")]
    effective_radius_um: Option<String>,
    /// Effective variance, or the smallest and largest of a range.
    #[arg(long, value_name = "V[,V]", default_value = "0")]
    effective_variance: String,
    /// Smallest and largest scattering angle, 0 = forward.
    #[arg(long, value_name = "DEG,DEG", default_value = "0,180")]
    theta_deg: String,
    /// First wavelength, step and number of wavelengths.
    #[arg(long, value_name = "NM,NM,N", default_value = "380,10,41")]
    spectrum: String,
    /// Error of interpolation along every axis over the peak of the bow.
    #[arg(long, value_name = "E", default_value_t = 2e-3)]
    relative_error: f64,
    /// Diameter of the sun's disc; 0 for a point.
    #[arg(long, value_name = "DEG", default_value_t = 0.533)]
    sun_disc_deg: f64,
    /// Temperature of the water.
    #[arg(
        long,
        value_name = "C",
        default_value_t = 20.0,
        allow_negative_numbers = true
    )]
    temperature_c: f64,
    /// The file to write.
    #[arg(short, long, value_name = "EXR")]
    output: PathBuf,
}

/// The theories by the name they have on the command line.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum TheoryName {
    /// Rays: cheapest, no supernumeraries.
    Geometric,
    /// Airy as I = f^2 M^2, without the factor a lambda.
    AiryPublished,
    /// Airy, absolute.
    Airy,
    /// Debye orders 0 to 7 without interference.
    Debye,
    /// Lorenz-Mie, exact.
    Mie,
}

impl From<TheoryName> for Theory {
    fn from(name: TheoryName) -> Self {
        match name {
            TheoryName::Geometric => Self::Geometric,
            TheoryName::AiryPublished => Self::AiryPublished,
            TheoryName::Airy => Self::Airy,
            TheoryName::Debye => Self::Debye { max_order: 7 },
            TheoryName::Mie => Self::Mie,
        }
    }
}

/// Runs the stage.
///
/// # Errors
/// As [`stages::scatter::make`]; a scene that needs no table.
pub(crate) fn execute(command: &ScatterCommand, common: &Common) -> Result<(), Failure> {
    let (need, wavelengths) = match &command.scene {
        Some(path) => of_scene(path, common)?,
        None => of_flags(command)?,
    };
    let airy = command.airy.as_deref();
    if command.scene.is_some() && need.theory.uses_airy_table() && airy.is_none() {
        return Err(Failure::Usage(
            "this scene needs --airy, made by `niji airy`".to_owned(),
        ));
    }
    stages::scatter::make(&need, wavelengths, airy, &command.output, common.manner()).map(|_| ())
}

fn of_scene(
    path: &std::path::Path,
    common: &Common,
) -> Result<(ScatteringNeed, WavelengthGrid), Failure> {
    let planned = scene_file::load(path, common)?;
    let unneeded = || Failure::Usage("the plan of this scene needs no scattering table".to_owned());
    let need = planned.plan.scattering.clone().ok_or_else(unneeded)?;
    let wavelengths = planned.scene.spectrum.grid();
    Ok((
        need,
        wavelengths.map_err(|error| Failure::bad_input(path, error))?,
    ))
}

fn of_flags(command: &ScatterCommand) -> Result<(ScatteringNeed, WavelengthGrid), Failure> {
    let usage = |error: &dyn std::fmt::Display| Failure::Usage(error.to_string());
    let radii = range(
        "effective-radius-um",
        command.effective_radius_um.as_deref().unwrap_or(""),
    )?;
    let variances = range("effective-variance", &command.effective_variance)?;
    let theta_deg = range("theta-deg", &command.theta_deg)?;
    let spectrum = numbers(&command.spectrum).map_err(Failure::Usage)?;
    let [first_nm, step_nm, n] = spectrum[..] else {
        return Err(Failure::Usage(
            "--spectrum: expected first,step,number as 380,10,41".to_owned(),
        ));
    };
    let wavelengths = WavelengthGrid::new(first_nm, step_nm, n as usize);
    let orders = numbers(&command.orders).map_err(Failure::Usage)?;
    let need = ScatteringNeed {
        theory: command.theory.map_or(Theory::Airy, Theory::from),
        orders: orders.into_iter().map(|order| order as u32).collect(),
        theta_range_rad: (theta_deg.0.to_radians(), theta_deg.1.to_radians()),
        relative_error: command.relative_error,
        effective_radius_um: radius_axis(radii, variances.0, command.relative_error)
            .map_err(|error| usage(&error))?,
        flattening: vec![0.0],
        effective_variance: variance_axis(variances).map_err(|error| usage(&error))?,
        sun_disc_diameter_rad: command.sun_disc_deg.to_radians(),
        temperature_c: command.temperature_c,
    };
    Ok((need, wavelengths.map_err(|error| usage(&error))?))
}

/// One number, or the ends of a range.
fn range(name: &str, text: &str) -> Result<(f64, f64), Failure> {
    match numbers(text).map_err(|error| Failure::Usage(format!("--{name}: {error}")))?[..] {
        [value] => Ok((value, value)),
        [low, high] => Ok((low, high)),
        _ => Err(Failure::Usage(format!(
            "--{name}: found {text:?}, expected one number or two"
        ))),
    }
}
