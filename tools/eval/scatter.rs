//! `niji eval scatter`: how one drop scatters.

use std::f64::consts::PI;
use std::f64::consts::TAU;
use std::fs;
use std::path::PathBuf;

use clap::Args;
use clap::ValueEnum;
use niji_airy::AiryBow;
use niji_airy::GeometricOrder;
use niji_airy::airy_squares;
use niji_mie::RefractiveIndex;
use niji_mie::ScatteringAngles;
use niji_mie::Sphere;
use niji_radiometry::Micrometers;
use niji_radiometry::Nanometers;
use niji_radiometry::Radians;
use niji_radiometry::water_refractive_index;

use super::line;
use crate::cli::numbers;
use crate::failure::Failure;

/// Amplitudes, phase function and efficiencies of one drop.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  niji eval scatter --theory mie --x 1000 --index 1.333+0i --angles-deg 0,90,180
  niji eval scatter --theory mie --x 1000 --index 1.333 --efficiencies
  niji eval scatter --theory debye --order 2 --radius-um 100 --wavelength-nm 560 --angles-deg 138,139

Columns of mie: angle_deg,s1_re,s1_im,s2_re,s2_im,p11,dop
Columns of debye, airy and geometric: angle_deg,i1,i2 with i = |S|^2
Columns of --efficiencies: q_ext,q_sca,g
Index n + ik with k >= 0 absorbing; S1 perpendicular, S2 parallel; dop = (i1 - i2)/(i1 + i2).")]
pub(super) struct ScatterArguments {
    /// How the drop scatters.
    #[arg(long)]
    theory: TheoryName,
    /// Order of debye, airy and geometric: 2 primary, 3 secondary.
    #[arg(long, value_name = "P")]
    order: Option<u32>,
    /// Size parameter 2 pi a / lambda.
    #[arg(long, conflicts_with_all = ["radius_um", "wavelength_nm"], requires = "index")]
    x: Option<f64>,
    /// Refractive index relative to the air, as 1.333 or 1.5+0.1i.
    #[arg(long, value_name = "N+Ki", allow_hyphen_values = true)]
    index: Option<String>,
    /// Radius of the drop.
    #[arg(long, value_name = "UM", requires = "wavelength_nm")]
    radius_um: Option<f64>,
    /// Wavelength in the air.
    #[arg(long, value_name = "NM", requires = "radius_um")]
    wavelength_nm: Option<f64>,
    /// Temperature of the water, where no index is given.
    #[arg(
        long,
        value_name = "C",
        default_value_t = 20.0,
        allow_negative_numbers = true
    )]
    temperature_c: f64,
    /// Scattering angles, 0 = forward.
    #[arg(long, value_name = "A,B,…")]
    angles_deg: Option<String>,
    /// A file of scattering angles.
    #[arg(long, value_name = "FILE", conflicts_with = "angles_deg")]
    angles_file: Option<PathBuf>,
    /// Efficiencies and the mean cosine instead of angles.
    #[arg(long)]
    efficiencies: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum TheoryName {
    Mie,
    Debye,
    Airy,
    Geometric,
}

pub(super) fn csv(arguments: &ScatterArguments) -> Result<String, Failure> {
    let usage = |error: &dyn std::fmt::Display| Failure::Usage(error.to_string());
    let (x, index) = drop(arguments)?;
    if arguments.efficiencies {
        let sphere = Sphere::new(x, index).map_err(|error| usage(&error))?;
        let q = sphere.efficiencies();
        return Ok("q_ext,q_sca,g\n".to_owned() + &line(&[q.q_ext, q.q_sca, q.asymmetry]));
    }
    let angles_deg = angles_deg(arguments)?;
    let angles = ScatteringAngles::from_degrees(&angles_deg).map_err(|error| usage(&error))?;
    if arguments.theory == TheoryName::Mie {
        let sphere = Sphere::new(x, index).map_err(|error| usage(&error))?;
        return Ok(mie(&sphere, &angles_deg, &angles));
    }
    let needs = || Failure::Usage("this theory needs --order, 2 primary, 3 secondary".to_owned());
    let order = arguments.order.ok_or_else(needs)?;
    let intensities = match arguments.theory {
        TheoryName::Mie => Vec::new(),
        TheoryName::Debye => {
            let sphere = Sphere::new(x, index).map_err(|error| usage(&error))?;
            sphere
                .debye(order)
                .amplitudes(&angles)
                .intensities()
                .collect()
        }
        TheoryName::Airy | TheoryName::Geometric => {
            by_rays(arguments.theory, [x, index.n], order, &angles_deg)?
        }
    };
    let mut csv = "angle_deg,i1,i2\n".to_owned();
    for (angle_deg, [i1, i2]) in angles_deg.iter().zip(intensities) {
        csv += &line(&[*angle_deg, i1, i2]);
    }
    Ok(csv)
}

