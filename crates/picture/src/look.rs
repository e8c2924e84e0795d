//! A scene looked at while it is worked on: by few pixels and wavelengths, from coarse tables, at once.
//!
//! What is decided for a look holds as long as nothing but the sun, the view and how the picture is shown change: its
//! table is of all angles. Light that drops scatter more than once is left to the picture itself.

use niji_render::Integration;
use niji_render::PixelFootprint;
use niji_scene::Accuracy;
use niji_scene::Effect;
use niji_scene::Picture;
use niji_scene::Preset;
use niji_scene::Scene;
use niji_scene::Switch;
use niji_scene::canonical_json;

use crate::error::Error;
use crate::kept_parts::photograph_of;
use crate::planned_scene::PlanRequest;
use crate::planned_scene::PlannedScene;

/// Effects that any view of drops may show, and of air.
const OF_DROPS: [Effect; 7] = [
    Effect::PrimaryBow,
    Effect::SecondaryBow,
    Effect::Supernumeraries,
    Effect::SizeSpread,
    Effect::SunDisc,
    Effect::DropExtinction,
    Effect::DropShadow,
];
const OF_AIR: [Effect; 5] = [
    Effect::SunlightThroughAir,
    Effect::AirExtinction,
    Effect::AirInscatter,
    Effect::SkylitDrops,
    Effect::Sky,
];

/// How finely a scene is looked at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Look {
    /// In a fraction of a second: where the bow stands, and its colors about.
    First,
    /// In a second.
    Finer,
}

impl Look {
    /// Columns at most, wavelengths at most, and the relative error of the table.
    fn sizes(self) -> (u32, usize, f64) {
        match self {
            Self::First => (144, 9, 0.1),
            Self::Finer => (320, 13, 0.02),
        }
    }

    /// The scene as it is looked at.
    #[must_use]
    pub fn scene(self, scene: &Scene) -> Scene {
        let (width_px, n_wavelengths, table_error) = self.sizes();
        let mut looked = scene.clone();
        // A map of distances has the pixels of its picture.
        let has_map = scene
            .occluders
            .as_ref()
            .is_some_and(|it| it.depth.is_some());
        if !has_map {
            looked.camera = scene.camera.no_wider_than(width_px);
        }
        looked.spectrum = scene.spectrum.in_wider_bins(n_wavelengths);
        looked.accuracy = Accuracy {
            preset: Preset::Draft,
            theory: scene.accuracy.theory,
            sky: scene.accuracy.sky,
            mirrored_light: scene.accuracy.mirrored_light,
            table_relative_error: Some(table_error),
            integration: Some(Integration::CellExact),
            pixel_footprint: Some(PixelFootprint::Center),
            ..Accuracy::default()
        };
        looked.effects.set(Effect::MultipleScattering, Switch::Off);
        // What another view shows may not be in this one.
        let of_air = scene.air.iter().flat_map(|_| OF_AIR);
        // A photograph holds the light of its air.
        let of_air = of_air.filter(|it| scene.photo.is_none() || !it.is_in_photographs());
        for effect in OF_DROPS.into_iter().chain(of_air) {
            if scene.effects.of(effect) == Switch::Auto {
                looked.effects.set(effect, Switch::On);
            }
        }
        looked
    }
}

/// What was decided for looks at a scene, as long as it holds.
#[derive(Default)]
pub struct Looks {
    decided: Vec<(Look, String, PlannedScene)>,
}

impl Looks {
    /// A scene planned for a look, without measuring anything.
    ///
    /// # Errors
    /// As [`PlannedScene::new`].
    pub fn planned(
        &mut self,
        scene: &Scene,
        look: Look,
        request: PlanRequest,
    ) -> Result<PlannedScene, Error> {
        scene.check()?;
        let scene = look.scene(scene);
        let key = decided_by(&scene);
        let known = self.decided.iter().find(|it| it.0 == look && it.1 == key);
        if let Some((_, _, planned)) = known {
            return Ok(planned.moved_to(scene));
        }
        let request = PlanRequest {
            is_hasty: true,
            ..request
        };
        let mut planned = PlannedScene::of_checked(scene.clone(), request)?;
        if let Some(need) = &mut planned.plan.scattering {
            need.theta_range_rad = (0.0, std::f64::consts::PI);
        }
        self.decided.retain(|it| it.0 != look);
        let looked = planned.moved_to(scene);
        // Where no drops are in view it says nothing of their table.
        if planned.plan.scattering.is_some() {
            self.decided.push((look, key, planned));
        }
        Ok(looked)
    }
}

