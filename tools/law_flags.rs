//! Size laws on the command line: `--law NAME` and the parameters of that law.

use clap::Args;
use clap::ValueEnum;
use niji_sizes::MarshallPalmer;
use niji_sizes::Monodisperse;
use niji_sizes::Normal;
use niji_sizes::SizeLaw;
use niji_sizes::Uniform;

use crate::failure::Failure;

/// The laws by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum LawName {
    /// One radius: --radius-um.
    Monodisperse,
    /// A range of radii: --radius-min-um, --radius-max-um.
    Uniform,
    /// --radius-mean-um, --radius-standard-deviation-um, cut off at 0.
    Normal,
    /// Rain: --rain-rate-mm-h, optionally --d-min-mm and --d-max-mm.
    MarshallPalmer,
}

/// A size law and its parameters.
#[derive(Debug, Args)]
#[command(next_help_heading = "Drop sizes")]
pub(crate) struct LawFlags {
    /// Law of the drop sizes.
    #[arg(long, value_name = "NAME")]
    pub law: LawName,
    /// The radius, for monodisperse.
    #[arg(long, value_name = "UM")]
    radius_um: Option<f64>,
    /// Smallest radius, for uniform.
    #[arg(long, value_name = "UM")]
    radius_min_um: Option<f64>,
    /// Largest radius, for uniform.
    #[arg(long, value_name = "UM")]
    radius_max_um: Option<f64>,
    /// Mean radius, for normal.
    #[arg(long, value_name = "UM")]
    radius_mean_um: Option<f64>,
    /// Standard deviation of the radius, for normal.
    #[arg(long, value_name = "UM")]
    radius_standard_deviation_um: Option<f64>,
    /// Rain rate, for marshall-palmer.
    #[arg(long, value_name = "MM/H")]
    rain_rate_mm_h: Option<f64>,
    /// Smallest diameter, for marshall-palmer.
    #[arg(long, value_name = "MM")]
    d_min_mm: Option<f64>,
    /// Largest diameter, for marshall-palmer.
    #[arg(long, value_name = "MM")]
    d_max_mm: Option<f64>,
    /// Drops per cubic metre; marshall-palmer has its own.
    #[arg(long, value_name = "1/M3")]
    pub number_density_m3: Option<f64>,
}

impl LawFlags {
    /// The law, checked.
    ///
    /// # Errors
    /// A parameter that is missing, belongs to another law, or is out of range.
    pub(crate) fn size_law(&self) -> Result<SizeLaw, Failure> {
        let own: &[&str] = match self.law {
            LawName::Monodisperse => &["radius-um"],
            LawName::Uniform => &["radius-min-um", "radius-max-um"],
            LawName::Normal => &["radius-mean-um", "radius-standard-deviation-um"],
            LawName::MarshallPalmer => &["rain-rate-mm-h", "d-min-mm", "d-max-mm"],
        };
        let given = [
            ("radius-um", self.radius_um),
            ("radius-min-um", self.radius_min_um),
            ("radius-max-um", self.radius_max_um),
            ("radius-mean-um", self.radius_mean_um),
            (
                "radius-standard-deviation-um",
                self.radius_standard_deviation_um,
            ),
            ("rain-rate-mm-h", self.rain_rate_mm_h),
            ("d-min-mm", self.d_min_mm),
            ("d-max-mm", self.d_max_mm),
        ];
        for (name, value) in given {
            if value.is_some() && !own.contains(&name) {
                let list = own.join(" --");
                return Err(Failure::Usage(format!(
                    "--{name} is of another law, expected --{list}"
                )));
            }
        }
        let need = |name: &str, value: Option<f64>| {
            value.ok_or_else(|| Failure::Usage(format!("this law needs --{name}")))
        };
        let law = match self.law {
            LawName::Monodisperse => SizeLaw::Monodisperse(Monodisperse {
                radius_um: need("radius-um", self.radius_um)?,
            }),
            LawName::Uniform => SizeLaw::Uniform(Uniform {
                radius_min_um: need("radius-min-um", self.radius_min_um)?,
                radius_max_um: need("radius-max-um", self.radius_max_um)?,
            }),
            LawName::Normal => SizeLaw::Normal(Normal {
                radius_mean_um: need("radius-mean-um", self.radius_mean_um)?,
                radius_standard_deviation_um: need(
                    "radius-standard-deviation-um",
                    self.radius_standard_deviation_um,
                )?,
            }),
            LawName::MarshallPalmer => SizeLaw::MarshallPalmer(MarshallPalmer {
                rain_rate_mm_h: need("rain-rate-mm-h", self.rain_rate_mm_h)?,
                d_min_mm: self.d_min_mm,
                d_max_mm: self.d_max_mm,
            }),
        };
        law.validate()
            .map_err(|error| Failure::Usage(error.to_string()))?;
        Ok(law)
    }
}
