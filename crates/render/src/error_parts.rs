//! The estimated error of a ray or a pixel by what causes it.

/// Estimated errors of a ray or a pixel by cause [cd/m²].
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct RayErrors {
    pub(crate) quadrature: f64,
    pub(crate) angles: f64,
    pub(crate) sizes: f64,
    pub(crate) shadow: f64,
    pub(crate) orders: f64,
    pub(crate) air: f64,
    pub(crate) surfaces: f64,
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
        self.surfaces += share * ray.surfaces;
    }

    /// All of them, in the order of the channels of [`crate::PictureLayer::Error`].
    pub(crate) fn parts(&self) -> [f64; 7] {
        [
            self.quadrature,
            self.angles,
            self.sizes,
            self.shadow,
            self.orders,
            self.air,
            self.surfaces,
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
