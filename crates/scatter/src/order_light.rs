//! Light of single orders of drops at evenly spaced angles, as coarse as a bound may be.
//!
//! t_p = (dσ/dΩ)/(π⟨r²⟩) in 1/sr, natural light: the mean of both polarizations
//! Orders are those of a theory ([`crate::bow_light`]), means over sizes those of [`crate::mean_square`]; what
//! is saved against a table is the number of sizes, wavelengths and angles. The exact theories have the
//! orders of the uniform one, and glory and corona besides. Light of rays is the mean over a step of the
//! angles; the step with the caustic in it has the light that a table for a point sun has there.

use ndarray::Array3;
use niji_airy::rainbow_ray;
use niji_radiometry::Micrometers;
use niji_radiometry::Nanometers;
use niji_radiometry::Radians;
use niji_radiometry::Water;
use rayon::prelude::*;

use crate::bow_light::Bin;
use crate::bow_light::BowLight;
use crate::bow_light::BowTheory;
use crate::bow_light::LawDrops;
use crate::bow_light::Order;
use crate::bow_light::Places;
use crate::corona::corona;
use crate::glory::glory;
use crate::mean_square::Averaging;
use crate::mean_square::MeanSquare;
use crate::rings::Rings;
use crate::theory::Theory;
use niji_radiometry::size_parameter;

/// Largest error of means over sizes.
const BOUND_ERROR: f64 = 1e-2;

/// A band of wavelengths.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Band {
    /// The wavelength that stands for it.
    pub center: Nanometers,
    /// Its width.
    pub width: Nanometers,
}

/// Which light is asked for.
#[derive(Clone, Debug)]
pub struct LightRequest {
    /// How a drop scatters.
    pub theory: Theory,
    /// Effective radius in micrometres and effective variance of each law of sizes.
    pub laws: Vec<(f64, f64)>,
    /// The wavelengths.
    pub bands: Vec<Band>,
    /// Scattering angles, the middles of these rings.
    pub rings: Rings,
    /// What the drops are made of.
    pub water: Water,
}

/// Light by law, band and angle, 1/sr.
pub type Light = Array3<f64>;

/// Drops of some laws of sizes, ready to say what light they send.
#[derive(Clone, Debug)]
pub struct DropLight {
    request: LightRequest,
    theory: BowTheory,
    /// Those of the bows, by ascending effective variance.
    mean_squares: Vec<(f64, MeanSquare)>,
}

impl DropLight {
    /// Averages the bows over the laws of sizes.
    pub fn new(request: LightRequest) -> Self {
        let theory = request.theory.expected_bows();
        let mut variances: Vec<f64> = request.laws.iter().map(|(_, variance)| *variance).collect();
        variances.sort_by(f64::total_cmp);
        variances.dedup();
        let mean_square = |effective_variance: f64| {
            let mean_square = MeanSquare::compute(Averaging {
                exponent: theory.form().radius_exponent(),
                effective_variance,
                error: BOUND_ERROR,
                highest_z: f64::INFINITY,
                airy_table: None,
            });
            (effective_variance, mean_square)
        };
        let mean_squares = variances.into_iter().map(mean_square).collect();
        Self {
            request,
            theory,
            mean_squares,
        }
    }

