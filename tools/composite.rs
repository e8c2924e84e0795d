//! `niji composite`: a rendered bow set into a photograph or a plate.

use std::path::Path;
use std::path::PathBuf;

use clap::Args;
use clap::ValueEnum;
use niji_exchange::Provenance;
use niji_exchange::SpectralImage;
use niji_photo::LinearPicture;
use niji_photo::PremultipliedPicture;
use niji_photo::alpha_over;
use niji_photo::read_depth_map;
use niji_photo::write_jpeg;
use niji_photo::write_png;
use niji_picture::CardExposure;
use niji_picture::Composite;
use niji_picture::CompositeRequest;
use niji_picture::DEPTH_MAP;
use niji_picture::Error;
use niji_picture::PlannedScene;
use niji_radiometry::RgbPrimaries;
use serde_json::json;

use crate::failure::Failure;
use crate::flags::Common;
use crate::output;
use crate::photo_source::PhotoSource;
use crate::stages::Done;
use crate::stages::Request;
use crate::stages::StageOptions;
use crate::stages::perform;
use crate::stages::photo;

/// Set a rendered bow into a photograph (EXR, PNG, JPEG).
///
/// In linear light: photograph x transmittance + bow + veil, and what the drops scatter of the photograph's own
/// light: before one of a single color they are not seen. The image of `niji render` gives bow,
/// veil and transmittance; it may be smaller than the photograph, in the same shape. A name ending
/// in .exr writes the premultiplied bow alone for compositors, to be set over the photograph (R, G, B
/// above 0 where A is 0 is added light), and the picture as PNG beside it; .png and .jpg write the
/// picture.
///
/// An EXR plate is scene-linear, half or float, with any data window; R, G and B are what its attribute
/// chromaticities says, Rec.709 or ACEScg. A channel Z beside them holds distances along the view ray
/// in metres (`niji depth --along axis` converts those along the optical axis).
#[derive(Clone, Debug, Args)]
#[command(
    mut_arg("scene", |scene| scene.conflicts_with("exposure")),
    mut_arg("photo", |photo| photo.help("The photograph (PNG, JPEG) or plate (EXR)")),
    after_help = "Examples:
  niji composite data/photos/pavilion.jpg --image out/image.exr -o bow-in-photo.png
  niji composite plate.exr --image out/image.exr --depth depth.exr --exposure 0.8 -o bow.exr
  niji composite plate.exr --image out/image.exr --exposure 1 --over shot.exr -o bow.exr

With depth, light that niji render integrated up to the same surfaces is sharp at their edges,
however small the image is; of an image rendered without them a bow whose mean distance is beyond
the surface is hidden: all light of a pixel is taken to come from one distance."
)]
pub(crate) struct CompositeCommand {
    /// The photograph.
    #[command(flatten)]
    source: PhotoSource,
    /// The spectral image of `niji render`.
    #[arg(long, value_name = "EXR")]
    image: PathBuf,
    /// Distances of the photographed surfaces (`niji depth`), which hide the bow behind them: the
    /// plate's own channel Z where this is left out.
    #[arg(long, value_name = "EXR")]
    depth: Option<PathBuf>,
    /// What red, green and blue of the plate are, whatever its file says.
    #[arg(long, value_enum, value_name = "NAME")]
    plate_primaries: Option<PrimariesName>,
    /// What red, green and blue are in the EXR files written: those of the plate where this is left out.
    #[arg(long, value_enum, value_name = "NAME")]
    primaries: Option<PrimariesName>,
    /// Also write the plate with the bow in it (EXR).
    #[arg(long, value_name = "EXR")]
    over: Option<PathBuf>,
    /// Value of a sunlit white card in the photograph, linear: `match` takes the mean of the picture
    /// for grey, `camera` the f-number, time and speed in EXIF, a number is taken as it is.
    #[arg(long, value_name = "match|camera|VALUE", default_value = "match", value_parser = exposure)]
    exposure: CardExposure,
    /// Exposure of the PNG or JPEG, in stops: EXR files hold the light as it is.
    #[arg(
        long,
        value_name = "STOPS",
        default_value_t = 0.0,
        allow_negative_numbers = true
    )]
    show_ev: f64,
    /// The published rule for what is too bright: scale all channels so that the largest is white.
    #[arg(long)]
    published: bool,
    /// The picture to write: .exr, .png or .jpg.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
}

