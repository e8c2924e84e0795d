//! A scene: everything that a picture depends on, read from TOML.

use niji_radiometry::WavelengthGrid;
use niji_scatter::DropMotion;
use schemars::JsonSchema;
use serde::Deserialize;
use serde::Serialize;
use serde::de::IgnoredAny;

use crate::accuracy::Accuracy;
use crate::air::Air;
use crate::albedo::Albedo;
use crate::albedo::MeshAlbedo;
use crate::camera_section::Camera;
use crate::canonical_json::canonical_json;
use crate::drops::Drops;
use crate::effect::Effect;
use crate::effect::Section;
use crate::effect_switches::EffectSwitches;
use crate::effect_switches::Switch;
use crate::occluders::Occluders;
use crate::photo::Photo;
use crate::schema::parts::Tracks;
use crate::sections::Ground;
use crate::sections::Picture;
use crate::sections::Sun;
use crate::sections::Water;
use crate::terrain::Terrain;
use crate::water_surface::WaterSurface;

/// The version of the scene format that this crate reads.
pub const FORMAT: u32 = 1;

/// A scene.
///
/// ```
/// use niji_scene::{Scene, SceneError};
///
/// let text = r#"
/// format = 1
/// name = "fog"
/// [sun]
/// elevation_deg = 20.0
/// azimuth_deg = 180.0
/// [camera]
/// position_m = [0.0, 1.6, 0.0]
/// azimuth_deg = 0.0
/// elevation_deg = 10.0
/// horizontal_fov_deg = 90.0
/// width_px = 64
/// height_px = 48
/// [drops]
/// shape = "uniform"
/// box_min_m = [-50.0, 0.0, -120.0]
/// box_max_m = [50.0, 50.0, -20.0]
/// voxel_m = 5.0
/// law = { monodisperse = { radius_um = 20.0 } }
/// number_density_m3 = 1e7
/// "#;
/// let scene = Scene::from_toml(text)?;
/// assert_eq!(scene.camera.width_px, 64);
///
/// let misspelt = text.replace("azimuth_deg = 180.0", "azimut_deg = 180.0");
/// let error = Scene::from_toml(&misspelt).unwrap_err();
/// assert!(error.to_string().starts_with("line 6: unknown key `azimut_deg` in [sun], did you mean"));
/// # Ok::<(), SceneError>(())
/// ```
///
/// `S` is the section `[sun]`: the sun, or, while a file is read, what is written there.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Scene<S = Sun> {
    /// Version of the format: 1.
    #[schemars(extend("const" = FORMAT))]
    pub format: u32,
    /// What the scene is called.
    pub name: String,
    /// What it shows.
    #[serde(default)]
    pub description: String,
    /// The light.
    pub sun: S,
    /// The eye.
    pub camera: Camera,
    /// The wavelengths.
    #[serde(default = "WavelengthGrid::visible")]
    pub spectrum: WavelengthGrid,
    /// The drops.
    pub drops: Drops,
    /// What the drops are made of.
    #[serde(default)]
    pub water: Water,
    /// Water that mirrors the sun.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub water_surface: Option<WaterSurface>,
    /// How falling drops tilt and tremble.
    #[serde(default)]
    pub drop_motion: DropMotion,
    /// The air; a vacuum where it is left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub air: Option<Air>,
    /// The ground.
    #[serde(default)]
    pub ground: Ground,
    /// What is to be simulated.
    #[serde(default)]
    pub effects: EffectSwitches,
    /// How accurately.
    #[serde(default)]
    pub accuracy: Accuracy,
    /// How the preview is shown.
    #[serde(default)]
    pub picture: Picture,
    /// Surfaces that hide what is behind them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub occluders: Option<Occluders>,
    /// Heights of the land.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub terrain: Option<Terrain>,
    /// The photograph that the bow stands in.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub photo: Option<Photo>,
    /// What changes from frame to frame, lists of frame and value under the scene's own keys; the scene
    /// itself is none of its frames.
    #[serde(default, skip_serializing)]
    #[schemars(with = "Option<Tracks>")]
    pub sequence: Option<IgnoredAny>,
}

impl Scene {
    /// Whether it has a section that effects may need.
    pub(crate) fn has(&self, section: Section) -> bool {
        match section {
            Section::Air => self.air.is_some(),
            Section::WaterSurface => self.water_surface.is_some(),
            Section::Shutter => false,
        }
    }

    /// Whether anything may stand in front of the drops.
    pub(crate) fn has_surfaces(&self) -> bool {
        self.occluders.is_some() || self.terrain.is_some() || self.photo.is_some()
    }

    /// The water that the camera may see: a photograph has its own.
    pub(crate) fn seen_water(&self) -> Option<niji_render::WaterSurface> {
        let is_off = self.photo.is_some() || self.effects.of(Effect::SeenWater) == Switch::Off;
        self.water_surface
            .filter(|_| !is_off)
            .map(|water| water.surface())
    }

    /// The most that each of the surfaces with an albedo gives back.
    pub(crate) fn albedos(&self) -> impl Iterator<Item = f64> {
        let meshes = self.occluders.iter().flat_map(|it| &it.meshes);
        let of_meshes = meshes.filter_map(|mesh| mesh.albedo.map(MeshAlbedo::largest));
        let of_terrain = self.terrain.iter().filter_map(|it| it.albedo);
        of_meshes.chain(of_terrain.map(Albedo::largest))
    }

    /// What the drops are made of: the sea's water where all of them are its spray, otherwise pure, unless
    /// the section `[water]` says something else.
    pub fn water(&self) -> niji_radiometry::Water {
        self.water
            .of(self.drops.populations().iter().map(|it| it.source.name()))
    }

    /// All values, those left out in the file included, as JSON whose bytes depend on nothing but
    /// the values: sorted keys, no white space, shortest decimals that read back exactly. Of a scene that
    /// [`Self::check`] refuses NaN and infinity become `null`, which is read as left out.
    pub fn canonical_json(&self) -> String {
        canonical_json(self)
    }
}
