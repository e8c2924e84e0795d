//! The section `[photo]`: a photograph that the bow stands in.

use schemars::JsonSchema;
use serde::Deserialize;
use serde::Serialize;

use crate::moment::SunPosition;

/// The section `[photo]`: the camera of the scene is the one that took the picture.
///
/// The picture may be larger than the camera's, in the same shape: the bow is smooth, its edges are
/// those of the surfaces at the picture's own size.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Photo {
    /// Path of the photograph (PNG, JPEG, EXR), relative to the scene file.
    #[schemars(length(min = 1))]
    pub picture: String,
    /// Path of the distances of its layers (TOML); where it is left out and there are no
    /// `[occluders]`, layers are proposed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub layers: Option<String>,
    /// Path of the labels of its layers (PNG).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub labels: Option<String>,
    /// Points of the wanted bow in pixels of the photograph, from which the sun follows; three or
    /// more, and no `[sun]` then.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[schemars(length(max = 1000))]
    pub picks_px: Vec<[f64; 2]>,
    /// What a person should know of the sun that followed from them, where no bow goes through them.
    #[serde(skip)]
    pub misfit: Option<String>,
    /// Which bow was picked.
    #[serde(default)]
    pub bow: PickedBow,
    /// Which color edge of it was picked.
    #[serde(default)]
    pub edge: PickedColor,
    /// How bright a sunlit white card is in the photograph.
    #[serde(default)]
    pub exposure: PhotoExposure,
    /// Value of a sunlit white card in the photograph, linear, instead of `exposure`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0.0, "maximum" = 1e7))]
    pub white_card: Option<f64>,
    /// Part of the sky under clouds, 0..1, to be checked against the bow.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = 1.0))]
    pub cloud_cover: Option<f64>,
}

/// The sun of the possible bow that is nearest to picks.
#[derive(Debug, Clone, PartialEq)]
pub struct PickedSun {
    /// Where it stands.
    pub position: SunPosition,
    /// By how much the picks miss its bow in the root mean square, degrees.
    pub missed_deg: f64,
    /// Why they miss it, where their own errors do not explain that.
    pub reason: Option<String>,
}

impl From<SunPosition> for PickedSun {
    /// That of a bow which goes through the picks.
    fn from(position: SunPosition) -> Self {
        Self {
            position,
            missed_deg: 0.0,
            reason: None,
        }
    }
}

impl PickedSun {
    /// What a person should know of it.
    pub(crate) fn misfit(&self) -> Option<String> {
        let reason = self.reason.as_ref()?;
        Some(format!(
            "no bow goes through photo.picks_px, the nearest misses them by {:.1} degrees (root mean square): {reason}",
            self.missed_deg
        ))
    }
}

/// Which bow.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum PickedBow {
    /// The inner, brighter bow.
    #[default]
    Primary,
    /// The outer, fainter bow.
    Secondary,
}

/// Which color edge of a bow.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum PickedColor {
    /// Red, 650 nm.
    #[default]
    Red,
    /// The green middle, 550 nm.
    Middle,
    /// Violet, 410 nm.
    Violet,
}

/// Where the exposure of a photograph comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum PhotoExposure {
    /// The mean of the picture is taken for grey.
    #[default]
    Match,
    /// From f-number, time and speed in EXIF.
    Camera,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::SceneError;
    use crate::occluders::Along;
    use crate::scene::Scene;

    const SCENE: &str = r#"
format = 1
name = "photo"
[camera]
position_m = [0.0, 1.6, 0.0]
azimuth_deg = 0.0
elevation_deg = 0.0
horizontal_fov_deg = 60.0
width_px = 64
height_px = 48
[drops]
file = "drops.vdb"
[photo]
picture = "photo.jpg"
picks_px = [[10.0, 20.0], [32.0, 8.0], [54, 20]]
"#;

    fn with_sun(text: &str) -> String {
        format!("{text}\n[sun]\nelevation_deg = 20.0\nazimuth_deg = 180.0\n")
    }

    /// Reads a scene whose sun stands where picks would put it.
    fn picked(text: &str) -> Result<Scene, SceneError> {
        Scene::from_toml_with_picks(text, |scene| {
            assert!(scene.photo.is_some());
            Ok(near(None))
        })
    }

    fn near(reason: Option<&str>) -> PickedSun {
        PickedSun {
            position: SunPosition {
                elevation_deg: 20.0,
                azimuth_deg: 180.0,
            },
            missed_deg: 2.04,
            reason: reason.map(str::to_owned),
        }
    }

    #[test]
    fn a_sun_by_picks_is_that_of_a_section() {
        let written = Scene::from_toml(&with_sun(SCENE));
        assert_eq!(picked(SCENE), written);
        let missed = Scene::from_toml_with_picks(SCENE, |_| -> Result<_, SceneError> {
            Ok(near(Some("a halo")))
        });
        let misfit = missed.unwrap().photo.unwrap().misfit.unwrap();
        assert!(misfit.contains("misses them by 2.0 degrees") && misfit.ends_with(": a halo"));
        // With a sun there is nothing to pick.
        let never = |_: &Scene| -> Result<PickedSun, SceneError> { panic!("picked") };
        assert_eq!(
            Scene::from_toml_with_picks(&with_sun(SCENE), never),
            written
        );
        let refusal = |result: Result<Scene, SceneError>| result.unwrap_err().to_string();
        let lacking = "line 1: the top level lacks `sun`";
        assert_eq!(refusal(Scene::from_toml(SCENE)), lacking);
        let unpicked = SCENE.replace("picks_px", "#");
        assert_eq!(refusal(picked(&unpicked)), lacking);
        // What else is wrong is told before anything is solved.
        let two = SCENE.replace(", [54, 20]", "");
        let never = |_: &Scene| -> Result<PickedSun, SceneError> { panic!("picked") };
        assert!(refusal(Scene::from_toml_with_picks(&two, never)).contains("picks_px"));
    }

    #[test]
    fn contradictions_of_a_photograph_are_refused_with_their_line() {
        let refused = |line: &str| {
            let text = with_sun(&SCENE.replace("picks_px", &format!("{line}\npicks_px")));
            Scene::from_toml(&text).unwrap_err().to_string()
        };
        assert!(refused("layers = \"layers.toml\"").contains("layers and labels"));
        assert!(refused("white_card = 0.5\nexposure = \"camera\"").contains("either exposure"));
        assert!(refused("white_card = -1.0").starts_with("line 15"));
        assert!(refused("cloud_cover = 1.5").contains("0 to 1"));
        assert!(refused("pictur = \"a.png\"").contains("did you mean `picture`"));
        let occluded = with_sun(SCENE) + "[occluders]\ndepth = \"depth.exr\"\nalong = \"axis\"\n";
        assert_eq!(
            Scene::from_toml(&occluded)
                .unwrap()
                .occluders
                .unwrap()
                .along,
            Along::Axis
        );
        assert!(Scene::from_toml(&occluded.replace("axis", "axle")).is_err());
    }
}
