//! A scene with what it calls for, and its parts made one by one.

use std::collections::BTreeMap;
use std::io;
use std::path::Path;
use std::path::PathBuf;

use ndarray::Array2;
use niji_airy::AiryTable;
use niji_dropfield::DropVolume;
use niji_exchange::AtmosphereTable;
use niji_exchange::FrameTime;
use niji_exchange::Provenance;
use niji_exchange::ScatteringTable;
use niji_exchange::SpectralImage;
use niji_exchange::content_hash;
use niji_photo::ClusterCount;
use niji_render::Surfaces;
use niji_scatter::airy_from_file;
use niji_scatter::airy_to_file;
use niji_scene::DropSpacing;
use niji_scene::DropSummary;
use niji_scene::Foretold;
use niji_scene::Picture;
use niji_scene::Plan;
use niji_scene::Scene;
use niji_scene::Stage;
use niji_scene::plan_looking;
use niji_scene::plan_of_switches;

use crate::air;
use crate::choice;
use crate::choice::Choice;
use crate::composite::Composite;
use crate::composite::CompositeRequest;
use crate::drop_volume::LaidOut;
use crate::drop_volume::VolumePart;
use crate::drop_volume::VolumeSource;
use crate::error::Error;
use crate::open_shutter::OpenShutter;
use crate::photo_depth::DepthMap;
use crate::photo_depth::Distances;
use crate::photo_depth::EYE_HEIGHT;
use crate::photo_depth::MapValues;
use crate::photo_depth::POSITION_WEIGHT;
use crate::photo_depth::PhotoDepthRequest;
use crate::photo_depth::photo_camera;
use crate::photo_depth::read_photo;
use crate::picture::PictureParts;
use crate::picture::PictureSettings;
use crate::picture::PictureWork;
use crate::pilot;
use crate::pilot::Seen;
use crate::pilot::SmallPicture;
use crate::scattering;
use crate::scene_checks::check_files;
use crate::sequence_choice::SequenceChoice;
use crate::sequence_choice::with_scales;
use crate::surfaces::SurfaceFiles;
use crate::watch::Watch;
use crate::watch::unwatched;

/// A scene and what it calls for.
#[derive(Clone, Debug)]
pub struct PlannedScene {
    /// Where the files lie that it names.
    pub folder: PathBuf,
    /// The scene.
    pub scene: Scene,
    /// What it calls for.
    pub plan: Plan,
    /// Its drop volume, where it names one.
    pub drop_file: Option<PathBuf>,
    /// What its drop volume is made from, where it names none.
    pub drop_source: Option<VolumeSource>,
    /// What was decided, and from what.
    pub choice: Choice,
    /// When it is shown, where it is a frame.
    pub time: Option<FrameTime>,
    /// How its picture is shown, where it was decided on for [`Scene::picture`].
    pub shown: Picture,
    /// It while its shutter is open, where that is followed.
    pub shutter: Option<OpenShutter>,
}

/// How a scene is planned.
#[derive(Clone, Copy)]
pub struct PlanRequest<'a> {
    /// Where the files lie that the scene names.
    pub folder: &'a Path,
    /// Whether it is a frame of a sequence that is decided on: sizes are rounded outward, so that other frames have the
    /// same.
    pub is_frame: bool,
    /// The program that asks, as far as it decides on results: what another one decided is not taken.
    pub version: &'a str,
    /// SHA-256 of a file's content, in hexadecimal, by whoever may know it already.
    pub hash_of: fn(&Path) -> io::Result<String>,
    /// What was decided before: taken where it is of this very request, so that nothing is measured.
    pub choice: Option<&'a Choice>,
    /// What was decided for a request of this hash, by whoever keeps that.
    pub kept: &'a dyn Fn(&str) -> Option<Choice>,
    /// What was decided for the same scene at another tolerance: what was measured for it is not measured again.
    pub measured: Option<&'a Choice>,
    /// Whether there is no time to measure anything: what was, bounds and estimates decide, and the error of the picture
    /// lacks what only small pictures tell.
    pub is_hasty: bool,
    /// Whoever waits for what is measured.
    pub watch: Watch<'a>,
}

