//! The stage `render`: drops, scattering and air become a picture.

use std::ops::ControlFlow;
use std::path::Path;
use std::path::PathBuf;
use std::time::Instant;

use niji_exchange::Provenance;
use niji_exchange::SpectralImage;
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
use niji_render::Rendered;
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
use crate::stages::given_table;
use crate::stages::perform;
use crate::stages::saved_rows;
use crate::stages::saved_rows::Saving;
use crate::stages::saved_rows::Work;
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
    let (mut rendered, mut spent) = (None, None);
    let done = perform(&request(&stage)?, options, |provenance| {
        let (image, of_all) = picture(stage, &provenance, options.verbosity)?;
        spent = of_all;
        write_spectral(&image, stage.target.path)?;
        rendered = Some(image);
        Ok(())
    })?;
    saved_rows::clear(stage.target.path);
    shown.make(rendered, Done { spent, ..done }, options)
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
    let whole = &mut |_: &Rendered, _| region.height_px;
    let rendered = render_in_steps(&work.request(region), (&progress, deadline), whole);
    bar.finish_and_clear();
    let (rendered, spent) = rendered.map_err(|error| refusal(&error, stage.inputs))?;
    let settings = stage.settings.clone().with(spent.afforded);
    let as_afforded = RenderStage {
        settings: &settings,
        ..stage
    };
    let shown = Shown::of(&as_afforded)?;
    shown.check_free(options)?;
    let mut made = None;
    let done = perform(&request(&as_afforded)?, options, |provenance| {
        let image = work.keeping(work.image(rendered, region, provenance));
        write_spectral(&image, stage.target.path)?;
        made = Some(image);
        Ok(())
    })?;
    let done = Done {
        seconds: (deadline.now_s)() - start_s,
        spent: Some(spent),
        ..shown.make(made, done, options)?
    };
    Ok((done, spent.afforded))
}

/// How a picture is shown: the plain image and the preview beside the spectral image, made anew without it where it is
/// shown otherwise.
struct Shown<'a> {
    settings: PictureSettings,
    stage: RenderStage<'a>,
    files: [PathBuf; 2],
}

impl<'a> Shown<'a> {
    fn of(stage: &RenderStage<'a>) -> Result<Self, Failure> {
        let settings = stage.settings;
        if settings.shown != settings.picture && stage.target.region != settings.whole()? {
            return Err(Failure::Usage(format!(
                "tiles are shown as their picture was decided on, at picture.exposure_ev = {}, found {}: plan it anew, \
                 or leave --tiles and --region out",
                settings.picture.exposure_ev, settings.shown.exposure_ev
            )));
        }
        Ok(Self {
            settings: PictureSettings {
                picture: settings.shown,
                ..settings.clone()
            },
            stage: *stage,
            files: companions(stage.target.path),
        })
    }

    /// The request of the picture if it had been decided on for this.
    fn request(&self) -> Result<Request<'_>, Failure> {
        let stage = RenderStage {
            settings: &self.settings,
            ..self.stage
        };
        Ok(Request {
            outputs: self.files.iter().map(PathBuf::as_path).collect(),
            ..request(&stage)?
        })
    }

    /// Refuses files of others before anything is rendered.
    fn check_free(&self, options: StageOptions) -> Result<(), Failure> {
        let [plain, preview] = &self.files;
        output::check_distinct(&[self.stage.target.path, plain, preview])?;
        stages::check_free_to_make(&self.request()?, options)
    }

    /// Makes both, after `done`, of what was rendered or stands in its file.
    fn make(
        &self,
        rendered: Option<SpectralImage>,
        done: Done,
        options: StageOptions,
    ) -> Result<Done, Failure> {
        let path = self.stage.target.path;
        // Of those that are there the image is told.
        let options = StageOptions {
            verbosity: Verbosity::Quiet,
            ..options
        };
        let made = perform(&self.request()?, options, |provenance| {
            let image = match rendered {
                Some(image) => image,
                None => SpectralImage::read_picture(path)
                    .map_err(|error| Failure::bad_input(path, error))?,
            };
            let image = SpectralImage {
                provenance,
                ..image
            };
            write_shown(&image, &self.settings.picture, path)
        })?;
        Ok(Done {
            files: [done.files, made.files].concat(),
            up_to_date: done.up_to_date && made.up_to_date,
            seconds: done.seconds + made.seconds,
            ..done
        })
    }
}

/// What the spectral image of a picture is asked for with.
fn request<'a>(stage: &RenderStage<'a>) -> Result<Request<'a>, Failure> {
    let RenderStage {
        settings,
        inputs,
        target,
    } = *stage;
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

fn picture(
    stage: RenderStage,
    provenance: &Provenance,
    verbosity: Verbosity,
) -> Result<(SpectralImage, Option<Spent>), Failure> {
    let RenderStage { inputs, target, .. } = stage;
    let is_mean = stage.settings.shutter.is_some();
    let n_pixels = stage.settings.n_pictures() * target.region.n_pixels();
    let bar = progress::bar("render", n_pixels, verbosity);
    let (start, mut spent) = (Instant::now(), None);
    let image = work(stage)?.over_shutter(&unwatched, |work, place| {
        let work = Work {
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
        let to = if is_mean {
            saved_rows::at_instant(target.path, place)
        } else {
            target.path.to_owned()
        };
        let image = saved_rows::render(&work, &to, Saving::STANDARD);
        let (image, of_all) = image.map_err(|error| refusal(&error, inputs))?;
        // Of a mean nothing is told of its parts.
        spent = of_all.filter(|_| !is_mean);
        Ok::<_, Failure>(image)
    });
    bar.finish_and_clear();
    Ok((image?, spent))
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
