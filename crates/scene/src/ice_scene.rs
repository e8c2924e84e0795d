//! Scenes of ice: a document of their own, read as strictly as a [`crate::Scene`].
//!
//! Sun, camera, spectrum, air and picture are the sections of every scene; `[ice]` is the body, `[sky]`
//! a uniform sky in the place of air, `[ground]` what is below the horizon.

use std::collections::BTreeMap;

use glam::DVec3;
use niji_geometry::Up;
use niji_ice::Bubbles;
use niji_ice::Ground as IceGround;
use niji_ice::IceSurface;
use niji_ice::IceTransport;
use niji_ice::Iceberg;
use niji_ice::PathWavelengths;
use niji_ice::Snow;
use niji_radiometry::Reflectance;
use niji_radiometry::WavelengthGrid;
use niji_render::SkyModel;
use schemars::JsonSchema;
use serde::Deserialize;
use serde::Serialize;

use crate::accuracy::Preset;
use crate::air::Air;
use crate::camera_section;
use crate::camera_section::Camera;
use crate::check::Check;
use crate::check::TURNS_DEG;
use crate::document;
use crate::error::SceneError;
use crate::scene::FORMAT;
use crate::sections::Picture;
use crate::sections::Sun;

/// A scene of ice.
///
/// ```
/// use niji_scene::{IceScene, SceneError};
///
/// let text = include_str!("../../../data/scenes/ice-cube-50-m.toml");
/// let scene = IceScene::from_toml(text)?;
/// assert_eq!(scene.name, "ice-cube-50-m");
///
/// let misspelt = text.replace("edge_m", "egde_m");
/// let error = IceScene::from_toml(&misspelt).unwrap_err();
/// assert!(error.to_string().contains("unknown key `egde_m` in [ice.shape], did you mean `edge_m`?"));
/// # Ok::<(), SceneError>(())
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct IceScene {
    /// Version of the format: 1.
    #[schemars(extend("const" = FORMAT))]
    pub format: u32,
    /// What the scene is called.
    pub name: String,
    /// What it shows.
    #[serde(default)]
    pub description: String,
    /// The light.
    pub sun: Sun,
    /// The eye.
    pub camera: Camera,
    /// The wavelengths.
    #[serde(default = "WavelengthGrid::visible")]
    pub spectrum: WavelengthGrid,
    /// The ice.
    pub ice: IceSection,
    /// The air that sunlight comes through and whose sky shines; a vacuum where it is left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub air: Option<Air>,
    /// A uniform sky in the place of that of the air.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sky: Option<UniformSky>,
    /// What is below the horizon.
    pub ground: IceGround,
    /// How accurately.
    #[serde(default)]
    pub accuracy: IceAccuracy,
    /// How the preview is shown.
    #[serde(default)]
    pub picture: Picture,
}

/// The section `[ice]`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct IceSection {
    /// Its shape.
    pub shape: IceShape,
    /// Where the middle of the base of a cube or box stands, where the origin of a mesh lies, or the
    /// water line of an iceberg, m: x east, y up, z south.
    #[serde(default)]
    #[schemars(inner(range(min = -1e7, max = 1e7)))]
    pub base_m: [f64; 3],
    /// What its surface does with light: the published diffuse one where it is left out.
    #[serde(default = "published_surface")]
    pub surface: IceSurface,
    /// Bubbles; clear ice where they are left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bubbles: Option<Bubbles>,
    /// Snow on top; bare ice where it is left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub snow: Option<Snow>,
}

fn published_surface() -> IceSurface {
    IceSurface::PUBLISHED
}

/// The shape of ice.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum IceShape {
    /// A cube.
    Cube {
        /// Length of an edge, m.
        #[schemars(range(min = 1e-6, max = 1e6))]
        edge_m: f64,
        /// Turned about the vertical, clockwise seen from above, degrees.
        #[serde(default)]
        #[schemars(range(min = -360.0, max = 360.0))]
        turn_deg: f64,
    },
    /// A box.
    Box {
        /// Extent east, up and south, m.
        #[schemars(inner(range(min = 1e-6, max = 1e6)))]
        size_m: [f64; 3],
    },
    /// A closed surface from a file.
    Mesh {
        /// OBJ, glTF or STL, relative to the scene.
        #[schemars(length(min = 1))]
        file: String,
        /// Longest extent of the body, m: as in the file where it is left out.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        #[schemars(range(min = 1e-6, max = 1e6))]
        length_m: Option<f64>,
        /// Which way is up in the file.
        #[serde(default)]
        up: Up,
    },
    /// An iceberg by chance.
    Iceberg(Iceberg),
}