impl Default for PlanRequest<'_> {
    /// A scene by itself, its files relative to where the program runs.
    fn default() -> Self {
        Self {
            folder: Path::new(""),
            is_frame: false,
            version: env!("CARGO_PKG_VERSION"),
            hash_of: content_hash,
            choice: None,
            kept: &|_| None,
            measured: None,
            is_hasty: false,
            watch: &unwatched,
        }
    }
}

/// What is measured for a plan.
enum Measured {
    /// For a choice of this request.
    Now(String),
    /// It was, and is kept with what was decided from it.
    Before(Box<Choice>),
}

/// What the drops of a scene whose files lie in `folder` come from.
fn source_of(scene: &Scene, folder: &Path) -> Option<VolumeSource> {
    let file = || scene.drops.file().map(|file| folder.join(file));
    VolumeSource::of(scene, folder)
        .or_else(|| Some(VolumeSource::only(VolumePart::Volume(file()?))))
}

/// Hashes of the files of its drops by role.
pub(crate) fn drop_hashes(
    scene: &Scene,
    request: PlanRequest,
) -> Result<BTreeMap<String, String>, Error> {
    let source = source_of(scene, request.folder);
    let files = source.iter().flat_map(VolumeSource::inputs);
    let hashes = files.map(|(role, path)| {
        let hash = (request.hash_of)(path).map_err(|error| Error::file(path, error))?;
        Ok((role, hash))
    });
    hashes.collect()
}

/// What a plan knows of the drops of a scene; files are read.
pub(crate) fn drops_of(scene: &Scene, request: PlanRequest) -> Result<Option<LaidOut>, Error> {
    let of_file = |drops: DropSummary| {
        if request.is_frame {
            drops.with_rounded_sizes()
        } else {
            drops
        }
    };
    let source = source_of(scene, request.folder);
    source.map_or(Ok(None), |source| source.laid_out(of_file))
}

/// A scene with the nodes of its drops so close, but where it names how close they are.
fn with_spacing(mut scene: Scene, spacing: DropSpacing) -> Scene {
    if spacing != DropSpacing::AsGiven {
        scene.accuracy.drop_spacing.get_or_insert(spacing);
    }
    scene
}

impl PlannedScene {
    /// Plans a scene; files of drops are read, and what no bound settles is measured in small pictures: what light
    /// that drops scatter more than once adds, how finely that of the air has to be solved, what the spacing of the
    /// drops' nodes changes. What was chosen before for the same scene, however shown, is taken as it is.
    ///
    /// # Errors
    /// A scene that was changed in code to one that is none ([`Scene::check`]), a file that is missing, a drop volume that
    /// is wrong, or a scene that cannot be planned; [`Error::Stopped`].
    pub fn new(scene: Scene, request: PlanRequest) -> Result<Self, Error> {
        scene.check()?;
        Self::of_checked(scene, request)
    }

    /// The same of a scene whose switches need not go together.
    pub(crate) fn of_checked(scene: Scene, request: PlanRequest) -> Result<Self, Error> {
        check_files(&scene, request.folder)?;
        let files = drop_hashes(&scene, request)?;
        let key = |scene: &Scene| choice::request((request.version, &files), scene);
        if let Some(before) = request.choice {
            let shown = scene.picture;
            let scene = Scene {
                picture: before.picture,
                ..scene.clone()
            };
            if before.request == key(&scene) {
                let decided = Self::decided(scene, request.folder, before.clone());
                return Ok(Self { shown, ..decided });
            }
        }
        let key = key(&scene);
        if let Some(kept) = (request.kept)(&key).filter(|it| it.request == key) {
            return Ok(Self::decided(scene, request.folder, kept));
        }
        let drops = drops_of(&scene, request)?;
        let planned = Self::with_drops(scene, request, (drops, Measured::Now(key)))?;
        let spacing = planned.choice.seen.spacing();
        planned.at_spacing(spacing, request)
    }

