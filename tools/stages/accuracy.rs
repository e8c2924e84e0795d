//! How accurate a picture is by its own estimate, and what limits it.
//!
//! error = RMS over the pixels of what the renderer estimated + that of what the plan left out
//!
//! Both are over display white, the luminance that a preview shows as white, like the tolerance. Theory and the air's
//! lengths are taken as given: what these err by is in no estimate.

use std::collections::BTreeMap;
use std::path::Path;

use niji_exchange::LayerRms;
use niji_render::PictureLayer;
use niji_render::STANDARD_ERRORS;
use niji_scene::Goal;
use niji_scene::Plan;
use serde::Serialize;

use crate::failure::Failure;
use crate::stages::Done;
use niji_picture::DROP_SPACING;
use niji_picture::LEFT_OUT;
use niji_picture::MOTION;
use niji_picture::PlannedScene;
use niji_picture::SKY;

/// What to do about each cause of error, by its channel.
const REMEDIES: [(&str, &str); 11] = [
    (
        "footprint",
        "edges inside pixels: a larger picture, or up to 256 rays a pixel, by --tolerance without --accuracy and \
         accuracy.pixel_footprint, but none in a photograph",
    ),
    (
        ORDERS,
        "multiple scattering, its noise and what lies between its directions: more paths_per_node or \
         nodes_across in accuracy.drop_orders",
    ),
    (
        "quadrature",
        "the integral along the rays: a smaller relative_error in accuracy.integration",
    ),
    (
        "shadow",
        "the way of sunlight through the drops: a smaller voxel_m in accuracy.sun_path, then smaller \
         voxels of the drops",
    ),
    (
        "air",
        "the air's light along the rays: more n_nodes of quadrature in accuracy.air_path",
    ),
    (
        "surfaces",
        "light that lit surfaces send each other, of which two reflections are followed by a few rays: a darker albedo \
         or a more open place makes this less",
    ),
    (
        "angles",
        "the table's angles and flattenings: make it with more, by a smaller \
         accuracy.table_relative_error",
    ),
    (
        "sizes",
        "the table's sizes: make it with more radii, by a smaller accuracy.table_relative_error",
    ),
    (
        SKY,
        "light that the air scatters more than once: a smaller accuracy.tolerance has it solved more finely, \
         without --accuracy draft or reference",
    ),
    (
        DROP_SPACING,
        "what lies between the nodes of the drops: a smaller voxel_m in [drops]",
    ),
    (
        MOTION,
        "what moves while the shutter is open: more accuracy.shutter_instants, or a smaller sequence.shutter_deg",
    ),
];

/// The channel of light of further orders.
const ORDERS: &str = "orders";

/// How accurate a picture is, in parts of display white.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Reached {
    /// The tolerance.
    tolerance: f64,
    /// What the picture errs by: `estimated` and `left_out`.
    pub(crate) error: f64,
    /// What the renderer and small pictures before it estimated, RMS over the picture.
    estimated: f64,
    /// What the effects add that the plan left out by itself, RMS.
    left_out: f64,
    /// The same by cause: squares add up.
    causes: BTreeMap<&'static str, f64>,
    /// Light that drops scatter more than once, RMS.
    #[serde(skip)]
    further_orders: f64,
}

impl Reached {
    /// The error in words.
    pub(crate) fn text(&self) -> String {
        format!(
            "{}, {} {} (tolerance {})",
            self.text_of_error(),
            if self.is_kept() {
                "within"
            } else {
                "not within"
            },
            of_white(self.tolerance),
            self.tolerance
        )
    }

    /// The error alone.
    pub(crate) fn text_of_error(&self) -> String {
        let tolerance = of_white(self.tolerance);
        let mut digits = [2, 3, 4, 5]
            .map(|it| with_digits(self.error, it))
            .into_iter();
        // With as many digits as show that it is missed.
        let error = digits.find(|it| self.is_kept() || *it != tolerance);
        format!("error {} of display white", error.unwrap_or(tolerance))
    }