impl CompositeCommand {
    /// What a scene says of its photograph, with what is not said of it as in `self`.
    ///
    /// # Errors
    /// A scene without one.
    fn for_scene(&self, planned: &PlannedScene) -> Result<Self, Failure> {
        let section = photo::section(planned)?;
        Ok(Self {
            source: PhotoSource::of_scene(planned)?,
            exposure: section.into(),
            ..self.clone()
        })
    }

    /// The photograph of a scene with its image and its depth map.
    ///
    /// # Errors
    /// A scene without one.
    pub(crate) fn of_scene(
        planned: &PlannedScene,
        (image, depth): (PathBuf, PathBuf),
        output: PathBuf,
    ) -> Result<Self, Failure> {
        Ok(Self {
            source: PhotoSource::of_scene(planned)?,
            image,
            depth: Some(depth),
            plate_primaries: None,
            primaries: None,
            over: None,
            exposure: photo::section(planned)?.into(),
            show_ev: 0.0,
            published: false,
            output,
        })
    }
}

/// Primaries by their name on the command line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum PrimariesName {
    Rec709,
    #[value(name = "acescg")]
    AcesCg,
}

impl From<PrimariesName> for RgbPrimaries {
    fn from(name: PrimariesName) -> Self {
        match name {
            PrimariesName::Rec709 => Self::Rec709,
            PrimariesName::AcesCg => Self::AcesCg,
        }
    }
}

/// Kind of a picture by its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Exr,
    Png,
    Jpeg,
}

/// Composites.
///
/// # Errors
/// As [`make`]; a scene that is missing or wrong.
pub(crate) fn execute(command: &CompositeCommand, common: &Common) -> Result<(), Failure> {
    let of_scene = (command.source).command(common, |planned| command.for_scene(planned))?;
    make(of_scene.as_ref().unwrap_or(command), common.options()).map(|_| ())
}

/// Composites, or keeps a picture that fits.
///
/// # Errors
/// Inputs that are missing, damaged or of other shapes, an output that exists or cannot be written.
pub(crate) fn make(command: &CompositeCommand, options: StageOptions) -> Result<Done, Failure> {
    let kind = kind(&command.output)?;
    let beside = command.output.with_extension("png");
    let mut outputs: Vec<&Path> = vec![&command.output];
    if kind == Kind::Exr {
        outputs.push(&beside);
    }
    outputs.extend(command.over.as_deref());
    let mut inputs = vec![
        ("photo", command.source.photo.as_path()),
        ("image", command.image.as_path()),
    ];
    inputs.extend(command.depth.iter().map(|path| ("depth", path.as_path())));
    let job = Request {
        stage: "composite",
        settings: settings(command),
        inputs,
        outputs,
    };
    perform(&job, options, |provenance| {
        let result = picture(command)?;
        options.verbosity.say(format_args!(
            "  composite  a sunlit white card has the value {:.4} in the photograph",
            result.bow.gain
        ));
        if let Some(path) = &command.over {
            write_over(&result, path, &provenance)?;
        }
        let shown = result
            .background
            .shown(&result.bow.picture, command.show_ev);
        let files = Files {
            kind,
            main: &command.output,
            beside: &beside,
            provenance: &provenance,
        };
        write(&result, &shown, &files)
    })
}

