//! Scene files whose scenes change from frame to frame, and what is decided for all of their frames.

use std::path::Path;

use niji_exchange::FrameTime;
use niji_picture::Error;
use niji_picture::PlanRequest;
use niji_picture::PlannedScene;
use niji_picture::SequenceChoice;
use niji_picture::SequenceRequest;
use niji_picture::check_files;
use niji_scene::Effect;
use niji_scene::Scene;
use niji_scene::Sequence;
use niji_scene::Switch;
use niji_scene::canonical_json;

use crate::choice_file;
use crate::failure::Failure;
use crate::flags::Common;
use crate::frame_list::FrameList;
use crate::scene_file;
use crate::sequence_frames::SequenceFrames;
use crate::text_file;

/// Refuses a scene whose frames have a shutter where it is taken as it stands.
///
/// # Errors
/// What makes frames, and the key that leaves the shutter out.
pub(crate) fn refuse_shutter(path: &Path, scene: &Scene) -> Result<(), Failure> {
    let sequence = Sequence::from_toml(&text_file::read(path)?);
    let sequence = sequence.map_err(|error| Failure::bad_input(path, error))?;
    let has_shutter = sequence.is_some_and(|it| it.shutter.is_open());
    if !has_shutter || scene.effects.of(Effect::MotionBlur) == Switch::Off {
        return Ok(());
    }
    Err(Failure::Usage(format!(
        "{}: found sequence.shutter_deg, expected no shutter where stages are run one by one, which make no frames: \
         `niji run {0} --frames LIST -o DIR` makes them, effects.motion_blur = \"off\" leaves it out",
        path.display()
    )))
}

/// A scene file with a sequence.
pub(crate) struct SequenceFile<'a> {
    path: &'a Path,
    common: &'a Common,
    sequence: Sequence,
}

impl<'a> SequenceFile<'a> {
    /// Reads one.
    ///
    /// # Errors
    /// A scene that is missing or wrong, or one in which nothing changes.
    pub(crate) fn read(path: &'a Path, common: &'a Common) -> Result<Self, Failure> {
        let sequence = Sequence::from_toml(&text_file::read(path)?);
        let sequence = sequence.map_err(|error| Failure::bad_input(path, error))?;
        let sequence = sequence.ok_or_else(|| {
            Failure::Usage(format!(
                "nothing changes from frame to frame in {}: give it a section [sequence], say \
                 sun.elevation_deg = [[1, 10.0], [240, 20.0]], or a drop file named \"spray.####.vdb\"",
                path.display()
            ))
        })?;
        Ok(Self {
            path,
            common,
            sequence,
        })
    }

    /// The scene of a frame.
    ///
    /// # Errors
    /// What is wrong with it, with its number.
    pub(crate) fn scene(&self, number: u32) -> Result<Scene, Failure> {
        let scene = self.scene_beside(number, 0.0);
        scene.map_err(|failure| failure.within(&format!("frame {number}")))
    }

    /// The scene so many frames after one.
    fn scene_beside(&self, number: u32, after: f64) -> Result<Scene, Failure> {
        let text = self.sequence.scene_text_beside(number, after);
        scene_file::frame_scene(&text, self.path, self.common)
    }

    /// Scenes while the shutter of a frame is open.
    fn scenes_beside(&self, number: u32, after: &[f64]) -> Result<Vec<Scene>, Failure> {
        let scenes = after.iter().map(|after| self.scene_beside(number, *after));
        let scenes = scenes.collect::<Result<_, _>>();
        scenes.map_err(|failure: Failure| {
            failure.within(&format!("frame {number}, while its shutter is open"))
        })
    }

    /// A frame as it was decided.
    ///
    /// # Errors
    /// As [`Self::scene`].
    pub(crate) fn frame(
        &self,
        number: u32,
        choice: &SequenceChoice,
    ) -> Result<PlannedScene, Failure> {
        let time = FrameTime {
            frame: number,
            frames_per_second: self.sequence.frames_per_second,
        };
        let instants = choice.instants(self.sequence.shutter);
        let instants = self.scenes_beside(number, &instants)?;
        let frame = (self.scene(number)?, time, instants);
        Ok(PlannedScene::of_frame(frame, self.request().folder, choice))
    }

    /// Refuses frames of which something is wrong or missing, the last before the first is made.
    ///
    /// # Errors
    /// As [`Self::scene`]; a file that is missing.
    pub(crate) fn check(&self, numbers: &FrameList) -> Result<(), Failure> {
        let shutter = self.sequence.shutter;
        numbers.iter().try_for_each(|number| {
            if shutter.is_open() {
                self.scenes_beside(number, &shutter.ends())?;
            }
            let found = check_files(&self.scene(number)?, self.request().folder);
            found.map_err(|error| Failure::from(error).within(&format!("frame {number}")))
        })
    }

    /// What is decided for all frames: as --choice says, as it was decided before, or anew.
    ///
    /// # Errors
    /// A choice for something else; a frame that is looked at and cannot be planned.
    pub(crate) fn choice(&self, before: Option<SequenceChoice>) -> Result<SequenceChoice, Failure> {
        if let Some(file) = &self.common.choice {
            let choice: SequenceChoice = choice_file::read(file)?;
            let mut flags = self.common.picture_flags();
            flags.extend(["--frames", "LIST"].map(str::to_owned));
            let of = (file.as_path(), self.path, flags.as_slice());
            scene_file::check_version(&choice.version, of)?;
            if choice.request == self.key(&choice.frames)? {
                return Ok(choice);
            }
            return Err(scene_file::refused(
                "for another scene or other accuracy",
                of,
            ));
        }
        let frames = SequenceFrames::of(&self.sequence, self.request().folder);
        let looked_at = frames.to_look_at();
        // Of volumes those with the smallest and largest drops were looked at too.
        let has_looked =
            |before: &SequenceChoice| looked_at.iter().all(|it| before.frames.contains(it));
        if let Some(before) = before.filter(has_looked)
            && before.request == self.key(&before.frames)?
        {
            return Ok(before);
        }
        let between = self.scenes(&frames.between())?;
        self.asked(&looked_at, |request| request.decide(&between))
    }

    /// Frames with their numbers.
    fn scenes(&self, numbers: &[u32]) -> Result<Vec<(u32, Scene)>, Failure> {
        let scenes = numbers.iter().map(|it| Ok((*it, self.scene(*it)?)));
        scenes.collect()
    }

    fn request(&self) -> PlanRequest<'_> {
        scene_file::beside(self.path)
    }

    /// What a choice has as its request that looked at these frames.
    #[expect(
        clippy::redundant_closure_for_method_calls,
        reason = "a path has one lifetime"
    )]
    fn key(&self, frames: &[u32]) -> Result<String, Failure> {
        self.asked(frames, |request| request.key())
    }

    /// What is asked of these frames.
    fn asked<T>(
        &self,
        frames: &[u32],
        ask: impl FnOnce(&SequenceRequest) -> Result<T, niji_picture::Error>,
    ) -> Result<T, Failure> {
        let scenes = self.scenes(frames)?;
        let goal = self.common.goal();
        let settings = (self.sequence.settings(), goal.preset, goal.tolerance);
        let request = SequenceRequest {
            plan: self.request(),
            settings: &canonical_json(&settings),
            frames: &scenes,
            shutter: self.sequence.shutter,
            beside: &|number, after| {
                let scene = self.scene_beside(number, after);
                scene.map_err(|failure| Error::Scene(failure.to_string()))
            },
        };
        ask(&request).map_err(|error| scene_file::unplannable(self.path, error))
    }
}
