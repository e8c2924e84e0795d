//! The picture of a scene from its parts.

use niji_dropfield::Bricks;
use niji_dropfield::DropVolume;
use niji_exchange::AtmosphereTable;
use niji_exchange::FrameTime;
use niji_exchange::Provenance;
use niji_exchange::ScatteringTable;
use niji_exchange::SpectralImage;
use niji_geometry::PixelRegion;
use niji_radiometry::WavelengthGrid;
use niji_render::Afforded;
use niji_render::Deadline;
use niji_render::DropOrders;
use niji_render::LitDrops;
use niji_render::MirroredLight;
use niji_render::PictureLayer;
use niji_render::Progress;
use niji_render::RenderEffects;
use niji_render::RenderRequest;
use niji_render::Rendered;
use niji_render::SunPath;
use niji_render::Surfaces;
use niji_render::Toggle;
use niji_render::render_in_steps;
use niji_scene::BRIGHT_DROPS;
use niji_scene::Camera;
use niji_scene::Effect;
use niji_scene::Levels;
use niji_scene::Picture;
use niji_scene::ScatteringNeed;
use niji_scene::Stage;
use niji_scene::Sun;
use niji_scene::WaterSurface;
use niji_scene::most_error_of_orders;
use niji_scene::most_error_of_rays;
use niji_scene::tolerance_for_rays;
use serde::Serialize;

use crate::air;
use crate::error::Error;
use crate::foreseen_errors::ForeseenErrors;
use crate::foreseen_errors::Place;
use crate::image;
use crate::open_shutter::OpenShutter;
use crate::planned_scene::PlannedScene;
use crate::sun_volume;
use crate::sun_volume::Allowed;
use crate::sun_volume::Sunlight;
use crate::watch::Watch;
use crate::watch::Watched;

/// Rows or pixels, fifty tiles, of a step for each thread, whichever are fewer: so a thread that is done
/// first waits for 2 % of a step.
const ROWS_PER_THREAD: u32 = 25;
const PIXELS_PER_THREAD: u32 = 12_800;

/// What a picture depends on besides its parts; as JSON, the settings of its file.
#[derive(Clone, Debug, Serialize)]
pub struct PictureSettings {
    /// The eye.
    pub camera: Camera,
    /// The light.
    pub sun: Sun,
    /// The wavelengths.
    pub spectrum: WavelengthGrid,
    /// What is simulated, by name.
    pub effects: Vec<&'static str>,
    /// How accurately.
    pub levels: Levels,
    /// Largest error of a pixel before it gets more rays, over display white; none where the scene names how
    /// much of a pixel is seen, or has a photograph.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tolerance: Option<f64>,
    /// Largest relative error of the light of drops by what shades them; none where the scene names how the sun's
    /// way is followed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shadow_relative_error: Option<f64>,
    /// RMS that the light of further orders may err by, over display white; none where it is off, the scene names its
    /// level, or a budget left so many paths.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub orders_error: Option<f64>,
    /// How many times larger the error of a pixel may be before it gets more rays, where a budget left that.
    #[serde(skip_serializing_if = "is_one")]
    pub coarser_rays: f64,
    /// How the preview is shown; where it was decided on for something else, for which.
    pub picture: Picture,
    /// How the preview is shown.
    #[serde(skip)]
    pub shown: Picture,
    /// Number of a frame, and how many are shown in a second.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub frame: Option<(u32, f64)>,
    /// Water that lights the drops too or is seen, where it does or is.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub water_surface: Option<WaterSurface>,
    /// Water that is seen.
    #[serde(skip)]
    pub seen_water: Option<WaterSurface>,
    /// The same, and what of its light is followed.
    #[serde(skip)]
    pub mirrored_water: Option<(WaterSurface, MirroredLight)>,
    /// The frame while its shutter is open, where that is followed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shutter: Option<OpenShutter>,
    /// What it errs by beside what is estimated with it; last in the file, so that of two pictures what a person
    /// wrote is told first.
    #[serde(rename = "unseen")]
    pub foreseen_errors: ForeseenErrors,
    /// What is simulated, as the renderer takes it.
    #[serde(skip)]
    pub render_effects: RenderEffects,
    /// Whether its surfaces are those of a photograph, whose distances are those of whole pixels.
    #[serde(skip)]
    pub is_of_photo: bool,
    /// What a tolerance is relative to [cd/m²].
    #[serde(skip)]
    pub display_white_cd_m2: f64,
    /// What the scattering table has to hold, where there is one.
    #[serde(skip)]
    pub scattering: Option<ScatteringNeed>,
}

