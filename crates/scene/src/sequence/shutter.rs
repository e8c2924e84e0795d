//! How long the shutter of a frame is open, and what moves meanwhile.
//!
//! s_i = (a/360) (2 i + 1 - n)/(2 n),   i = 0 ... n - 1
//! `s_i` middles of n equal parts of the time, in frames after the frame itself; `a` angle of the shutter, degrees of a
//! frame's 360. The frame stands in the middle, and for an odd n is one of them.

/// Sections of what a picture is counted in and how it is made, which stay those of the frame.
const STILL_SECTIONS: [&str; 3] = ["spectrum", "accuracy", "picture"];

/// Last parts of keys that are counted, or lay a grid out.
const STILL_KEYS: [&str; 2] = ["seed", "voxel_m"];

/// Degrees of a frame.
const FRAME_DEG: f64 = 360.0;

/// How long of a frame the shutter is open, half of it before the frame and half after; closed where nothing is said.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Shutter {
    /// The angle, 0 to 360 degrees.
    pub angle_deg: f64,
}

impl Shutter {
    pub(super) fn of_angle(angle_deg: f64) -> Self {
        Self { angle_deg }
    }

    /// Whether anything can move while it is open.
    #[must_use]
    pub fn is_open(self) -> bool {
        self.angle_deg > 0.0
    }

    /// When it opens and when it closes, in frames after the frame.
    #[must_use]
    pub fn ends(self) -> [f64; 2] {
        let half = 0.5 * self.angle_deg / FRAME_DEG;
        [-half, half]
    }

    /// The middles of so many equal parts of that time, in frames after the frame.
    #[must_use]
    pub fn instants(self, n_instants: u32) -> Vec<f64> {
        let n = f64::from(n_instants);
        let place = |index: u32| (2.0 * f64::from(index) + 1.0 - n) / (2.0 * n);
        let instants = (0..n_instants).map(|index| self.angle_deg / FRAME_DEG * place(index));
        instants.collect()
    }
}

/// What a key does between two frames.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Within {
    Moves,
    /// It has the frame's own value: of counts there is none between, and a grid may not change.
    Still,
}

impl Within {
    /// That of a key with its section.
    pub(super) fn of(path: &str) -> Self {
        let parts = path.split_once('.').zip(path.rsplit_once('.'));
        let is_still = parts.is_none_or(|((section, _), (_, key))| {
            let is_counted = STILL_KEYS.contains(&key) || key.ends_with("_px");
            is_counted || STILL_SECTIONS.contains(&section)
        });
        if is_still { Self::Still } else { Self::Moves }
    }
}
