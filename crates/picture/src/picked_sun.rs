//! Where the sun stands by pixels of a photograph where a bow is or should be.

use std::path::Path;

use glam::DQuat;
use niji_geometry::PinholeCamera;
use niji_photo::BowAnglePrior;
use niji_photo::Finding;
use niji_photo::FitRequest;
use niji_photo::Photograph;
use niji_photo::PickedEdge;
use niji_photo::SunSolution;
use niji_photo::Verdict;
use niji_photo::diagnose_picks;
use niji_photo::sun_from_picks;
use niji_radiometry::Radians;
use niji_scene::Photo;
use niji_scene::PickedSun;
use niji_scene::Scene;
use niji_scene::SunPosition;

use crate::bow_edge::BowEdge;
use crate::bow_edge::EDGE_ERROR;
use crate::error::Error;
use crate::photo_depth::photo_camera;
use crate::photo_depth::pinhole;
use crate::sandbox::Sandbox;

/// Standard error of a pick, pixels.
pub const PICK_ERROR_PX: f64 = 1.0;

/// Standard error of the angle of a bow that picks do not widen, however much they miss it.
const HELD: Radians = Radians(1e-5);

/// Picks of one color edge of a bow.
#[derive(Clone, Copy, Debug)]
pub struct PicksRequest<'a> {
    /// What took the photograph.
    pub camera: &'a PinholeCamera,
    /// Where the edge was picked, pixels.
    pub picks_px: &'a [[f64; 2]],
    /// Standard error of a pick, pixels.
    pub noise_px: f64,
    /// What was picked.
    pub edge: PickedEdge,
    /// Whether the angle of that edge is known beforehand, or comes out.
    pub is_angle_known: bool,
}

/// What picks say of the sun.
#[derive(Clone, Debug)]
pub struct PickedSuns {
    /// All places for it, the best first.
    pub solutions: Vec<SunSolution>,
    /// What speaks against the picks, the worst first.
    pub findings: Vec<Finding>,
    /// That of the bow of the known angle which comes nearest to the picks; `None` where the sun would have set.
    nearest: Option<SunSolution>,
}

impl PicksRequest<'_> {
    /// Finds the sun.
    ///
    /// # Errors
    /// Fewer than three picks, or numbers out of range.
    pub fn suns(&self) -> Result<PickedSuns, niji_photo::Error> {
        let offsets_rad = vec![0.0; self.picks_px.len()];
        let request = FitRequest {
            camera: self.camera,
            picks_px: self.picks_px,
            offsets_rad: &offsets_rad,
            noise_px: self.noise_px,
            prior: self.is_angle_known.then_some(self.edge.expected),
        };
        let solutions = sun_from_picks(&request)?;
        let findings = diagnose_picks(&request, self.edge, &solutions);
        let prior = request.prior.map(|prior| BowAnglePrior {
            standard_error: HELD,
            ..prior
        });
        let held = sun_from_picks(&FitRequest { prior, ..request })?;
        let is_near = |it: &SunSolution| [Verdict::Possible, Verdict::Misfit].contains(&it.verdict);
        Ok(PickedSuns {
            solutions,
            findings,
            nearest: held.into_iter().find(is_near),
        })
    }
}

impl PickedSuns {
    /// The first place against which nothing speaks.
    ///
    /// # Errors
    /// [`Error::NoSun`] if there is none.
    pub fn best(&self) -> Result<PickedSun, Error> {
        let mut solutions = self.solutions.iter();
        let possible = solutions.find(|it| it.verdict == Verdict::Possible);
        possible.map_or_else(
            || Err(Error::NoSun(self.reason())),
            |best| Ok(picked(best, None)),
        )
    }

    /// The same, or that of the bow which comes nearest to the picks.
    ///
    /// # Errors
    /// [`Error::NoSun`] where that has set, or the picks are too close together to tell.
    pub fn nearest(&self) -> Result<PickedSun, Error> {
        let best = self.best();
        let nearest = self.nearest.filter(|_| best.is_err());
        nearest.map_or(best, |it| Ok(picked(&it, Some(self.reason()))))
    }

    /// What speaks most against the picks.
    fn reason(&self) -> String {
        let first = self.findings.first();
        let none = "no place of the sun gives a bow through these picks";
        first.map_or(none, |finding| &finding.reason).to_owned()
    }
}

fn picked(sun: &SunSolution, reason: Option<String>) -> PickedSun {
    PickedSun {
        position: SunPosition {
            elevation_deg: sun.elevation.to_degrees(),
            azimuth_deg: sun.azimuth.to_degrees(),
        },
        missed_deg: sun.fit.residual.to_degrees(),
        reason,
    }
}

/// Reads a scene from TOML; where it says no sun, that follows from the picks in its photograph, which lies
/// in `folder`.
///
/// # Errors
/// The first thing that is wrong with the scene; a photograph that cannot be read; picks that no bow is near.
pub fn scene_from_toml(text: &str, folder: &Path) -> Result<Scene, Error> {
    Sandbox::default().scene_from_toml(text, folder)
}