    /// A scene as it was decided: nothing is measured, and no file of drops read.
    fn decided(scene: Scene, folder: &Path, choice: Choice) -> Self {
        let scene = with_spacing(scene, choice.seen.spacing());
        Self {
            folder: folder.to_owned(),
            drop_file: scene.drops.file().map(|file| folder.join(file)),
            drop_source: VolumeSource::of(&scene, folder),
            plan: choice.plan.clone(),
            choice,
            time: None,
            shown: scene.picture,
            shutter: None,
            scene,
        }
    }

    /// The same with the nodes of its drops as close as they were seen to be needed.
    pub(crate) fn at_spacing(
        self,
        spacing: DropSpacing,
        request: PlanRequest,
    ) -> Result<Self, Error> {
        if spacing == DropSpacing::AsGiven || self.plan.levels.drop_spacing == spacing {
            return Ok(self);
        }
        let scene = with_spacing(self.scene, spacing);
        let drops = drops_of(&scene, request)?;
        let before = Measured::Before(Box::new(self.choice));
        Self::with_drops(scene, request, (drops, before))
    }

    /// The same of a scene whose drops were summed up.
    ///
    /// # Errors
    /// A scene that cannot be planned.
    pub(crate) fn of_drops(
        scene: Scene,
        request: PlanRequest,
        drops: LaidOut,
    ) -> Result<Self, Error> {
        let key = String::new();
        Self::with_drops(scene, request, (Some(drops), Measured::Now(key)))
    }

    /// A frame of a sequence as it was decided for all of them, at the scenes of its instants
    /// ([`SequenceChoice::instants`]): nothing is measured, and no file of drops read.
    #[must_use]
    pub fn of_frame(
        (scene, time, instants): (Scene, FrameTime, Vec<Scene>),
        folder: &Path,
        choice: &SequenceChoice,
    ) -> Self {
        let scaled = |scene: Scene| with_scales(scene, &choice.densest_lines_m);
        let scene = scaled(scene);
        let of_frame = Choice {
            version: choice.version.clone(),
            request: choice.request.clone(),
            picture: scene.picture,
            afforded: None,
            plan: choice.plan.of_frame(&scene),
            seen: choice.seen.clone(),
        };
        let decided = Self::decided(scene, folder, of_frame);
        let frame = Self {
            time: Some(time),
            ..decided
        };
        let instants = instants.into_iter();
        let instants: Vec<Scene> = instants
            .map(|it| with_spacing(scaled(it), choice.seen.spacing()))
            .collect();
        let shutter = (!instants.is_empty()).then(|| OpenShutter::new(&frame, instants));
        Self { shutter, ..frame }
    }

    /// The same for a scene that needs no other tables, levels and effects, as it was decided.
    pub(crate) fn moved_to(&self, scene: Scene) -> Self {
        let plan = self.plan.of_frame(&scene);
        let choice = Choice {
            plan,
            ..self.choice.clone()
        };
        Self {
            time: self.time,
            ..Self::decided(scene, &self.folder, choice)
        }
    }

