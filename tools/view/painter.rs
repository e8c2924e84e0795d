//! Pictures of the scene as it is: coarse at once, then finer, and as `niji run` makes it when the hand rests.
//!
//! A newer change ends what is being made. What it does not touch is kept in memory ([`KeptParts`], [`Looks`]).

use std::ops::ControlFlow;
use std::path::Path;
use std::time::Duration;
use std::time::Instant;

use niji_exchange::LayerRms;
use niji_picture::Error;
use niji_picture::KeptParts;
use niji_picture::Look;
use niji_picture::Looks;
use niji_picture::PictureSettings;
use niji_picture::PictureWork;
use niji_picture::PlanRequest;
use niji_picture::PlannedScene;
use niji_picture::Scene;
use niji_picture::Watch;
use niji_scene::Plan;
use niji_scene::Stage;
use niji_scene::canonical_json;
use serde_json::Value;
use serde_json::json;

use super::desk::Desk;
use super::desk::Job;
use super::picture::Picture;
use crate::checksums::hash_once;
use crate::failure::Failure;
use crate::scene_file;
use crate::stages::accuracy;

/// How long a hand rests before the picture itself is made.
const REST: Duration = Duration::from_millis(300);

/// A picture on the way to the last one.
#[derive(Clone, Copy)]
enum Level {
    Look(Look),
    /// As `niji run` makes it.
    Full,
}

impl Level {
    fn name(self) -> &'static str {
        match self {
            Self::Look(Look::First) => "first look",
            Self::Look(Look::Finer) => "finer look",
            Self::Full => "picture",
        }
    }
}

/// Whoever makes the pictures.
pub(super) struct Painter<'a> {
    desk: &'a Desk,
    path: &'a Path,
    kept: KeptParts,
    looks: Looks,
    n_pictures: u64,
}

impl<'a> Painter<'a> {
    pub(super) fn new(desk: &'a Desk, path: &'a Path) -> Self {
        Self {
            desk,
            path,
            kept: KeptParts::default(),
            looks: Looks::default(),
            n_pictures: 0,
        }
    }

    /// Paints whatever is wanted, for ever.
    pub(super) fn paint(mut self) -> ! {
        let mut done = 0;
        loop {
            let job = self.desk.job(done);
            done = job.revision;
            if let Err(error) = self.paint_job(&job)
                && !matches!(error, Error::Stopped)
            {
                self.desk.say(Failure::from(error).to_string());
            }
        }
    }

    fn paint_job(&mut self, job: &Job) -> Result<(), Error> {
        let start = Instant::now();
        for level in [
            Level::Look(Look::First),
            Level::Look(Look::Finer),
            Level::Full,
        ] {
            if matches!(level, Level::Full) && !self.desk.rests(job.revision, REST) {
                return Ok(());
            }
            match (self.paint_level(job, level, start), level) {
                // What is wrong with a look is wrong with the picture, or with the look alone.
                (Err(error), Level::Look(_)) if !matches!(error, Error::Stopped) => (),
                (painted, _) => painted?,
            }
        }
        Ok(())
    }

    fn paint_level(&mut self, job: &Job, level: Level, start: Instant) -> Result<(), Error> {
        let (desk, revision, name) = (self.desk, job.revision, level.name());
        let go_on = || {
            if desk.is_stale(revision) {
                ControlFlow::Break(())
            } else {
                ControlFlow::Continue(())
            }
        };
        let watch = |stage: Stage, part: f64| {
            desk.hear(
                match stage {
                    Stage::Render => name,
                    _ => "tables",
                },
                part,
            );
            go_on()
        };
        desk.hear("plan", 0.0);
        let measuring = |_, _| go_on();
        let planned = self.planned(&job.scene, (level, &measuring))?;
        if go_on().is_break() {
            return Err(Error::Stopped);
        }
        let files = files(&job.scene, self.path)?;
        let of_photograph = (files.as_str(), job.scene.camera.width_px);
        let photograph = self.kept.photograph(&planned, of_photograph)?;
        let photograph = photograph.as_deref();
        let parts = (self.kept).parts(&planned, (&files, photograph), &watch)?;
        let settings = PictureSettings::of(&planned);
        let whole = settings.whole()?;
        let work = PictureWork::new(settings, parts, &watch)?;
        // A sequence, whose shutter could be open, is not shown.
        let (image, drops) = work.render_with_drops(whole, &watch)?;
        let in_photograph = photograph
            .zip(planned.scene.photo.as_ref())
            .map(|(it, section)| it.shown(&image, section));
        self.n_pictures += 1;
        let is_finished = matches!(level, Level::Full);
        let layers = is_finished.then(|| image.aovs.iter().map(LayerRms::of).collect::<Vec<_>>());
        let reached = layers.map(|it| accuracy::reached_by(&planned.plan, &it));
        let picture = Picture {
            number: self.n_pictures,
            revision,
            level: name,
            is_finished,
            time: start.elapsed(),
            display_white_cd_m2: planned.plan.display_white_cd_m2,
            error_of_white: reached.flatten().map(|it| it.error),
            scene: planned.scene,
            in_photograph: in_photograph.transpose()?,
            image,
            drops,
        };
        let plan = is_finished.then(|| told(&planned.plan));
        desk.show(picture, plan);
        Ok(())
    }

    fn planned(
        &mut self,
        scene: &Scene,
        (level, watch): (Level, Watch),
    ) -> Result<PlannedScene, Error> {
        let request = PlanRequest {
            watch,
            ..scene_file::beside(self.path)
        };
        match level {
            Level::Look(look) => self.looks.planned(scene, look, request),
            Level::Full => {
                let planned = PlannedScene::new(scene.clone(), request)?;
                planned.check()?;
                Ok(planned)
            }
        }
    }
}

/// What the files hold that a scene names.
fn files(scene: &Scene, path: &Path) -> Result<String, Error> {
    let folder = scene_file::beside(path).folder;
    let hashes = scene.files().into_iter().map(|file| {
        let path = folder.join(file);
        let hash = hash_once(&path).map_err(|error| Error::File {
            path,
            message: error.to_string(),
        })?;
        Ok((file, hash))
    });
    Ok(canonical_json(&hashes.collect::<Result<Vec<_>, Error>>()?))
}

/// What was decided, for people: the effects with what each contributes at most.
fn told(plan: &Plan) -> Value {
    let effects = plan.effects.iter().map(|it| {
        json!({
            "effect": it.effect.name(),
            "asked": it.asked,
            "on": it.on,
            "is_left_out": it.is_left_out,
            "most_of_white": it.bound.value,
            "reason": it.reason,
        })
    });
    json!({
        "effects": effects.collect::<Vec<_>>(),
        "warnings": plan.warnings,
        "tolerance": plan.tolerance,
    })
}
