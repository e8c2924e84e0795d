//! What of a scene decides the size of its effects, in words.

use niji_scatter::Theory;

use crate::figures::brief;
use crate::figures::length;

/// What reasons speak of.
#[expect(
    clippy::struct_excessive_bools,
    reason = "facts that do not depend on each other"
)]
pub(crate) struct Facts {
    pub(crate) has_air: bool,
    /// Are surfaces given that hide drops?
    pub(crate) has_surfaces: bool,
    /// How many of them have an albedo.
    pub(crate) n_lit: usize,
    pub(crate) sun_elevation_deg: f64,
    /// Scattering angles of rays that may meet drops, degrees.
    pub(crate) theta_deg: Option<(f64, f64)>,
    /// Nearest and farthest drops in view, m.
    pub(crate) distance_m: Option<(f64, f64)>,
    /// Largest optical depth of the drops in view and towards the sun, Q = 1.
    pub(crate) depth: f64,
    pub(crate) sun_depth: f64,
    /// May anything shade ground in view?
    pub(crate) is_ground_shaded: bool,
    /// Largest share of the sun's light that the air takes at any wavelength.
    pub(crate) sunlight_lost: f64,
    pub(crate) effective_variance: f64,
    pub(crate) largest_radius_um: f64,
    pub(crate) smallest_radius_um: f64,
    /// The theory of the table that is made.
    pub(crate) theory: Theory,
    /// Is light of further orders on where it is seen?
    pub(crate) weighs_further_orders: bool,
    /// Is the bow set into a photograph?
    pub(crate) is_for_photograph: bool,
    /// Largest share of the sun's light that water mirrors; `None` without water.
    pub(crate) mirrored_share: Option<f64>,
    /// May a ray of the camera meet water?
    pub(crate) sees_water: bool,
}

impl Facts {
    /// The scattering angles in view, and what stands there.
    pub(crate) fn angles(&self, what_stands_where: &str) -> String {
        match self.theta_deg {
            Some((low, high)) => format!(
                "rays through the drops scatter by {low:.0} to {high:.0} degrees; {what_stands_where}"
            ),
            None => "no drops are in view".to_string(),
        }
    }

    /// How near the drops are.
    pub(crate) fn distances(&self) -> String {
        match self.distance_m {
            Some((near_m, far_m)) => format!(
                "the drops in view lie {} to {} away",
                length(near_m),
                length(far_m)
            ),
            None => "no drops are in view".to_string(),
        }
    }

    /// How much the drops in view take.
    pub(crate) fn depth_of(&self, which: &str) -> String {
        format!("optical depth of {which} up to {}", brief(self.depth))
    }

    /// How large the drops are, and how much they differ.
    pub(crate) fn sizes(&self) -> String {
        format!(
            "effective radius {} to {} um, effective variance up to {}",
            brief(self.smallest_radius_um),
            brief(self.largest_radius_um),
            brief(self.effective_variance)
        )
    }
}
