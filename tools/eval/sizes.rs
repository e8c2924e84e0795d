//! `niji eval sizes`: what a size law amounts to.

use clap::Args;

use super::line;
use crate::failure::Failure;
use crate::law_flags::LawFlags;

/// Number, water, extinction, effective radius and variance of a size law.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  niji eval sizes --law marshall-palmer --rain-rate-mm-h 5 --d-min-mm 0.1 --d-max-mm 6
  niji eval sizes --law monodisperse --radius-um 10 --number-density-m3 1e8

Columns: number_density_m3,lwc_g_m3,extinction_m1,effective_radius_m,effective_variance
(extinction at Q = 2)")]
pub(super) struct SizesArguments {
    #[command(flatten)]
    law: LawFlags,
}

pub(super) fn csv(arguments: &SizesArguments) -> Result<String, Failure> {
    let law = arguments.law.size_law()?;
    let number_density_m3 = match (
        law.natural_number_density_m3(),
        arguments.law.number_density_m3,
    ) {
        (Some(_), Some(_)) => {
            let message =
                "marshall-palmer has a number density of its own: leave out --number-density-m3";
            return Err(Failure::Usage(message.to_owned()));
        }
        (Some(natural), None) => natural,
        (None, Some(given)) if given >= 0.0 && given.is_finite() => given,
        (None, Some(given)) => {
            return Err(Failure::Usage(format!(
                "found {given} drops per m3, expected at least 0"
            )));
        }
        (None, None) => {
            return Err(Failure::Usage(
                "this law needs --number-density-m3".to_owned(),
            ));
        }
    };
    let bulk = law.moments().bulk_properties(number_density_m3);
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
