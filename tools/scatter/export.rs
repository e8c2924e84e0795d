//! Scattering tables for other programs.
//!
//! CSV: one line for each angle, wavelength and size, in the table's own unit.
//!
//! Mitsuba's `tabphase` takes values on even steps of cos θ from −1 (backward) to 1 (forward) and
//! always divides them by their trapezoidal integral N over the sphere. A table of drops has no norm
//! of 1: the light of one order is a few per cent of all, and a forward lobe is narrower than the steps,
//! so that N would be off by factors. Here the forward lobe is left out as everywhere in this project
//! (values within 10 degrees of forward are held at that of 10 degrees) and N is handed over: a medium
//! with extinction π M2 and single-scattering albedo N scatters π M2 (N) (t/N) = π M2 t, as it must.
//! W. Jakob et al., Mitsuba 3 documentation, `tabphase` (2022).

use std::f64::consts::PI;
use std::f64::consts::TAU;
use std::io::Write;
use std::path::Path;

use clap::ValueEnum;
use niji_exchange::ScatteringTable;

use crate::bow_curves::BowCurves;
use crate::failure::Failure;
use crate::output;

/// Steps of cos θ: 0.04 degrees at the primary bow.
const N_STEPS: usize = 4096;
/// Within it the diffracted light of a drop is left out.
const FORWARD_LOBE_RAD: f64 = 10.0 * PI / 180.0;

/// What to write.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum Format {
    /// Lines of numbers.
    Csv,
    /// A `tabphase` for each wavelength, XML.
    Mitsuba,
}

pub(super) fn write(format: Format, table: &ScatteringTable, path: &Path) -> Result<(), Failure> {
    match format {
        Format::Csv => write_csv(table, path),
        Format::Mitsuba => write_mitsuba(table, path),
    }
}

fn write_csv(table: &ScatteringTable, path: &Path) -> Result<(), Failure> {
    output::write_file(path, |writer| {
        writeln!(
            writer,
            "theta_deg,wavelength_nm,effective_radius_um,effective_variance,s_sr1,p_sr1"
        )?;
        for (radius, radius_um) in table.effective_radius_um.iter().enumerate() {
            for (variance, effective_variance) in table.effective_variance.iter().enumerate() {
                for (wavelength, center) in table.wavelengths.centers().enumerate() {
                    for (angle, theta_rad) in table.theta_rad.iter().enumerate() {
                        let at = |j| table.values[[j, radius, variance, wavelength, angle]];
                        writeln!(
                            writer,
                            "{:.6},{},{radius_um},{effective_variance},{:e},{:e}",
                            theta_rad.to_degrees(),
                            center.0,
                            at(0),
                            at(1)
                        )?;
                    }
                }
            }
        }
        Ok::<(), std::io::Error>(())
    })
}

fn write_mitsuba(table: &ScatteringTable, path: &Path) -> Result<(), Failure> {
    let n_rows = table.effective_radius_um.len() * table.effective_variance.len();
    if n_rows > 1 {
        return Err(Failure::Usage(format!(
            "found a table of {n_rows} drop sizes, expected one: a tabphase holds one phase \
             function; give one --effective-radius-um and one --effective-variance"
        )));
    }
    let angles: Vec<f64> = (0..=N_STEPS).map(|step| cosine(step).acos()).collect();
    let first = table.theta_rad[0];
    let last = table.theta_rad[table.theta_rad.len() - 1];
    let held = angles
        .iter()
        .map(|theta| theta.clamp(FORWARD_LOBE_RAD, PI))
        .collect();
    let light = BowCurves::of(table, [0, 0], held);
    output::write_file(path, |writer| {
        writeln!(writer, "<scene version=\"3.0.0\">")?;
        writeln!(
            writer,
            "  <!-- {}, effective radius {} um, effective variance {}. Medium: sigma_t = pi M2 \
             (M2 = drops per m^3 times mean squared radius), albedo as given: tabphase divides its \
             values by their integral, and the albedo gives it back. -->",
            table.theory, table.effective_radius_um[0], table.effective_variance[0]
        )?;
        for (index, wavelength) in table.wavelengths.centers().enumerate() {
            let within = |theta: f64| (first..=last).contains(&theta);
            let values: Vec<f64> = light
                .values_sr1
                .column(index)
                .iter()
                .zip(&angles)
                .map(|(value, theta)| {
                    if within(theta.max(FORWARD_LOBE_RAD)) {
                        *value
                    } else {
                        0.0
                    }
                })
                .collect();
            let text: Vec<String> = values.iter().map(|value| format!("{value:.6e}")).collect();
            writeln!(
                writer,
                "  <!-- {} nm: albedo {:.8} -->\n  <phase type=\"tabphase\" id=\"niji_{}nm\">\n    \
                 <string name=\"values\" value=\"{}\"/>\n  </phase>",
                wavelength.0,
                integral(&values),
                wavelength.0,
                text.join(", ")
            )?;
        }
        writeln!(writer, "</scene>")
    })
}

/// cos θ of a step, from −1 to 1.
fn cosine(step: usize) -> f64 {
    2.0 * step as f64 / N_STEPS as f64 - 1.0
}

/// 2π ∫ t d(cos θ) by the trapezoidal rule, as `tabphase` takes it.
fn integral(values: &[f64]) -> f64 {
    let inner: f64 = values[1..values.len() - 1].iter().sum();
    let ends = 0.5 * (values[0] + values[values.len() - 1]);
    TAU * (inner + ends) * 2.0 / N_STEPS as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_isotropic_table_has_its_norm() {
        let values = vec![1.0 / (4.0 * PI); N_STEPS + 1];
        assert!((integral(&values) - 1.0).abs() < 1e-12);
        assert_eq!((cosine(0), cosine(N_STEPS)), (-1.0, 1.0));
    }
}
