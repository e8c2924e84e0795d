//! Where the bows, the point opposite to the sun and the horizon lie in a picture.
//!
//! The bows are those of large round drops and a point sun: fringes and flattening move what is seen from there.

use glam::DVec3;
use niji_geometry::Camera;
use niji_geometry::EARTH;
use niji_geometry::direction_from_azimuth_elevation;
use niji_photo::bow_path;
use niji_radiometry::Radians;
use niji_scene::PickedBow;
use niji_scene::PickedColor;
use niji_scene::Scene;

use crate::bow_edge::BowEdge;
use crate::error::Error;

/// Broken lines of places in pixels from the top left corner of the picture.
pub type Lines = Vec<Vec<[f64; 2]>>;

/// What a picture may have drawn over it.
#[derive(Clone, Debug)]
pub struct SkyMarks {
    /// The color edges of both bows.
    pub bows: Vec<(BowEdge, Lines)>,
    /// The horizon of the sea.
    pub horizon: Lines,
    /// The point opposite to the sun, where it is in the picture.
    pub antisolar_px: Option<[f64; 2]>,
    /// The sun, where it is in the picture.
    pub sun_px: Option<[f64; 2]>,
}

impl SkyMarks {
    /// Those of a scene.
    ///
    /// # Errors
    /// A camera that cannot be, of a scene that was built in code.
    pub fn of(scene: &Scene) -> Result<Self, Error> {
        let camera = scene.camera.camera().map_err(Error::scene)?;
        let antisolar = -scene.sun.direction();
        let edges = [PickedBow::Primary, PickedBow::Secondary]
            .into_iter()
            .flat_map(|bow| {
                [PickedColor::Red, PickedColor::Violet].map(|color| BowEdge {
                    bow,
                    color,
                    water: scene.water(),
                })
            });
        let bows = edges.map(|edge| (edge, bow_path(&camera, antisolar, edge.angle())));
        let below_rad = EARTH.horizon_dip(camera.position().y).0;
        let from_nadir = Radians(0.5 * std::f64::consts::PI - below_rad);
        Ok(Self {
            bows: bows.collect(),
            horizon: bow_path(&camera, DVec3::NEG_Y, from_nadir),
            antisolar_px: place(&camera, antisolar),
            sun_px: place(&camera, -antisolar),
        })
    }
}

/// The highest point of a bow, of its red edge.
#[derive(Clone, Copy, Debug)]
pub struct BowTop {
    /// How high it stands, degrees.
    pub elevation_deg: f64,
    /// Where, 0 to 360 degrees.
    pub azimuth_deg: f64,
    /// Its place in pixels from the top left corner, where it is in the picture.
    pub place_px: Option<[f64; 2]>,
}

impl BowTop {
    /// That of a bow of a scene.
    ///
    /// # Errors
    /// As [`SkyMarks::of`].
    pub fn of(scene: &Scene, bow: PickedBow) -> Result<Self, Error> {
        let camera = scene.camera.camera().map_err(Error::scene)?;
        let edge = BowEdge {
            bow,
            color: PickedColor::Red,
            water: scene.water(),
        };
        let elevation_deg = edge.angle().to_degrees() - scene.sun.elevation_deg;
        let azimuth_deg = (scene.sun.azimuth_deg + 180.0).rem_euclid(360.0);
        let [azimuth, elevation] = [azimuth_deg, elevation_deg].map(Radians::from_degrees);
        Ok(Self {
            elevation_deg,
            azimuth_deg,
            place_px: place(
                &camera,
                direction_from_azimuth_elevation(azimuth, elevation),
            ),
        })
    }
}

/// Where a direction is in the picture.
fn place(camera: &Camera, direction: DVec3) -> Option<[f64; 2]> {
    let (x, y) = camera.project(direction)?;
    let size = [camera.width_px(), camera.height_px()].map(f64::from);
    let is_inside = (0.0..=size[0]).contains(&x) && (0.0..=size[1]).contains(&y);
    is_inside.then_some([x, y])
}

