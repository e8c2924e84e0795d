//! The stage `drops`: a shape becomes a drop volume.

use std::path::Path;

use niji_dropfield::DropVolume;
use niji_dropfield::VolumeSummary;
use niji_droplets::Shape;
use niji_scene::canonical_json;
use niji_vdb::Compression;
use niji_vdb::VdbFile;

use crate::failure::Failure;
use crate::output;
use crate::progress::Verbosity;
use crate::stages::Done;
use crate::stages::Manner;
use crate::stages::Request;
use crate::stages::perform;

/// Name of the file in the folder of a run.
pub(crate) const FILE: &str = "drops.vdb";

/// Writes the drop volume of a shape and says what is in it.
///
/// # Errors
/// A shape that cannot be, an output that exists, or a file that cannot be written.
pub(crate) fn make(
    shape: &Shape,
    compression: Compression,
    to: &Path,
    manner: Manner,
) -> Result<Done, Failure> {
    shape
        .validate()
        .map_err(|error| Failure::Usage(error.to_string()))?;
    let settings = canonical_json(&(shape, compression == Compression::Zip));
    let request = Request {
        stage: "drops",
        settings,
        inputs: Vec::new(),
        outputs: vec![to],
    };
    perform(&request, manner, |provenance| {
        let volume = shape
            .volume()
            .map_err(|error| Failure::Impossible(error.to_string()))?;
        let summary = volume.summary();
        let file = volume.to_vdb(&provenance.to_text_items());
        let file = file.map_err(|error| Failure::Failed(error.to_string()))?;
        output::write_file(to, |writer| file.write(writer, compression))?;
        if manner.verbosity > Verbosity::Quiet {
            print_summary(&summary);
        }
        Ok(())
    })
}

/// Reads a drop volume.
///
/// # Errors
/// A missing or damaged file, or one that holds no drops of ours.
pub(crate) fn read(path: &Path) -> Result<DropVolume, Failure> {
    let file = VdbFile::read(path).map_err(|error| bad_vdb(path, &error))?;
    DropVolume::from_vdb(&file).map_err(|error| Failure::bad_input(path, error))
}

/// A VDB file that cannot be read, with the causes in one line.
pub(crate) fn bad_vdb(path: &Path, error: &niji_vdb::Error) -> Failure {
    let mut message = String::new();
    let mut cause: Option<&dyn std::error::Error> = Some(error);
    while let Some(error) = cause {
        if !message.is_empty() {
            message += ": ";
        }
        message += &error.to_string();
        cause = error.source();
    }
    let named = format!("cannot read {}: ", path.display());
    Failure::bad_input(path, message.strip_prefix(&named).unwrap_or(&message))
}

/// Says on standard error how much water and how much extinction there is, and what is unnatural.
pub(crate) fn print_summary(summary: &VolumeSummary) {
    let (r_low, r_high) = summary.effective_radius_um;
    let [tau_x, tau_y, tau_z] = summary.optical_depth_q1;
    eprintln!(
        "      drops  {} nodes, effective radius {r_low:.4} to {r_high:.4} um",
        summary.n_nodes
    );
    eprintln!(
        "             liquid water {:.3e} g/m3 mean, {:.3e} max; extinction (Q = 2) {:.3e} 1/m max",
        summary.mean_liquid_water_g_m3,
        summary.max_liquid_water_g_m3,
        2.0 * summary.max_extinction_m1_q1
    );
    eprintln!(
        "             optical depth (Q = 2) across x, y, z: {:.3}, {:.3}, {:.3}",
        2.0 * tau_x,
        2.0 * tau_y,
        2.0 * tau_z
    );
    for warning in &summary.warnings {
        eprintln!("    warning  {warning}");
    }
}
