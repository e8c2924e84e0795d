//! A frame over the time its shutter is open: which pictures it is the mean of.
//!
//! Each is the scene at an instant, with the tables, levels and effects of the frame. From one to the next only what moves
//! is made anew: drops are laid out where they change, lit where they or the sun do, the air tabulated where it does. Where
//! nothing moves a picture stands for the next one too. A depth image stays that of the frame, pixel by pixel.

use std::sync::Arc;

use niji_exchange::SpectralImage;
use niji_scene::Scene;
use serde::Serialize;
use serde::Serializer;

use crate::error::Error;
use crate::mean_of_instants::MeanOfInstants;
use crate::picture::PictureSettings;
use crate::picture::PictureWork;
use crate::planned_scene::PlannedScene;
use crate::watch::Watch;

/// A frame at the instants over which it is the mean, in the order of time.
#[derive(Clone, Debug)]
pub struct OpenShutter {
    frame: Arc<PlannedScene>,
    instants: Arc<[PlannedScene]>,
}

impl OpenShutter {
    /// Of a frame that is planned, at the scenes of its instants.
    pub(crate) fn new(frame: &PlannedScene, scenes: Vec<Scene>) -> Self {
        let instants = scenes.into_iter().map(|scene| frame.moved_to(scene));
        Self {
            instants: instants.collect(),
            frame: Arc::new(frame.clone()),
        }
    }

    /// How many instants there are.
    #[must_use]
    pub fn n_instants(&self) -> usize {
        self.instants.len()
    }

    fn scenes(&self) -> impl Iterator<Item = &Scene> {
        self.instants.iter().map(|it| &it.scene)
    }
}

impl Serialize for OpenShutter {
    /// First and last scene: values between follow from these and from the frame's own, whose key they may have.
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let [first, last] = [self.scenes().next(), self.scenes().last()];
        [first, last].serialize(serializer)
    }
}

impl PictureSettings {
    /// How many pictures it is the mean of.
    pub fn n_pictures(&self) -> u64 {
        self.shutter.as_ref().map_or(1, |it| {
            let scenes: Vec<&Scene> = it.scenes().collect();
            1 + scenes.windows(2).filter(|pair| pair[0] != pair[1]).count() as u64
        })
    }
}

impl PictureWork {
    /// The mean of pictures that `render` makes, each told by its place among the instants; where there is no shutter the
    /// only one. It keeps as much of its spectra as the scene says ([`Self::keeping`]).
    ///
    /// # Errors
    /// As [`PictureWork::new`]; what `render` reports.
    pub fn over_shutter<E: From<Error>>(
        self,
        watch: Watch,
        mut render: impl FnMut(&Self, usize) -> Result<SpectralImage, E>,
    ) -> Result<SpectralImage, E> {
        let Some(OpenShutter { frame, instants }) = self.settings().shutter.clone() else {
            return Ok(self.keeping(render(&self, 0)?));
        };
        let mut mean = MeanOfInstants::new(instants.len());
        let (mut work, mut at) = (self, &*frame);
        let mut before: Option<SpectralImage> = None;
        for (place, instant) in instants.iter().enumerate() {
            let same = before.take().filter(|_| at.scene == instant.scene);
            let image = if let Some(same) = same {
                same
            } else {
                work = work.moved((at, instant), watch)?;
                render(&work, place)?
            };
            mean.add(&image);
            let next = instants.get(place + 1);
            let stays = next.is_some_and(|next| next.scene == instant.scene);
            (at, before) = (instant, stays.then_some(image));
        }
        Ok(work.keeping(mean.finish()))
    }
}