/// All of a scene that its effects, sizes and tables depend on, but for where it is seen from and lit.
fn decided_by(scene: &Scene) -> String {
    let light = (scene.sun.body, scene.sun.phase_angle_deg);
    let Scene {
        spectrum,
        drops,
        water,
        water_surface,
        drop_motion,
        air,
        ground,
        effects,
        accuracy,
        occluders,
        terrain,
        ..
    } = scene;
    let surfaces = (occluders, terrain, photograph_of(scene));
    let of_drops = (drops, water, drop_motion, water_surface);
    canonical_json(&(
        light, spectrum, of_drops, air, ground, effects, accuracy, surfaces,
    ))
}

/// Whether two scenes differ in nothing that is rendered.
#[must_use]
pub fn have_same_light(one: &Scene, other: &Scene) -> bool {
    let shown = |scene: &Scene| Scene {
        name: String::new(),
        description: String::new(),
        picture: Picture::default(),
        ..scene.clone()
    };
    shown(one) == shown(other)
}

#[cfg(test)]
mod tests {
    use std::ops::ControlFlow;
    use std::path::Path;

    use super::*;
    use crate::kept_parts::KeptParts;
    use crate::picture::PictureSettings;
    use crate::picture::PictureWork;
    use crate::watch::unwatched;

    fn scene(name: &str) -> Scene {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data/scenes");
        let text = std::fs::read_to_string(folder.join(name)).unwrap();
        let mut scene = Scene::from_toml(&text).unwrap();
        scene.camera = scene.camera.no_wider_than(24);
        scene
    }

    /// Luminance of a first look, all pixels together.
    fn light(scene: &Scene, (looks, kept): (&mut Looks, &mut KeptParts)) -> f64 {
        let planned = looks.planned(scene, Look::First, PlanRequest::default());
        let planned = planned.unwrap();
        let parts = kept.parts(&planned, ("", None), &unwatched).unwrap();
        let settings = PictureSettings::of(&planned);
        let whole = settings.whole().unwrap();
        let work = PictureWork::new(settings, parts, &unwatched).unwrap();
        let image = work.render(whole, &unwatched).unwrap();
        niji_exchange::luminance(&image.radiance, &image.wavelengths).sum()
    }

    #[test]
    fn scenes_of_every_kind_can_be_looked_at() {
        for name in [
            "paper-c-figure-3.toml",
            "rain-5-mm-h-flattened.toml",
            "fog-bank-fogbow.toml",
            "garden-fountain.toml",
            "moonbow.toml",
            "panorama-rain.toml",
            "reflection-bow.toml",
            "twinned-bow.toml",
            "clear-sky.toml",
        ] {
            let light = light(
                &scene(name),
                (&mut Looks::default(), &mut KeptParts::default()),
            );
            assert!(light > 0.0 && light.is_finite(), "{name} {light}");
        }
    }

    #[test]
    fn another_sun_needs_no_other_parts_and_other_drops_do() {
        let (mut looks, mut kept) = (Looks::default(), KeptParts::default());
        let mut scene = scene("rain-5-mm-h-flattened.toml");
        let before = light(&scene, (&mut looks, &mut kept));
        let stopped = |_, _| ControlFlow::Break(());
        let mut parts = |scene: &Scene| {
            let planned = looks.planned(scene, Look::First, PlanRequest::default());
            kept.parts(&planned.unwrap(), ("", None), &stopped)
                .map(|_| ())
        };
        scene.sun.elevation_deg = 35.0;
        scene.camera.azimuth_deg = 40.0;
        assert!(parts(&scene).is_ok());
        let mut warmer = scene.clone();
        warmer.water.temperature_c = 30.0;
        assert!(matches!(parts(&warmer), Err(Error::Stopped)));
        assert!(light(&scene, (&mut looks, &mut kept)) != before);
    }

    #[test]
    fn a_bow_that_comes_into_view_is_seen() {
        let (mut looks, mut kept) = (Looks::default(), KeptParts::default());
        let mut scene = scene("paper-c-figure-3.toml");
        let seen = light(&scene, (&mut Looks::default(), &mut KeptParts::default()));
        let azimuth_deg = scene.camera.azimuth_deg;
        scene.camera.azimuth_deg += 180.0;
        let away = light(&scene, (&mut looks, &mut kept));
        scene.camera.azimuth_deg = azimuth_deg;
        let back = light(&scene, (&mut looks, &mut kept));
        assert!(away < 0.1 * seen, "{away} {seen}");
        assert!((back / seen - 1.0).abs() < 1e-3, "{back} {seen}");
    }
}