    /// What causes most of an error that is larger than the tolerance, and what to do.
    pub(crate) fn too_much(&self) -> Option<&'static str> {
        let size = |cause: &str| self.causes.get(cause).copied().unwrap_or(0.0);
        let largest = REMEDIES
            .iter()
            .max_by(|(a, _), (b, _)| size(a).total_cmp(&size(b)));
        largest
            .map(|(_, remedy)| *remedy)
            .filter(|_| !self.is_kept())
    }

    fn is_kept(&self) -> bool {
        self.error <= self.tolerance
    }

    /// Refuses a picture that misses its tolerance, naming the largest cause.
    ///
    /// # Errors
    /// [`Failure::AccuracyNotReached`].
    pub(crate) fn verdict(&self) -> Result<(), Failure> {
        self.too_much().map_or(Ok(()), |cause| {
            let text = self.text();
            Err(Failure::AccuracyNotReached(format!(
                "the picture misses its tolerance: {text}: most of it from {cause} (it was written)"
            )))
        })
    }
}

/// A part of display white in percent, two digits: `0.18 %`.
pub(crate) fn of_white(part: f64) -> String {
    with_digits(part, 2)
}

/// The same with so many digits.
fn with_digits(part: f64, n_digits: u32) -> String {
    let percent = 100.0 * part;
    if percent > 0.0 && percent < LEAST_PERCENT {
        return format!("below {LEAST_PERCENT} %");
    }
    let last = f64::from(n_digits) - 1.0;
    let n_decimals = (last - percent.max(LEAST_PERCENT).log10().floor()).max(0.0);
    let text = format!("{percent:.0$}", n_decimals as usize);
    let text = if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.')
    } else {
        &text
    };
    format!("{text} %")
}

/// No smaller error is told in digits, percent.
const LEAST_PERCENT: f64 = 1e-4;

/// How accurate a picture in a file is; `None` if it holds no estimate.
///
/// # Errors
/// A file that cannot be read.
pub(crate) fn reached(planned: &PlannedScene, image: &Path) -> Result<Option<Reached>, Failure> {
    let layers = LayerRms::read(image).map_err(|e| Failure::bad_input(image, e))?;
    Ok(reached_by(&planned.plan_as_shown(), &layers))
}

/// How accurate a picture is by its layers; `None` if it holds no estimate.
pub(crate) fn reached_by(plan: &Plan, layers: &[LayerRms]) -> Option<Reached> {
    let layer = |layer: PictureLayer| layers.iter().find(|it| it.name == layer.name());
    let error = layer(PictureLayer::Error)?;
    let part = |channel| {
        let told = error.of_channel(channel) / plan.display_white_cd_m2;
        // Of noise a picture tells what few pixels exceed, which is more than what is expected of all.
        if channel == ORDERS {
            told / STANDARD_ERRORS
        } else {
            told
        }
    };
    let squares = REMEDIES.map(|(cause, _)| part(cause).powi(2));
    let estimated = squares.iter().sum::<f64>().sqrt();
    let left_out = part(LEFT_OUT);
    let multiple = layer(PictureLayer::BowMultiple);
    Some(Reached {
        further_orders: multiple.map_or(0.0, |it| it.of_channel("Y")) / plan.display_white_cd_m2,
        tolerance: plan.tolerance,
        error: estimated + left_out,
        estimated,
        left_out,
        causes: REMEDIES.map(|(cause, _)| (cause, part(cause))).into(),
    })
}

/// What would have taken less time.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Cheaper {
    /// The key and its value.
    change: &'static str,
    /// Seconds less.
    seconds: f64,
    /// What the picture would err by, over display white.
    error: f64,
    /// What its own estimate would be, which few pixels exceed.
    told: f64,
}

