//! `niji eval scatter`: how one drop, or a mean over drops, scatters.
//!
//! For a size law means over the number of drops: ⟨i⟩ = ⟨r²⟩ k² Σ_j w_j i(x_j)/x_j² with the weights w
//! of the drops' cross-sections; p11 = 4π ⟨dσ/dΩ⟩/⟨C_sca⟩, efficiencies over ⟨π r²⟩.

mod drop;

use std::f64::consts::PI;
use std::f64::consts::TAU;

use clap::Args;
use niji_airy::AiryBow;
use niji_airy::BowDirection;
use niji_airy::GeometricOrder;
use niji_airy::UniformBow;
use niji_airy::airy_squares;
use niji_mie::ScatteringAngles;
use niji_mie::Sphere;
use niji_radiometry::Micrometers;
use niji_radiometry::Nanometers;
use niji_radiometry::Radians;

use self::drop::Drop;
use self::drop::DropArguments;
use self::drop::Drops;
use super::csv::line;
use crate::failure::Failure;
use crate::theory_name::TheoryName;

/// Amplitudes, phase function and efficiencies of one drop, or of a gamma law of sizes.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  niji eval scatter --theory mie --x 1000 --index 1.333+0i --angles-deg 0,90,180
  niji eval scatter --theory mie --x 1000 --index 1.333 --efficiencies
  niji eval scatter --theory debye --order 2 --radius-um 100 --wavelength-nm 560 \\
      --angles-deg 138,139
  niji eval scatter --theory uniform --order 2 --radius-um 100 --effective-variance 0.05 \\
      --wavelength-nm 560 --angles-deg 138,139

Columns of mie: angle_deg,s1_re,s1_im,s2_re,s2_im,p11,dop
Columns of mie with --effective-variance, where amplitudes have no mean: angle_deg,i1,i2,p11,dop
Columns of debye, uniform, airy and geometric: angle_deg,i1,i2 with i = |S|^2
Columns of --efficiencies: q_ext,q_sca,g
Index n + ik with k >= 0 absorbing; S1 perpendicular, S2 parallel; dop = (i1 - i2)/(i1 + i2).")]
pub(super) struct ScatterArguments {
    /// How the drop scatters.
    #[arg(long)]
    theory: TheoryName,
    /// Order of debye, uniform, airy and geometric: 2 primary, 3 secondary bow.
    #[arg(long, value_name = "P")]
    order: Option<u32>,
    #[command(flatten)]
    drop: DropArguments,
    /// Efficiencies and the mean cosine instead of angles.
    #[arg(long)]
    efficiencies: bool,
}

pub(super) fn csv(arguments: &ScatterArguments) -> Result<String, Failure> {
    let drops = arguments.drop.drops()?;
    let is_mie = arguments.theory == TheoryName::Mie;
    if arguments.efficiencies {
        if !is_mie {
            return Err(Failure::Usage(
                "--efficiencies are of all the light of a drop: expected --theory mie".to_owned(),
            ));
        }
        let [q_ext, q_sca, g] = efficiencies(&drops)?;
        return Ok("q_ext,q_sca,g\n".to_owned() + &line(&[q_ext, q_sca, g]));
    }
    let angles_deg = arguments.drop.angles_deg()?;
    let angles = ScatteringAngles::from_degrees(&angles_deg).map_err(usage)?;
    if is_mie {
        return match &drops.nodes[..] {
            [drop] => Ok(amplitudes(&drop.sphere()?, &angles_deg, &angles)),
            _ => mean_phase_function(&drops, &angles_deg, &angles),
        };
    }
    let needs = || Failure::Usage("this theory needs --order, 2 primary, 3 secondary".to_owned());
    let order = arguments.order.ok_or_else(needs)?;
    let means = if arguments.theory == TheoryName::Debye {
        mean_intensities(&drops, |drop| {
            let waves = drop.sphere()?.debye(order);
            Ok(waves.amplitudes(&angles).intensities().collect())
        })
    } else {
        let index = drops.nodes[0].index;
        if index.k > 0.0 {
            return Err(Failure::Usage(format!(
                "found an absorbing drop, k = {}: expected --theory mie or debye, which know of it",
                index.k
            )));
        }
        let directions = directions(arguments.theory, index.n, order, &angles_deg)?;
        mean_intensities(&drops, |drop| {
            let at = |direction: &BowDirection| intensities(direction, drop.x);
            Ok(directions.iter().map(at).collect())
        })
    }?;
    let mut csv = "angle_deg,i1,i2\n".to_owned();
    for (angle_deg, [i1, i2]) in angles_deg.iter().zip(means) {
        csv += &line(&[*angle_deg, i1, i2]);
    }
    Ok(csv)
}