impl PictureSettings {
    /// What the plan of a scene says.
    #[must_use]
    pub fn of(planned: &PlannedScene) -> Self {
        let (scene, plan) = (&planned.scene, &planned.plan);
        let accuracy = &scene.accuracy;
        let is_of_photo = scene.photo.is_some();
        let adds_rays = accuracy.pixel_footprint.is_none() && !is_of_photo;
        let mut render_effects = plan.render_effects();
        // The level that ignores the sun's path is the shadow left out.
        if plan.sun_path() == SunPath::Ignore {
            render_effects.drop_shadow = Toggle::Off;
        }
        let mirrored_water = scene.water_surface.zip(plan.mirrored_light());
        let seen_water = (scene.water_surface).filter(|_| plan.is_on(Effect::SeenWater));
        let follows_rounds =
            accuracy.drop_orders.is_none() && plan.is_on(Effect::MultipleScattering);
        let sky = planned.choice.seen.sky.as_ref();
        let error_of_sky = sky.map_or(0.0, |it| it.error.bound().rms);
        let shared = |most_error: fn(f64, f64, f64) -> f64| {
            most_error(plan.tolerance, plan.left_out, error_of_sky)
        };
        let of_rays = tolerance_for_rays(plan.tolerance);
        let settings = Self {
            coarser_rays: 1.0,
            camera: scene.camera,
            sun: scene.sun,
            spectrum: scene.spectrum,
            effects: plan.effects_on().map(Effect::name).collect(),
            levels: plan.levels,
            tolerance: adds_rays.then(|| {
                if follows_rounds {
                    of_rays
                } else {
                    shared(most_error_of_rays)
                }
            }),
            is_of_photo,
            shadow_relative_error: (accuracy.sun_path.is_none()).then_some(of_rays / BRIGHT_DROPS),
            orders_error: follows_rounds.then(|| shared(most_error_of_orders)),
            picture: Picture {
                // Whatever it was decided on with.
                spectral: planned.shown.spectral,
                ..scene.picture
            },
            shown: planned.shown,
            frame: (planned.time).map(|time| (time.frame, time.frames_per_second)),
            shutter: planned.shutter.clone(),
            water_surface: seen_water.or(mirrored_water.map(|(surface, _)| surface)),
            seen_water,
            mirrored_water,
            foreseen_errors: ForeseenErrors::of(plan, &planned.choice.seen),
            render_effects,
            display_white_cd_m2: plan.display_white_cd_m2,
            scattering: plan.scattering.clone(),
        };
        match planned.choice.afforded {
            Some(afforded) => settings.with(afforded.into()),
            None => settings,
        }
    }

    /// With no more than there was time for.
    #[must_use]
    pub fn with(mut self, afforded: Afforded) -> Self {
        self.coarser_rays = afforded.coarser_rays;
        if let (Some(n_paths), DropOrders::MultipleScattering { paths_per_node, .. }) =
            (afforded.paths_per_node, &mut self.levels.drop_orders)
        {
            *paths_per_node = n_paths;
            self.orders_error = None;
        }
        self
    }

    /// All pixels of the picture, overscan included.
    ///
    /// # Errors
    /// A camera that cannot be, of a scene that was built in code.
    pub fn whole(&self) -> Result<PixelRegion, Error> {
        self.camera.region().map_err(Error::scene)
    }
}

/// What a picture is made from.
#[derive(Clone, Debug)]
pub struct PictureParts {
    /// Where drops are.
    pub drops: DropVolume,
    /// How they scatter, where a bow is on.
    pub table: Option<ScatteringTable>,
    /// The air, where an effect of the air is on.
    pub air: Option<AtmosphereTable>,
    /// Surfaces that hide what is behind them.
    pub surfaces: Option<Surfaces>,
}

/// A picture with all that its rays need, its drops lit by the sun.
pub struct PictureWork {
    settings: PictureSettings,
    camera: niji_geometry::Camera,
    wavelengths: WavelengthGrid,
    sun_irradiance: Vec<f64>,
    drops: LitDrops,
    table: Option<ScatteringTable>,
    air: Option<AtmosphereTable>,
    surfaces: Option<Surfaces>,
}

