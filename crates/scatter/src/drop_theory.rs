//! The exact theories, one drop after the other at one wavelength: its light, in parts that flattening
//! moves differently.
//!
//! Debye's series gives a part for each order with a bow and one for all others. The exact solution
//! knows no orders: what it has beyond reflected and transmitted rays (orders 0 and 1) counts as
//! secondary below the dark band, as primary above, with a smooth passage between; forwards, where it is diffracted
//! light, as neither, with another. It is so divided only where drops are flattened, and not for drops below 30 µm, whose bows flattening moves by a thousandth of
//! a degree.

use std::collections::BTreeMap;
use std::collections::BTreeSet;
use std::f64::consts::PI;

use niji_airy::GeometricOrder;
use niji_airy::RainbowRay;
use niji_airy::rainbow_ray;
use niji_mie::PartialWaves;
use niji_mie::RefractiveIndex;
use niji_mie::Sphere;
use niji_mie::cross_sections_of_each;
use niji_radiometry::Micrometers;
use niji_radiometry::Radians;
use niji_radiometry::size_parameter;

use crate::angle_grids::AngleGrid;
use crate::angle_grids::AngleGrids;
use crate::bow_light::Bin;
use crate::error::Error;

/// Primary and secondary bow.
pub(crate) const MOVED_ORDERS: [u32; 2] = [2, 3];
/// Drops below this radius (µm) are spheres.
pub(crate) const STILL_UM: f64 = 30.0;
/// Where light beyond rays is diffracted, and from where on it is a bow's: no bow's light is seen to move there.
const DIFFRACTED_UP_TO_RAD: [f64; 2] = [PI / 3.0, PI / 2.0];
/// Orders whose light flattening leaves where it is.
const RAYS: [u32; 2] = [0, 1];

/// How a drop is computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Solution {
    /// That of Lorenz and Mie, whose orders interfere.
    LorenzMie,
    /// Debye's series, order by order.
    Debye,
}

/// What all drops share at one wavelength.
#[derive(Clone)]
pub(crate) struct Setting<'a> {
    pub(crate) bin: Bin,
    /// Those of the series.
    pub(crate) orders: Vec<u32>,
    /// Grids of the flattened drops; empty for spheres.
    pub(crate) flattened: BTreeSet<usize>,
    pub(crate) grids: &'a AngleGrids,
}

/// Light of one drop at the angles of a grid, (dσ/dΩ)/(π a²) in 1/sr for both polarisations.
pub(crate) struct Part {
    /// The order whose bow flattening moves; `None` for light that stays.
    pub(crate) moved: Option<u32>,
    pub(crate) light: Vec<[f64; 2]>,
}

/// A theory, ready for drops of any size at one wavelength.
pub(crate) struct DropTheory<'a> {
    solution: Solution,
    setting: Setting<'a>,
    /// Of the exact solution, where drops are flattened.
    division: Option<Division>,
}

/// How the exact solution is divided.
pub(crate) struct Division {
    /// By grid.
    angles: BTreeMap<usize, Vec<DividedAngle>>,
}

/// What light is at an angle.
struct DividedAngle {
    /// That of rays, of both polarizations.
    rays: [f64; 2],
    /// Shares of both bows in what lies beyond rays.
    shares: [f64; 2],
}

impl<'a> DropTheory<'a> {
    pub(crate) fn new(solution: Solution, setting: Setting<'a>) -> Result<Self, Error> {
        let is_divided = solution == Solution::LorenzMie && !setting.flattened.is_empty();
        Ok(Self {
            solution,
            division: is_divided.then(|| Division::new(&setting)).transpose()?,
            setting,
        })
    }