impl Cheaper {
    /// A line for people.
    pub(crate) fn text(&self) -> String {
        let Self {
            change,
            seconds,
            error,
            told,
        } = self;
        let [error, told] = [*error, *told].map(of_white);
        let estimate = if told == error {
            String::new()
        } else {
            format!(", which its estimate puts at {told}")
        };
        format!("cheaper: {change}: {seconds:.1} s less, error {error}{estimate}")
    }
}

/// What would have taken a tenth less of all `total_s`, as the stages that ran measured it: pixels without more rays,
/// no light of further orders. Nothing where the picture was there already or was made in parts.
///
/// e_rays = sqrt(e^2 + <d^2>),   e_orders = e + rms of their light
/// `e` error of the picture; `d` what more than one ray each changed its pixels by. The estimate of the picture
/// without them has what they took away of it in place of d^2.
pub(crate) fn cheaper(
    planned: &PlannedScene,
    (done, total_s): (&[Done], f64),
    reached: &Reached,
) -> Vec<Cheaper> {
    let Some(spent) = done.iter().find_map(|it| it.spent) else {
        return Vec::new();
    };
    let white = planned.plan_as_shown().display_white_cd_m2;
    let with = |squares: f64| {
        let estimated = reached.estimated.powi(2) + squares / (white * white);
        estimated.max(0.0).sqrt() + reached.left_out
    };
    let of_rays = Cheaper {
        change: "accuracy.pixel_footprint = \"prefiltered\"",
        seconds: spent.more_rays_s,
        error: with(spent.more_rays.change),
        told: with(spent.more_rays.error),
    };
    let of_orders = Cheaper {
        change: "effects.multiple_scattering = \"off\"",
        seconds: spent.further_orders_s + done.iter().map(|it| it.further_orders_s).sum::<f64>(),
        error: reached.error + reached.further_orders,
        told: reached.error + reached.further_orders,
    };
    let mut found = vec![of_rays, of_orders];
    found.retain(|it| it.seconds > WORTH_SAYING * total_s && it.seconds > LEAST_S);
    found.sort_by(|a, b| b.seconds.total_cmp(&a.seconds));
    found
}

/// Part of the time and seconds below which less time is not worth a line.
const WORTH_SAYING: f64 = 0.1;
const LEAST_S: f64 = 0.1;

/// Refuses a picture that misses the tolerance on the command line; without one nothing is asked.
///
/// # Errors
/// A file that cannot be read; as [`Reached::verdict`].
pub(crate) fn check(planned: &PlannedScene, image: &Path, goal: Goal) -> Result<(), Failure> {
    if goal.tolerance.is_none() {
        return Ok(());
    }
    let reached = reached(planned, image)?;
    reached.map_or(Ok(()), |reached| reached.verdict())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percents_have_two_digits() {
        for (percent, text) in [
            (0.0, "0 %"),
            (1e-6, "below 0.0001 %"),
            (0.00123, "0.0012 %"),
            (0.18, "0.18 %"),
            (0.5, "0.5 %"),
            (2.345, "2.3 %"),
            (20.0, "20 %"),
            (234.0, "234 %"),
        ] {
            assert_eq!(of_white(percent / 100.0), text);
        }
    }

    #[test]
    fn what_the_plan_left_out_counts_and_the_largest_cause_is_named() {
        let reached = |estimated, left_out| Reached {
            tolerance: 0.01,
            error: estimated + left_out,
            estimated,
            left_out,
            causes: [("sizes", 0.2 * estimated), ("shadow", 0.9 * estimated)].into(),
            further_orders: 0.0,
        };
        assert!(reached(0.006, 0.003).verdict().is_ok());
        let missed = reached(0.006, 0.005).verdict().unwrap_err().to_string();
        assert!(missed.contains("1.1 % of display white"), "{missed}");
        assert!(missed.contains("1 % (tolerance 0.01)"), "{missed}");
        assert!(missed.contains("accuracy.sun_path"), "{missed}");
        // By a hair.
        let missed = reached(0.01004, 0.0).text();
        assert!(
            missed.starts_with("error 1.004 % of display white, not"),
            "{missed}"
        );
    }
}
