//! The estimated error of a picture by what causes it.
//!
//! error² = quadrature² + angles² + sizes² + shadow² + orders² + air² + footprint²
//!
//! The causes have nothing to do with each other, so that their signs agree as often as not (JCGM 100:2008,
//! 5.1.2). The plain sum, as if all had one sign, covered hardly more pixels of the shipped scenes and told up
//! to six tenths more.

use ndarray::Array2;

/// Number of causes.
pub(crate) const N_PARTS: usize = 7;

/// Estimated absolute errors of luminance by cause [cd/m²].
#[derive(Clone, Debug, PartialEq)]
pub struct ErrorParts {
    /// The quadrature along the ray.
    pub quadrature: Array2<f32>,
    /// Linear interpolation between the angles of the scattering table, and between its flattenings.
    pub angles: Array2<f32>,
    /// Linear interpolation between the radii of the scattering table.
    pub sizes: Array2<f32>,
    /// The optical depth of the drops towards the sun.
    pub shadow: Array2<f32>,
    /// Noise of the light that drops scatter more than once.
    pub orders: Array2<f32>,
    /// The quadrature of the air's light.
    pub air: Array2<f32>,
    /// What the rays of a pixel miss of it.
    pub footprint: Array2<f32>,
}

impl ErrorParts {
    /// No errors.
    pub(crate) fn none((height, width): (usize, usize)) -> Self {
        let plane = || Array2::zeros((height, width));
        Self {
            quadrature: plane(),
            angles: plane(),
            sizes: plane(),
            shadow: plane(),
            orders: plane(),
            air: plane(),
            footprint: plane(),
        }
    }

    /// All parts by name.
    #[must_use]
    pub fn named(&self) -> [(&'static str, &Array2<f32>); N_PARTS] {
        [
            ("quadrature", &self.quadrature),
            ("angles", &self.angles),
            ("sizes", &self.sizes),
            ("shadow", &self.shadow),
            ("orders", &self.orders),
            ("air", &self.air),
            ("footprint", &self.footprint),
        ]
    }
}

/// Estimated errors of a ray or a pixel by cause [cd/m²].
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct RayErrors {
    pub(crate) quadrature: f64,
    pub(crate) angles: f64,
    pub(crate) sizes: f64,
    pub(crate) shadow: f64,
    pub(crate) orders: f64,
    pub(crate) air: f64,
}

impl RayErrors {
    /// Add the errors of a ray that stands for `share` of a pixel, of whose first order air lets
    /// `transmitted` pass.
    pub(crate) fn add(&mut self, share: f64, transmitted: f64, ray: &Self) {
        let of_first_order = share * transmitted;
        self.quadrature += of_first_order * ray.quadrature;
        self.angles += of_first_order * ray.angles;
        self.sizes += of_first_order * ray.sizes;
        self.shadow += of_first_order * ray.shadow;
        self.orders += share * ray.orders;
        self.air += share * ray.air;
    }

    /// All of them, in the order of [`ErrorParts`].
    pub(crate) fn parts(&self) -> [f64; 6] {
        [
            self.quadrature,
            self.angles,
            self.sizes,
            self.shadow,
            self.orders,
            self.air,
        ]
    }

    /// All of them in one.
    pub(crate) fn together(&self) -> f64 {
        together(&self.parts())
    }
}

/// Root of the sum of the squares of errors whose causes are independent.
pub(crate) fn together(errors: &[f64]) -> f64 {
    let squares: f64 = errors.iter().map(|error| error * error).sum();
    squares.sqrt()
}
