//! A picture that is to be there at a time: less is done where that costs least.
//!
//! Paths of light of further orders are followed in rounds of twice as many; another round takes as long as all
//! before it, and is begun where that leaves half of the time. Then all pixels are followed once. A few of those that
//! would get more rays get them as a trial, for one tolerance after the other from the coarsest on: the finest for
//! which there is time holds for the picture, down to a sixteenth of what is asked for. Neither do paths end where
//! their noise is small enough: a time is for the best picture. What was settled is told, so that the same picture can
//! be made again without a clock.

/// Seconds since some moment, by whoever knows the time.
pub type Clock<'a> = &'a (dyn Fn() -> f64 + Sync);

/// When a picture is to be there.
#[derive(Clone, Copy)]
pub struct Deadline<'a> {
    /// The time.
    pub now_s: Clock<'a>,
    /// When there is no more time, on that clock.
    pub end_s: f64,
}

impl Deadline<'_> {
    /// Time without end, on a clock that stands.
    pub const NEVER: Self = Self {
        now_s: &|| 0.0,
        end_s: f64::INFINITY,
    };

    /// Whether time ends.
    pub(crate) fn is_set(&self) -> bool {
        self.end_s < f64::INFINITY
    }

    /// Seconds that are left.
    pub(crate) fn left_s(&self) -> f64 {
        self.end_s - (self.now_s)()
    }
}

/// What went into a picture: what there was time for, and what that took.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spent {
    /// What there was time for.
    pub afforded: Afforded,
    /// Seconds in which light of further orders was made ready: its paths, and what diffraction changes in the bows.
    pub further_orders_s: f64,
    /// Seconds in which pixels got more rays.
    pub more_rays_s: f64,
    /// What more than one ray for each pixel did, mean over the pixels [cd²/m⁴].
    pub more_rays: MoreRays,
}

/// What more than one ray did, by the squares of luminance.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MoreRays {
    /// What it changed.
    pub change: f64,
    /// What it took away from the estimated error.
    pub error: f64,
}

/// What there was time for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Afforded {
    /// [`RenderRequest::coarser_rays`](crate::RenderRequest::coarser_rays).
    pub coarser_rays: f64,
    /// Paths of light of further orders for each direction; `None` where there is no such light.
    pub paths_per_node: Option<usize>,
}