/// The section `[sky]` of a scene of ice.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct UniformSky {
    /// Irradiance of level ground by the sky over that of a plane across the sun's light above the
    /// air; the sky has the sun's color.
    #[schemars(range(min = 0.0, max = 1000.0))]
    pub irradiance_share: f64,
}

/// The section `[accuracy]` of a scene of ice.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct IceAccuracy {
    /// How light is followed.
    #[serde(default = "usual_transport")]
    pub transport: IceTransport,
    /// Standard error of the luminance of a pixel, over that of a white plane that faces
    /// the sun above the air, at which it is done: all paths are drawn where it is left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1e-6, max = 1.0))]
    pub tolerance: Option<f64>,
    /// Another seed is another noise.
    #[serde(default)]
    pub seed: u64,
    /// How often the air scatters the light of its sky: all orders where it is left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sky: Option<SkyModel>,
}

fn usual_transport() -> IceTransport {
    IceAccuracy::transport_of(Preset::Standard)
}

impl IceAccuracy {
    /// What a preset means for ice: ever more paths.
    #[must_use]
    pub fn transport_of(preset: Preset) -> IceTransport {
        let paths_per_pixel = match preset {
            Preset::Draft => 32,
            Preset::Standard => 256,
            Preset::Reference => 4096,
        };
        IceTransport::PathTraced {
            paths_per_pixel,
            wavelengths: PathWavelengths::All,
        }
    }

    /// How often the air scatters the light of its sky.
    #[must_use]
    pub fn sky_model(&self) -> SkyModel {
        self.sky.unwrap_or(SkyModel::MultipleScattering)
    }
}

impl Default for IceAccuracy {
    fn default() -> Self {
        Self {
            transport: usual_transport(),
            tolerance: None,
            seed: 0,
            sky: None,
        }
    }
}

impl IceScene {
    /// Reads a scene from TOML; every key must be known, of the right type and within its range.
    ///
    /// # Errors
    /// The first thing that is wrong, with its line and what would be right.
    pub fn from_toml(text: &str) -> Result<Self, SceneError> {
        let document = document::parse::<Self>(text)?;
        document.value.check(&document.lines)?;
        Ok(document.value)
    }

    fn check(&self, lines: &BTreeMap<String, usize>) -> Result<(), SceneError> {
        let check = Check { lines };
        if self.format != FORMAT {
            let found = self.format.to_string();
            let expected = format!("{FORMAT}, the only format yet");
            return Err(check.out_of_range("format", found, &expected));
        }
        self.check_numbers().map_err(|(key, found, expected)| {
            check.out_of_range(key, found.to_string(), expected)
        })?;
        camera_section::check(&self.camera, &check)?;
        self.camera
            .pinhole()
            .map_err(|error| check.refused("camera", &error))?;
        if let Some(air) = &self.air {
            air.model(self.spectrum, self.ground_reflectance(), &self.sun)
                .map_err(|error| check.refused("air", &error))?;
        }
        self.check_ice().map_err(|error| match error {
            niji_ice::Error::Parameter {
                parameter,
                found,
                expected,
            } => {
                let ending = format!(".{parameter}");
                let key = lines.keys().find(|key| key.ends_with(&ending));
                let key = key.map_or_else(|| format!("ice{ending}"), Clone::clone);
                check.out_of_range(&key, found.to_string(), expected)
            }
            other => check.refused("ice", &other),
        })
    }

