//! The stage `render`: drops, scattering and air become a picture.

use std::ops::ControlFlow;
use std::path::Path;
use std::path::PathBuf;
use std::time::Instant;

use niji_exchange::PictureFile;
use niji_exchange::PictureHead;
use niji_exchange::Provenance;
use niji_exchange::Spectra;
use niji_exchange::SpectralImage;
use niji_exchange::StripWriter;
use niji_geometry::PixelRegion;
use niji_picture::Error;
use niji_picture::PictureParts;
use niji_picture::PictureSettings;
use niji_picture::PictureWork;
use niji_picture::SurfaceFiles;
use niji_picture::read_drops;
use niji_picture::scattering::as_needed;
use niji_picture::unwatched;
use niji_render::Afforded;
use niji_render::Deadline;
use niji_render::Input;
use niji_render::Progress;
use niji_render::Spent;
use niji_render::render_in_steps;
use niji_scene::Picture;

use crate::failure::Failure;
use crate::output;
use crate::progress;
use crate::progress::Verbosity;
use crate::stages;
use crate::stages::Done;
use crate::stages::Request;
use crate::stages::StageOptions;
use crate::stages::assembly::Assembly;
use crate::stages::given_table;
use crate::stages::perform;
use crate::stages::saved_rows;
use crate::stages::saved_rows::Saving;
use crate::stages::saved_rows::Work;
use crate::stages::shown::Shown;
use crate::stages::tile::Tile;

/// Name of the spectral image in the folder of a run.
pub(crate) const FILE: &str = "image.exr";

/// The files that a picture is made from.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Inputs<'a> {
    /// The drop volume.
    pub drops: &'a Path,
    /// The scattering table, where a bow is on.
    pub table: Option<&'a Path>,
    /// The air, where an effect of the air is on.
    pub air: Option<&'a Path>,
    /// Surfaces that hide what is behind them.
    pub surfaces: &'a SurfaceFiles,
}

/// An image to be made.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Target<'a> {
    /// Its file.
    pub path: &'a Path,
    /// The pixels that it shall hold.
    pub region: PixelRegion,
}

/// The plain image and the preview beside a spectral image.
#[must_use]
pub(crate) fn companions(image: &Path) -> [PathBuf; 2] {
    [
        image.with_extension("layers.exr"),
        image.with_extension("png"),
    ]
}

/// A picture or a tile to be rendered.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RenderStage<'a> {
    /// What it depends on besides its files.
    pub settings: &'a PictureSettings,
    /// The files that it is made from.
    pub inputs: Inputs<'a>,
    /// What it becomes.
    pub target: Target<'a>,
}

/// Renders a picture or a tile: the spectral image, the plain one and the preview.
///
/// # Errors
/// Inputs that are missing, damaged or contradict each other, an output that exists, or a file that
/// cannot be written.
pub(crate) fn make(stage: RenderStage, options: StageOptions) -> Result<Done, Failure> {
    let shown = Shown::of(&stage)?;
    shown.check_free(options)?;
    let (mut rows, mut spent) = (None, None);
    let done = perform(&request(&stage)?, options, |provenance| {
        let mut shown_rows = shown.rows()?;
        let add = &mut |rows: &SpectralImage| shown_rows.add(rows);
        spent = write_rows(stage, (&provenance, options.verbosity), add)?;
        rows = Some(shown_rows);
        Ok(())
    })?;
    saved_rows::clear(stage.target.path);
    shown.make(rows, Done { spent, ..done }, options)
}

/// Renders a picture in the time there is.
///
/// # Errors
/// As [`make`].
pub(crate) fn make_until(
    stage: RenderStage,
    deadline: Deadline,
    options: StageOptions,
) -> Result<(Done, Afforded), Failure> {
    let start_s = (deadline.now_s)();
    let region = stage.target.region;
    let work = work(stage)?;
    let bar = progress::bar("render", region.n_pixels(), options.verbosity);
    let progress = |n_pixels| {
        bar.inc(n_pixels);
        ControlFlow::Continue(())
    };
    let watch = (&progress as Progress, deadline);
    let rendered = render_in_steps(&work.request(region), watch, region.height_px);
    bar.finish_and_clear();
    let (rendered, spent) = rendered.map_err(|error| refusal(&error, stage.inputs))?;
    let settings = stage.settings.clone().with(spent.afforded);
    let as_afforded = RenderStage {
        settings: &settings,
        ..stage
    };
    let shown = Shown::of(&as_afforded)?;
    shown.check_free(options)?;
    let mut rows = None;
    let done = perform(&request(&as_afforded)?, options, |provenance| {
        let image = work.keeping(work.image(rendered, region, provenance));
        write_spectral(&image, stage.target.path)?;
        let mut shown_rows = shown.rows()?;
        image.strips().try_for_each(|rows| shown_rows.add(&rows))?;
        rows = Some(shown_rows);
        Ok(())
    })?;
    let done = Done {
        seconds: (deadline.now_s)() - start_s,
        spent: Some(spent),
        ..shown.make(rows, done, options)?
    };
    Ok((done, spent.afforded))
}

