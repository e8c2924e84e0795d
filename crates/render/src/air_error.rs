//! What the few nodes of the air err by, on a lattice of pixels.

use ndarray::Array2;

/// Relative errors of the air's light on a lattice of pixels.
pub(crate) struct AirError {
    /// Pixels from ray to ray.
    pub(crate) step_px: (u32, u32),
    /// By row and column.
    pub(crate) relative: Array2<f64>,
    /// Of the bows that air dims, wherever they are.
    pub(crate) relative_of_bows: f64,
    /// The largest error (cd/m²).
    pub(crate) largest_cd_m2: f64,
}

impl AirError {
    /// None at all.
    pub(crate) fn none() -> Self {
        Self {
            step_px: (1, 1),
            relative: Array2::zeros((2, 2)),
            relative_of_bows: 0.0,
            largest_cd_m2: 0.0,
        }
    }

    /// At a pixel of the frame, or the nearest of those to one beyond it.
    pub(crate) fn at(&self, (x_px, y_px): (f64, f64)) -> f64 {
        let cell = |at_px: f64, step_px: u32, n_rays: usize| {
            // Below 0 the cast ends at 0.
            ((at_px / f64::from(step_px)) as usize).min(n_rays - 2)
        };
        let (n_rows, n_columns) = self.relative.dim();
        let row = cell(y_px, self.step_px.1, n_rows);
        let column = cell(x_px, self.step_px.0, n_columns);
        let of_row =
            |row: usize| self.relative[[row, column]].max(self.relative[[row, column + 1]]);
        of_row(row).max(of_row(row + 1))
    }
}
