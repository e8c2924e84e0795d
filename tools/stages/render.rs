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
    [image.with_extension("rgb.exr"), image.with_extension("png")]
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
    let companions = companions(stage.target.path);
    let mut spent = None;
    let done = perform(&request(&stage, &companions)?, options, |provenance| {
        let image = picture(stage, &provenance, options.verbosity)?;
        spent = image.1;
        write(&image.0, &stage.settings.picture, stage.target.path)
    })?;
    saved_rows::clear(stage.target.path);
    Ok(Done { spent, ..done })
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
    let companions = companions(stage.target.path);
    let request = request(&as_afforded, &companions)?;
    let done = perform(&request, options, |provenance| {
        let image = work.image(rendered, region, provenance);
        write(&image, &settings.picture, stage.target.path)
    })?;
    let done = Done {
        seconds: (deadline.now_s)() - start_s,
        spent: Some(spent),
        ..done
    };
    Ok((done, spent.afforded))
}

/// What the files of a picture are asked for with.
fn request<'a>(
    stage: &RenderStage<'a>,
    [plain, preview]: &'a [PathBuf; 2],
) -> Result<Request<'a>, Failure> {
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
        outputs: vec![target.path, plain, preview],
    })
}

/// Writes an image, the plain one and the preview.
///
/// # Errors
/// A file that cannot be written.
pub(crate) fn write(image: &SpectralImage, shown: &Picture, to: &Path) -> Result<(), Failure> {
    let [plain, preview] = companions(to);
    output::write_file(&preview, |writer| {
        image.write_png(writer, shown.exposure_ev)
    })?;
    output::write_file(&plain, |writer| {
        image.write_rgb_exr(shown.primaries.into(), writer)
    })?;
    output::write_file(to, |writer| image.write_spectral(writer))
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