/// What the spectral image of a picture is asked for with.
fn request<'a>(stage: &RenderStage<'a>) -> Result<Request<'a>, Failure> {
    request_with(stage.settings, stage)
}

/// The same with other settings than the stage's.
pub(super) fn request_with<'a>(
    settings: &PictureSettings,
    stage: &RenderStage<'a>,
) -> Result<Request<'a>, Failure> {
    let RenderStage { inputs, target, .. } = *stage;
    let mut files = vec![("drops", inputs.drops)];
    files.extend(inputs.table.map(|path| ("table", path)));
    files.extend(inputs.air.map(|path| ("air", path)));
    files.extend(inputs.surfaces.inputs());
    let region = target.region;
    let whole = settings.whole()?;
    let text = inputs.surfaces.settings(settings);
    Ok(Request {
        stage: "render",
        settings: Tile { region, whole }.settings(&text),
        inputs: files,
        outputs: vec![target.path],
    })
}

/// Writes an image, the plain one and the preview.
///
/// # Errors
/// A file that cannot be written.
pub(crate) fn write(image: &SpectralImage, shown: &Picture, to: &Path) -> Result<(), Failure> {
    write_shown(image, shown, to)?;
    write_spectral(image, to)
}

fn write_spectral(image: &SpectralImage, to: &Path) -> Result<(), Failure> {
    output::write_file(to, |writer| image.write_spectral(writer))
}

fn write_shown(image: &SpectralImage, shown: &Picture, beside: &Path) -> Result<(), Failure> {
    let [plain, preview] = companions(beside);
    output::write_file(&preview, |writer| {
        image.write_png(writer, shown.exposure_ev)
    })?;
    output::write_file(&plain, |writer| {
        image.write_layers(shown.primaries.into(), writer)
    })
}

/// The files of a picture, read, and its drops in the light of the sun.
fn work(stage: RenderStage) -> Result<PictureWork, Failure> {
    let RenderStage {
        settings, inputs, ..
    } = stage;
    let table = inputs
        .table
        .zip(settings.scattering.as_ref())
        .map(|(path, need)| {
            let table = given_table::read(path, need, settings.spectrum)?;
            Ok::<_, Failure>(as_needed(table, need))
        });
    let parts = PictureParts {
        drops: read_drops(inputs.drops)?,
        table: table.transpose()?,
        air: inputs.air.map(stages::atmosphere::read).transpose()?,
        surfaces: inputs.surfaces.read(settings.camera)?,
    };
    PictureWork::new(settings.clone(), parts, &unwatched).map_err(|error| match error {
        Error::Volume(_) | Error::Light(_) => Failure::bad_input(inputs.drops, error),
        error => error.into(),
    })
}

/// Renders the picture and writes its spectral image; `add` gets its rows from the top, too.
fn write_rows(
    stage: RenderStage,
    (provenance, verbosity): (&Provenance, Verbosity),
    add: &mut dyn FnMut(&SpectralImage) -> Result<(), Failure>,
) -> Result<Option<Spent>, Failure> {
    let Target { path, region } = stage.target;
    let watched = (provenance, verbosity);
    let mut spent = None;
    if Spectra::from(stage.settings.picture.spectral) == Spectra::Full {
        let head = PictureHead::new(PictureFile::Spectral, region, provenance.clone());
        output::make_file(path, |writer| {
            let failed = |error| output::failed(path, &error);
            let mut file = StripWriter::new(head, writer);
            spent = render_rows(stage, watched, &mut |rows| {
                file.add(rows).map_err(failed)?;
                add(rows)
            })?;
            file.finish().map(|_| ()).map_err(failed)
        })?;
    } else {
        // Which of its channels half floats hold is known when all of it is there.
        let mut image = Collected::new(region, provenance);
        spent = render_rows(stage, watched, &mut |rows| {
            image.add(rows);
            add(rows)
        })?;
        write_spectral(&image.finish(), path)?;
    }
    Ok(spent)
}

