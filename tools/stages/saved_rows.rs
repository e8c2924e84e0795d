//! Rows of a picture that takes long, saved while it is rendered.
//!
//! Beside `image.exr` stands a folder `image.exr.parts` until the picture is there. What an
//! interrupted render left in it is not rendered again: the picture goes on below the last row saved,
//! and is the one that an uninterrupted render gives, because no pixel depends on the region that it
//! is rendered in. Files of another request are not taken.
//!
//! An image that is the mean of several over the time a shutter is open has a folder for each of them in its own.
//!
//! Saving is decided by the clock and changes nothing but the time: rows are saved when there was
//! something to lose for a while, and only where that costs little of the time they took.

use std::fs;
use std::ops::Range;
use std::path::Path;
use std::path::PathBuf;
use std::time::Instant;

use niji_exchange::Provenance;
use niji_exchange::SpectralImage;
use niji_geometry::PixelRegion;
use niji_picture::rows_of_step;
use niji_render::Deadline;
use niji_render::Error;
use niji_render::Progress;
use niji_render::RenderRequest;
use niji_render::Rendered;
use niji_render::Spent;
use niji_render::render_in_steps;

use crate::failure::Failure;
use crate::output;
use crate::stages::assembly::Assembly;
use crate::stages::stored_provenance;
use crate::stages::tile::Tile;

/// When rows are saved.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Saving {
    /// Rendering that may be lost, in seconds.
    pub(crate) every_s: f64,
    /// Largest part of the time that saving may take.
    pub(crate) most_cost: f64,
}

impl Saving {
    /// For people who wait.
    pub(crate) const STANDARD: Self = Self {
        every_s: 0.5,
        most_cost: 0.02,
    };
}

/// Bytes of pixels that are saved in a second, before it was measured.
const FIRST_GUESS_BYTES_PER_S: f64 = 1e8;
/// Steps of a picture: threads wait for each other at the end of each.
const N_STEPS: u32 = 10;

/// A picture to be rendered, and how it becomes an image.
pub(crate) struct Work<'a> {
    /// The picture.
    pub(crate) request: RenderRequest<'a>,
    /// Where the image comes from.
    pub(crate) provenance: Provenance,
    /// Makes an image of what was rendered of a region, with a provenance.
    pub(crate) image: &'a (dyn Fn(Rendered, PixelRegion, Provenance) -> SpectralImage + Sync),
    /// Hears how many pixels were done.
    pub(crate) progress: Progress<'a>,
    /// When it has to be there.
    pub(crate) deadline: Deadline<'a>,
}

/// Renders a picture that becomes the image `to`, and goes on where it was interrupted; and what went into it where
/// it was not.
///
/// # Errors
/// As [`render_in_steps`].
pub(crate) fn render(
    work: &Work,
    to: &Path,
    saving: Saving,
) -> Result<(SpectralImage, Option<Spent>), Error> {
    let region = work.request.region;
    let folder = folder(to);
    let (mut assembly, n_found) = found(&folder, work);
    let below = PixelRegion {
        y_px: region.y_px + n_found as i32,
        height_px: region.height_px - n_found,
        ..region
    };
    // Whoever waits for it is heard before the first row.
    let _ = (work.progress)(region.n_pixels() - below.n_pixels());
    if below.height_px > 0 {
        let request = RenderRequest {
            region: below,
            ..work.request
        };
        let mut saver = Saver::new(work, folder, below, saving);
        let n_rows = rows_of_step(below).max(below.height_px / N_STEPS);
        let mut next = |rendered: &Rendered, n_finished: u32| {
            saver.save_if_due(rendered, n_finished);
            n_rows
        };
        let watch = (work.progress, work.deadline);
        let (rendered, spent) = render_in_steps(&request, watch, &mut next)?;
        let image = (work.image)(rendered, below, work.provenance.clone());
        let Some(assembly) = &mut assembly else {
            return Ok((image, Some(spent)));
        };
        if assembly.add(&image).is_err() {
            // Another build of this version saved other layers.
            clear(to);
            return render(work, to, saving);
        }
    }
    let assembly = assembly.expect("rows that need no rendering were found");
    Ok((assembly.finish(), None))
}

/// What an image is called that is one of those over which another is the mean: its rows are saved beside the other's
/// own until that is there.
pub(crate) fn at_instant(image: &Path, place: usize) -> PathBuf {
    folder(image).join(format!("instant-{place:03}"))
}

