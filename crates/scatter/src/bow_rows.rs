//! Rows of a table by geometric optics or Airy's theory: size average and sun's disc in one.

use std::f64::consts::TAU;

use niji_radiometry::Micrometers;
use rayon::prelude::*;

use crate::bow_light::Bin;
use crate::bow_light::BowLight;
use crate::bow_light::BowTheory;
use crate::bow_light::LawDrops;
use crate::bow_light::Places;
use crate::by_size::Blend;
use crate::error::Error;
use crate::mean_square::Averaging;
use crate::mean_square::MeanSquare;
use crate::request::SizeRows;
use crate::request::TableRequest;
use crate::rings::Rings;
use crate::sun_disc::AverageRow;

/// Rings across the sun's disc. Against a literal average over the disc, in parts of the peak: 1.7e-5
/// for single drops of 0.1 mm, 6e-4 for 1 mm and 1e-3 for 1.5 mm radius at 400 nm, 12 degrees inside.
const RINGS_PER_DISC: f64 = 20.0;

/// Largest error of means over sizes.
const MEAN_ERROR: f64 = 1e-5;

/// What no size changes of the orders of a table.
#[derive(Debug)]
pub(crate) struct BowLights {
    theory: BowTheory,
    places: Places,
    /// By wavelength, order by order.
    orders: Vec<Vec<(u32, BowLight)>>,
}

impl BowLights {
    /// Of all orders of a request, to be seen from these angles.
    pub(crate) fn new(
        request: &TableRequest,
        theory: BowTheory,
        theta_rad: &[f64],
    ) -> Result<Self, Error> {
        let (places, orders) = (places(request, theta_rad), request.orders_in());
        let light = |(index, p): (usize, u32)| {
            let order = theory.order(Bin::new(request, index), p);
            let order = order.ok_or_else(|| Error::Orders {
                found: orders.clone(),
            })?;
            Ok((p, BowLight::new(&order, &places)))
        };
        let of_wavelength = |index| orders.iter().map(|p| light((index, *p))).collect();
        let wavelengths = (0..request.wavelengths.len()).into_par_iter();
        let of_wavelengths = wavelengths
            .map(of_wavelength)
            .collect::<Result<_, Error>>()?;
        Ok(Self {
            theory,
            orders: of_wavelengths,
            places,
        })
    }

    /// Whether they serve other angles of the same request.
    pub(crate) fn are_rings(&self) -> bool {
        matches!(self.places, Places::Rings(_))
    }

    fn at(&self, wavelength_index: usize, wanted: &[u32]) -> impl Iterator<Item = &BowLight> {
        let orders = self.orders[wavelength_index].iter();
        orders.filter_map(move |(p, light)| wanted.contains(p).then_some(light))
    }

    /// The largest z for drops of a radius (µm).
    fn highest_z(&self, request: &TableRequest, orders: &[u32]) -> f64 {
        let largest_um = request.effective_radius_um.last().copied().unwrap_or(1.0);
        let z = |index: usize| {
            let x = TAU * 1e3 * largest_um / request.wavelengths.center(index).0;
            let arguments = self.at(index, orders).map(BowLight::largest_argument);
            arguments.fold(0.0, f64::max) * (x * x).cbrt()
        };
        (0..self.orders.len()).map(z).fold(0.0, f64::max)
    }
}

/// Everything that the rows of all sizes and wavelengths share.
pub(crate) struct BowRows<'a> {
    request: &'a TableRequest<'a>,
    lights: &'a BowLights,
    /// Those that take part.
    orders: Vec<u32>,
    /// By effective variance.
    mean_squares: Vec<MeanSquare>,
    /// By angle of the table; `None` without a disc.
    averages: Option<Vec<AverageRow>>,
    /// Which sizes others make, in a table by size.
    blend: Option<Blend>,
}

/// One effective radius with one effective variance.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SizeRow {
    pub(crate) radius_index: usize,
    pub(crate) variance_index: usize,
}

