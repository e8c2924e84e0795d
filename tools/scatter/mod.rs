//! `niji scatter`: the scattering table of a scene, or of flags; plotted, exported and compared.

mod compare;
mod export;
mod plot;

use std::path::PathBuf;

use clap::Args;
use niji_exchange::ScatteringTable;
use niji_radiometry::WavelengthGrid;
use niji_scatter::DropMotion;
use niji_scatter::SizeRows;
use niji_scatter::Theory;
use niji_scene::ScatteringNeed;
use niji_sizes::bin_step;
use niji_sizes::bins;
use niji_sizes::radius_axis;
use niji_sizes::variance_axis;

use crate::failure::Failure;
use crate::flags::Common;
use crate::flags::numbers;
use crate::output;
use crate::progress::Verbosity;
use crate::scatter::export::Format;
use crate::scene_file;
use crate::stages;
use crate::stages::scatter::TableInputs;
use crate::theory_name::TheoryName;
use crate::water_flags::WaterFlags;

/// Tabulate how drops scatter (EXR).
///
/// Gives (dsigma/dOmega)/(pi <r^2>) in 1/sr for both polarizations by scattering angle, wavelength,
/// effective radius and variance. With --compare it answers which theory is good enough for one
/// drop size instead; with --plot it draws, with --export it writes for other renderers.
#[derive(Clone, Debug, Args)]
#[command(after_help = "Examples:
  niji scatter --scene scene.toml --airy airy.exr -o scatter.exr
  niji scatter --theory mie --effective-radius-um 10 --effective-variance 0.1 -o fog.exr
  niji scatter --theory uniform --effective-radius-um 100,1000 --theta-deg 120,180 -o rain.exr
  niji scatter --theory uniform --radii-um 20,3000 --flattened --theta-deg 100,180 -o any-rain.exr
  niji scatter --theory by-size --radii-um 1,4000 --effective-variance 0.05 --flattened \
      --orders 0,2,3,6,7 --theta-deg 50,180 --relative-error 0.005 --temperature-c 15 \
      -o fog-to-rain.exr
  niji scatter --compare airy,uniform,mie --effective-radius-um 8 --plot fogbow.svg
  niji scatter --table rain.exr --plot rain.svg
  niji scatter --theory mie --effective-radius-um 100 --export csv -o phase.csv

