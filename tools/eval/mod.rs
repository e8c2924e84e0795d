//! `niji eval`: physics as CSV on standard output, one header line, full precision.

mod air;
mod airy;
mod csv;
mod ice;
mod index;
mod scatter;
mod sizes;
mod sun;

use clap::Args;
use clap::Subcommand;

use crate::failure::Failure;
use crate::flags::Common;
use crate::output;

/// Print physics as CSV: airy, scatter, sizes, index, air, sun, ice.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  niji eval airy --z -3,0,1.5
  niji eval sizes --law marshall-palmer --rain-rate-mm-h 5
  niji eval index --material water --wavelengths-nm 400,550,700

`niji eval QUANTITY --help` gives the columns.")]
pub(crate) struct EvalCommand {
    #[command(subcommand)]
    quantity: Quantity,
}

#[derive(Debug, Subcommand)]
enum Quantity {
    Airy(airy::AiryArguments),
    Scatter(scatter::ScatterArguments),
    Sizes(sizes::SizesArguments),
    Index(index::IndexArguments),
    Air(Box<air::AirArguments>),
    Sun(sun::SunArguments),
    Ice(ice::IceArguments),
}

/// Prints the table that was asked for.
///
/// # Errors
/// Arguments out of range, or a file of arguments that cannot be read.
pub(crate) fn execute(command: &EvalCommand, common: &Common) -> Result<(), Failure> {
    let csv = match &command.quantity {
        Quantity::Airy(arguments) => airy::csv(arguments)?,
        Quantity::Scatter(arguments) => scatter::csv(arguments)?,
        Quantity::Sizes(arguments) => sizes::csv(arguments)?,
        Quantity::Index(arguments) => index::csv(arguments)?,
        Quantity::Air(arguments) => air::csv(arguments, common)?,
        Quantity::Sun(arguments) => sun::csv(arguments)?,
        Quantity::Ice(arguments) => ice::csv(arguments)?,
    };
    output::print(&csv)
}
