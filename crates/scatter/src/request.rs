//! What a scattering table is made from, and what can be wrong with it.

use std::f64::consts::PI;

use niji_airy::AiryTable;
use niji_radiometry::Bytes;
use niji_radiometry::Micrometers;
use niji_radiometry::Water;
use niji_radiometry::WavelengthGrid;
use serde::Deserialize;
use serde::Serialize;

use crate::drop_motion::DropMotion;
use crate::error::Error;
use crate::moved_orders::MovedOrders;
use crate::theory::ORDERS;
use crate::theory::Theory;
use crate::theta_axis::NumberOfAngles;

/// Largest table: the renderer holds all of it.
const LARGEST_TABLE: Bytes = Bytes(4 << 30);

/// What the rows of a table stand for.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum SizeRows {
    /// A law of each effective radius and variance, of variance 0 that very size.
    Laws,
    /// Single sizes, each for all between its neighbors: laws no narrower than this effective variance
    /// are sums over them.
    Bins {
        /// Step of ln r over which each is a mean, from one to the next; 0 for just these sizes.
        ln_step: f64,
        /// Effective variance of the narrowest law.
        narrowest_variance: f64,
    },
}

/// A row of a table: drops of one effective radius and variance.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SizeRow {
    /// Number of the row.
    pub(crate) index: usize,
    pub(crate) radius_index: usize,
    pub(crate) variance_index: usize,
    pub(crate) radius: Micrometers,
    pub(crate) variance: f64,
}

/// What a scattering table is made from.
#[derive(Clone, Debug)]
pub struct TableRequest<'a> {
    /// How a drop scatters.
    pub theory: Theory,
    /// Orders that take part, each once: 2 primary, 3 secondary, up to 7; 0 reflected and 1 transmitted
    /// light are rays in the theories of bows, without the light diffracted forward, which the orders
    /// of [`Theory::Debye`] have in 0. Those add the orders up to theirs, the published color scale is
    /// the primary alone, and [`Theory::Mie`] has them all whatever is asked for, as the small drops of
    /// [`Theory::BySize`] have.
    pub orders: Vec<u32>,
    /// Smallest and largest scattering angle in radians.
    pub theta_range_rad: (f64, f64),
    /// Error of linear interpolation over the peak of the bow: the largest in θ, and, in
    /// [`crate::adaptive_table`], the rms over the angles along the other axes.
    pub tolerance: f64,
    /// Wavelength bins.
    pub wavelengths: WavelengthGrid,
    /// Effective radii in micrometres.
    pub effective_radius_um: Vec<f64>,
    /// Effective variances.
    pub effective_variance: Vec<f64>,
    /// What the rows stand for.
    pub rows: SizeRows,
    /// How flattened drops move, where the light that flattening moves is kept apart; `None` for
    /// spheres.
    pub motion: Option<DropMotion>,
    /// Diameter of the sun's disc in radians; 0 for a point.
    pub sun_disc_diameter_rad: f64,
    /// What the drops are made of.
    pub water: Water,
    /// Airy's integral in advance; `None` computes every value.
    pub airy_table: Option<&'a AiryTable>,
}

/// A smaller disc is a point: it blurs less than the fringes of any drop are wide, and rings across it would fill
/// the memory.
const SMALLEST_DISC_RADIUS_RAD: f64 = 1e-5;

