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
//! something to lose for a while, and only where that costs little of the time they took. Until then they wait in
//! memory; of a picture that is rendered about as fast as it would be saved no more are, once they are too many for that.

use std::fs;
use std::ops::ControlFlow;
use std::path::Path;
use std::path::PathBuf;
use std::time::Instant;

use niji_exchange::PictureFile;
use niji_exchange::PictureHead;
use niji_exchange::Provenance;
use niji_exchange::STRIP_BYTES;
use niji_exchange::SpectralImage;
use niji_exchange::StripWriter;
use niji_geometry::PixelRegion;
use niji_picture::rows_of_step;
use niji_radiometry::memory_limit;
use niji_render::Deadline;
use niji_render::Error;
use niji_render::LEAST_STEPS;
use niji_render::Progress;
use niji_render::RenderRequest;
use niji_render::Rendered;
use niji_render::Spent;
use niji_render::render_in_strips;

use crate::failure::Failure;
use crate::output;
use crate::stages::assembly::check_kind;
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
/// Part of the memory that the rows of a step may take, unless they are no more than so many.
const OF_MEMORY: u128 = 4;
const LEAST_ROWS: u32 = 16;
/// Most bytes of spectra that wait for the time to save them.
const MOST_PENDING_BYTES: f64 = 64e6;

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

/// Gets rows of an image from the top, and may stop it.
pub(crate) type Take<'a> = &'a mut dyn FnMut(&SpectralImage) -> ControlFlow<()>;

/// Renders a picture that becomes the image `to`, and goes on where it was interrupted; what went into it where
/// it was not.
///
/// # Errors
/// As [`render_in_strips`].
pub(crate) fn render(
    work: &Work,
    to: &Path,
    (saving, take): (Saving, Take),
) -> Result<Option<Spent>, Error> {
    let region = work.request.region;
    let folder = folder(to);
    let n_found = take_found(&folder, work, take)?;
    let below = PixelRegion {
        y_px: region.y_px + n_found as i32,
        height_px: region.height_px - n_found,
        ..region
    };
    // Whoever waits for it is heard before the first row.
    let _ = (work.progress)(region.n_pixels() - below.n_pixels());
    if below.height_px == 0 {
        return Ok(None);
    }
    let request = RenderRequest {
        region: below,
        ..work.request
    };
    let mut saver = Saver::new(work, folder, saving);
    let mut take = |strip, rows| {
        let image = (work.image)(rows, strip, work.provenance.clone());
        take(&image)?;
        saver.save_if_due(image);
        ControlFlow::Continue(())
    };
    let watch = (work.progress, work.deadline);
    let spent = render_in_strips(&request, watch, rows_of_strip(&request), &mut take)?;
    Ok((n_found == 0).then_some(spent))
}

/// Rows that are rendered at a time.
fn rows_of_strip(request: &RenderRequest) -> u32 {
    let region = request.region;
    let row_bytes = u64::from(region.width_px) * request.bytes_per_pixel();
    let of_limit = memory_limit().0 / OF_MEMORY;
    let strip_bytes = u64::try_from(of_limit.min(STRIP_BYTES as u128)).unwrap_or(u64::MAX);
    let in_memory = u32::try_from(strip_bytes / row_bytes.max(1)).unwrap_or(u32::MAX);
    let n_rows = rows_of_step(region).max(region.height_px / LEAST_STEPS);
    n_rows.min(in_memory.max(LEAST_ROWS))
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

/// Hands over the rows at the top that were saved for this very picture, and says how many.
fn take_found(folder: &Path, work: &Work, take: Take) -> Result<u32, Error> {
    let whole = work.request.region;
    let mut expected = (work.image)(work.request.no_rows(), whole, work.provenance.clone());
    expected.windows.data = whole;
    let mut n_rows = 0;
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
        // A damaged file is as good as none, and one by another build of this version, with other layers.
        let Ok(part) = SpectralImage::read_spectral(&file) else {
            break;
        };
        if part.windows.data != tile.region || check_kind(&expected, &part).is_err() {
            break;
        }
        if take(&part).is_break() {
            return Err(Error::Stopped);
        }
        n_rows += tile.region.height_px;
    }
    Ok(n_rows)
}

/// Saves rows that were rendered.
struct Saver<'a> {
    work: &'a Work<'a>,
    folder: PathBuf,
    saving: Saving,
    last: Instant,
    bytes_per_s: f64,
    /// Rows that were not saved yet, from the top.
    pending: Vec<SpectralImage>,
}

impl<'a> Saver<'a> {
    fn new(work: &'a Work<'a>, folder: PathBuf, saving: Saving) -> Self {
        Self {
            work,
            folder,
            saving,
            last: Instant::now(),
            bytes_per_s: FIRST_GUESS_BYTES_PER_S,
            pending: Vec::new(),
        }
    }

    fn save_if_due(&mut self, image: SpectralImage) {
        let is_last = image.windows.data.bottom() == self.work.request.region.bottom();
        if is_last || self.saving.every_s == f64::INFINITY {
            return;
        }
        self.pending.push(image);
        let n_values: usize = (self.pending.iter()).map(|it| it.radiance.len()).sum();
        let n_bytes = (size_of::<f32>() * n_values) as f64;
        let waited_s = self.last.elapsed().as_secs_f64();
        let is_dear = n_bytes > self.saving.most_cost * waited_s * self.bytes_per_s;
        if is_dear && n_bytes > MOST_PENDING_BYTES {
            // It is rendered about as fast as it would be saved.
            self.give_up();
        }
        if is_dear || waited_s < self.saving.every_s {
            return;
        }
        let start = Instant::now();
        let saved = self.save();
        self.pending.clear();
        if saved.is_err() {
            // A disk that is full now will be so again; the picture does not need these rows.
            self.give_up();
        }
        self.bytes_per_s = n_bytes / start.elapsed().as_secs_f64().max(1e-9);
        self.last = Instant::now();
    }

    fn give_up(&mut self) {
        self.saving.every_s = f64::INFINITY;
        self.pending = Vec::new();
    }

    fn save(&self) -> Result<(), Failure> {
        let whole = self.work.request.region;
        let [Some(top), Some(bottom)] = [self.pending.first(), self.pending.last()] else {
            return Ok(());
        };
        let top_px = top.windows.data.y_px;
        let region = PixelRegion {
            y_px: top_px,
            height_px: (bottom.windows.data.bottom() - i64::from(top_px)) as u32,
            ..whole
        };
        let provenance = Provenance {
            settings: Tile { region, whole }.settings(&self.work.provenance.settings),
            ..self.work.provenance.clone()
        };
        let head = PictureHead::new(PictureFile::Spectral, region, provenance);
        let first = region.y_px.abs_diff(whole.y_px);
        let name = format!("rows-{first:08}-{:08}.exr", first + region.height_px);
        output::write_file(&self.folder.join(name), |writer| {
            let mut file = StripWriter::new(head, writer);
            (self.pending.iter()).try_for_each(|rows| file.add(rows))?;
            file.finish().map(|_| ())
        })
    }
}

#[cfg(test)]
#[path = "saved_rows_tests.rs"]
mod tests;