--compare prints theory,relative_rmse,max_over_peak,mean_color_difference,max_color_difference,
peak_shift_deg,seconds against the most accurate theory of the list; color differences are CIEDE2000.
--export csv: theta_deg,wavelength_nm,effective_radius_um,effective_variance,s_sr1,p_sr1.
--export mitsuba: one tabphase for each wavelength, with the albedo that undoes its normalisation.")]
pub(crate) struct ScatterCommand {
    /// The scene whose plan says what is needed.
    #[arg(long, value_name = "TOML", conflicts_with_all = ["theory", "effective_radius_um", "radii_um"])]
    scene: Option<PathBuf>,
    /// A finished table to plot or export, instead of making one.
    #[arg(long, value_name = "EXR", conflicts_with_all = ["scene", "theory", "effective_radius_um", "radii_um"])]
    table: Option<PathBuf>,
    /// The table of f(z), for airy and airy-published; without it every value is computed.
    #[arg(long, value_name = "EXR")]
    airy: Option<PathBuf>,
    /// How a drop scatters.
    #[arg(long, required_unless_present_any = ["scene", "table", "compare"])]
    theory: Option<TheoryName>,
    /// Compare theories for one drop size, the most accurate of them the reference.
    #[arg(long, value_name = "T,T", value_delimiter = ',', conflicts_with_all = ["scene", "table", "theory", "export"])]
    compare: Vec<TheoryName>,
    /// Orders that take part, 0 to 7: 2 primary, 3 secondary bow [default: 2,3; all for --compare].
    #[arg(long, value_name = "P,P")]
    orders: Option<String>,
    /// Effective radius, or the smallest and largest of a range.
    #[arg(long, value_name = "UM[,UM]", required_unless_present_any = ["scene", "table", "radii_um"])]
    effective_radius_um: Option<String>,
    /// Effective variance, or the smallest and largest of a range; beside --radii-um that of the narrowest
    /// law, the larger the fewer radii, 0 for drops of one size.
    #[arg(long, value_name = "V[,V]", default_value = "0")]
    effective_variance: String,
    /// Single radii of a range in place of --effective-radius-um: a table that serves any law of such drops,
    /// and any scene of the same water, wavelengths and theory.
    #[arg(long, value_name = "UM,UM", conflicts_with = "effective_radius_um")]
    radii_um: Option<String>,
    /// Keep apart what flattening moves, so that the table serves flattened drops too.
    #[arg(long)]
    flattened: bool,
    /// Add phase functions at all angles, for light that drops scatter more than once.
    #[arg(long)]
    phase_functions: bool,
    /// Smallest and largest scattering angle, 0 = forward [default: 0,180; 120,160 for --compare].
    #[arg(long, value_name = "DEG,DEG")]
    theta_deg: Option<String>,
    /// First wavelength, step and number of wavelengths.
    #[arg(long, value_name = "NM,NM,N", default_value = "380,10,41")]
    spectrum: String,
    /// Error of interpolation along every axis over the peak of the bow.
    #[arg(long, value_name = "E", default_value_t = 2e-3)]
    relative_error: f64,
    /// Diameter of the sun's disc; 0 for a point.
    #[arg(long, value_name = "DEG", default_value_t = 0.533)]
    sun_disc_deg: f64,
    /// The water.
    #[command(flatten)]
    water: WaterFlags,
    /// Draw intensity against angle.
    #[arg(long, value_name = "SVG")]
    plot: Option<PathBuf>,
    /// Write the table for another program instead of as EXR.
    #[arg(long, value_name = "FORMAT", requires = "output")]
    export: Option<Format>,
    /// The file to write.
    #[arg(short, long, value_name = "FILE", required_unless_present_any = ["plot", "compare"])]
    output: Option<PathBuf>,
}

/// Orders of a table unless others are asked for.
const BOWS: &str = "2,3";
/// Angles of a table unless others are asked for.
const ALL_ANGLES_DEG: &str = "0,180";

/// Runs the stage.
///
/// # Errors
/// As [`stages::scatter::make`]; a scene that needs no table; an output that exists.
pub(crate) fn execute(command: &ScatterCommand, common: &Common) -> Result<(), Failure> {
    let options = common.options();
    for path in [&command.plot].into_iter().flatten() {
        output::check_free(path, options.existing)?;
    }
    if !command.compare.is_empty() {
        return compare::execute(command, common);
    }
    let Some(table) = table(command, common)? else {
        return Ok(());
    };
    if let (Some(format), Some(path)) = (command.export, &command.output) {
        output::check_free(path, options.existing)?;
        export::write(format, &table, path)?;
    }
    match &command.plot {
        Some(path) => plot::of_table(&table).write_svg(path),
        None => Ok(()),
    }
}

/// The table that was asked for; written to the output unless that is for an export, and `None` if
/// nothing is left to do with it then.
fn table(command: &ScatterCommand, common: &Common) -> Result<Option<ScatteringTable>, Failure> {
    if let Some(path) = &command.table {
        return stages::scatter::read(path).map(Some);
    }
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
    let options = common.options();
    match &command.output {
        Some(path) if command.export.is_none() => {
            let made_from = TableInputs {
                need: &need,
                wavelengths,
                airy,
            };
            stages::scatter::make(made_from, path, options)?;
            if command.plot.is_none() && options.verbosity <= Verbosity::Normal {
                return Ok(None);
            }
            let table = stages::scatter::read(path)?;
            if options.verbosity > Verbosity::Normal
                && let Some(error) = stages::scatter::interpolation_error(&table)
            {
                options.verbosity.say(error);
            }
            Ok(Some(table))
        }
        _ => stages::scatter::computed(&need, wavelengths, airy, options.verbosity).map(Some),
    }
}

fn of_scene(
    path: &std::path::Path,
    common: &Common,
) -> Result<(ScatteringNeed, WavelengthGrid), Failure> {
    let planned = scene_file::load(path, common)?;
    let unneeded = || Failure::Usage("the plan of this scene needs no scattering table".to_owned());
    let need = planned.plan.scattering.clone().ok_or_else(unneeded)?;
    Ok((need, planned.scene.spectrum))
}

