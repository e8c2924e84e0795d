//! The drop, or the law of drops, and the angles of `niji eval scatter`.

use std::f64::consts::TAU;
use std::path::PathBuf;

use clap::Args;
use niji_mie::RefractiveIndex;
use niji_mie::Sphere;
use niji_radiometry::Micrometers;
use niji_radiometry::Nanometers;
use niji_sizes::gamma_area_quadrature;

use crate::failure::Failure;
use crate::flags::numbers;
use crate::text_file;
use crate::water_flags::WaterFlags;

/// Sizes of a law: resolves 6 periods of the fringes in a standard deviation to 1e-7.
const N_SIZES: usize = 256;

/// One drop or a gamma law, and angles.
#[derive(Debug, Args)]
pub(super) struct DropArguments {
    /// Size parameter 2 pi a / lambda.
    #[arg(long, conflicts_with_all = ["radius_um", "wavelength_nm"], requires = "index")]
    x: Option<f64>,
    /// Refractive index relative to the air, as 1.333 or 1.5+0.1i.
    #[arg(long, value_name = "N+Ki", allow_hyphen_values = true)]
    index: Option<String>,
    /// Radius of the drop, the effective one of a law.
    #[arg(long, value_name = "UM", requires = "wavelength_nm")]
    radius_um: Option<f64>,
    /// Wavelength in the air.
    #[arg(long, value_name = "NM", requires = "radius_um")]
    wavelength_nm: Option<f64>,
    /// Effective variance of a gamma law of sizes; 0 for one drop.
    #[arg(long, value_name = "V", default_value_t = 0.0)]
    effective_variance: f64,
    /// The water, where no index is given.
    #[command(flatten)]
    water: WaterFlags,
    /// Scattering angles, 0 = forward.
    #[arg(long, value_name = "A,B,…")]
    angles_deg: Option<String>,
    /// A file of scattering angles.
    #[arg(long, value_name = "FILE", conflicts_with = "angles_deg")]
    angles_file: Option<PathBuf>,
}

/// A drop with its share of the cross-section of all.
pub(super) struct Drop {
    /// Size parameter.
    pub(super) x: f64,
    pub(super) index: RefractiveIndex,
    pub(super) area_weight: f64,
}

/// The drops whose mean is asked for.
pub(super) struct Drops {
    /// One drop, or the nodes of a law.
    pub(super) nodes: Vec<Drop>,
    /// ⟨x²⟩ over the number of drops: the mean cross-section over π in units of 1/k².
    pub(super) mean_square_x: f64,
}

impl Drop {
    pub(super) fn sphere(&self) -> Result<Sphere, Failure> {
        Sphere::new(self.x, self.index).map_err(|error| Failure::Usage(error.to_string()))
    }
}

impl DropArguments {
    /// The drops whose mean is asked for.
    pub(super) fn drops(&self) -> Result<Drops, Failure> {
        let usage = |error: &dyn std::fmt::Display| Failure::Usage(error.to_string());
        let (x, index) = self.effective_drop()?;
        // Checks x and index, whichever theory takes them.
        Sphere::new(x, index).map_err(|error| usage(&error))?;
        let n_sizes = if self.effective_variance == 0.0 {
            1
        } else {
            N_SIZES
        };
        // In units of the size parameter: the law has no other scale.
        let nodes = gamma_area_quadrature(Micrometers(x), self.effective_variance, n_sizes)
            .map_err(|error| usage(&error))?;
        let drop = |(x, area_weight)| Drop {
            x,
            index,
            area_weight,
        };
        let variance = self.effective_variance;
        Ok(Drops {
            nodes: nodes.into_iter().map(drop).collect(),
            // ⟨r²⟩ = r_e² (1 − v_e)(1 − 2 v_e).
            mean_square_x: x * x * (1.0 - variance) * (1.0 - 2.0 * variance),
        })
    }

    fn effective_drop(&self) -> Result<(f64, RefractiveIndex), Failure> {
        let given = self.index.as_deref().map(parse_index).transpose()?;
        if let (Some(radius_um), Some(nm)) = (self.radius_um, self.wavelength_nm) {
            if !(300.0..=1000.0).contains(&nm) && given.is_none() {
                return Err(Failure::Usage(format!(
                    "found {nm} nm, expected 300 to 1000 nm"
                )));
            }
            let n = self.water.water()?.refractive_index(Nanometers(nm));
            let index = given.unwrap_or(RefractiveIndex { n, k: 0.0 });
            return Ok((TAU * radius_um / (1e-3 * nm), index));
        }
        match (self.x, given) {
            (Some(x), Some(index)) => Ok((x, index)),
            _ => Err(Failure::Usage(
                "expected a drop: --x and --index, or --radius-um and --wavelength-nm".to_owned(),
            )),
        }
    }

    /// The angles in degrees.
    pub(super) fn angles_deg(&self) -> Result<Vec<f64>, Failure> {
        match (&self.angles_deg, &self.angles_file) {
            (Some(text), _) => numbers(text).map_err(Failure::Usage),
            (None, Some(path)) => {
                let text = text_file::read(path)?;
                numbers(&text).map_err(|error| Failure::bad_input(path, error))
            }
            (None, None) => Err(Failure::Usage(
                "expected --angles-deg, --angles-file or --efficiencies".to_owned(),
            )),
        }
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