impl<'a> BowRows<'a> {
    pub(crate) fn new(
        request: &'a TableRequest<'a>,
        lights: &'a BowLights,
        theta_rad: &[f64],
    ) -> Result<Self, Error> {
        let orders = request.orders_in();
        let highest_z = lights.highest_z(request, &orders);
        Ok(Self {
            request,
            mean_squares: mean_squares(request, lights.theory, highest_z),
            averages: averages(request, &lights.places, theta_rad),
            lights,
            orders,
            blend: (request.theory.method().blends())
                .then(|| Blend::new(request))
                .transpose()?,
        })
    }

    /// Whether a row has light of bows at a wavelength.
    pub(crate) fn is_lit(&self, wavelength_index: usize, size: &SizeRow) -> bool {
        let row = size.radius_index * self.request.effective_variance.len() + size.variance_index;
        let wavelength = self.request.wavelengths.center(wavelength_index);
        let blend = self.blend.as_ref();
        blend.is_none_or(|blend| blend.is_mixed_law(row) || blend.share(row, wavelength) < 1.0)
    }

    /// All rows, the variance fastest.
    pub(crate) fn size_rows(&self) -> Vec<SizeRow> {
        let n_variances = self.request.effective_variance.len();
        let n_rows = self.request.effective_radius_um.len() * n_variances;
        (0..n_rows)
            .map(|row| SizeRow {
                radius_index: row / n_variances,
                variance_index: row % n_variances,
            })
            .collect()
    }

    /// (dσ/dΩ)/(π⟨r²⟩) in 1/sr at every angle of the table, for both polarisations.
    pub(crate) fn row(&self, wavelength_index: usize, size: &SizeRow) -> Vec<[f64; 2]> {
        let wavelength = self.request.wavelengths.center(wavelength_index);
        let radius = Micrometers(self.request.effective_radius_um[size.radius_index]);
        let drops = LawDrops {
            factor: self.lights.theory.form().size_factor(radius, wavelength),
            parameter: TAU * 1e3 * radius.0 / wavelength.0,
            mean_square: &self.mean_squares[size.variance_index],
        };
        let mut light = vec![[0.0; 2]; self.lights.places.n()];
        for order in self.lights.at(wavelength_index, &self.orders) {
            order.add_to(&mut light, &drops);
        }
        match &self.averages {
            Some(averages) => averages.iter().map(|row| row.apply(&light)).collect(),
            None => light,
        }
    }
}

/// Where light is computed for the angles of a table.
pub(crate) fn places(request: &TableRequest, theta_rad: &[f64]) -> Places {
    let radius_rad = 0.5 * request.sun_disc_diameter_rad;
    if radius_rad <= 0.0 {
        return Places::Angles(theta_rad.to_vec());
    }
    let step_rad = 2.0 * radius_rad / RINGS_PER_DISC;
    Places::Rings(Rings::over(request.theta_range_rad, step_rad, radius_rad))
}

/// How the sun's disc is averaged over at the angles of a table.
fn averages(request: &TableRequest, places: &Places, theta_rad: &[f64]) -> Option<Vec<AverageRow>> {
    let Places::Rings(rings) = places else {
        return None;
    };
    let row = |&theta: &f64| rings.disc_row(theta, 0.5 * request.sun_disc_diameter_rad);
    Some(theta_rad.par_iter().map(row).collect())
}

fn mean_squares(request: &TableRequest, theory: BowTheory, highest_z: f64) -> Vec<MeanSquare> {
    let bin_variance = bin_variance(request);
    let mean_square = |&effective_variance: &f64| {
        let effective_variance = effective_variance.max(bin_variance);
        MeanSquare::compute(Averaging {
            exponent: theory.form().radius_exponent(),
            // Rays do not ask for it.
            effective_variance: if theory.has_waves() {
                effective_variance
            } else {
                0.0
            },
            error: MEAN_ERROR,
            highest_z,
            airy_table: request.airy_table,
        })
    };
    request.effective_variance.iter().map(mean_square).collect()
}

/// Effective variance of a law as wide as a bin of single sizes: a twelfth of the squared step of ln r.
pub(crate) fn bin_variance(request: &TableRequest) -> f64 {
    match request.rows {
        SizeRows::Laws => 0.0,
        SizeRows::Bins { ln_step, .. } => ln_step * ln_step / 12.0,
    }
}