/// Picks in the photograph of a scene turned together, as the bow through them goes where a hand drags it: from one
/// place to another, both in parts of the frame from its top left corner. They stay on a circle of their angle.
///
/// # Errors
/// A scene without a photograph, or whose photograph cannot be read; a place that the camera does not see from then on.
pub fn turned_picks(
    (scene, folder): (&Scene, &Path),
    picks_px: &[[f64; 2]],
    [from, to]: [[f64; 2]; 2],
) -> Result<Vec<[f64; 2]>, Error> {
    let (camera, size) = photograph_camera(scene, folder)?;
    let ray = |[right, down]: [f64; 2]| {
        let [width, height] = size.map(|n| n as f64);
        camera.ray(right * width, down * height).direction
    };
    let turn = DQuat::from_rotation_arc(ray(from), ray(to));
    let turned = picks_px.iter().map(|[x_px, y_px]| {
        let place = camera.project(turn * camera.ray(*x_px, *y_px).direction);
        let place = place.filter(|it| it.0.is_finite() && it.1.is_finite());
        let gone = || Error::NoSun("a pick would lie behind the camera".to_owned());
        place.map(|(x, y)| [x, y]).ok_or_else(gone)
    });
    turned.collect()
}

fn section_of(scene: &Scene) -> Result<&Photo, Error> {
    let none = || Error::NoSun("no photograph to pick in".to_owned());
    scene.photo.as_ref().ok_or_else(none)
}

/// What took the photograph of a scene, and its width and height.
fn photograph_camera(scene: &Scene, folder: &Path) -> Result<(PinholeCamera, [usize; 2]), Error> {
    let path = folder.join(&section_of(scene)?.picture);
    let size = Photograph::size_in(&path).map_err(|error| Error::file(&path, error))?;
    Ok((pinhole(photo_camera(&scene.camera, size))?, size))
}

/// The sun of the possible bow that is nearest to picks in the photograph of a scene, which lies in `folder`.
///
/// # Errors
/// A scene without a photograph, or whose photograph cannot be read; picks that no bow is near.
pub fn picked_sun(scene: &Scene, folder: &Path) -> Result<PickedSun, Error> {
    let (camera, _) = photograph_camera(scene, folder)?;
    let section = section_of(scene)?;
    let edge = BowEdge {
        bow: section.bow,
        color: section.edge,
        water: scene.water(),
    };
    let request = PicksRequest {
        camera: &camera,
        picks_px: &section.picks_px,
        noise_px: PICK_ERROR_PX,
        edge: edge.picked(edge.angle(), EDGE_ERROR),
        is_angle_known: true,
    };
    request.suns()?.nearest()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pavilion() -> (Scene, &'static Path) {
        let folder = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../data/scenes"));
        let text = include_str!("../../../data/scenes/photo-pavilion-rain.toml");
        (scene_from_toml(text, folder).unwrap(), folder)
    }

    #[test]
    fn a_bow_that_is_dragged_stays_one_and_its_sun_goes_with_it() {
        let (mut scene, folder) = pavilion();
        let picks_px = scene.photo.as_ref().unwrap().picks_px.clone();
        let sun = scene.sun;
        let turned = |ends| turned_picks((&scene, folder), &picks_px, ends).unwrap();
        let stays = turned([[0.3, 0.4]; 2]);
        for (stays, was) in stays.iter().zip(&picks_px) {
            assert!((stays[0] - was[0]).hypot(stays[1] - was[1]) < 1e-9);
        }
        // A pick that is taken goes where the hand goes: 640 x 427 pixels.
        let part = |[x, y]: [f64; 2]| [x / 640.0, y / 427.0];
        let wanted = [picks_px[1][0] + 20.0, picks_px[1][1] - 25.0];
        let moved = turned([part(picks_px[1]), part(wanted)]);
        assert!((moved[1][0] - wanted[0]).hypot(moved[1][1] - wanted[1]) < 1e-9);
        // Up by 25 pixels of 60/640 degrees: the sun sinks by as much.
        scene.photo.as_mut().unwrap().picks_px = moved;
        let sunk = sun.elevation_deg - picked_sun(&scene, folder).unwrap().position.elevation_deg;
        assert!((sunk - 2.4).abs() < 0.3, "{sunk}");
        let behind = turned_picks((&scene, folder), &[[0.0, 213.0]], [[0.9, 0.5], [-1e9, 0.5]]);
        assert!(matches!(behind, Err(Error::NoSun(_))));
        scene.photo = None;
        let none = turned_picks((&scene, folder), &[], [[0.0; 2]; 2]);
        assert!(matches!(none, Err(Error::NoSun(_))));
    }

    #[test]
    fn picks_that_are_off_give_the_nearest_bow_and_by_how_much_it_misses_them() {
        let (mut scene, folder) = pavilion();
        assert_eq!(scene.photo.as_ref().unwrap().misfit, None);
        let text = include_str!("../../../data/scenes/photo-pavilion-rain.toml");
        let off = text.replace("[440.0, 48.7]", "[440.0, 88.7]");
        assert_ne!(off, text);
        scene = scene_from_toml(&off, folder).unwrap();
        let misfit = scene.photo.as_ref().unwrap().misfit.as_ref().unwrap();
        assert!(
            misfit.contains("misses them by") && misfit.contains("straight line"),
            "{misfit}"
        );
        // A search over all places in steps of a twentieth of a degree finds 1.69 degrees with the sun 28.45 high.
        let nearest = picked_sun(&scene, folder).unwrap();
        assert!(
            (nearest.missed_deg - 1.69).abs() < 0.05,
            "{}",
            nearest.missed_deg
        );
        let elevation_deg = nearest.position.elevation_deg;
        assert!((elevation_deg - 28.45).abs() < 0.3, "{elevation_deg}");
        assert!((scene.sun.elevation_deg - elevation_deg).abs() < 1e-12);
        // Picks on one another tell nothing.
        let one = text.replace(
            "[440.0, 48.7], [620.0, 76.7]",
            "[200.0, 109.6], [200.0, 109.6]",
        );
        assert!(matches!(
            scene_from_toml(&one, folder),
            Err(Error::NoSun(_))
        ));
    }
}