fn of_flags(command: &ScatterCommand) -> Result<(ScatteringNeed, WavelengthGrid), Failure> {
    let theta_deg = command.theta_deg.as_deref().unwrap_or(ALL_ANGLES_DEG);
    let theta_deg = range("theta-deg", theta_deg)?;
    let wavelengths = spectrum(&command.spectrum)?;
    let orders = orders(command.orders.as_deref().unwrap_or(BOWS))?;
    let sizes = sizes(command)?;
    let ends = sizes.0.first().copied().zip(sizes.0.last().copied());
    let need = ScatteringNeed {
        theory: command.theory.map_or(Theory::Airy, Theory::from),
        orders,
        theta_range_rad: (theta_deg.0.to_radians(), theta_deg.1.to_radians()),
        relative_error: command.relative_error,
        effective_radius_um: sizes.0,
        effective_variance: sizes.1,
        support_um: ends.unwrap_or_default(),
        rows: sizes.2,
        motion: command.flattened.then(DropMotion::default),
        phase_functions: command.phase_functions,
        sun_disc_diameter_rad: command.sun_disc_deg.to_radians(),
        water: command.water.water()?,
    };
    Ok((need, wavelengths))
}

/// Radii, variances and what the rows stand for.
fn sizes(command: &ScatterCommand) -> Result<(Vec<f64>, Vec<f64>, SizeRows), Failure> {
    let usage = |error: niji_sizes::Error| Failure::Usage(error.to_string());
    let error = command.relative_error;
    if let Some(radii) = &command.radii_um {
        let radii = range("radii-um", radii)?;
        let (narrowest_variance, _) = range("effective-variance", &command.effective_variance)?;
        variance_axis((narrowest_variance, narrowest_variance)).map_err(usage)?;
        let axis = radius_axis(radii, 0.0, error).map_err(usage)?;
        let widest = command.theory.map_or(f64::INFINITY, |theory| {
            Theory::from(theory).widest_bin(error)
        });
        let step = bin_step(narrowest_variance, error).map(|step| step.min(widest));
        let rows = SizeRows::Bins {
            ln_step: step.unwrap_or(0.0),
            narrowest_variance,
        };
        let axis = step.map_or(axis, |step| bins(radii, step));
        return Ok((axis, vec![0.0], rows));
    }
    let radii = command.effective_radius_um.as_deref().unwrap_or("");
    let radii = range("effective-radius-um", radii)?;
    let variances = range("effective-variance", &command.effective_variance)?;
    let radii = radius_axis(radii, variances.0, error).map_err(usage)?;
    let variances = variance_axis(variances).map_err(usage)?;
    Ok((radii, variances, SizeRows::Laws))
}

/// First wavelength, step and number.
pub(crate) fn spectrum(text: &str) -> Result<WavelengthGrid, Failure> {
    let [first_nm, step_nm, n] = numbers(text).map_err(Failure::Usage)?[..] else {
        return Err(Failure::Usage(
            "--spectrum: expected first,step,number as 380,10,41".to_owned(),
        ));
    };
    let grid = WavelengthGrid::new(first_nm, step_nm, n as usize);
    grid.map_err(|error| Failure::Usage(format!("--spectrum: {error}")))
}

pub(crate) fn orders(text: &str) -> Result<Vec<u32>, Failure> {
    let wrong = |found: &str| {
        Failure::Usage(format!(
            "--orders: found {found:?}, expected numbers from 0 to 7 as 2,3"
        ))
    };
    let order = |entry: &str| entry.trim().parse().map_err(|_| wrong(entry));
    text.split(',').map(order).collect()
}

/// One number, or the ends of a range.
pub(crate) fn range(name: &str, text: &str) -> Result<(f64, f64), Failure> {
    match numbers(text).map_err(|error| Failure::Usage(format!("--{name}: {error}")))?[..] {
        [value] => Ok((value, value)),
        [low, high] => Ok((low, high)),
        _ => Err(Failure::Usage(format!(
            "--{name}: found {text:?}, expected one number or two"
        ))),
    }
}
