//! Light of drops on its way from the march to the shading.
//!
//! A ray's light is kept by drop size, with the first two moments of its distance: the air between
//! needs no more (see `air_slabs`).

use crate::size_axes::SizeAxes;
use crate::size_axes::SizeBins;
use crate::size_axes::SizePlace;

/// Light that a ray has gathered since the last time it was shaded.
#[derive(Clone, Debug)]
pub(crate) struct Deposits {
    /// By size.
    pub(crate) bins: SizeBins,
    /// All of it [-].
    pub(crate) light: f64,
    /// First moment of its distance (m).
    pub(crate) light_m: f64,
    /// Second moment of its distance [m²].
    pub(crate) light_m2: f64,
    /// Its mean optical depth to the sun at Q = 1, times the light.
    pub(crate) light_tau_sun: f64,
    /// Estimated error of the light.
    pub(crate) error: f64,
    /// The light times the variance of sizes, on the table's radius axis, that errs as much as the points of
    /// a stretch or a piece do [nodes²].
    pub(crate) size_variance: f64,
}

impl Deposits {
    /// Nothing yet.
    pub(crate) fn new(axes: &SizeAxes) -> Self {
        let bins = SizeBins::new(axes);
        Self {
            bins,
            light: 0.0,
            light_m: 0.0,
            light_m2: 0.0,
            light_tau_sun: 0.0,
            error: 0.0,
            size_variance: 0.0,
        }
    }

    /// Nothing again.
    pub(crate) fn clear(&mut self) {
        self.bins.clear();
        (self.light, self.light_m, self.light_m2) = (0.0, 0.0, 0.0);
        (self.light_tau_sun, self.error, self.size_variance) = (0.0, 0.0, 0.0);
    }

    /// Light of drops at a place of the size axes.
    #[inline]
    pub(crate) fn add(&mut self, place: SizePlace, distance_m: f64, tau_sun: f64, light: f64) {
        self.bins.add(place, light as f32);
        self.light += light;
        self.light_m += light * distance_m;
        self.light_m2 += light * distance_m * distance_m;
        self.light_tau_sun += light * tau_sun;
    }
}
