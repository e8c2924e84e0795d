//! `niji lee`: the color of the bow against drop radius, the field's standard picture.
//!
//! Columns are drop radii, even in their logarithm; rows are bow angles (180 degrees − θ), the larger
//! ones on top; every column is drawn relative to its own brightest direction, so that the weak bow of
//! a small drop is seen beside that of a large one.
//! R. L. Lee, Applied Optics 37, 1506-1519 (1998).

use std::f64::consts::PI;
use std::path::PathBuf;

use clap::Args;
use ndarray::Array3;
use niji_exchange::AttributeValue;
use niji_exchange::Attributes;
use niji_exchange::ImageWindows;
use niji_exchange::Spectra;
use niji_exchange::SpectralImage;
use niji_radiometry::WavelengthGrid;
use niji_radiometry::solar_irradiance;
use niji_scatter::SizeRows;
use niji_scatter::Theory;
use niji_scene::ScatteringNeed;
use niji_scene::canonical_json;

use crate::bow_curves::BowCurves;
use crate::failure::Failure;
use crate::flags::Common;
use crate::output;
use crate::plot::Picture;
use crate::scatter::orders;
use crate::scatter::range;
use crate::scatter::spectrum;
use crate::stages;
use crate::stages::Request;
use crate::stages::perform;
use crate::theory_name::TheoryName;
use crate::water_flags::WaterFlags;
use niji_picture::white_luminance_cd_m2;

/// Interpolation error of the table behind the picture, over the peak of the bow.
const RELATIVE_ERROR: f64 = 1e-3;

/// Draw the color of the bow against drop radius (EXR, PNG, SVG).
///
/// Writes a spectral EXR and beside it a PNG and an SVG with axes. Columns are radii, even in their logarithm, rows are bow
/// angles (180 degrees less the scattering angle), the largest on top. Each column is relative to its
/// own brightest direction.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  niji lee --theory uniform -o lee.exr
  niji lee --theory mie --radius-um 5,100 --effective-variance 0.01 -o fogbows.exr
  niji lee --theory airy --radius-um 10,1000 --bow-angle-deg 36,56 --size-px 1200,600 -o wide.exr")]
pub(crate) struct LeeCommand {
    /// How a drop scatters.
    #[arg(long, default_value = "uniform")]
    theory: TheoryName,
    /// Orders that take part, 0 to 7.
    #[arg(long, value_name = "P,P", default_value = "0,1,2,3,4,5,6,7")]
    orders: String,
    /// Smallest and largest effective radius.
    #[arg(long, value_name = "UM,UM", default_value = "10,1000")]
    radius_um: String,
    /// Effective variance of the sizes in a column; 0 for equal drops.
    #[arg(long, value_name = "V", default_value_t = 0.0)]
    effective_variance: f64,
    /// Smallest and largest bow angle.
    #[arg(long, value_name = "DEG,DEG", default_value = "34,54")]
    bow_angle_deg: String,
    /// Width and height of the picture.
    #[arg(long, value_name = "PX,PX", default_value = "600,500")]
    size_px: String,
    /// First wavelength, step and number of wavelengths.
    #[arg(long, value_name = "NM,NM,N", default_value = "380,10,41")]
    spectrum: String,
    /// Diameter of the sun's disc; 0 for a point.
    #[arg(long, value_name = "DEG", default_value_t = 0.533)]
    sun_disc_deg: f64,
    /// The water.
    #[command(flatten)]
    water: WaterFlags,
    /// The spectral EXR to write; a PNG and an SVG with axes of the same name are written beside it.
    #[arg(short, long, value_name = "EXR")]
    output: PathBuf,
}

/// The diagram that is asked for.
struct Diagram {
    need: ScatteringNeed,
    wavelengths: WavelengthGrid,
    angles_rad: Vec<f64>,
}

/// Draws the diagram.
///
/// # Errors
/// Flags out of range, or an output that exists or cannot be written.
pub(crate) fn execute(command: &LeeCommand, common: &Common) -> Result<(), Failure> {
    let options = common.options();
    let diagram = diagram(command)?;
    let preview = command.output.with_extension("png");
    let plot = command.output.with_extension("svg");
    let wavelengths = &diagram.wavelengths;
    let spectrum = (
        wavelengths.first_nm(),
        wavelengths.step_nm(),
        wavelengths.len(),
    );
    let request = Request {
        stage: "lee",
        settings: canonical_json(&(&diagram.need, spectrum, diagram.angles_rad.len())),
        inputs: Vec::new(),
        outputs: vec![&command.output, &preview, &plot],
    };
    perform(&request, options, |provenance| {
        let table =
            stages::scatter::computed(&diagram.need, *wavelengths, None, options.verbosity)?;
        let columns: Vec<BowCurves> = (0..diagram.need.effective_radius_um.len())
            .map(|radius| BowCurves::of(&table, [radius, 0], diagram.angles_rad.clone()))
            .collect();
        let image = SpectralImage {
            provenance,
            ..diagram.image(&columns)
        };
        let mut png = Vec::new();
        image
            .write_png(&mut png, 0.0)
            .map_err(|error| Failure::Failed(error.to_string()))?;
        diagram
            .with_axes(&png)
            .write_svg(&plot, &image.provenance)?;
        output::write_file(&preview, |writer| std::io::Write::write_all(writer, &png))?;
        output::write_file(&command.output, |writer| image.write_spectral(writer))
    })
    .map(|_| ())
}

