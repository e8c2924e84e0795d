//! Intensity against angle, out of a scattering table or of several theories.

use niji_exchange::ScatteringTable;

use crate::bow_curves::BowCurves;
use crate::plot::Curve;
use crate::plot::Plot;

/// Wavelengths that are drawn: blue, green, red.
const SHOWN_NM: [f64; 3] = [450.0, 550.0, 650.0];
/// The wavelength at which theories are drawn side by side.
const COMPARED_NM: f64 = 550.0;
/// Step of the curves.
const STEP_DEG: f64 = 0.05;
const Y_LABEL: &str = "(dσ/dΩ) / (π⟨r²⟩)  [1/sr], natural light";
const X_LABEL: &str = "scattering angle [degrees], 0 = forward";

/// The smallest and the largest size of a table at three wavelengths.
pub(super) fn of_table(table: &ScatteringTable) -> Plot {
    let mut curves = Vec::new();
    let mut radius_indices = vec![0, table.effective_radius_um.len() - 1];
    radius_indices.dedup();
    for radius_index in radius_indices {
        let angles = BowCurves::even_angles(range_rad(table), STEP_DEG.to_radians());
        let light = BowCurves::of(table, [radius_index, 0], angles);
        for wavelength_nm in SHOWN_NM {
            let radius_um = table.effective_radius_um[radius_index];
            curves.push(Curve {
                label: format!("{radius_um:.1} µm, {wavelength_nm} nm"),
                points: light.curve_near(wavelength_nm),
            });
        }
    }
    Plot {
        title: format!(
            "{}, effective variance {}",
            table.theory, table.effective_variance[0]
        ),
        x_label: X_LABEL,
        y_label: Y_LABEL,
        curves,
    }
}

/// Theories side by side at one wavelength.
pub(super) fn of_theories(title: String, theories: &[(String, BowCurves)]) -> Plot {
    let curve = |(label, light): &(String, BowCurves)| Curve {
        label: label.clone(),
        points: light.curve_near(COMPARED_NM),
    };
    Plot {
        title,
        x_label: X_LABEL,
        y_label: Y_LABEL,
        curves: theories.iter().map(curve).collect(),
    }
}

/// The angles of a table.
fn range_rad(table: &ScatteringTable) -> (f64, f64) {
    let last = table.theta_rad.len() - 1;
    (table.theta_rad[0], table.theta_rad[last])
}