    /// The light of each of some drops on the grid `grid_index`.
    pub(crate) fn drops(
        &self,
        radii: &[Micrometers],
        grid_index: usize,
    ) -> Result<Vec<Vec<Part>>, Error> {
        let angles = &self.setting.grids.at(grid_index).folded;
        let bin = self.setting.bin;
        let index = RefractiveIndex::from(bin.index);
        match self.solution {
            Solution::LorenzMie => {
                let of_sphere = |radius: &Micrometers| {
                    PartialWaves::of_sphere(size_parameter(*radius, bin.center), index)
                };
                let waves = radii.iter().map(of_sphere);
                let waves = waves.collect::<Result<Vec<PartialWaves>, _>>()?;
                let lights = cross_sections_of_each(&waves, angles).into_iter();
                let parts = |(light, radius): (Vec<[f64; 2]>, &Micrometers)| match &self.division {
                    Some(division) if radius.0 >= STILL_UM => division.parts(&light, grid_index),
                    Some(_) | None => vec![Part { moved: None, light }],
                };
                Ok(lights.zip(radii).map(parts).collect())
            }
            Solution::Debye => {
                let groups = self.groups();
                let parts = |radius: &Micrometers| -> Result<Vec<Part>, Error> {
                    let series = Sphere::from_radius(*radius, bin.center, index)?.debye_series();
                    let part = |(moved, orders): &(Option<u32>, Vec<u32>)| Part {
                        moved: *moved,
                        light: series.incoherent_cross_sections(orders, angles),
                    };
                    Ok(groups.iter().map(part).collect())
                };
                radii.iter().map(parts).collect()
            }
        }
    }

    /// Debye orders that move alike.
    fn groups(&self) -> Vec<(Option<u32>, Vec<u32>)> {
        let is_flattened = !self.setting.flattened.is_empty();
        let mut groups: Vec<(Option<u32>, Vec<u32>)> = Vec::new();
        for &p in &self.setting.orders {
            let moved = Some(p).filter(|p| is_flattened && MOVED_ORDERS.contains(p));
            match groups.iter_mut().find(|(of_group, _)| *of_group == moved) {
                Some((_, group)) => group.push(p),
                None => groups.push((moved, vec![p])),
            }
        }
        groups
    }
}

impl Division {
    fn new(setting: &Setting) -> Result<Self, Error> {
        let no_bow = || Error::Orders {
            found: MOVED_ORDERS.to_vec(),
        };
        let bows: Vec<RainbowRay> = MOVED_ORDERS
            .iter()
            .map(|&p| rainbow_ray(setting.bin.index, p).ok_or_else(no_bow))
            .collect::<Result<_, _>>()?;
        let rays: Vec<GeometricOrder> = RAYS
            .iter()
            .map(|&p| GeometricOrder::new(setting.bin.index, p).ok_or_else(no_bow))
            .collect::<Result<_, _>>()?;
        let (primary_rad, secondary_rad) = (bows[0].theta_rad(), bows[1].theta_rad());
        let at = |&theta: &f64| {
            let mut light = [0.0; 2];
            for order in &rays {
                let [s, p] = order.normalized_cross_section(Radians(theta));
                light = [light[0] + s, light[1] + p];
            }
            let primary = passage(theta, [secondary_rad, primary_rad]);
            let forwards = 1.0 - passage(theta, DIFFRACTED_UP_TO_RAD);
            DividedAngle {
                rays: light,
                shares: [primary, 1.0 - primary - forwards],
            }
        };
        let angles = |(index, grid): (usize, &AngleGrid)| {
            let angles = grid.angles_rad.iter().map(at).collect();
            (index, angles)
        };
        let divided = setting.flattened.iter();
        Ok(Self {
            angles: divided
                .map(|index| angles((*index, setting.grids.at(*index))))
                .collect(),
        })
    }

    fn parts(&self, light: &[[f64; 2]], grid_index: usize) -> Vec<Part> {
        let angles = &self.angles[&grid_index];
        let part = |moved: Option<usize>| {
            let at = |(light, DividedAngle { rays, shares }): (&[f64; 2], &DividedAngle)| {
                let still = if moved.is_none() { *rays } else { [0.0; 2] };
                let share = moved.map_or(1.0 - shares[0] - shares[1], |bow| shares[bow]);
                [0, 1].map(|j| still[j] + share * (light[j] - rays[j]))
            };
            Part {
                moved: moved.map(|bow| MOVED_ORDERS[bow]),
                light: light.iter().zip(angles).map(at).collect(),
            }
        };
        [None, Some(0), Some(1)].map(part).into()
    }
}

/// From 0 at one angle to 1 at another, smoothly.
fn passage(theta_rad: f64, [from_rad, to_rad]: [f64; 2]) -> f64 {
    let part = ((theta_rad - from_rad) / (to_rad - from_rad)).clamp(0.0, 1.0);
    part * part * (3.0 - 2.0 * part)
}