/// Removes what was saved of an image that is there.
pub(crate) fn clear(image: &Path) {
    let folder = folder(image);
    let entries = fs::read_dir(&folder).into_iter().flatten().flatten();
    for entry in entries.filter(|entry| entry.path().is_dir()) {
        clear(&entry.path().with_extension(""));
    }
    let is_own = |file: &PathBuf| {
        stored_provenance(file)
            .as_ref()
            .and_then(Tile::of)
            .is_some()
    };
    for file in files(&folder).into_iter().filter(is_own) {
        // What cannot be removed does no harm.
        let _ = fs::remove_file(file);
    }
    output::remove_abandoned(&folder);
    let _ = fs::remove_dir(folder);
}

fn folder(image: &Path) -> PathBuf {
    let mut name = image.as_os_str().to_owned();
    name.push(".parts");
    PathBuf::from(name)
}

/// Files of rows, from top to bottom.
fn files(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let is_of_rows = |path: &PathBuf| {
        let name = path.file_name().and_then(|name| name.to_str());
        let is_exr = path.extension().is_some_and(|extension| extension == "exr");
        is_exr && name.is_some_and(|name| name.starts_with("rows-"))
    };
    let mut files: Vec<PathBuf> = entries
        .map(|entry| entry.path())
        .filter(is_of_rows)
        .collect();
    files.sort();
    files
}

/// The rows at the top that were saved for this very picture, and how many.
fn found(folder: &Path, work: &Work) -> (Option<Assembly>, u32) {
    let whole = work.request.region;
    let (mut assembly, mut n_rows) = (None, 0);
    for file in files(folder) {
        let tile = stored_provenance(&file).as_ref().and_then(Tile::of);
        let Some((tile, provenance)) = tile else {
            continue;
        };
        let next = whole.y_px + n_rows as i32;
        let is_next = tile.region.y_px == next && tile.region.bottom() <= whole.bottom();
        if provenance != work.provenance || tile.whole != whole || !is_next {
            continue;
        }
        // A damaged file is as good as none.
        let Ok(part) = SpectralImage::read_spectral(&file) else {
            break;
        };
        let whole =
            assembly.get_or_insert_with(|| Assembly::new(&part, whole, work.provenance.clone()));
        if part.windows.data != tile.region || whole.add(&part).is_err() {
            break;
        }
        n_rows += tile.region.height_px;
    }
    (assembly.filter(|_| n_rows > 0), n_rows)
}

/// Saves rows that were rendered.
struct Saver<'a> {
    work: &'a Work<'a>,
    folder: PathBuf,
    region: PixelRegion,
    saving: Saving,
    last: Instant,
    bytes_per_s: f64,
    n_saved: u32,
}

impl<'a> Saver<'a> {
    fn new(work: &'a Work<'a>, folder: PathBuf, region: PixelRegion, saving: Saving) -> Self {
        Self {
            work,
            folder,
            region,
            saving,
            last: Instant::now(),
            bytes_per_s: FIRST_GUESS_BYTES_PER_S,
            n_saved: 0,
        }
    }

    fn save_if_due(&mut self, rendered: &Rendered, n_finished: u32) {
        let waited_s = self.last.elapsed().as_secs_f64();
        let rows = self.n_saved as usize..n_finished as usize;
        if rows.is_empty() || waited_s < self.saving.every_s {
            return;
        }
        let n_wavelengths = rendered.radiance.dim().0 as f64;
        let n_pixels = rows.len() as f64 * f64::from(self.region.width_px);
        let n_bytes = size_of::<f32>() as f64 * n_wavelengths * n_pixels;
        if n_bytes > self.saving.most_cost * waited_s * self.bytes_per_s {
            return;
        }
        let start = Instant::now();
        match self.save(rendered, rows) {
            Ok(()) => self.n_saved = n_finished,
            // A disk that is full now will be so again; the picture does not need these rows.
            Err(_) => self.saving.every_s = f64::INFINITY,
        }
        self.bytes_per_s = n_bytes / start.elapsed().as_secs_f64().max(1e-9);
        self.last = Instant::now();
    }

    fn save(&self, rendered: &Rendered, rows: Range<usize>) -> Result<(), Failure> {
        let whole = self.work.request.region;
        let region = PixelRegion {
            y_px: self.region.y_px + rows.start as i32,
            height_px: rows.len() as u32,
            ..self.region
        };
        let provenance = Provenance {
            settings: Tile { region, whole }.settings(&self.work.provenance.settings),
            ..self.work.provenance.clone()
        };
        let first = region.y_px.abs_diff(whole.y_px);
        let name = format!("rows-{first:08}-{:08}.exr", first + region.height_px);
        let image = (self.work.image)(rendered.rows(rows), region, provenance);
        output::write_file(&self.folder.join(name), |writer| {
            image.write_spectral(writer)
        })
    }
}

#[cfg(test)]
#[path = "saved_rows_tests.rs"]
mod tests;