    /// Light of order `p` for a point sun, none where the theory has no such order.
    ///
    /// ```
    /// use niji_radiometry::{Nanometers, Water};
    /// use niji_scatter::{Band, DropLight, LightRequest, Rings, Theory};
    ///
    /// let drops = DropLight::new(LightRequest {
    ///     theory: Theory::Uniform,
    ///     laws: vec![(500.0, 0.0), (500.0, 0.2)],
    ///     bands: vec![Band { center: Nanometers(550.0), width: Nanometers(10.0) }],
    ///     rings: Rings::around((2.35, 2.55), 1e-3),
    ///     water: Water::pure(15.0),
    /// });
    /// let bow = drops.of_order(2);
    /// let peak = |law: usize| bow.slice(ndarray::s![law, 0, ..]).iter().copied().fold(0.0, f64::max);
    /// // Drops of all sizes have no dark fringes, and no peak as high.
    /// assert!(peak(0) > peak(1) && peak(1) > 0.05);
    /// ```
    pub fn of_order(&self, p: u32) -> Light {
        let request = &self.request;
        if request.theory.orders_among(&[p]).is_empty() {
            return self.none();
        }
        self.by_band(|bin| {
            let Some(order) = self.theory.order(bin, p) else {
                return vec![vec![0.0; request.rings.n]; request.laws.len()];
            };
            // Index of the angle with a caustic, and the light there in a table for a point sun.
            let caustic = if let Order::Rays(rays) = &order {
                rainbow_ray(bin.index, p).and_then(|bow| {
                    let index = request.rings.holding(bow.theta_rad())?;
                    let light = rays.normalized_cross_section(Radians(bow.theta_rad()));
                    Some((index, natural(light)))
                })
            } else {
                None
            };
            let places = match &order {
                Order::Rays(_) | Order::Colors(_) => Places::Rings(request.rings),
                Order::Airy(..) | Order::Uniform(_) => Places::Angles(request.rings.angles()),
            };
            let light = BowLight::new(&order, &places);
            let row = |(radius_um, variance): &(f64, f64)| {
                let known = self
                    .mean_squares
                    .partition_point(|(known, _)| known < variance);
                let mut both = vec![[0.0; 2]; places.n()];
                let drops = LawDrops::new(
                    self.theory,
                    Micrometers(*radius_um),
                    bin.center,
                    &self.mean_squares[known].1,
                );
                light.add_to(&mut both, &drops);
                let mut row: Vec<f64> = both.into_iter().map(natural).collect();
                if let Some((index, light)) = caustic {
                    row[index] = row[index].max(light);
                }
                row
            };
            request.laws.iter().map(row).collect()
        })
    }

    /// Light of the exact solution around the antisolar point.
    pub fn glory(&self) -> Light {
        let theta_rad: Vec<f64> = self.request.rings.angles();
        self.by_band(|bin| {
            let row = |law: &(f64, f64)| glory(*law, bin, &theta_rad);
            self.request.laws.iter().map(row).collect()
        })
    }

    /// Light diffracted around the sun.
    pub fn corona(&self) -> Light {
        let angles = self.request.rings.angles();
        self.by_band(|bin| {
            let row = |(radius_um, _): &(f64, f64)| {
                let x = size_parameter(Micrometers(*radius_um), bin.center);
                angles
                    .iter()
                    .map(|theta_rad| corona(x, *theta_rad))
                    .collect()
            };
            self.request.laws.iter().map(row).collect()
        })
    }

    /// No light.
    pub fn none(&self) -> Light {
        let request = &self.request;
        Array3::zeros((request.laws.len(), request.bands.len(), request.rings.n))
    }

    /// Light of which the rows of a band, by law, are known.
    fn by_band(&self, rows: impl Fn(Bin) -> Vec<Vec<f64>> + Sync) -> Light {
        let bin = |band: &Band| Bin {
            center: band.center,
            width: band.width,
            index: self.request.water.refractive_index(band.center),
        };
        let bands = self.request.bands.par_iter();
        let rows: Vec<Vec<Vec<f64>>> = bands.map(|band| rows(bin(band))).collect();
        let shape = self.none().dim();
        Array3::from_shape_fn(shape, |(law, band, angle)| rows[band][law][angle])
    }
}

/// Natural light of both polarizations.
pub(crate) fn natural([s, p]: [f64; 2]) -> f64 {
    0.5 * (s + p)
}

#[cfg(test)]
mod tests {
    use ndarray::Array1;
    use ndarray::s;
    use niji_radiometry::WavelengthGrid;

    use super::*;
    use crate::request::SizeRows;
    use crate::request::TableRequest;
    use crate::theta_axis::TableAngles;

    const WATER: Water = Water::pure(15.0);
    const THEORIES: [Theory; 4] = [
        Theory::Geometric,
        Theory::AiryPublished,
        Theory::Airy,
        Theory::Uniform,
    ];
    const LAWS: [(f64, f64); 3] = [(30.0, 0.0), (200.0, 0.05), (500.0, 1.0 / 3.0)];