impl PictureWork {
    /// Lights the drops.
    ///
    /// # Errors
    /// Drops without room for them or their shadow; a camera or a spectrum that cannot be;
    /// [`Error::Stopped`].
    pub fn new(
        settings: PictureSettings,
        parts: PictureParts,
        watch: Watch,
    ) -> Result<Self, Error> {
        let drops = bricks(&settings, parts.drops)?;
        let others = (parts.table, parts.air, parts.surfaces);
        Self::of_bricks(settings, (drops, others), watch)
    }

    fn of_bricks(
        settings: PictureSettings,
        (drops, (table, air, surfaces)): (Vec<Bricks>, OtherParts),
        watch: Watch,
    ) -> Result<Self, Error> {
        let wavelengths = settings.spectrum;
        Ok(Self {
            camera: settings.camera.camera().map_err(Error::scene)?,
            wavelengths,
            sun_irradiance: settings.sun.irradiance(&wavelengths),
            drops: lit(&settings, drops, watch)?,
            table,
            air,
            surfaces: if settings.is_of_photo {
                surfaces.map(Surfaces::of_whole_pixels)
            } else {
                surfaces
            },
            settings,
        })
    }

    /// The same scene at another instant: of its parts those that differ there are made anew.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub(crate) fn moved(
        self,
        (from, to): (&PlannedScene, &PlannedScene),
        watch: Watch,
    ) -> Result<Self, Error> {
        let settings = PictureSettings::of(to);
        let air_of = |it: &PlannedScene| air::settings(&it.scene, it.plan.scattering_orders());
        let air = if air_of(from) == air_of(to) {
            self.air
        } else {
            to.air(watch)?
        };
        let surfaces_of =
            |it: &PlannedScene| (it.scene.occluders.clone(), it.scene.terrain.clone());
        let surfaces = if surfaces_of(from) == surfaces_of(to) {
            self.surfaces
        } else {
            to.surfaces(None)?
        };
        let has_same_drops = from.scene.drops == to.scene.drops
            && reaches_ground(&self.settings) == reaches_ground(&settings);
        let has_same_light = from.scene.sun.direction() == to.scene.sun.direction()
            && from.scene.water_surface == to.scene.water_surface;
        if has_same_drops && has_same_light {
            return Ok(Self {
                camera: settings.camera.camera().map_err(Error::scene)?,
                sun_irradiance: settings.sun.irradiance(&self.wavelengths),
                air,
                surfaces,
                settings,
                ..self
            });
        }
        let drops = if has_same_drops {
            self.drops.into_bricks()
        } else {
            drop(self.drops);
            bricks(&settings, to.drops()?)?
        };
        Self::of_bricks(settings, (drops, (self.table, air, surfaces)), watch)
    }

    /// Its drops, without the light of the sun.
    pub(crate) fn into_bricks(self) -> Vec<Bricks> {
        self.drops.into_bricks()
    }

    /// What it depends on besides its parts.
    pub(crate) fn settings(&self) -> &PictureSettings {
        &self.settings
    }

    /// What the renderer is asked for.
    pub fn request(&self, region: PixelRegion) -> RenderRequest<'_> {
        let settings = &self.settings;
        RenderRequest {
            camera: &self.camera,
            region,
            sun_direction: settings.sun.direction(),
            wavelengths: self.wavelengths,
            sun_irradiance: &self.sun_irradiance,
            drops: &self.drops,
            table: self.table.as_ref(),
            air: self.air.as_ref(),
            surfaces: self.surfaces.as_ref(),
            water: settings.seen_water.map(|water| water.surface()),
            effects: settings.render_effects,
            levels: settings.levels.render_levels(),
            tolerance_cd_m2: settings
                .tolerance
                .map(|tolerance| tolerance * settings.display_white_cd_m2),
            orders_error_cd_m2: settings
                .orders_error
                .map(|error| error * settings.display_white_cd_m2),
            coarser_rays: settings.coarser_rays,
        }
    }

    /// What was rendered of a region, as an image.
    pub fn image(
        &self,
        rendered: Rendered,
        region: PixelRegion,
        provenance: Provenance,
    ) -> SpectralImage {
        let mut image = image::of_rendered(rendered, &self.camera, self.wavelengths);
        let settings = &self.settings;
        let error = PictureLayer::Error.name();
        if let Some(error) = image.aovs.iter_mut().find(|aov| aov.name == error) {
            let place = Place {
                region,
                frame_px: [settings.camera.width_px, settings.camera.height_px],
                display_white_cd_m2: settings.display_white_cd_m2,
            };
            settings.foreseen_errors.add_to(error, place);
        }
        if let Some((frame, frames_per_second)) = settings.frame {
            let time = FrameTime {
                frame,
                frames_per_second,
            };
            image.attributes.extend(time.attributes());
        }
        image.windows.data = region;
        image.provenance = provenance;
        image
    }

    /// An image of it with as much of its spectra as the scene keeps, `[picture] spectral`.
    #[must_use]
    pub fn keeping(&self, image: SpectralImage) -> SpectralImage {
        image.keeping(self.settings.picture.spectral.into())
    }

    /// Renders a region, over the time its shutter is open; the image has no provenance.
    ///
    /// # Errors
    /// Parts that contradict each other or the settings; [`Error::Stopped`].
    pub fn render(self, region: PixelRegion, watch: Watch) -> Result<SpectralImage, Error> {
        let part = 1.0 / self.settings.n_pictures() as f64;
        let mut n_done = 0.0;
        self.over_shutter(watch, |work, _| {
            let before = n_done;
            n_done += 1.0;
            let part_of = |stage, it| watch(stage, part * (before + it));
            work.at_once(region, &part_of)
        })
    }

    /// Renders a region as it is at one instant; the image has no provenance.
    ///
    /// # Errors
    /// As [`Self::render`].
    pub(crate) fn at_once(
        &self,
        region: PixelRegion,
        watch: Watch,
    ) -> Result<SpectralImage, Error> {
        let watched = Watched::new(Stage::Render, region.n_pixels(), watch);
        let progress: Progress = &|n| watched.add(n);
        let watch = (progress, Deadline::NEVER);
        let (rendered, _) = render_in_steps(&self.request(region), watch, rows_of_step(region))?;
        Ok(self.image(rendered, region, Provenance::default()))
    }
}