fn mie(sphere: &Sphere, angles_deg: &[f64], angles: &ScatteringAngles) -> String {
    let amplitudes = sphere.amplitudes(angles);
    let p11 = sphere.p11(&amplitudes);
    let polarization = amplitudes.degrees_of_polarization();
    let mut csv = "angle_deg,s1_re,s1_im,s2_re,s2_im,p11,dop\n".to_owned();
    for (index, &angle_deg) in angles_deg.iter().enumerate() {
        let (s1, s2) = (amplitudes.s1[index], amplitudes.s2[index]);
        csv += &line(&[
            angle_deg,
            s1.re,
            s1.im,
            s2.re,
            s2.im,
            p11[index],
            polarization[index],
        ]);
    }
    csv
}

/// |S|² = π x² (dσ/dΩ)/(π a²) of Airy's theory or of rays.
fn by_rays(
    theory: TheoryName,
    [x, n]: [f64; 2],
    order: u32,
    angles_deg: &[f64],
) -> Result<Vec<[f64; 2]>, Failure> {
    let no_bow = || Failure::Impossible(format!("no bow of order {order} at index {n}"));
    let bow = AiryBow::new(n, order).ok_or_else(no_bow)?;
    let rays = GeometricOrder::new(n, order).ok_or_else(no_bow)?;
    // Only the ratio of radius and wavelength matters.
    let wavelength = Nanometers(1000.0);
    let radius = Micrometers(x / TAU);
    let at = |angle_deg: &f64| {
        let theta = Radians::from_degrees(*angle_deg);
        let t = match theory {
            TheoryName::Airy => {
                bow.direction(theta)
                    .normalized_cross_section(radius, wavelength, airy_squares)
            }
            TheoryName::Geometric | TheoryName::Mie | TheoryName::Debye => {
                rays.normalized_cross_section(theta)
            }
        };
        t.map(|t| PI * x * x * t)
    };
    Ok(angles_deg.iter().map(at).collect())
}

fn drop(arguments: &ScatterArguments) -> Result<(f64, RefractiveIndex), Failure> {
    let given = arguments.index.as_deref().map(parse_index).transpose()?;
    if let (Some(radius_um), Some(nm)) = (arguments.radius_um, arguments.wavelength_nm) {
        if !(300.0..=1000.0).contains(&nm) && given.is_none() {
            return Err(Failure::Usage(format!(
                "found {nm} nm, expected 300 to 1000 nm"
            )));
        }
        let n = || water_refractive_index(Nanometers(nm), arguments.temperature_c);
        let index = given.unwrap_or_else(|| RefractiveIndex { n: n(), k: 0.0 });
        return Ok((TAU * radius_um / (1e-3 * nm), index));
    }
    match (arguments.x, given) {
        (Some(x), Some(index)) => Ok((x, index)),
        _ => Err(Failure::Usage(
            "expected a drop: --x and --index, or --radius-um and --wavelength-nm".to_owned(),
        )),
    }
}

fn parse_index(text: &str) -> Result<RefractiveIndex, Failure> {
    let wrong = || Failure::Usage(format!("found index {text:?}, expected 1.333 or 1.5+0.1i"));
    let compact = text.trim().replace(' ', "");
    let Some(complex) = compact.strip_suffix('i') else {
        let n = compact.parse().map_err(|_| wrong())?;
        return Ok(RefractiveIndex { n, k: 0.0 });
    };
    // The last sign that does not belong to an exponent splits n from k.
    let is_split = |(at, c): &(usize, char)| {
        let after_exponent = compact[..*at].ends_with(['e', 'E']);
        *at > 0 && ['+', '-'].contains(c) && !after_exponent
    };
    let split = complex
        .char_indices()
        .rev()
        .find(is_split)
        .ok_or_else(wrong)?
        .0;
    let n = complex[..split].parse().map_err(|_| wrong())?;
    let k = complex[split..].parse().map_err(|_| wrong())?;
    Ok(RefractiveIndex { n, k })
}

fn angles_deg(arguments: &ScatterArguments) -> Result<Vec<f64>, Failure> {
    match (&arguments.angles_deg, &arguments.angles_file) {
        (Some(text), _) => numbers(text).map_err(Failure::Usage),
        (None, Some(path)) => {
            let text = fs::read_to_string(path).map_err(|e| Failure::bad_input(path, e))?;
            numbers(&text).map_err(|error| Failure::bad_input(path, error))
        }
        (None, None) => Err(Failure::Usage(
            "expected --angles-deg, --angles-file or --efficiencies".to_owned(),
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn indices_are_read_in_every_usual_form() {
        let read = |text| parse_index(text).unwrap();
        assert_eq!(read("1.333"), RefractiveIndex { n: 1.333, k: 0.0 });
        assert_eq!(read("1.333+0i"), RefractiveIndex { n: 1.333, k: 0.0 });
        assert_eq!(read("1.33 + 1e-5i"), RefractiveIndex { n: 1.33, k: 1e-5 });
        assert_eq!(read("1.5-0.1i"), RefractiveIndex { n: 1.5, k: -0.1 });
        for wrong in ["", "i", "n", "1.3+i2", "+0.1i"] {
            assert!(parse_index(wrong).is_err(), "{wrong}");
        }
    }
}