fn picture(command: &CompositeCommand) -> Result<Composite, Failure> {
    let depth_m = command.depth.as_ref().map(|path| {
        let depth_m = read_depth_map(path);
        depth_m.map_err(|error| Failure::bad_input(path, error))
    });
    let request = CompositeRequest {
        photo: &command.source.photo,
        depth_m: depth_m.transpose()?,
        plate_primaries: command.plate_primaries.map(RgbPrimaries::from),
        primaries: command.primaries.map(RgbPrimaries::from),
        exposure: command.exposure,
        scales_to_white: command.published,
    };
    let image = SpectralImage::read_picture(&command.image)
        .map_err(|error| Failure::bad_input(&command.image, error))?;
    request.with_bow(&image).map_err(|error| match error {
        // Of all sizes only that of the depth map is a file's of its own.
        Error::Photo(niji_photo::Error::Size {
            what: DEPTH_MAP, ..
        }) => Failure::bad_input(command.depth.as_ref().unwrap_or(&command.image), error),
        Error::Photo(_) | Error::PartOfFrame => Failure::bad_input(&command.image, error),
        error => error.into(),
    })
}

/// Where a composite goes.
struct Files<'a> {
    kind: Kind,
    main: &'a Path,
    /// The picture beside an EXR file.
    beside: &'a Path,
    provenance: &'a Provenance,
}

fn write(result: &Composite, shown: &LinearPicture, files: &Files) -> Result<(), Failure> {
    let Files {
        kind,
        main,
        beside,
        provenance,
    } = *files;
    match kind {
        Kind::Png => output::write_file(main, |to| write_png(shown, provenance, to)),
        Kind::Jpeg => output::write_file(main, |to| write_jpeg(shown, to)),
        Kind::Exr => {
            output::write_file(beside, |to| write_png(shown, provenance, to))?;
            let alpha = result.bow.added.transmittance.mapv(|t| 1.0 - t);
            let picture = PremultipliedPicture {
                light: &result.bow.added.light,
                alpha: Some(&alpha),
                frame: result.background.frame,
            };
            output::write_file(main, |to| picture.write_exr(provenance, to))
        }
    }
}

/// Writes the plate with the bow in it, with its alpha if it has one.
fn write_over(result: &Composite, to: &Path, provenance: &Provenance) -> Result<(), Failure> {
    let background = &result.background;
    let alpha = background
        .alpha
        .as_ref()
        .map(|plate| alpha_over(plate, &result.bow.added));
    let alpha = alpha
        .transpose()
        .map_err(|error| Failure::Failed(error.to_string()))?;
    let picture = PremultipliedPicture {
        light: &result.bow.picture,
        alpha: alpha.as_ref(),
        frame: background.frame,
    };
    output::write_file(to, |to| picture.write_exr(provenance, to))
}

fn settings(command: &CompositeCommand) -> String {
    let exposure = match command.exposure {
        CardExposure::Match => json!("match"),
        CardExposure::Camera => json!("camera"),
        CardExposure::Value(value) => json!(value),
    };
    let name = |primaries: PrimariesName| format!("{primaries:?}");
    json!({
        "exposure": exposure,
        "published": command.published,
        "show_ev": command.show_ev,
        "plate_primaries": command.plate_primaries.map(name),
        "primaries": command.primaries.map(name),
    })
    .to_string()
}

fn exposure(text: &str) -> Result<CardExposure, String> {
    match text {
        "match" => Ok(CardExposure::Match),
        "camera" => Ok(CardExposure::Camera),
        _ => match text.parse() {
            Ok(value) if value > 0.0 && f64::is_finite(value) => Ok(CardExposure::Value(value)),
            _ => Err(format!(
                "found {text:?}, expected match, camera or a number above 0"
            )),
        },
    }
}

fn kind(path: &Path) -> Result<Kind, Failure> {
    let extension = path.extension().and_then(|extension| extension.to_str());
    match extension.map(str::to_ascii_lowercase).as_deref() {
        Some("exr") => Ok(Kind::Exr),
        Some("png") => Ok(Kind::Png),
        Some("jpg" | "jpeg") => Ok(Kind::Jpeg),
        _ => Err(Failure::Usage(format!(
            "{}: expected a name that ends in .exr, .png or .jpg",
            path.display()
        ))),
    }
}
