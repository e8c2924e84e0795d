//! Whether the shutter of a sequence is followed: by what it changes, which small pictures of its frames show.
//!
//! It is on where that and all that is left out besides are more than half of the tolerance.

use crate::effect::Effect;
use crate::effect_switches::Switch;
use crate::scene::Scene;
use crate::sequence::Shutter;

use super::bound::Bound;
use super::bound::BoundKind;
use super::decide::SHARE_FOR_EFFECTS;
use super::decided::Plan;
use super::reasons::Decided;
use super::reasons::of_switch;

/// What an open shutter changes in the frames of a sequence, and what it takes to follow it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Blur {
    /// The change at most and in the RMS, over display white.
    pub change: Bound,
    /// Instants over which the mean keeps the tolerance.
    pub n_instants: u32,
}

impl Blur {
    /// That of frames that do not move.
    pub const NONE: Self = Self {
        change: Bound {
            value: 0.0,
            rms: 0.0,
            kind: BoundKind::Measured,
        },
        n_instants: 3,
    };

    /// The more of two frames.
    #[must_use]
    pub fn or_more(self, other: Self) -> Self {
        Self {
            change: Bound {
                value: self.change.value.max(other.change.value),
                rms: self.change.rms.max(other.change.rms),
                kind: BoundKind::Measured,
            },
            n_instants: self.n_instants.max(other.n_instants),
        }
    }
}

impl Plan {
    /// The plan of a sequence with the shutter of its frames, all being as `scene` asks.
    #[must_use]
    pub fn with_shutter(mut self, scene: &Scene, (shutter, blur): (Shutter, Blur)) -> Self {
        let effect = Effect::MotionBlur;
        let asked = scene.effects.of(effect);
        let left_out = self.left_out + blur.change.value;
        let is_seen = blur.change.value > 0.0 && left_out > SHARE_FOR_EFFECTS * self.tolerance;
        let is_on = match asked {
            Switch::On => true,
            Switch::Off => false,
            Switch::Auto => is_seen,
        };
        let decided = Decided {
            effect,
            asked,
            is_on,
            bound: blur.change,
        };
        let fact = format!(
            "the shutter is open for {} degrees of 360",
            shutter.angle_deg
        );
        if let Some(decision) = self.effects.iter_mut().find(|it| it.effect == effect) {
            decision.on = is_on;
            decision.is_left_out = !is_on && asked == Switch::Auto;
            decision.reason = of_switch(&decided, &fact);
            decision.bound = blur.change;
            if decision.is_left_out {
                self.left_out = left_out;
            }
        }
        let n_instants = scene.accuracy.shutter_instants.unwrap_or(blur.n_instants);
        self.levels.shutter_instants = is_on.then_some(n_instants);
        self
    }
}
