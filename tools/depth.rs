//! `niji depth`: how far away the surfaces of a photograph are.

use std::io::Write;
use std::path::Path;
use std::path::PathBuf;

use clap::Args;
use clap::ValueEnum;
use ndarray::Array2;
use niji_exchange::Provenance;
use niji_photo::ClusterCount;
use niji_photo::Layers;
use niji_photo::LinearPicture;
use niji_photo::Photograph;
use niji_photo::layers_to_toml;
use niji_photo::write_depth_map;
use niji_photo::write_labels;
use niji_photo::write_png;
use niji_picture::DepthMap;
use niji_picture::Distances;
use niji_picture::EYE_HEIGHT;
use niji_picture::MapValues;
use niji_picture::POSITION_WEIGHT;
use niji_picture::PhotoDepthRequest;
use niji_picture::PlannedScene;
use niji_radiometry::Meters;
use niji_scene::Along;
use serde_json::json;

use crate::failure::Failure;
use crate::flags;
use crate::flags::Common;
use crate::output;
use crate::photo_source::PhotoSource;
use crate::schema_flags::names;
use crate::stages::Done;
use crate::stages::Request;
use crate::stages::StageOptions;
use crate::stages::perform;
use crate::sun::camera_flags::Camera;
use crate::sun::camera_flags::CameraFlags;

/// Distance that is half bright in the preview, m.
const PREVIEW_HALF_M: f32 = 30.0;

/// Give the surfaces of a photograph their distances (EXR, metres along the view ray).
///
/// Layers of similar color with proposed distances, written as *.layers.toml and *.labels.png to
/// be corrected and given back with --layers and --labels; or a depth map from elsewhere, whose kind
/// must be stated.
#[derive(Debug, Args)]
#[command(
    mut_arg("scene", |scene| scene.conflicts_with_all([
        "clusters", "position_weight", "eye_height_m", "layers", "labels", "map", "kind", "along",
        "unit_m", "anchors", "CameraFlags"
    ])),
    after_help = "Examples:
  niji depth data/photos/pavilion.jpg --fov-deg 60 --clusters 6 -o depth.exr
  niji depth data/photos/pavilion.jpg --fov-deg 60 --layers depth.layers.toml \\
      --labels depth.labels.png -o corrected.exr
  niji depth --scene data/scenes/photo-pavilion-rain.toml -o depth.exr
  niji depth photo.jpg --map disparity.png --kind inverse --anchor 320,400,5 \\
      --anchor 60,200,80 -o depth.exr"
)]
pub(crate) struct DepthCommand {
    /// The photograph.
    #[command(flatten)]
    source: PhotoSource,
    /// Number of layers [default: the one with the largest index of Calinski and Harabasz].
    #[arg(long, value_name = "N")]
    clusters: Option<usize>,
    /// Weight of position beside color: 0 for color alone, as published.
    #[arg(long, value_name = "W", default_value_t = POSITION_WEIGHT)]
    position_weight: f64,
    /// Height of the eye above level ground in metres, for proposed distances.
    #[arg(long, value_name = "M", default_value_t = EYE_HEIGHT.0)]
    eye_height_m: f64,
    /// Corrected distances of layers.
    #[arg(
        long,
        value_name = "TOML",
        requires = "labels",
        conflicts_with = "clusters"
    )]
    layers: Option<PathBuf>,
    /// Corrected labels of layers, of the size of the photograph or smaller.
    #[arg(long, value_name = "PNG", requires = "layers")]
    labels: Option<PathBuf>,
    /// A depth map from elsewhere: EXR with a channel Z, or a grey PNG, whose white is 1.
    #[arg(long, value_name = "FILE", requires = "kind", conflicts_with_all = ["layers", "clusters"])]
    map: Option<PathBuf>,
    /// What the values of the map are.
    #[arg(long, value_enum, requires = "map")]
    kind: Option<Kind>,
    /// Along what the map measures.
    #[arg(long, value_name = "ALONG", value_parser = names::<Along>(), default_value = "ray")]
    along: Along,
    /// What the value 1 of a map in metres is, in metres.
    #[arg(long, value_name = "M", default_value_t = 1.0)]
    unit_m: f64,
    /// A pixel of the photograph whose distance is known; two or more for inverse and relative maps.
    #[arg(long = "anchor", value_name = "X,Y,METRES", value_parser = anchor)]
    anchors: Vec<[f64; 3]>,
    /// The depth map to write.
    #[arg(short, long, value_name = "EXR")]
    output: PathBuf,
    /// The camera.
    #[command(flatten)]
    camera: CameraFlags,
}

/// Kinds of depth maps by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Kind {
    /// Metres; 0 and infinity are the sky.
    Metres,
    /// Inverse depth of unknown scale and shift, near = large (MiDaS, Depth Anything, stereo).
    Inverse,
    /// Depth of unknown scale and shift, near = small.
    Relative,
}