/// Table, air and surfaces.
type OtherParts = (
    Option<ScatteringTable>,
    Option<AtmosphereTable>,
    Option<Surfaces>,
);

/// Whether nothing is to be said of it.
#[allow(clippy::trivially_copy_pass_by_ref, reason = "serde hands it over so")]
fn is_one(factor: &f64) -> bool {
    *factor == 1.0
}

/// Rows of a step of a picture: threads wait for each other at the end of each.
pub fn rows_of_step(region: PixelRegion) -> u32 {
    let n_threads = u32::try_from(rayon::current_num_threads()).unwrap_or(u32::MAX);
    let n_rows = ROWS_PER_THREAD.min(PIXELS_PER_THREAD / region.width_px.max(1));
    n_rows.saturating_mul(n_threads).max(1)
}

/// Whether drops that stand on the ground reach it.
fn reaches_ground(settings: &PictureSettings) -> bool {
    let eye = settings.camera.position_m.into();
    (settings.render_effects).ground_hides(settings.levels.sky, eye)
}

/// Drops as rays meet them.
fn bricks(settings: &PictureSettings, volume: DropVolume) -> Result<Vec<Bricks>, Error> {
    // A mode is given back as soon as its bricks stand.
    let modes = volume.modes.into_iter();
    let interpolation = settings.levels.interpolation;
    let has_ground = reaches_ground(settings);
    let bricks = modes.map(|mode| {
        let mode = if has_ground {
            mode.down_to_ground()
        } else {
            mode
        };
        Bricks::build(&mode, interpolation)
    });
    Ok(bricks.collect::<Result<_, _>>()?)
}

/// Drops in the light of the sun, and of water that mirrors it.
fn lit(settings: &PictureSettings, bricks: Vec<Bricks>, watch: Watch) -> Result<LitDrops, Error> {
    let sun_path = if settings.render_effects.drop_shadow.is_on() {
        settings.levels.sun_path
    } else {
        SunPath::Ignore
    };
    let allowed = settings
        .shadow_relative_error
        .map(|relative_error| Allowed {
            relative_error,
            efficiency: settings.levels.drop_extinction.efficiency(),
        });
    let sun_direction = settings.sun.direction();
    let sunlight = Sunlight {
        direction: sun_direction,
        path: sun_path,
        progress: &|_| watch(Stage::Render, 0.0),
    };
    let lit = sun_volume::lit(bricks, sunlight, allowed);
    let lit = lit.and_then(|drops| match settings.mirrored_water {
        Some((surface, light)) => drops.beside_water(surface.surface(), light, sun_direction),
        None => Ok(drops),
    });
    lit.map_err(|error| match Error::from(error) {
        Error::Render(error) => Error::Light(error),
        stopped => stopped,
    })
}
