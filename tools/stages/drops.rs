//! The stage `drops`: a shape, or a density grid of another program, becomes a drop volume; several of
//! them, and volumes that exist already, become one.

use std::path::Path;

use niji_dropfield::DropVolume;
use niji_dropfield::Warning;
use niji_picture::VolumeSource;
use niji_vdb::Compression;

use crate::failure::Failure;
use crate::output;
use crate::stages::Done;
use crate::stages::Request;
use crate::stages::StageOptions;
use crate::stages::perform;

/// Name of the file in the folder of a run.
pub(crate) const FILE: &str = "drops.vdb";

/// Writes a drop volume and says what is in it.
///
/// # Errors
/// As [`VolumeSource::volume`]; an output that exists, or a file that cannot be written.
pub(crate) fn make(
    source: &VolumeSource,
    compression: Compression,
    to: &Path,
    options: StageOptions,
) -> Result<Done, Failure> {
    let inputs = source.inputs();
    let request = Request {
        stage: "drops",
        settings: source.settings(compression == Compression::Zip),
        inputs: inputs
            .iter()
            .map(|(role, path)| (role.as_str(), *path))
            .collect(),
        outputs: vec![to],
    };
    perform(&request, options, |provenance| {
        let volume = source.volume()?;
        let file = volume.to_vdb(&provenance.to_text_items());
        let file = file.map_err(|error| match error {
            niji_dropfield::Error::BadModeName { .. } => Failure::Usage(error.to_string()),
            _ => Failure::Failed(error.to_string()),
        })?;
        output::write_file(to, |writer| file.write(writer, compression))?;
        options.verbosity.say(summary(volume, source.is_thrown()));
        Ok(())
    })
}

/// How much water and how much extinction there is, and what is unnatural.
fn summary(volume: DropVolume, is_thrown: bool) -> String {
    let whole = volume.summary();
    let modes = if volume.modes.len() > 1 {
        volume.modes
    } else {
        Vec::new()
    };
    let (r_low, r_high) = whole.effective_radius_um;
    let [tau_x, tau_y, tau_z] = whole.optical_depth_q1.map(|tau| 2.0 * tau);
    let mut lines = vec![
        format!(
            "      drops  {} nodes, effective radius {r_low:.4} to {r_high:.4} um",
            whole.n_nodes
        ),
        format!(
            "             liquid water {:.3e} g/m3 mean, {:.3e} max; extinction (Q = 2) {:.3e} 1/m max",
            whole.mean_liquid_water_g_m3,
            whole.max_liquid_water_g_m3,
            2.0 * whole.max_extinction_m1_q1
        ),
        format!(
            "             optical depth (Q = 2) across x, y, z: {tau_x:.3}, {tau_y:.3}, {tau_z:.3}"
        ),
    ];
    for mode in modes {
        let name = mode.name.clone();
        let mode = DropVolume { modes: vec![mode] }.summary();
        let (r_low, r_high) = mode.effective_radius_um;
        let deepest = mode.optical_depth_q1.into_iter().fold(0.0, f64::max);
        lines.push(format!(
            "             {name}: {} nodes, {:.3e} g of water, effective radius {r_low:.4} to \
             {r_high:.4} um, optical depth (Q = 2) up to {:.3}",
            mode.n_nodes,
            mode.total_water_g,
            2.0 * deepest
        ));
    }
    let is_meant = |it: &&Warning| is_thrown && matches!(it, Warning::LiquidWater { .. });
    let warnings = whole.warnings.iter().filter(|it| !is_meant(it));
    lines.extend(warnings.map(|warning| format!("    warning  {warning}")));
    lines.join("\n")
}