impl Diagram {
    /// Radiance of a white card in the brightest direction of each column.
    fn image(&self, columns: &[BowCurves]) -> SpectralImage {
        let white_luminance_cd_m2 = white_luminance_cd_m2(&self.wavelengths);
        let sun = solar_irradiance(&self.wavelengths);
        let n = (self.wavelengths.len(), self.angles_rad.len(), columns.len());
        let mut radiance = Array3::zeros(n);
        for (x, column) in columns.iter().enumerate() {
            let brightest = column.xyz().iter().map(|xyz| xyz[1]).fold(0.0, f64::max);
            if brightest <= 0.0 {
                continue;
            }
            for ((y, wavelength), value) in column.values_sr1.indexed_iter() {
                // f32: a picture.
                radiance[[wavelength, y, x]] =
                    (value * sun[wavelength] * white_luminance_cd_m2 / brightest) as f32;
            }
        }
        SpectralImage {
            wavelengths: self.wavelengths,
            radiance,
            spectra: Spectra::Full,
            windows: ImageWindows::whole(n.2, n.1),
            aovs: Vec::new(),
            white_luminance_cd_m2,
            world_to_camera: None,
            attributes: self.attributes(),
            provenance: niji_exchange::Provenance::default(),
        }
    }

    fn with_axes<'a>(&self, png: &'a [u8]) -> Picture<'a> {
        let radii = &self.need.effective_radius_um;
        let bow_angle_deg = |index: usize| (PI - self.angles_rad[index]).to_degrees();
        Picture {
            title: format!(
                "{}, effective variance {}",
                self.need.theory.name(),
                self.need.effective_variance[0]
            ),
            x_label: "effective radius [µm]",
            y_label: "angle from the antisolar point [degrees]",
            x_range: (radii[0], radii[radii.len() - 1]),
            y_range: (bow_angle_deg(self.angles_rad.len() - 1), bow_angle_deg(0)),
            png,
        }
    }

    /// What the pixels stand for.
    fn attributes(&self) -> Attributes {
        let radii = &self.need.effective_radius_um;
        let bow_angle = |index: usize| AttributeValue::Number(PI - self.angles_rad[index]);
        let number = AttributeValue::Number;
        [
            (
                "niji:theory",
                AttributeValue::Text(self.need.theory.name().to_owned()),
            ),
            ("niji:firstRadiusUm", number(radii[0])),
            ("niji:lastRadiusUm", number(radii[radii.len() - 1])),
            ("niji:topBowAngleRad", bow_angle(0)),
            (
                "niji:bottomBowAngleRad",
                bow_angle(self.angles_rad.len() - 1),
            ),
            (
                "niji:effectiveVariance",
                number(self.need.effective_variance[0]),
            ),
        ]
        .into_iter()
        .map(|(name, value)| (name.to_owned(), value))
        .collect()
    }
}

fn diagram(command: &LeeCommand) -> Result<Diagram, Failure> {
    let (low_um, high_um) = range("radius-um", &command.radius_um)?;
    let (low_deg, high_deg) = range("bow-angle-deg", &command.bow_angle_deg)?;
    let (width, height) = range("size-px", &command.size_px)?;
    let usage = |message: String| Err(Failure::Usage(message));
    if !(low_um > 0.0 && high_um > low_um) {
        return usage(format!(
            "--radius-um: found {low_um},{high_um}, expected two ascending radii above 0"
        ));
    }
    if !(low_deg >= 0.0 && high_deg > low_deg && high_deg <= 180.0) {
        return usage(format!(
            "--bow-angle-deg: found {low_deg},{high_deg}, expected two ascending angles from 0 to 180"
        ));
    }
    if !((2.0..=8192.0).contains(&width) && (2.0..=8192.0).contains(&height)) {
        return usage(format!(
            "--size-px: found {width},{height}, expected 2 to 8192 for each"
        ));
    }
    let (n_columns, n_rows) = (width as usize, height as usize);
    let step = (high_um / low_um).ln() / (n_columns - 1) as f64;
    let radii = (0..n_columns).map(|column| low_um * (step * column as f64).exp());
    let angles_rad = BowCurves::even_angles_between(
        (PI - high_deg.to_radians(), PI - low_deg.to_radians()),
        n_rows,
    );
    Ok(Diagram {
        need: ScatteringNeed {
            theory: Theory::from(command.theory),
            orders: orders(&command.orders)?,
            theta_range_rad: (angles_rad[0], angles_rad[n_rows - 1]),
            relative_error: RELATIVE_ERROR,
            effective_radius_um: radii.collect(),
            effective_variance: vec![command.effective_variance],
            support_um: (low_um, high_um),
            rows: SizeRows::Laws,
            motion: None,
            phase_functions: false,
            sun_disc_diameter_rad: command.sun_disc_deg.to_radians(),
            water: command.water.water()?,
        },
        wavelengths: spectrum(&command.spectrum)?,
        angles_rad,
    })
}