impl TableRequest<'_> {
    /// Radius of the disc over which light is averaged in radians; 0 for a point.
    pub(crate) fn disc_radius_rad(&self) -> f64 {
        let radius_rad = 0.5 * self.sun_disc_diameter_rad;
        if radius_rad < SMALLEST_DISC_RADIUS_RAD {
            0.0
        } else {
            radius_rad
        }
    }

    /// The orders whose light is kept apart ([`Theory::moved_orders`]).
    pub(crate) fn moved_orders(&self) -> Vec<u32> {
        let moves = self.motion.is_some();
        let moved = moves.then(|| self.theory.moved_orders(&self.orders));
        moved.unwrap_or_default()
    }

    /// Is there light that drops diffract forward? Order 0 is reflection and diffraction together.
    pub(crate) fn holds_diffraction(&self) -> bool {
        let has_order = self.theory.holds_every_order() || self.orders.contains(&0);
        self.theory.is_exact() && has_order
    }

    /// How many rows there are.
    pub(crate) fn n_rows(&self) -> usize {
        self.effective_radius_um.len() * self.effective_variance.len()
    }

    /// All rows, the variance fastest.
    pub(crate) fn size_rows(&self) -> impl Iterator<Item = SizeRow> {
        let n_variances = self.effective_variance.len();
        (0..self.n_rows()).map(move |index| {
            let (radius_index, variance_index) = (index / n_variances, index % n_variances);
            SizeRow {
                index,
                radius_index,
                variance_index,
                radius: Micrometers(self.effective_radius_um[radius_index]),
                variance: self.effective_variance[variance_index],
            }
        })
    }

    /// Effective variances of the drops in the rows: a mean over a step of ln r has a twelfth of its square.
    pub(crate) fn variances_of_drops(&self) -> impl Iterator<Item = f64> {
        let least = match self.rows {
            SizeRows::Laws => 0.0,
            SizeRows::Bins { ln_step, .. } => ln_step * ln_step / 12.0,
        };
        let variances = self.effective_variance.iter();
        variances.map(move |variance| variance.max(least))
    }

    /// The orders that take part.
    pub(crate) fn orders_in(&self) -> Vec<u32> {
        self.theory.orders_among(&self.orders)
    }

    /// How many places the table has: rows times angles of all light and of each order that is kept apart. At each
    /// there are two values a wavelength, one for each polarization.
    #[must_use]
    pub fn n_places(&self, angles: &NumberOfAngles) -> usize {
        let n_moved = MovedOrders::new(self).n_moved();
        let of_orders: usize = angles.of_orders.iter().map(|n| n * n_moved).sum();
        self.n_rows() * angles.all + of_orders
    }

    /// Refuses a table of so many angles that would be too large.
    ///
    /// # Errors
    /// [`Error::TooLarge`].
    pub fn check_size(&self, angles: &NumberOfAngles) -> Result<(), Error> {
        let (radii, variances) = (
            self.effective_radius_um.len(),
            self.effective_variance.len(),
        );
        let wavelengths = self.wavelengths.len();
        let n_values = 2.0 * self.n_places(angles) as f64 * wavelengths as f64;
        let needed = Bytes::of(size_of::<f32>() as f64 * n_values);
        if needed <= LARGEST_TABLE {
            return Ok(());
        }
        Err(Error::TooLarge {
            needed,
            most: LARGEST_TABLE,
            radii,
            variances,
            wavelengths,
            angles: angles.all,
        })
    }

    /// Refuses what no table can be made of.
    ///
    /// # Errors
    /// An axis that is empty, not ascending or outside its range, orders that take no part, water of
    /// which nobody measured the index, or sizes that the theory does not compute.
    pub fn check(&self) -> Result<(), Error> {
        let refused = |axis, found, expected| {
            Err(Error::Axis {
                axis,
                found,
                expected,
            })
        };
        let radii = &self.effective_radius_um;
        let sound_radius = |radius: &f64| *radius > 0.0 && radius.is_finite();
        if !(is_ascending(radii) && radii.iter().all(sound_radius)) {
            let expected = "ascending radii above 0 um";
            return refused("effective radius", format!("{radii:?}"), expected);
        }
        let variances = &self.effective_variance;
        let sound_variance = |variance: &f64| (0.0..0.5).contains(variance);
        let found = format!("{variances:?}");
        if !(is_ascending(variances) && variances.iter().all(sound_variance)) {
            let expected = "ascending values from 0 to below 0.5";
            return refused("effective variance", found, expected);
        }
        // Compared with the value that stands for single sizes.
        if (self.rows != SizeRows::Laws || self.motion.is_some()) && *variances != [0.0] {
            let expected = "0 alone, for a table of single sizes";
            return refused("effective variance", found, expected);
        }
        let (low, high) = self.theta_range_rad;
        if !(low >= 0.0 && high > low && high <= PI + 1e-12) {
            let found = format!("{} to {} degrees", low.to_degrees(), high.to_degrees());
            return refused("theta", found, "a range within 0 to 180 degrees");
        }
        let tolerance = self.tolerance;
        if !(tolerance > 0.0 && tolerance <= 1.0) {
            return refused("tolerance", tolerance.to_string(), "above 0 and at most 1");
        }
        if let SizeRows::Bins { ln_step, .. } = self.rows
            && !(0.0..=1.0).contains(&ln_step)
        {
            return refused("step of ln r", ln_step.to_string(), "0 to 1");
        }
        if !(0.0..0.1).contains(&self.sun_disc_diameter_rad) {
            let found = format!("{} rad", self.sun_disc_diameter_rad);
            return refused("sun disc", found, "0 to 0.1 rad");
        }
        self.water.check().map_err(Error::Water)?;
        let is_new = |(index, p): (usize, &u32)| !self.orders[..index].contains(p);
        let sound_orders = !self.orders_in().is_empty()
            && self.orders.iter().all(|p| ORDERS.contains(p))
            && self.orders.iter().enumerate().all(is_new);
        if !self.theory.ignores_orders() && !sound_orders {
            return Err(Error::Orders {
                found: self.orders.clone(),
            });
        }
        Ok(())
    }
}

/// Not empty, and every value above the one before; a NaN is above none.
fn is_ascending(values: &[f64]) -> bool {
    !values.is_empty() && values.windows(2).all(|pair| pair[1] > pair[0])
}
