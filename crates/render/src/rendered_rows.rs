//! Rows of a picture as a picture.

use std::ops::Range;

use ndarray::Array2;
use ndarray::Array3;
use ndarray::s;

use crate::error_parts::ErrorParts;
use crate::picture_tiles::Rendered;

impl Rendered {
    /// A copy of some rows.
    ///
    /// # Panics
    /// If there are no such rows.
    #[must_use]
    pub fn rows(&self, rows: Range<usize>) -> Self {
        let planes = |values: &Array3<f32>| values.slice(s![.., rows.clone(), ..]).to_owned();
        let plane = |values: &Array2<f32>| values.slice(s![rows.clone(), ..]).to_owned();
        Self {
            radiance: planes(&self.radiance),
            bow_primary: planes(&self.bow_primary),
            bow_secondary: planes(&self.bow_secondary),
            bow_multiple: self.bow_multiple.as_ref().map(planes),
            bow_reflected: self.bow_reflected.as_ref().map(planes),
            inscatter: planes(&self.inscatter),
            skylit: self.skylit.as_ref().map(planes),
            transmittance: plane(&self.transmittance),
            tau_sun: plane(&self.tau_sun),
            depth: plane(&self.depth),
            surface: self.surface.as_ref().map(plane),
            error: plane(&self.error),
            error_parts: ErrorParts {
                quadrature: plane(&self.error_parts.quadrature),
                angles: plane(&self.error_parts.angles),
                sizes: plane(&self.error_parts.sizes),
                shadow: plane(&self.error_parts.shadow),
                orders: plane(&self.error_parts.orders),
                air: plane(&self.error_parts.air),
                footprint: plane(&self.error_parts.footprint),
            },
        }
    }
}
