//! What is decided once for all frames of a sequence, so that nothing jumps from one to the next and any of them has
//! the same bytes made alone.
//!
//! A few frames are looked at: an effect that any of them shows is on in all, the finest level that any of them needs
//! is that of all, and what they err by beside what is estimated is the largest of theirs in every place. Where each
//! frame has a volume of drops of its own, those with the smallest and largest drops and with the densest are looked at
//! too. Where a shutter is open, the ends of its time are looked at with them. Densities that are told by an optical depth have one factor:
//! k = s k_1 / l,   l the largest of max_line(sum_line(d) h) in the frames that are looked at
//! `s` scale of the scene, `d` values of the grid, `h` its voxel, `k` extinction at Q = 2 where the grid says 1.

use std::collections::BTreeMap;
use std::collections::BTreeSet;

use niji_dropfield::DensityMeans;
use niji_dropfield::DropVolume;
use niji_exchange::Provenance;
use niji_scene::Blur;
use niji_scene::DropSource;
use niji_scene::DropSpacing;
use niji_scene::DropSummary;
use niji_scene::Effect;
use niji_scene::FromVdb;
use niji_scene::Plan;
use niji_scene::PlannedFrame;
use niji_scene::Scene;
use niji_scene::Shutter;
use niji_scene::Switch;
use serde::Deserialize;
use serde::Serialize;

use crate::drop_volume::VolumePart;
use crate::error::Error;
use crate::kept_parts::KeptParts;
use crate::pilot::Seen;
use crate::pilot::motion;
use crate::pilot::motion::MovingFrame;
use crate::planned_scene::PlanRequest;
use crate::planned_scene::PlannedScene;
use crate::planned_scene::drop_hashes;
use crate::planned_scene::drops_of;

/// What was decided for a sequence.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SequenceChoice {
    /// The program that decided, as far as it decides on results.
    pub version: String,
    /// Hash of the sequence with what is asked of its pictures, of the files of the frames that were looked at, and of
    /// the program.
    pub request: String,
    /// The frames that were looked at.
    pub frames: Vec<u32>,
    /// For each population of drops, values of its density along its densest line (m); 0 where they do not matter.
    pub(crate) densest_lines_m: Vec<f64>,
    /// What all frames call for.
    pub plan: Plan,
    /// What was measured for it.
    pub(crate) seen: Seen,
}

/// A sequence to decide on.
pub struct SequenceRequest<'a> {
    /// How its frames are planned.
    pub plan: PlanRequest<'a>,
    /// All that is written of it and asked of its pictures.
    pub settings: &'a str,
    /// The frames to look at, with their numbers.
    pub frames: &'a [(u32, Scene)],
    /// How long of each frame its shutter is open.
    pub shutter: Shutter,
    /// The scene so many frames after one.
    pub beside: &'a dyn Fn(u32, f64) -> Result<Scene, Error>,
}

impl SequenceChoice {
    /// The instants of a frame over which it is the mean, in frames after it; none where it is seen at once.
    #[must_use]
    pub fn instants(&self, shutter: Shutter) -> Vec<f64> {
        let n_instants = self.plan.levels.shutter_instants;
        n_instants.map_or_else(Vec::new, |n| shutter.instants(n))
    }
}