fn usage(error: impl std::fmt::Display) -> Failure {
    Failure::Usage(error.to_string())
}

/// Efficiencies over the mean cross-section, and the mean cosine of the scattered light.
fn efficiencies(drops: &Drops) -> Result<[f64; 3], Failure> {
    let mut sums = [0.0; 3];
    for drop in &drops.nodes {
        let sphere = drop.sphere()?;
        let q = sphere.efficiencies();
        sums[0] += drop.area_weight * q.q_ext;
        sums[1] += drop.area_weight * q.q_sca;
        sums[2] += drop.area_weight * q.q_sca * q.asymmetry;
    }
    let [q_ext, q_sca, q_sca_g] = sums;
    Ok([
        q_ext,
        q_sca,
        if q_sca > 0.0 { q_sca_g / q_sca } else { 0.0 },
    ])
}

fn amplitudes(sphere: &Sphere, angles_deg: &[f64], angles: &ScatteringAngles) -> String {
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

fn mean_phase_function(
    drops: &Drops,
    angles_deg: &[f64],
    angles: &ScatteringAngles,
) -> Result<String, Failure> {
    let means = mean_intensities(drops, |drop| {
        Ok(drop.sphere()?.amplitudes(angles).intensities().collect())
    })?;
    let [_, q_sca, _] = efficiencies(drops)?;
    let mut csv = "angle_deg,i1,i2,p11,dop\n".to_owned();
    for (angle_deg, [i1, i2]) in angles_deg.iter().zip(means) {
        // 4π (i1 + i2)/(2 k²) / (π⟨r²⟩ Q_sca).
        let p11 = 2.0 * (i1 + i2) / (drops.mean_square_x * q_sca);
        let polarization = if i1 + i2 > 0.0 {
            (i1 - i2) / (i1 + i2)
        } else {
            0.0
        };
        csv += &line(&[*angle_deg, i1, i2, p11, polarization]);
    }
    Ok(csv)
}

/// Means over the number of drops of what each drop gives.
fn mean_intensities(
    drops: &Drops,
    of_drop: impl Fn(&Drop) -> Result<Vec<[f64; 2]>, Failure>,
) -> Result<Vec<[f64; 2]>, Failure> {
    let mut means: Vec<[f64; 2]> = Vec::new();
    for drop in &drops.nodes {
        let values = of_drop(drop)?;
        means.resize(values.len(), [0.0; 2]);
        let weight = drop.area_weight * drops.mean_square_x / (drop.x * drop.x);
        for (mean, value) in means.iter_mut().zip(values) {
            mean[0] += weight * value[0];
            mean[1] += weight * value[1];
        }
    }
    Ok(means)
}

/// The light of one order in each direction, for drops of every size.
fn directions(
    theory: TheoryName,
    n: f64,
    order: u32,
    angles_deg: &[f64],
) -> Result<Vec<BowDirection>, Failure> {
    let no_bow = || Failure::Impossible(format!("no bow of order {order} at index {n}"));
    let angles = angles_deg
        .iter()
        .map(|&angle_deg| Radians::from_degrees(angle_deg));
    match theory {
        TheoryName::Geometric => {
            let order = GeometricOrder::new(n, order).ok_or_else(no_bow)?;
            let rays = |theta| BowDirection {
                argument: 0.0,
                strength: [0.0; 2],
                derivative_strength: [0.0; 2],
                rays: order.normalized_cross_section(theta),
            };
            Ok(angles.map(rays).collect())
        }
        TheoryName::Airy => {
            let bow = AiryBow::new(n, order).ok_or_else(no_bow)?;
            Ok(angles.map(|theta| bow.direction(theta)).collect())
        }
        TheoryName::Uniform => {
            let bow = UniformBow::new(n, order).ok_or_else(no_bow)?;
            Ok(angles.map(|theta| bow.direction(theta)).collect())
        }
        TheoryName::BySize => Err(Failure::Usage(
            "by-size is a rule for tables: small drops are those of mie, large ones those of uniform; \
             expected one of these"
                .to_owned(),
        )),
        TheoryName::GeometricPublished
        | TheoryName::AiryPublished
        | TheoryName::Debye
        | TheoryName::Mie => Err(Failure::Usage(
            "expected geometric, airy, uniform, debye or mie: the published forms have no amplitude"
                .to_owned(),
        )),
    }
}

/// |S|² = π x² (dσ/dΩ)/(π a²) for both polarisations.
fn intensities(direction: &BowDirection, x: f64) -> [f64; 2] {
    // Only the ratio of radius and wavelength matters.
    let (radius, wavelength) = (Micrometers(x / TAU), Nanometers(1000.0));
    let t = direction.normalized_cross_section(radius, wavelength, airy_squares);
    t.map(|t| PI * x * x * t)
}
