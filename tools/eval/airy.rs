//! `niji eval airy`: f(z) and f'(z).

use std::path::PathBuf;

use clap::Args;
use niji_airy::airy_integral_with_derivative;

use super::csv::line;
use crate::failure::Failure;
use crate::flags::numbers;
use crate::text_file;

/// Airy's rainbow integral f(z) and its derivative.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  niji eval airy --z -3,0,1.5\n\nColumns: z,f,dfdz")]
pub(super) struct AiryArguments {
    /// Arguments.
    #[arg(
        long,
        value_name = "Z,Z,…",
        required_unless_present = "z_file",
        allow_hyphen_values = true
    )]
    z: Option<String>,
    /// A file of arguments, separated by commas or white space.
    #[arg(long, value_name = "FILE", conflicts_with = "z")]
    z_file: Option<PathBuf>,
}

pub(super) fn csv(arguments: &AiryArguments) -> Result<String, Failure> {
    let z = match (&arguments.z, &arguments.z_file) {
        (_, Some(path)) => {
            let text = text_file::read(path)?;
            numbers(&text).map_err(|error| Failure::bad_input(path, error))?
        }
        (Some(text), None) => numbers(text).map_err(Failure::Usage)?,
        (None, None) => Vec::new(),
    };
    let mut csv = "z,f,dfdz\n".to_owned();
    for z in z {
        let (f, dfdz) = airy_integral_with_derivative(z);
        csv += &line(&[z, f, dfdz]);
    }
    Ok(csv)
}
