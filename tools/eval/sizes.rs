//! `niji eval sizes`: what a size law amounts to.

use clap::Args;
use niji_sizes::Amount;
use niji_sizes::SizeLaw;
use schemars::JsonSchema;
use serde::Deserialize;

use super::csv::line;
use crate::failure::Failure;
use crate::schema_flags::Flagged;
use crate::schema_flags::Given;

/// Number, water, extinction, effective radius and variance of a size law.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  niji eval sizes --law marshall-palmer --rain-rate-mm-h 5 --d-min-mm 0.1 --d-max-mm 6
  niji eval sizes --law monodisperse --radius-um 10 --number-density-m3 1e8
  niji eval sizes --law hansen-travis --effective-radius-um 10 --effective-variance 0.1 \\
      --lwc-g-m3 0.2
  niji eval sizes --law cloud --preset fog

Columns: number_density_m3,lwc_g_m3,extinction_m1,effective_radius_m,effective_variance
(extinction at Q = 2)")]
pub(super) struct SizesArguments {
    #[command(flatten)]
    given: Given<Sizes>,
}

/// What the flags stand for.
#[derive(Debug, Deserialize, JsonSchema)]
struct Sizes {
    /// Law of the drop sizes.
    law: SizeLaw,
    /// How many drops there are; rain and clouds say it themselves.
    amount: Option<Amount>,
}

impl Flagged for Sizes {}

pub(super) fn csv(arguments: &SizesArguments) -> Result<String, Failure> {
    let Sizes { law, amount } = arguments.given.read()?;
    let refused =
        |error: niji_sizes::Error| Failure::Usage(Sizes::flags().name_flags(&error.to_string()));
    law.validate().map_err(refused)?;
    if let Some(amount) = &amount {
        amount.validate().map_err(refused)?;
    }
    let moments = law.moments();
    let number_density_m3 = match (law.natural_number_density_m3(), amount) {
        (Some(natural), None) => natural,
        (None, Some(amount)) => amount.number_density_m3(&moments),
        (Some(_), Some(_)) => {
            return Err(Failure::Usage(format!(
                "{} says itself how many drops there are: leave out --number-density-m3, \
                 --lwc-g-m3 and --extinction-m1",
                law.name()
            )));
        }
        (None, None) => {
            return Err(Failure::Usage(format!(
                "{} needs --number-density-m3, --lwc-g-m3 or --extinction-m1",
                law.name()
            )));
        }
    };
    let bulk = moments.bulk_properties(number_density_m3);
    let header = "number_density_m3,lwc_g_m3,extinction_m1,effective_radius_m,effective_variance\n";
    Ok(header.to_owned()
        + &line(&[
            bulk.number_density_m3,
            bulk.lwc_g_m3,
            bulk.extinction_m1,
            bulk.effective_radius_m,
            bulk.effective_variance,
        ]))
}
