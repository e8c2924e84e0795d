//! What the air does, as a table: the file between the air stage and the renderer.
//!
//! The air is a sum of constituents. Each has one relative density rho(h), a function of height
//! alone, and one extinction and scattering coefficient per wavelength at density 1, so that
//!   optical depth(lambda) = sum over constituents of  extinction(lambda) * length,
//! where the equivalent length  L = integral rho ds  [m] knows no wavelength. Lookups therefore
//! return lengths; whoever holds the spectra multiplies at the very end. Optical depths add and
//! subtract safely, transmittances do not, so no transmittance is stored.
//!
//! Stored is the reach  L(h, mu)/rho(h)  [m] to the top of the air for rays that lead upwards or
//! level (mu = cosine of the zenith angle, 0..1). It varies slowly with height, f32 holds it to
//! 6e-8, and its reciprocal is smooth in mu down to the horizontal. Rays that lead downwards follow
//! from their perigee p:  L(h, -mu) = 2 L(p, 0) - L(h, mu),  a difference that loses nothing,
//! because L(p, 0) >= L(h, mu).

mod closed_form;
mod diffuse_file;
mod diffuse_light;
mod file;
mod harmonics;
mod interpolation;
mod lookup;
mod ray_start;

use ndarray::Array2;
use niji_radiometry::WavelengthGrid;

pub use self::diffuse_light::DiffuseLight;
pub use self::diffuse_light::DiffusePlace;
pub use self::diffuse_light::DiffuseView;
pub use self::harmonics::cosines_of_multiples;
pub use self::harmonics::expansion_weights;
pub use self::harmonics::harmonics;
pub use self::harmonics::legendre_polynomials;
pub use self::harmonics::moment_index;
pub use self::harmonics::n_moments;
pub use self::interpolation::Stencil;

/// How the density runs between its nodes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DensityLaw {
    /// Linear in the logarithm: exact for exponential layers. Its columns come from the table of
    /// reaches. Densities must be positive.
    Exponential,
    /// Linear: exact for tents. Its columns have a closed form; no reaches are stored.
    Linear,
}

/// One constituent of the air: Rayleigh scattering, ozone, an aerosol, …
#[derive(Clone, Debug, PartialEq)]
pub struct AirConstituent {
    /// Name, unique in the table.
    pub name: String,
    /// Extinction by wavelength where the relative density is 1, 1/m.
    pub extinction_m1: Vec<f64>,
    /// Scattering by wavelength where the relative density is 1, 1/m.
    pub scattering_m1: Vec<f64>,
    /// How the density runs between its nodes.
    pub law: DensityLaw,
    /// Heights of the density's nodes, m, rising. Above the last the density is 0; below the first
    /// it stays as it is there.
    pub height_m: Vec<f64>,
    /// Relative density at the nodes.
    pub density: Vec<f64>,
    /// Heights of the reaches, m, rising, from the first to the last density node.
    pub reach_height_m: Vec<f64>,
    /// Cosines of the zenith angle of the reaches, rising from 0 to 1.
    pub reach_mu: Vec<f64>,
    /// Equivalent length to the top of the air over the density at its start, m: `[height, mu]`.
    pub reach_m: Array2<f64>,
    /// Scattering angles of the phase function, rising from 0 to pi.
    pub phase_angle_rad: Vec<f64>,
    /// Phase function, 1/sr, its integral over the sphere is 1: `[wavelength, angle]`.
    pub phase_sr1: Array2<f64>,
}

/// The air above one planet.
#[derive(Clone, Debug, PartialEq)]
pub struct AtmosphereTable {
    /// Radius of the planet at sea level, m.
    pub planet_radius_m: f64,
    /// Height above which there is no air, m.
    pub top_height_m: f64,
    /// Wavelengths of every spectrum in the table.
    pub wavelengths: WavelengthGrid,
    /// Irradiance by the sun at the top of the air on a surface that faces it, W m^-2 nm^-1, bin
    /// means.
    pub sun_irradiance: Vec<f64>,
    /// Share of the light that the ground gives back, diffusely, by wavelength.
    pub ground_albedo: Vec<f64>,
    /// What the air is made of.
    pub constituents: Vec<AirConstituent>,
    /// Light of higher orders of scattering, where it was asked for.
    pub diffuse: Option<DiffuseLight>,
}

impl AtmosphereTable {
    /// Relative density of a constituent at a height.
    ///
    /// # Panics
    /// If there is no constituent of that index; so do the other lookups.
    pub fn density_at(&self, constituent_index: usize, height_m: f64) -> f64 {
        self.constituents[constituent_index].density_at(height_m)
    }

    /// Equivalent length from a point to the top of the air, m; infinite for a ray that ends on the
    /// ground.
    ///
    /// `mu` is the cosine of the ray's zenith angle. An observer above the air gets the whole chord,
    /// or 0 if the ray passes over the air. Relative error below 1e-6 up to nine tenths of the
    /// constituent's height, and below 5e-5 in the last tenth (see the tests of the air stage).
    pub fn column_at(&self, constituent_index: usize, height_m: f64, mu: f64) -> f64 {
        lookup::column(
            &self.constituents[constituent_index],
            self.planet_radius_m,
            height_m,
            mu,
        )
    }

    /// Equivalent length of the first `length_m` of a ray, m.
    ///
    /// Integrates the profile over short segments, where the difference of two columns would cancel,
    /// and takes that difference over long ones. `length_m` may be infinite. What lies below the
    /// ground is filled with air like the lowest node, so a segment may end there.
    pub fn segment_length(
        &self,
        constituent_index: usize,
        height_m: f64,
        mu: f64,
        length_m: f64,
    ) -> f64 {
        let constituent = &self.constituents[constituent_index];
        lookup::segment(constituent, self.planet_radius_m, [height_m, mu, length_m])
    }

    /// Phase function of a constituent at a scattering angle, 1/sr.
    pub fn phase_at(
        &self,
        constituent_index: usize,
        wavelength_index: usize,
        theta_rad: f64,
    ) -> f64 {
        self.constituents[constituent_index].phase_at(wavelength_index, theta_rad)
    }

    /// Optical depth to the top of the air at one wavelength; infinite behind the ground.
    ///
    /// A constituent that does not extinguish at this wavelength adds 0 even behind the ground.
    pub fn optical_depth_at(&self, wavelength_index: usize, height_m: f64, mu: f64) -> f64 {
        let depth = |index: usize| {
            let extinction_m1 = self.constituents[index].extinction_m1[wavelength_index];
            if extinction_m1 > 0.0 {
                extinction_m1 * self.column_at(index, height_m, mu)
            } else {
                0.0
            }
        };
        (0..self.constituents.len()).map(depth).sum()
    }
}

impl AirConstituent {
    /// Relative density at a height.
    pub fn density_at(&self, height_m: f64) -> f64 {
        lookup::density(self, height_m)
    }

    /// Phase function at a scattering angle, 1/sr.
    pub fn phase_at(&self, wavelength_index: usize, theta_rad: f64) -> f64 {
        let row = self.phase_sr1.row(wavelength_index);
        let stencil = interpolation::Stencil::<4>::new(&self.phase_angle_rad, theta_rad);
        stencil.sum(|node| row[node]).max(0.0)
    }

    /// Phase function at a scattering angle by wavelength, 1/sr.
    pub fn phases_at(&self, theta_rad: f64) -> Vec<f64> {
        let stencil = interpolation::Stencil::<4>::new(&self.phase_angle_rad, theta_rad);
        let rows = self.phase_sr1.rows().into_iter();
        rows.map(|row| stencil.sum(|node| row[node]).max(0.0))
            .collect()
    }
}
