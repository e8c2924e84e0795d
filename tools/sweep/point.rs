//! One choice of levels, run and compared; and the folder that keeps what an interrupted sweep did.

use std::fs;
use std::path::Path;
use std::path::PathBuf;

use niji_exchange::Provenance;
use niji_exchange::SpectralImage;
use niji_exchange::write_srgb_png;
use niji_scene::canonical_json;
use serde::Deserialize;
use serde::Serialize;

use super::Variant;
use super::picture_distance::picture_distance;
use crate::checksums;
use crate::failure::Failure;
use crate::output;
use crate::peak_memory::PeakMemory;
use crate::run::files::hash;
use crate::stages;
use crate::stages::seconds_of;
use crate::timed_run::relative_rmse;
use crate::timed_run::rounded;
use crate::timed_run::timed_run;
use crate::version;
use niji_picture::PlannedScene;

/// Where a run is made, beside those that were.
const UNFINISHED: &str = "unfinished";

/// A point of the plane of error and time.
#[derive(Clone, Debug, Default, Serialize)]
pub(super) struct Point {
    /// The decision, or `preset`.
    pub(super) decision: String,
    /// The level in words.
    pub(super) level: String,
    /// Time of the whole run, s.
    pub(super) seconds: f64,
    /// Most memory held during the run, MB.
    pub(super) peak_memory_mb: Option<f64>,
    /// Of spectral radiance against the reference preset.
    pub(super) relative_rmse: f64,
    /// Of spectral radiance against the best level of the decision.
    pub(super) own_relative_rmse: f64,
    /// Largest difference of luminance, 1 being white.
    pub(super) max_over_white: f64,
    /// CIEDE2000, mean over the pixels.
    pub(super) mean_color_difference: f64,
    /// CIEDE2000, largest.
    pub(super) max_color_difference: f64,
    /// Whether no other point is faster and nearer.
    pub(super) on_front: bool,
    /// Name of its run.
    #[serde(skip)]
    pub(super) run: String,
}

/// What a run cost.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct Cost {
    seconds: f64,
    peak_bytes: Option<u64>,
}

/// The runs of a sweep.
pub(super) struct Runs {
    folder: PathBuf,
    /// Whether runs that look unchanged are read all the same.
    verifies: bool,
    /// Names of those that were made or found.
    names: Vec<String>,
    reference: SpectralImage,
    /// The best level of the decision at hand.
    best: SpectralImage,
}

impl Runs {
    /// Keeps runs in a folder, and makes the reference.
    pub(super) fn new(
        folder: &Path,
        verifies: bool,
        reference: &PlannedScene,
    ) -> Result<Self, Failure> {
        let (name, _, image) = run((folder, verifies), reference)?;
        Ok(Self {
            folder: folder.to_owned(),
            verifies,
            names: vec![name],
            best: image.clone(),
            reference: image,
        })
    }

    /// Runs a choice, unless it was, and compares it.
    pub(super) fn point(
        &mut self,
        variant: &Variant,
        planned: &PlannedScene,
    ) -> Result<Point, Failure> {
        let (name, cost, image) = run((&self.folder, self.verifies), planned)?;
        self.names.push(name.clone());
        let exposure_ev = planned.scene.picture.exposure_ev;
        let distance = picture_distance(&image, &self.reference, exposure_ev);
        let size = [image.radiance.dim().2, image.radiance.dim().1];
        output::write_file(&self.map(&name), |writer| {
            write_srgb_png(&distance.map, size, &Provenance::default(), writer)
        })?;
        output::write_file(&self.picture(&name), |writer| {
            image.write_png(writer, exposure_ev)
        })?;
        let own_relative_rmse = if variant.is_best {
            0.0
        } else {
            relative_rmse(&image.radiance, &self.best.radiance)
        };
        let named = planned.plan.levels.named();
        let level = named.into_iter().find(|(key, _)| key == variant.decision);
        let level = match level {
            Some((_, level)) => level,
            None => variant.accuracy.preset.name().to_owned(),
        };
        let point = Point {
            decision: variant.decision.to_owned(),
            level,
            seconds: rounded(cost.seconds),
            peak_memory_mb: cost.peak_bytes.map(|bytes| rounded(bytes as f64 / 1e6)),
            relative_rmse: rounded(distance.relative_rmse),
            own_relative_rmse: rounded(own_relative_rmse),
            max_over_white: rounded(distance.max_over_white),
            mean_color_difference: rounded(distance.mean_color_difference),
            max_color_difference: rounded(distance.max_color_difference),
            on_front: false,
            run: name,
        };
        if variant.is_best {
            self.best = image;
        }
        Ok(point)
    }

    /// The preview of a run.
    pub(super) fn picture(&self, run: &str) -> PathBuf {
        self.folder.join(format!("{run}.png"))
    }

    /// The map of its color differences.
    pub(super) fn map(&self, run: &str) -> PathBuf {
        self.folder.join(format!("{run}.difference.png"))
    }

    /// Removes what was kept in case of an interruption, and the folder if nothing else is in it.
    pub(super) fn remove(self) {
        for name in &self.names {
            let kept = [
                image_file(&self.folder, name),
                cost_file(&self.folder, name),
            ];
            for path in kept.into_iter().chain([self.map(name), self.picture(name)]) {
                checksums::remove(&path);
            }
        }
        let _ = fs::remove_dir(&self.folder);
    }
}

fn image_file(folder: &Path, run: &str) -> PathBuf {
    folder.join(format!("{run}.exr"))
}

fn cost_file(folder: &Path, run: &str) -> PathBuf {
    folder.join(format!("{run}.json"))
}

/// Name, cost and picture of a plan that is run from nothing, or was before.
fn run(
    (folder, verifies): (&Path, bool),
    planned: &PlannedScene,
) -> Result<(String, Cost, SpectralImage), Failure> {
    let request = request(planned)?;
    let name = hash(request.clone());
    let (image_path, cost_path) = (image_file(folder, &name), cost_file(folder, &name));
    let is_kept = |path: &PathBuf| checksums::fits(path, &request, verifies);
    // The cost is written last.
    if [&cost_path, &image_path].into_iter().all(is_kept)
        && let Ok(text) = fs::read_to_string(&cost_path)
        && let Ok(cost) = serde_json::from_str(&text)
        && let Ok(image) = SpectralImage::read_spectral(&image_path)
    {
        return Ok((name, cost, image));
    }
    let memory = PeakMemory::start();
    let (done, image) = timed_run(planned, &folder.join(UNFINISHED))?;
    let cost = Cost {
        seconds: seconds_of(&done),
        peak_bytes: memory.bytes(),
    };
    output::write_file(&image_path, |writer| image.write_spectral(writer))?;
    output::write_file(&cost_path, |writer| serde_json::to_writer(writer, &cost))?;
    [&image_path, &cost_path]
        .into_iter()
        .try_for_each(|path| checksums::note(path, &request))?;
    Ok((name, cost, image))
}

/// All that a run depends on.
fn request(planned: &PlannedScene) -> Result<String, Failure> {
    let scene = canonical_json(&planned.scene);
    let levels = canonical_json(&planned.plan.levels);
    let mut provenance = Provenance {
        version: version().to_owned(),
        settings: format!("{scene} {levels}"),
        ..Provenance::default()
    };
    for file in planned.scene.files() {
        let path = planned.folder.join(file);
        provenance.inputs.extend(stages::hashed(file, &path)?);
    }
    Ok(provenance.request_hash())
}
