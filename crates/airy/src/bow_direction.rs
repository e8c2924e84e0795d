//! A bow in one direction, in the form that every wave theory of the bow shares.
//!
//! t_j = x^(1/3) (s_j f²(z) + s'_j x^(−2/3) f'²(z)) + g_j,   z = ζ x^(2/3),   x = 2π a/λ
//! t = (dσ/dΩ)/(π a²) in 1/sr; `s`, `s'`, `ζ` and `g` depend on direction, index and order alone, so
//! they serve every drop size and the averages of f² and f'² over sizes serve every direction.
//! Airy's published form has another size factor in place of x^(1/3).

use niji_radiometry::Micrometers;
use niji_radiometry::Nanometers;
use niji_radiometry::size_parameter;

use crate::airy::AiryForm;

/// The bow in one direction, ready for every size of drop and every wavelength of its index:
/// t_j = `size_factor` (`strength_j` f²(z) + `derivative_strength_j` x^(−2/3) f'²(z)) + `rays_j` with
/// z = `argument` x^(2/3).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BowDirection {
    /// z x^(−2/3).
    pub argument: f64,
    /// Factor of f² for each polarisation.
    pub strength: [f64; 2],
    /// Factor of x^(−2/3) f'² for each polarisation.
    pub derivative_strength: [f64; 2],
    /// What geometric optics adds, in 1/sr.
    pub rays: [f64; 2],
}

impl BowDirection {
    /// (dσ/dΩ)/(π a²) in 1/sr for the polarisations s and p. `squares` gives f² and f'²,
    /// exact ([`crate::airy_squares`]), from a table or averaged.
    #[must_use]
    pub fn normalized_cross_section(
        &self,
        radius: Micrometers,
        wavelength: Nanometers,
        squares: impl Fn(f64) -> [f64; 2],
    ) -> [f64; 2] {
        let x = size_parameter(radius, wavelength);
        let scale = (x * x).cbrt();
        let [square, derivative_square] = squares(self.argument * scale);
        let factor = AiryForm::Absolute.size_factor(radius, wavelength);
        [0, 1].map(|j| {
            let wave =
                self.strength[j] * square + self.derivative_strength[j] * derivative_square / scale;
            factor * wave + self.rays[j]
        })
    }
}