    fn bands() -> Vec<Band> {
        let band = |center: f64| Band {
            center: Nanometers(center),
            width: Nanometers(100.0),
        };
        [450.0, 550.0].map(band).into()
    }

    fn request(theory: Theory) -> LightRequest {
        LightRequest {
            theory,
            laws: LAWS.into(),
            bands: bands(),
            rings: Rings::around((2.36, 2.5), 1e-3),
            water: WATER,
        }
    }

    /// Error over the peak; measured worst 5.5e-4 (rays), 1.2e-3 (waves).
    const TOLERANCE: f64 = 2.5e-3;

    #[test]
    fn it_is_the_light_of_a_table() {
        let [radii, variances] = [LAWS.map(|law| law.0), LAWS.map(|law| law.1)];
        for theory in THEORIES {
            let request = request(theory);
            let theta_rad = request.rings.angles();
            let light = DropLight::new(request).of_order(2);
            let table = TableRequest {
                theory,
                orders: vec![2],
                theta_range_rad: (theta_rad[0], theta_rad[theta_rad.len() - 1]),
                tolerance: 1e-3,
                wavelengths: WavelengthGrid::new(450.0, 100.0, 2).unwrap(),
                effective_radius_um: radii.into(),
                effective_variance: variances.into(),
                rows: SizeRows::Laws,
                motion: None,
                sun_disc_diameter_rad: 0.0,
                water: WATER,
                airy_table: None,
            };
            let angles = TableAngles {
                theta_rad: theta_rad.clone(),
                of_orders: Vec::new(),
            };
            let table =
                crate::builder::values_at(&table, &angles, None, &crate::unwatched).unwrap();
            for (law, band) in [(0, 0), (1, 0), (1, 1), (2, 1)] {
                let found = light.slice(s![law, band, ..]);
                let [s, p] = [0, 1].map(|j| table.all.slice(s![j, law, law, band, ..]));
                let expected =
                    Array1::from_shape_fn(found.len(), |i| natural([s[i], p[i]].map(f64::from)));
                let peak = expected.iter().copied().fold(0.0, f64::max);
                // Beside a caustic rays are means over the step.
                let is_steep = |light: f64| theory == Theory::Geometric && light > 0.2 * peak;
                let both = found.iter().zip(&expected);
                let worst = both
                    .filter(|(_, expected)| !is_steep(**expected))
                    .map(|(found, expected)| (found - expected).abs())
                    .fold(0.0, f64::max);
                assert!(
                    worst < TOLERANCE * peak,
                    "{theory:?} {law}: {}",
                    worst / peak
                );
                let brightest = found.iter().copied().fold(0.0, f64::max);
                assert!(brightest > 0.98 * peak, "{theory:?}: {brightest} {peak}");
            }
        }
    }

    #[test]
    fn exact_theories_have_the_orders_of_the_uniform_one() {
        let order = |theory, p| DropLight::new(request(theory)).of_order(p);
        assert_eq!(order(Theory::Mie, 3), order(Theory::Uniform, 3));
        let debye = Theory::Debye { max_order: 2 };
        assert_eq!(order(debye, 2), order(Theory::Uniform, 2));
        assert!(order(debye, 3).iter().all(|light| *light == 0.0));
    }

    #[test]
    fn the_color_scale_is_the_primary_alone() {
        let drops = DropLight::new(request(Theory::GeometricPublished));
        assert!(drops.of_order(2).iter().any(|light| *light > 0.0));
        assert_eq!(drops.of_order(3), drops.none());
    }

    #[test]
    fn without_drops_or_bands_there_is_no_light() {
        let drops = DropLight::new(LightRequest {
            laws: Vec::new(),
            ..request(Theory::Uniform)
        });
        assert_eq!(drops.of_order(2).len(), 0);
        let drops = DropLight::new(LightRequest {
            bands: Vec::new(),
            ..request(Theory::Mie)
        });
        assert_eq!(drops.glory().len() + drops.corona().len(), 0);
    }
}