    /// Numbers of the document that no other crate checks: key, value and range of the first one out
    /// of its range.
    fn check_numbers(&self) -> Result<(), (&'static str, f64, &'static str)> {
        let share = self.sky.map_or(0.0, |sky| sky.irradiance_share);
        let tolerance = self.accuracy.tolerance.unwrap_or(1.0);
        let [x, y, z] = self.ice.base_m;
        let (edge_m, turn_deg) = match self.ice.shape {
            IceShape::Cube { edge_m, turn_deg } => (edge_m, turn_deg),
            IceShape::Box { size_m } => (size_m.into_iter().fold(f64::INFINITY, f64::min), 0.0),
            IceShape::Mesh { length_m, .. } => (length_m.unwrap_or(1.0), 0.0),
            IceShape::Iceberg(_) => (1.0, 0.0),
        };
        for (key, found, [low, high], expected) in [
            (
                "sun.elevation_deg",
                self.sun.elevation_deg,
                [-90.0, 90.0],
                "-90 to 90",
            ),
            (
                "sun.azimuth_deg",
                self.sun.azimuth_deg,
                TURNS_DEG.into(),
                "-3600 to 3600",
            ),
            ("sky.irradiance_share", share, [0.0, 1e3], "0 to 1000"),
            (
                "picture.exposure_ev",
                self.picture.exposure_ev,
                [-40.0, 40.0],
                "-40 to 40",
            ),
            (
                "accuracy.tolerance",
                tolerance,
                [1e-6, 1.0],
                "0.000001 to 1",
            ),
            (
                "ice.base_m",
                DVec3::new(x, y, z).abs().max_element(),
                [0.0, 1e7],
                "within 1e7 m",
            ),
            ("ice.shape", edge_m, [1e-6, 1e6], "edges of 1e-6 to 1e6 m"),
            (
                "ice.shape.turn_deg",
                turn_deg,
                [-360.0, 360.0],
                "-360 to 360",
            ),
        ] {
            if !(low..=high).contains(&found) {
                return Err((key, found, expected));
            }
        }
        Ok(())
    }

    fn check_ice(&self) -> Result<(), niji_ice::Error> {
        let ice = niji_ice::Ice {
            absorption_per_m: Vec::new(),
            surface: self.ice.surface,
            bubbles: self.ice.bubbles,
            snow: self.ice.snow,
        };
        ice.check(0)?;
        self.ground.check()?;
        self.accuracy.transport.check()?;
        if let IceShape::Iceberg(iceberg) = &self.ice.shape {
            iceberg.check()?;
        }
        Ok(())
    }

    /// Share of the light that the ground gives back diffusely, as the air sees it.
    pub fn ground_reflectance(&self) -> Reflectance {
        match self.ground {
            IceGround::Land { albedo } | IceGround::Sea { albedo, .. } => Reflectance::Even(albedo),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SCENE: &str = include_str!("../../../data/scenes/ice-cube-0.1-m.toml");

    fn refused(from: &str, to: &str) -> String {
        assert!(SCENE.contains(from), "{from}");
        IceScene::from_toml(&SCENE.replace(from, to))
            .unwrap_err()
            .to_string()
    }

    #[test]
    fn wrong_keys_and_values_are_named_with_their_line() {
        let misspelt = refused("outer_reflectance", "outer_reflectnce");
        assert!(
            misspelt.contains("did you mean `outer_reflectance`?"),
            "{misspelt}"
        );
        let too_much = refused("outer_reflectance = 0.063", "outer_reflectance = 1.5");
        assert!(
            too_much.contains("`ice.surface.outer_reflectance` is 1.5"),
            "{too_much}"
        );
        assert!(!too_much.starts_with("line 1:"), "{too_much}");
        let shape = refused("shape = \"cube\"", "shape = \"cub\"");
        assert!(shape.contains("did you mean `cube`?"), "{shape}");
        let negative = refused("edge_m = 0.1", "edge_m = -0.1");
        assert!(negative.contains("edges of 1e-6"), "{negative}");
        let level = refused("paths_per_pixel = 192", "paths_per_pixel = 0");
        assert!(
            level.contains("`accuracy.transport.paths_per_pixel` is 0"),
            "{level}"
        );
    }

    #[test]
    fn the_sky_has_all_orders_unless_the_scene_says_otherwise() {
        let scene = IceScene::from_toml(SCENE).unwrap();
        assert_eq!(scene.accuracy.sky_model(), SkyModel::MultipleScattering);
        let once = SCENE.replace("[accuracy]", "[accuracy]\nsky = \"single-scattering\"");
        let scene = IceScene::from_toml(&once).unwrap();
        assert_eq!(scene.accuracy.sky_model(), SkyModel::SingleScattering);
        let misspelt = once.replace("single-", "twice-");
        assert!(IceScene::from_toml(&misspelt).is_err());
    }

    #[test]
    fn every_shipped_scene_of_ice_is_sound() {
        for text in [
            SCENE,
            include_str!("../../../data/scenes/ice-cube-50-m.toml"),
            include_str!("../../../data/scenes/ice-iceberg-sun-10.toml"),
            include_str!("../../../data/scenes/ice-iceberg-sun-40.toml"),
        ] {
            IceScene::from_toml(text).unwrap();
        }
    }
}