impl SequenceRequest<'_> {
    /// What a choice has as its request if it is of this sequence.
    ///
    /// # Errors
    /// A file of drops that is missing.
    pub fn key(&self) -> Result<String, Error> {
        let mut inputs = BTreeMap::new();
        for (number, scene) in self.frames {
            let hashes = drop_hashes(scene, self.plan)?.into_iter();
            inputs.extend(hashes.map(|(role, hash)| (format!("{role} {number}"), hash)));
        }
        let provenance = Provenance {
            version: self.plan.version.to_owned(),
            settings: self.settings.to_owned(),
            inputs,
            ..Provenance::default()
        };
        Ok(provenance.request_hash())
    }

    /// Decides; `between` are more frames, whose angles and drops the scattering table has to hold.
    ///
    /// # Errors
    /// As [`PlannedScene::new`]; [`Error::NoFrameWithDrops`].
    pub fn decide(&self, between: &[(u32, Scene)]) -> Result<SequenceChoice, Error> {
        let mut frames = self.frames.to_vec();
        frames.extend(self.extremes(between)?);
        frames.sort_by_key(|(number, _)| *number);
        let looking = SequenceRequest {
            frames: &frames,
            ..*self
        };
        let mut moved = Vec::new();
        for (number, scene) in between.iter().filter(|it| self.follows_shutter(&it.1)) {
            for after in self.shutter.ends() {
                let end = (self.beside)(*number, after);
                let end = end.map_err(|error| Error::Frame(*number, Box::new(error)))?;
                moved.extend((end != *scene).then_some(end));
            }
        }
        looking.decide_on(between.iter().map(|(_, scene)| scene).chain(&moved))
    }

    /// Whether a scene may be seen over the time that a shutter is open.
    fn follows_shutter(&self, scene: &Scene) -> bool {
        self.shutter.is_open() && scene.effects.of(Effect::MotionBlur) != Switch::Off
    }

    /// What the shutter changes in any of the frames that are looked at.
    fn blur(
        &self,
        frames: &[PlannedFrame],
        (plan, densest_lines_m): (&Plan, &[f64]),
    ) -> Result<Blur, Error> {
        let (mut blur, mut kept) = (Blur::NONE, KeptParts::default());
        for PlannedFrame { number, scene, .. } in frames {
            let beside = |after| Ok(with_scales((self.beside)(*number, after)?, densest_lines_m));
            let moving = MovingFrame {
                scene,
                beside: &beside,
                shutter: self.shutter,
            };
            let own = motion::blur(&moving, (plan, self.plan), &mut kept);
            blur = blur.or_more(own.map_err(|error| Error::Frame(*number, Box::new(error)))?);
        }
        Ok(blur)
    }

    /// Those of some frames with the smallest and largest drops and the densest, where frames have volumes of their
    /// own that are not looked at.
    fn extremes(&self, between: &[(u32, Scene)]) -> Result<Vec<(u32, Scene)>, Error> {
        let mut known: BTreeSet<&str> = self.frames.iter().flat_map(|it| volumes(&it.1)).collect();
        let request = PlanRequest {
            is_frame: true,
            ..self.plan
        };
        let mut found = Vec::new();
        for frame in between {
            let new: Vec<&str> = volumes(&frame.1).collect();
            if new.iter().all(|file| known.contains(file)) {
                continue;
            }
            known.extend(new);
            let drops = drops_of(&frame.1, request);
            let drops = drops.map_err(|error| Error::Frame(frame.0, Box::new(error)))?;
            found.extend(drops.map(|drops| (frame, drops.summary)));
        }
        let figures: [fn(&DropSummary) -> f64; 3] = [
            |drops| -drops.effective_radius_um.0,
            |drops| drops.effective_radius_um.1,
            |drops| drops.max_extinction_m1_q1,
        ];
        let most = figures.map(|figure| {
            let size = |it: &&(&(u32, Scene), DropSummary)| figure(&it.1);
            // Of equal ones the first.
            let frames = found.iter().rev();
            frames.max_by(|a, b| size(a).total_cmp(&size(b)))
        });
        // One frame may be several of them.
        let most: BTreeMap<u32, Scene> = (most.into_iter().flatten())
            .map(|(frame, _)| (*frame).clone())
            .collect();
        Ok(most.into_iter().collect())
    }

    fn decide_on<'a>(
        &self,
        between: impl Iterator<Item = &'a Scene>,
    ) -> Result<SequenceChoice, Error> {
        let request = PlanRequest {
            is_frame: true,
            ..self.plan
        };
        let scenes = || self.frames.iter().map(|(_, scene)| scene);
        let densest_lines_m = densest_lines_m(scenes(), request)?;
        let (mut frames, mut seen) = (Vec::new(), None::<Seen>);
        for (number, scene) in self.frames {
            let in_frame = |error| Error::Frame(*number, Box::new(error));
            let scene = with_scales(scene.clone(), &densest_lines_m);
            // What grows from nothing has frames without drops.
            let Some(drops) = drops_of(&scene, request).map_err(in_frame)? else {
                continue;
            };
            let summary = drops.summary.clone();
            let own = PlannedScene::of_drops(scene, request, drops).map_err(in_frame)?;
            seen = Some(match seen {
                Some(seen) => seen.or_more(&own.choice.seen),
                None => own.choice.seen.clone(),
            });
            frames.push((*number, own, summary));
        }
        let seen = seen.unwrap_or_default();
        let at_spacing = |(number, own, drops): (u32, PlannedScene, DropSummary)| {
            let own = own.at_spacing(seen.spacing(), request)?;
            // Files were read once; closer nodes are those of shapes.
            let drops = match seen.spacing() {
                DropSpacing::AsGiven => drops,
                DropSpacing::Halved => {
                    drops_of(&own.scene, request)?.map_or(drops, |it| it.summary)
                }
            };
            Ok(PlannedFrame {
                number,
                scene: own.scene,
                drops,
                plan: own.plan,
            })
        };
        let planned = frames.into_iter().map(at_spacing);
        let planned: Vec<PlannedFrame> = planned.collect::<Result<_, Error>>()?;
        let numbers = || self.frames.iter().map(|(number, _)| *number);
        let no_drops = || Error::NoFrameWithDrops(numbers().collect());
        let (first, others) = planned.split_first().ok_or_else(no_drops)?;
        let mut plan = Plan::of_sequence((first, others), seen.bright_drops, between)?;
        if let Some(sky) = &seen.sky {
            plan.sky_level = Some(sky.level);
        }
        if self.shutter.is_open() {
            let blur = if self.follows_shutter(&first.scene) {
                self.blur(&planned, (&plan, &densest_lines_m))?
            } else {
                Blur::NONE
            };
            plan = plan.with_shutter(&first.scene, (self.shutter, blur));
        }
        Ok(SequenceChoice {
            version: request.version.to_owned(),
            request: self.key()?,
            frames: numbers().collect(),
            densest_lines_m,
            plan,
            seen,
        })
    }
}