impl DepthCommand {
    /// What a scene says of its photograph.
    ///
    /// # Errors
    /// A scene without one.
    pub(crate) fn of_scene(planned: &PlannedScene, output: PathBuf) -> Result<Self, Failure> {
        let (layers, labels, map) = match planned.photo_distances() {
            Some(Distances::Layers { distances, labels }) => (Some(distances), Some(labels), None),
            Some(Distances::Map(map)) => (None, None, Some(map)),
            Some(Distances::Proposed { .. }) | None => (None, None, None),
        };
        Ok(Self {
            source: PhotoSource::of_scene(planned)?,
            clusters: None,
            position_weight: POSITION_WEIGHT,
            eye_height_m: EYE_HEIGHT.0,
            layers,
            labels,
            kind: map.as_ref().map(|_| Kind::Metres),
            along: map.as_ref().map_or(Along::Ray, |map| map.along),
            unit_m: 1.0,
            map: map.map(|map| map.path),
            anchors: Vec::new(),
            output,
            camera: CameraFlags::of_scene(&planned.scene.camera),
        })
    }
}

/// Makes the depth map.
///
/// # Errors
/// As [`make`]; a scene that is missing or wrong.
pub(crate) fn execute(command: &DepthCommand, common: &Common) -> Result<(), Failure> {
    let of_scene = command.source.command(common, |planned| {
        DepthCommand::of_scene(planned, command.output.clone())
    })?;
    make(of_scene.as_ref().unwrap_or(command), common.options()).map(|_| ())
}

/// Makes the depth map, or keeps one that fits.
///
/// # Errors
/// Inputs that are missing, damaged or contradict each other, or outputs that exist.
pub(crate) fn make(command: &DepthCommand, options: StageOptions) -> Result<Done, Failure> {
    let [toml, labels, preview] =
        ["layers.toml", "labels.png", "png"].map(|end| command.output.with_extension(end));
    let proposes = command.map.is_none() && command.layers.is_none();
    let mut outputs = vec![command.output.as_path(), &preview];
    if proposes {
        outputs.extend([toml.as_path(), &labels]);
    }
    let mut inputs = vec![("photo", command.source.photo.as_path())];
    for (role, path) in [
        ("layers", &command.layers),
        ("labels", &command.labels),
        ("map", &command.map),
    ] {
        inputs.extend(path.iter().map(|path| (role, path.as_path())));
    }
    let photo = Photograph::read(&command.source.photo)
        .map_err(|error| Failure::bad_input(&command.source.photo, error))?;
    let camera = command.camera.camera(&photo)?;
    let job = Request {
        stage: "depth",
        settings: settings(command, &camera),
        inputs,
        outputs,
    };
    perform(&job, options, |provenance| {
        let request = PhotoDepthRequest {
            photo: &photo,
            camera: camera.request(),
            distances: distances(command)?,
        };
        let found = request.depth()?;
        if let Some(layers) = &found.layers {
            write_layers(layers, (&toml, &labels), &provenance)?;
        }
        write(&found.depth_m, (&command.output, &preview), &provenance)
    })
}

/// Where the distances come from.
fn distances(command: &DepthCommand) -> Result<Distances, Failure> {
    if let Some(path) = &command.map {
        let values = match command.kind {
            Some(Kind::Inverse) => MapValues::Inverse(command.anchors.clone()),
            Some(Kind::Relative) => MapValues::Relative(command.anchors.clone()),
            Some(Kind::Metres) | None => MapValues::Metres(command.unit_m),
        };
        return Ok(Distances::Map(DepthMap {
            path: path.clone(),
            values,
            along: command.along,
        }));
    }
    match (command.layers.clone(), command.labels.clone()) {
        (Some(distances), Some(labels)) => Ok(Distances::Layers { distances, labels }),
        (None, None) => Ok(Distances::Proposed {
            count: command
                .clusters
                .map_or(ClusterCount::Criterion, ClusterCount::Given),
            position_weight: command.position_weight,
            eye_height: Meters(command.eye_height_m),
        }),
        _ => Err(Failure::Usage(
            "expected --layers and --labels together".to_owned(),
        )),
    }
}

fn write_layers(
    layers: &Layers,
    (toml, labels): (&Path, &Path),
    made_for: &Provenance,
) -> Result<(), Failure> {
    let text = layers_to_toml(&layers.layers);
    output::write_file_for(toml, made_for, |to| to.write_all(text.as_bytes()))?;
    let n_layers = layers.layers.len();
    output::write_file_for(labels, made_for, |to| {
        write_labels(&layers.labels, n_layers, to)
    })
}

fn write(
    depth_m: &Array2<f32>,
    (main, preview): (&Path, &Path),
    provenance: &Provenance,
) -> Result<(), Failure> {
    // Near is white, 30 m half bright, the sky black.
    let shown: LinearPicture = depth_m.mapv(|depth| {
        let grey = 1.0 / (1.0 + depth / PREVIEW_HALF_M);
        [grey * grey; 3]
    });
    output::write_file(preview, |to| write_png(&shown, provenance, to))?;
    output::write_file(main, |to| write_depth_map(depth_m, provenance, to))
}

fn settings(command: &DepthCommand, camera: &Camera) -> String {
    json!({
        "camera": camera,
        "clusters": command.clusters,
        "position_weight": command.position_weight,
        "eye_height_m": command.eye_height_m,
        "kind": command.kind.map(|kind| format!("{kind:?}")),
        "along": format!("{:?}", command.along),
        "unit_m": command.unit_m,
        "anchors": command.anchors,
    })
    .to_string()
}

/// `320,41,12.5`.
fn anchor(text: &str) -> Result<[f64; 3], String> {
    let values = flags::numbers(text)?;
    <[f64; 3]>::try_from(values.as_slice())
        .map_err(|_| format!("found {text:?}, expected X,Y,METRES, say 320,41,12.5"))
}
