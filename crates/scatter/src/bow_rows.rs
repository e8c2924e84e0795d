//! Rows of a table by geometric optics or Airy's theory: size average and sun's disc in one.

use niji_radiometry::Micrometers;
use rayon::prelude::*;

use crate::bow_light::Bin;
use crate::bow_light::BowLight;
use crate::bow_light::BowTheory;
use crate::bow_light::LawDrops;
use crate::bow_light::Places;
use crate::error::Error;
use crate::mean_square::Averaging;
use crate::mean_square::MeanSquare;
use crate::mean_square::lowest_z;
use crate::request::SizeRow;
use crate::request::TableRequest;
use crate::rings::DiscAverage;
use crate::rings::Rings;
use niji_radiometry::size_parameter;

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
    pub(crate) fn new(request: &TableRequest, theta_rad: &[f64]) -> Result<Self, Error> {
        let theory = request.theory.expected_bows();
        let (places, orders) = (Places::of_table(request, theta_rad), request.orders_in());
        let exponent = theory.form().radius_exponent();
        let darkest_z = request
            .variances_of_drops()
            .map(|variance| lowest_z(exponent, variance))
            .fold(0.0, f64::min);
        let smallest = request.effective_radius_um.first().copied();
        let light = |(index, p): (usize, u32)| {
            let bin = Bin::new(request, index);
            let order = theory.order(bin, p).ok_or_else(|| Error::Orders {
                found: orders.clone(),
            })?;
            let x = smallest.map_or(1.0, |um| size_parameter(Micrometers(um), bin.center));
            let order = order.above(darkest_z / (x * x).cbrt());
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
    fn highest_z(&self, request: &TableRequest) -> f64 {
        let largest_um = request.effective_radius_um.last().copied().unwrap_or(1.0);
        let orders = request.orders_in();
        let z = |index: usize| {
            let x = size_parameter(Micrometers(largest_um), request.wavelengths.center(index));
            let arguments = self.at(index, &orders).map(BowLight::largest_argument);
            arguments.fold(0.0, f64::max) * (x * x).cbrt()
        };
        (0..self.orders.len()).map(z).fold(0.0, f64::max)
    }
}

/// Everything that the rows of all sizes and wavelengths share.
pub(crate) struct BowRows<'a> {
    request: &'a TableRequest<'a>,
    pub(crate) lights: BowLights,
    /// By effective variance.
    mean_squares: Vec<MeanSquare>,
    /// Over the angles of the table.
    disc: DiscAverage,
}

/// Whose light is asked for.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Drops {
    pub(crate) radius: Micrometers,
    /// Which effective variance of the table their law has; `None` for drops of one size.
    pub(crate) variance_index: Option<usize>,
}

impl Drops {
    pub(crate) fn of_row(row: &SizeRow) -> Self {
        Self {
            radius: row.radius,
            variance_index: Some(row.variance_index),
        }
    }
}

impl<'a> BowRows<'a> {
    pub(crate) fn new(request: &'a TableRequest<'a>, lights: BowLights, theta_rad: &[f64]) -> Self {
        let radius_rad = request.disc_radius_rad();
        let row = |rings: &Rings, theta_rad: f64| rings.disc_row(theta_rad, radius_rad);
        Self {
            request,
            mean_squares: mean_squares(request, &lights),
            disc: lights.places.disc_average(theta_rad, row),
            lights,
        }
    }

    /// (dσ/dΩ)/(π⟨r²⟩) in 1/sr of some orders at every angle of the table, for both polarisations.
    pub(crate) fn light(
        &self,
        wavelength_index: usize,
        drops: Drops,
        orders: &[u32],
    ) -> Vec<[f64; 2]> {
        let wavelength = self.request.wavelengths.center(wavelength_index);
        let mean_square = match drops.variance_index {
            Some(index) => &self.mean_squares[index],
            None => &MeanSquare::Single,
        };
        let drops = LawDrops::new(self.lights.theory, drops.radius, wavelength, mean_square);
        let mut light = vec![[0.0; 2]; self.lights.places.n()];
        for order in self.lights.at(wavelength_index, orders) {
            order.add_to(&mut light, &drops);
        }
        self.disc.of_both(&light)
    }
}

fn mean_squares(request: &TableRequest, lights: &BowLights) -> Vec<MeanSquare> {
    let theory = lights.theory;
    let highest_z = lights.highest_z(request);
    let mean_square = |effective_variance: f64| {
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
    request.variances_of_drops().map(mean_square).collect()
}