    /// A scene every effect of which is switched on or off, for its own drops and where `others` are and how large.
    pub(crate) fn of_switches<'a>(
        scene: Scene,
        folder: &Path,
        (own, others): (
            Option<&'a DropSummary>,
            impl Iterator<Item = &'a DropSummary>,
        ),
    ) -> Result<Self, Error> {
        let drops = DropSummary::joined(own.into_iter().chain(others).cloned());
        let summary = drops.map(|drops| DropSummary {
            voxel_m: own.map_or(drops.voxel_m, |own| own.voxel_m),
            ..drops
        });
        let choice = Choice {
            version: String::new(),
            request: String::new(),
            picture: scene.picture,
            afforded: None,
            plan: plan_of_switches(&scene, summary)?,
            seen: Seen::default(),
        };
        Ok(Self::decided(scene, folder, choice))
    }

    fn with_drops(
        scene: Scene,
        request: PlanRequest,
        (drops, measured): (Option<LaidOut>, Measured),
    ) -> Result<Self, Error> {
        let (mut seen, key, afforded, measures) = match measured {
            Measured::Before(choice) => (choice.seen, choice.request, choice.afforded, false),
            Measured::Now(key) => (Seen::default(), key, None, true),
        };
        let summary = drops.as_ref().map(|drops| drops.summary.clone());
        let before = request.measured.map(|it| it.seen.clone());
        let before = before.unwrap_or_default();
        let sky_before = before.sky.clone();
        let look = |foretold: &Foretold| {
            if let Some(drops) = drops.as_ref().filter(|_| measures) {
                seen = pilot::seen_of_drops(&scene, (foretold, request), (drops, before))?;
            }
            Ok::<_, Error>(seen.of_drops())
        };
        let mut plan = plan_looking(&scene, summary, look)?;
        if measures {
            seen.sky = pilot::sky(&scene, &plan, (request, sky_before))?;
        }
        if let Some(sky) = &seen.sky {
            plan.sky_level = Some(sky.level);
        }
        let by_place = std::mem::take(&mut plan.left_out_by_place);
        seen.left_out = SmallPicture::of_parts(&scene.camera, by_place);
        let choice = Choice {
            version: request.version.to_owned(),
            request: key,
            picture: scene.picture,
            afforded,
            plan,
            seen,
        };
        Ok(Self::decided(scene, request.folder, choice))
    }

    /// The same scene with other switches or levels, planned anew; switches need not go together, as
    /// [`Plan::switched`] has them.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn replanned(&self, scene: Scene) -> Result<Self, Error> {
        let request = PlanRequest {
            folder: &self.folder,
            ..PlanRequest::default()
        };
        Self::of_checked(scene, request)
    }

    /// Its plan with all that is told over display white as the picture is shown.
    pub fn plan_as_shown(&self) -> Plan {
        let brighter = (self.shown.exposure_ev - self.scene.picture.exposure_ev).exp2();
        self.plan.clone().brighter(brighter)
    }

    /// Its drops.
    ///
    /// # Errors
    /// A shape that cannot be; a file that is missing, damaged or has no such grid.
    pub fn drops(&self) -> Result<DropVolume, Error> {
        match (&self.drop_source, &self.drop_file) {
            (Some(source), _) => source.volume(),
            (None, Some(file)) => VolumePart::Volume(file.clone()).volume(),
            (None, None) => Ok(DropVolume { modes: Vec::new() }),
        }
    }

    /// Airy's integral, where the theory of its scattering table uses it: in f32, as its file has it, so that
    /// the scattering table is the same from both.
    ///
    /// # Errors
    /// Never.
    pub fn airy(&self) -> Result<Option<AiryTable>, Error> {
        if !self.plan.runs(Stage::Airy) {
            return Ok(None);
        }
        let file = airy_to_file(&AiryTable::compute(), Provenance::default());
        Ok(Some(airy_from_file(&file)?))
    }

    /// Its scattering table, where it needs one; `airy` is Airy's integral in advance, without which every
    /// value is computed.
    ///
    /// # Errors
    /// A need that cannot be met; [`Error::Stopped`].
    pub fn scattering(
        &self,
        airy: Option<&AiryTable>,
        watch: Watch,
    ) -> Result<Option<ScatteringTable>, Error> {
        let Some(need) = &self.plan.scattering else {
            return Ok(None);
        };
        scattering::table(need, self.scene.spectrum, airy, watch).map(Some)
    }

    /// Its air, where an effect needs it.
    ///
    /// # Errors
    /// Parameters out of their range, of a scene that was built in code; [`Error::Stopped`].
    pub fn air(&self, watch: Watch) -> Result<Option<AtmosphereTable>, Error> {
        if !self.plan.runs(Stage::Atmosphere) {
            return Ok(None);
        }
        let orders = self.plan.scattering_orders();
        let table = air::table(&self.scene, orders, watch)?;
        // In f32, as its file has it: the picture is the same from both.
        let as_filed = |table: AtmosphereTable| {
            let file = table.to_file(Provenance::default());
            AtmosphereTable::from_file(&file).map_err(Error::scene)
        };
        table.map(as_filed).transpose()
    }

    /// Where the distances of the surfaces of its photograph come from, where it has one.
    pub fn photo_distances(&self) -> Option<Distances> {
        let section = self.scene.photo.as_ref()?;
        let beside = |file: &String| self.folder.join(file);
        if let (Some(layers), Some(labels)) = (&section.layers, &section.labels) {
            return Some(Distances::Layers {
                distances: beside(layers),
                labels: beside(labels),
            });
        }
        let occluders = self.scene.occluders.as_ref();
        let map = occluders.and_then(|it| Some((it.depth.as_ref()?, it.along)));
        Some(match map {
            Some((file, along)) => Distances::Map(DepthMap {
                path: beside(file),
                values: MapValues::Metres(1.0),
                along,
            }),
            None => Distances::Proposed {
                count: ClusterCount::Criterion,
                position_weight: POSITION_WEIGHT,
                eye_height: EYE_HEIGHT,
            },
        })
    }

    /// Distances of the surfaces of its photograph by row and column (m), where it has one.
    ///
    /// # Errors
    /// A file that is missing or damaged.
    pub fn photo_depth_m(&self) -> Result<Option<Array2<f32>>, Error> {
        let (Some(section), Some(distances)) = (&self.scene.photo, self.photo_distances()) else {
            return Ok(None);
        };
        let photo = read_photo(&self.folder.join(&section.picture))?;
        let request = PhotoDepthRequest {
            photo: &photo,
            camera: photo_camera(&self.scene.camera, [photo.width(), photo.height()]),
            distances,
        };
        Ok(Some(request.depth()?.depth_m))
    }

    /// The surfaces that hide what is behind them: those that it names, and those of its photograph, whose
    /// distances (m) are `photo_depth_m`.
    ///
    /// # Errors
    /// A file that is missing or damaged; distances that are none.
    pub fn surfaces(&self, photo_depth_m: Option<Array2<f32>>) -> Result<Option<Surfaces>, Error> {
        let files = SurfaceFiles::of_scene(&self.scene, &self.folder);
        let camera = self.scene.camera;
        match photo_depth_m {
            // A map of the scene has become distances of its photograph.
            Some(depth_m) => files.beside(Some(Surfaces::new(depth_m)?), camera),
            None => files.read(camera),
        }
    }

    /// Its photograph with the bow of an image of it, where it has one.
    ///
    /// # Errors
    /// A photograph that is missing or damaged, or an exposure that cannot be told.
    pub fn composite(
        &self,
        image: &SpectralImage,
        photo_depth_m: Option<Array2<f32>>,
    ) -> Result<Option<Composite>, Error> {
        let Some(section) = &self.scene.photo else {
            return Ok(None);
        };
        let request = CompositeRequest {
            photo: &self.folder.join(&section.picture),
            depth_m: photo_depth_m,
            plate_primaries: None,
            primaries: None,
            exposure: section.into(),
            scales_to_white: false,
        };
        request.with_bow(image).map(Some)
    }

    /// Its picture, of all pixels, with as much of its spectra as it keeps.
    ///
    /// # Errors
    /// As [`Self::check`] and as its parts: a scene that sends no light is refused; [`Error::Stopped`].
    pub fn picture(&self, watch: Watch) -> Result<SpectralImage, Error> {
        self.check()?;
        self.unchecked_picture(watch)
    }

    /// As [`Self::picture`] without [`Self::check`]: of a scene that sends no light a black one.
    ///
    /// # Errors
    /// As its parts; [`Error::Stopped`].
    pub fn unchecked_picture(&self, watch: Watch) -> Result<SpectralImage, Error> {
        let parts = PictureParts {
            drops: self.drops()?,
            table: self.scattering(self.airy()?.as_ref(), watch)?,
            air: self.air(watch)?,
            surfaces: self.surfaces(self.photo_depth_m()?)?,
        };
        let settings = PictureSettings::of(self);
        let whole = settings.whole()?;
        PictureWork::new(settings, parts, watch)?.render(whole, watch)
    }
}