/// Renders the picture from the top, with as much of its spectra as is kept of them; `take` gets its rows.
fn render_rows(
    stage: RenderStage,
    (provenance, verbosity): (&Provenance, Verbosity),
    take: &mut dyn FnMut(&SpectralImage) -> Result<(), Failure>,
) -> Result<Option<Spent>, Failure> {
    let RenderStage {
        settings,
        inputs,
        target,
    } = stage;
    let n_pixels = settings.n_pictures() * target.region.n_pixels();
    let bar = progress::bar("render", n_pixels, verbosity);
    let start = Instant::now();
    let one = |work: &PictureWork, to: &Path, take: &mut dyn FnMut(&SpectralImage) -> _| {
        let rows = Work {
            request: work.request(target.region),
            provenance: provenance.clone(),
            image: &|rendered, region, provenance| work.image(rendered, region, provenance),
            progress: &|n_pixels| {
                bar.inc(n_pixels);
                ControlFlow::Continue(())
            },
            deadline: Deadline {
                now_s: &|| start.elapsed().as_secs_f64(),
                ..Deadline::NEVER
            },
        };
        let mut failed = None;
        let mut take = |rows: &SpectralImage| match take(rows) {
            Ok(()) => ControlFlow::Continue(()),
            Err(failure) => {
                failed = Some(failure);
                ControlFlow::Break(())
            }
        };
        let spent = saved_rows::render(&rows, to, (Saving::STANDARD, &mut take));
        failed.map_or_else(|| spent.map_err(|error| refusal(&error, inputs)), Err)
    };
    let work = work(stage)?;
    let spent = if settings.shutter.is_some() {
        let image = work.over_shutter(&unwatched, |work, place| {
            let mut image = Collected::new(target.region, provenance);
            let to = saved_rows::at_instant(target.path, place);
            one(work, &to, &mut |rows| {
                image.add(rows);
                Ok(())
            })?;
            Ok::<_, Failure>(image.finish())
        })?;
        image.strips().try_for_each(|rows| take(&rows))?;
        // Of a mean nothing is told of its parts.
        None
    } else if Spectra::from(settings.picture.spectral) == Spectra::Full {
        one(&work, target.path, take)?
    } else {
        one(&work, target.path, &mut |rows| {
            take(&work.keeping(rows.clone()))
        })?
    };
    bar.finish_and_clear();
    Ok(spent)
}

/// Rows of a picture that has to be there as a whole.
struct Collected<'a> {
    region: PixelRegion,
    provenance: &'a Provenance,
    image: Option<Assembly>,
}

impl<'a> Collected<'a> {
    fn new(region: PixelRegion, provenance: &'a Provenance) -> Self {
        Self {
            region,
            provenance,
            image: None,
        }
    }

    fn add(&mut self, rows: &SpectralImage) {
        let new = || Assembly::new(rows, self.region, self.provenance.clone());
        let image = self.image.get_or_insert_with(new);
        image.add(rows).expect("rows of one picture are of a kind");
    }

    fn finish(self) -> SpectralImage {
        self.image.expect("a picture has rows").finish()
    }
}

/// A picture that was refused, said of the file that contradicts the scene.
fn refusal(error: &niji_render::Error, inputs: Inputs) -> Failure {
    let of_table = |path: Option<&Path>, maker: &str| {
        let path = path.unwrap_or(inputs.drops);
        let anew = format!("make it anew with `niji {maker}` for this scene and accuracy");
        Failure::bad_input(path, format!("{error}: {anew}"))
    };
    match (error.input(), error, &inputs.surfaces.depth) {
        (Some(Input::ScatteringTable), _, _) => of_table(inputs.table, "scatter"),
        (Some(Input::AtmosphereTable | Input::DiffuseLight), _, _) => {
            of_table(inputs.air, "atmosphere")
        }
        (None, niji_render::Error::SurfaceShape { .. }, Some(depth)) => {
            Failure::bad_input(&depth.path, error)
        }
        (None, niji_render::Error::Memory { .. }, _) => Failure::Failed(format!(
            "{error} (`niji render --tiles` or `--region`, or more `--memory`)"
        )),
        (None, _, _) => Failure::bad_input(inputs.table.unwrap_or(inputs.drops), error),
    }
}
