//! The section `[photo]`: a photograph that the bow stands in.

use schemars::JsonSchema;
use serde::Deserialize;
use serde::Serialize;

use crate::camera_section::Camera;
use crate::sections::Water;

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

/// What the sun of a scene follows from.
#[derive(Debug, Clone, PartialEq)]
pub struct PickedSun {
    /// The photograph, with its picks.
    pub photo: Photo,
    /// The eye.
    pub camera: Camera,
    /// What the drops are made of.
    pub water: niji_radiometry::Water,
}

/// What a scene file says whose sun follows from picks; `None` for any other text, even one that is no
/// scene.
pub fn picked_sun(text: &str) -> Option<PickedSun> {
    let mut scene: toml::Table = text.parse().ok()?;
    if scene.contains_key("sun") {
        return None;
    }
    let photo: Photo = scene.remove("photo")?.try_into().ok()?;
    let camera: Camera = scene.remove("camera")?.try_into().ok()?;
    let water: Water = match scene.remove("water") {
        Some(water) => water.try_into().ok()?,
        None => Water::default(),
    };
    let drops = scene
        .get("drops")
        .into_iter()
        .flat_map(|drops| match drops {
            toml::Value::Array(entries) => entries.as_slice(),
            one => std::slice::from_ref(one),
        });
    let shapes = drops.map(|drops| {
        let shape = drops.get("shape").and_then(toml::Value::as_str);
        shape.unwrap_or_default()
    });
    let shapes: Vec<&str> = shapes.collect();
    (!photo.picks_px.is_empty()).then(|| PickedSun {
        photo,
        camera,
        water: water.of(shapes),
    })
}

/// A scene file with a sun; the lines of everything else stay.
pub fn with_sun(text: &str, elevation_deg: f64, azimuth_deg: f64) -> String {
    format!("{text}\n[sun]\nelevation_deg = {elevation_deg:?}\nazimuth_deg = {azimuth_deg:?}\n")
}

#[cfg(test)]
mod tests {
    use super::*;
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

    #[test]
    fn a_sun_by_picks_becomes_a_section() {
        let PickedSun {
            photo,
            camera,
            water,
        } = picked_sun(SCENE).unwrap();
        assert_eq!(water, niji_radiometry::Water::pure(15.0));
        let spray = SCENE.replace("file = \"drops.vdb\"", "shape = \"sea-spray\"");
        let spray = picked_sun(&(spray + "[water]\ntemperature_c = 10.0\n")).unwrap();
        assert_eq!(spray.water, niji_radiometry::Water::of_the_sea(10.0));
        assert_eq!(photo.picks_px[2], [54.0, 20.0]);
        assert_eq!(camera.width_px, 64);
        let text = with_sun(SCENE, 0.1 + 0.2, 180.0);
        let scene = Scene::from_toml(&text).unwrap();
        assert_eq!(scene.sun.elevation_deg, 0.1 + 0.2);
        assert_eq!(scene.photo, Some(photo));
        // With a sun there is nothing to pick, and no text is an error here.
        assert_eq!(picked_sun(&text), None);
        assert_eq!(picked_sun("[photo"), None);
        assert!(
            Scene::from_toml(SCENE)
                .unwrap_err()
                .to_string()
                .contains("sun")
        );
    }

    #[test]
    fn contradictions_of_a_photograph_are_refused_with_their_line() {
        let refused = |line: &str| {
            let text = with_sun(
                &SCENE.replace("picks_px", &format!("{line}\npicks_px")),
                20.0,
                180.0,
            );
            Scene::from_toml(&text).unwrap_err().to_string()
        };
        assert!(refused("layers = \"layers.toml\"").contains("layers and labels"));
        assert!(refused("white_card = 0.5\nexposure = \"camera\"").contains("either exposure"));
        assert!(refused("white_card = -1.0").starts_with("line 15"));
        assert!(refused("cloud_cover = 1.5").contains("0 to 1"));
        assert!(refused("pictur = \"a.png\"").contains("did you mean `picture`"));
        let two = with_sun(&SCENE.replace(", [54, 20]", ""), 20.0, 180.0);
        assert!(
            Scene::from_toml(&two)
                .unwrap_err()
                .to_string()
                .contains("picks_px")
        );
        let occluded =
            with_sun(SCENE, 20.0, 180.0) + "[occluders]\ndepth = \"depth.exr\"\nalong = \"axis\"\n";
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