/// The files of drops whose sizes are their own.
fn volumes(scene: &Scene) -> impl Iterator<Item = &str> {
    let populations = scene.drops.populations().iter();
    populations.filter_map(|it| match &it.source {
        DropSource::File(drops) => Some(drops.file.as_str()),
        DropSource::FromVdb(_) | DropSource::Shape(_) => None,
    })
}

/// A scene whose optical depths are those of its sequence, whatever its own frame holds.
pub(crate) fn with_scales(mut scene: Scene, densest_lines_m: &[f64]) -> Scene {
    scene.drops = scene.drops.with_sources(|place, source| {
        let line_m = densest_lines_m.get(place).filter(|line_m| **line_m > 0.0);
        match (source, line_m) {
            (DropSource::FromVdb(density), Some(line_m)) => DropSource::FromVdb(FromVdb {
                density_means: DensityMeans::Extinction,
                scale: density.scale / line_m,
                ..density
            }),
            (source, _) => source,
        }
    });
    scene
}

/// Values of densities along the densest line in any of some frames (m), for each population.
fn densest_lines_m<'a>(
    scenes: impl Iterator<Item = &'a Scene>,
    request: PlanRequest,
) -> Result<Vec<f64>, Error> {
    let mut lines_m = Vec::new();
    for scene in scenes {
        let populations = scene.drops.populations();
        lines_m.resize(populations.len(), 0.0_f64);
        for (line_m, population) in lines_m.iter_mut().zip(populations) {
            let DropSource::FromVdb(density) = &population.source else {
                continue;
            };
            if density.density_means == DensityMeans::OpticalDepth {
                *line_m = line_m.max(densest_line_m(density, request)?);
            }
        }
    }
    Ok(lines_m)
}

fn densest_line_m(density: &FromVdb, request: PlanRequest) -> Result<f64, Error> {
    // Where the extinction at Q = 2 is what the grid says, depths are sums along its lines.
    let as_extinction = FromVdb {
        density_means: DensityMeans::Extinction,
        scale: 1.0,
        ..density.clone()
    };
    let part = VolumePart::of(&DropSource::FromVdb(as_extinction), request.folder);
    let volume: DropVolume = part.volume()?;
    let depths = volume.summary().optical_depth_q1;
    Ok(2.0 * depths.into_iter().fold(0.0, f64::max))
}
