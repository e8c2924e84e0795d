//! Where the sun stands by pixels of a photograph where a bow is or should be.

use std::path::Path;

use niji_geometry::PinholeCamera;
use niji_photo::Finding;
use niji_photo::FitRequest;
use niji_photo::PickedEdge;
use niji_photo::SunSolution;
use niji_photo::Verdict;
use niji_photo::diagnose_picks;
use niji_photo::sun_from_picks;
use niji_scene::Scene;
use niji_scene::SunPosition;

use crate::bow_edge::BowEdge;
use crate::bow_edge::EDGE_ERROR;
use crate::error::Error;
use crate::photo_depth::photo_camera;
use crate::photo_depth::pinhole;
use crate::photo_depth::read_photo;
use crate::sandbox::Sandbox;

/// Standard error of a pick, pixels.
pub const PICK_ERROR_PX: f64 = 1.0;

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
        Ok(PickedSuns {
            solutions,
            findings,
        })
    }
}

impl PickedSuns {
    /// The first place against which nothing speaks.
    ///
    /// # Errors
    /// [`Error::NoSun`] if there is none.
    pub fn best(&self) -> Result<SunPosition, Error> {
        let possible = |solution: &&SunSolution| solution.verdict == Verdict::Possible;
        let Some(best) = self.solutions.iter().find(possible) else {
            let first = self.findings.first();
            let reason = first.map_or(
                "no place of the sun gives a bow through these picks",
                |finding| &finding.reason,
            );
            return Err(Error::NoSun(reason.to_owned()));
        };
        Ok(SunPosition {
            elevation_deg: best.elevation.to_degrees(),
            azimuth_deg: best.azimuth.to_degrees(),
        })
    }
}

/// Reads a scene from TOML; where it says no sun, that follows from the picks in its photograph, which lies
/// in `folder`.
///
/// # Errors
/// The first thing that is wrong with the scene; a photograph that cannot be read; picks that no sun explains.
pub fn scene_from_toml(text: &str, folder: &Path) -> Result<Scene, Error> {
    Sandbox::default().scene_from_toml(text, folder)
}

/// The sun by picks in the photograph of a scene.
pub(crate) fn picked_sun(scene: &Scene, folder: &Path) -> Result<SunPosition, Error> {
    let section = scene.photo.as_ref();
    let section = section.ok_or_else(|| Error::NoSun("no photograph to pick in".to_owned()))?;
    let photo = read_photo(&folder.join(&section.picture))?;
    let edge = BowEdge {
        bow: section.bow,
        color: section.edge,
        water: scene.water(),
    };
    let request = PicksRequest {
        camera: &pinhole(photo_camera(&scene.camera, &photo))?,
        picks_px: &section.picks_px,
        noise_px: PICK_ERROR_PX,
        edge: edge.picked(edge.angle(), EDGE_ERROR),
        is_angle_known: true,
    };
    request.suns()?.best()
}