/// The angle of a place in a picture from the point opposite to the sun; `None` where the camera sees nothing.
///
/// # Errors
/// As [`SkyMarks::of`].
pub fn bow_angle(scene: &Scene, [x_px, y_px]: [f64; 2]) -> Result<Option<Radians>, Error> {
    let camera = scene.camera.camera().map_err(Error::scene)?;
    let ray = camera.ray(x_px, y_px);
    Ok(ray.map(|ray| Radians(ray.direction.angle_between(-scene.sun.direction()))))
}

#[cfg(test)]
mod tests {
    use niji_scene::Projection;

    use super::*;

    const SCENE: &str = include_str!("../../../data/scenes/rain-5-mm-h-flattened.toml");

    #[test]
    fn every_mark_lies_at_its_angle_through_any_lens() {
        let scene = Scene::from_toml(SCENE).unwrap();
        for (projection, height_px) in [
            (Projection::Pinhole, 320),
            (Projection::FisheyeEquidistant, 320),
            (Projection::FisheyeEquisolid, 320),
            (Projection::Panorama, 240),
        ] {
            let mut scene = scene.clone();
            scene.camera.projection = projection;
            scene.camera.height_px = height_px;
            let marks = SkyMarks::of(&scene).unwrap();
            let mut n_points = 0;
            for (edge, lines) in &marks.bows {
                for point in lines.iter().flatten() {
                    let found = bow_angle(&scene, *point).unwrap().unwrap();
                    assert!((found.0 - edge.angle().0).abs() < 1e-7, "{projection:?}");
                    n_points += 1;
                }
            }
            assert!(n_points > 500, "{projection:?} {n_points}");
            let camera = scene.camera.camera().unwrap();
            for [x, y] in marks.horizon.iter().flatten() {
                let rise_rad = camera.ray(*x, *y).unwrap().direction.y.asin();
                assert!(
                    (60.0 * rise_rad.to_degrees() + 2.72).abs() < 0.01,
                    "{projection:?}"
                );
            }
            assert!(!marks.horizon.is_empty());
        }
    }

    #[test]
    fn the_top_of_a_bow_is_on_its_edge_where_nothing_of_it_is_higher() {
        let mut scene = Scene::from_toml(SCENE).unwrap();
        scene.sun.azimuth_deg = 190.0;
        scene.camera.horizontal_fov_deg = Some(100.0);
        let top = BowTop::of(&scene, PickedBow::Primary).unwrap();
        assert!((top.azimuth_deg - 10.0).abs() < 1e-9);
        assert!((top.elevation_deg - 22.4).abs() < 0.2, "{top:?}");
        let place = top.place_px.unwrap();
        let angle = bow_angle(&scene, place).unwrap().unwrap();
        let (edge, lines) = &SkyMarks::of(&scene).unwrap().bows[0];
        assert_eq!(
            (edge.bow, edge.color),
            (PickedBow::Primary, PickedColor::Red)
        );
        assert!((angle.0 - edge.angle().0).abs() < 1e-7);
        let camera = scene.camera.camera().unwrap();
        let rise = |[x, y]: [f64; 2]| camera.ray(x, y).unwrap().direction.y;
        let highest = lines.iter().flatten().map(|point| rise(*point));
        assert!(highest.fold(0.0, f64::max) <= rise(place) + 1e-9);
    }

    #[test]
    fn sun_and_the_point_opposite_to_it_are_marked_where_they_are_seen() {
        let mut scene = Scene::from_toml(SCENE).unwrap();
        scene.camera.elevation_deg = -20.0;
        let marks = SkyMarks::of(&scene).unwrap();
        let [x, y] = marks.antisolar_px.unwrap();
        assert!((x - 240.0).abs() < 1e-9 && (y - 160.0).abs() < 1e-9);
        assert_eq!(marks.sun_px, None);
    }
}
