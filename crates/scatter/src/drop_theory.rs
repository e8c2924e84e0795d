//! The exact theories, one drop after the other at one wavelength: its light, in parts that flattening
//! moves differently.
//!
//! Debye's series gives a part for each order with a bow and one for all others. The exact solution
//! knows no orders: what it has beyond reflected and transmitted rays (orders 0 and 1) counts as
//! secondary below the dark band, as primary above, with a smooth passage between. It is so divided only
//! where drops are flattened.

use niji_airy::GeometricOrder;
use niji_airy::RainbowRay;
use niji_airy::rainbow_ray;
use niji_mie::RefractiveIndex;
use niji_mie::Sphere;
use niji_radiometry::Micrometers;
use niji_radiometry::Radians;

use crate::angle_grids::AngleGrid;
use crate::angle_grids::AngleGrids;
use crate::bow_light::Bin;
use crate::error::Error;
use crate::theory::MOVED_ORDERS;

/// Orders whose light flattening leaves where it is.
const RAYS: [u32; 2] = [0, 1];

/// What all drops share at one wavelength.
#[derive(Clone, Copy)]
pub(crate) struct Setting<'a> {
    pub(crate) bin: Bin,
    pub(crate) is_flattened: bool,
    pub(crate) grids: &'a AngleGrids,
}

/// Light of one drop at the angles of a grid, (dσ/dΩ)/(π a²) in 1/sr for both polarisations.
pub(crate) struct Part {
    /// The order that it is, of those that move.
    pub(crate) moved: Option<u32>,
    pub(crate) light: Vec<[f64; 2]>,
}

/// A theory, ready for drops of any size at one wavelength.
pub(crate) enum DropTheory<'a> {
    /// The exact solution, with the parts of its light that count as secondary, by grid, where drops are
    /// flattened.
    Mie {
        setting: Setting<'a>,
        division: Option<Division>,
    },
    /// Debye orders, in groups that move alike.
    Debye {
        setting: Setting<'a>,
        groups: Vec<(Option<u32>, Vec<u32>)>,
    },
}

/// How the exact solution is divided.
pub(crate) struct Division {
    /// By grid and angle: light of rays, and the weight of the primary.
    angles: Vec<Vec<([f64; 2], f64)>>,
}

impl<'a> DropTheory<'a> {
    pub(crate) fn mie(setting: Setting<'a>) -> Result<Self, Error> {
        let division = if setting.is_flattened {
            Some(Division::new(&setting)?)
        } else {
            None
        };
        Ok(Self::Mie { setting, division })
    }

    pub(crate) fn debye(setting: Setting<'a>, orders: &[u32]) -> Self {
        let mut groups: Vec<(Option<u32>, Vec<u32>)> = Vec::new();
        for &p in orders {
            let moved = Some(p).filter(|p| setting.is_flattened && MOVED_ORDERS.contains(p));
            match groups.iter_mut().find(|(of_group, _)| *of_group == moved) {
                Some((_, group)) => group.push(p),
                None => groups.push((moved, vec![p])),
            }
        }
        Self::Debye { setting, groups }
    }

    /// The light of one drop on the grid `grid_index`.
    pub(crate) fn drop(&self, radius: Micrometers, grid_index: usize) -> Result<Vec<Part>, Error> {
        match self {
            Self::Mie { setting, division } => {
                let angles = &setting.grids.at(grid_index).folded;
                let light = sphere(setting, radius)?
                    .waves()
                    .normalized_cross_sections(angles);
                Ok(match division {
                    Some(division) => division.parts(&light, grid_index),
                    None => vec![Part { moved: None, light }],
                })
            }
            Self::Debye { setting, groups } => {
                let angles = &setting.grids.at(grid_index).folded;
                let series = sphere(setting, radius)?.debye_series();
                let part = |(moved, orders): &(Option<u32>, Vec<u32>)| Part {
                    moved: *moved,
                    light: series.incoherent_cross_sections(orders, angles),
                };
                Ok(groups.iter().map(part).collect())
            }
        }
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
            let part = ((theta - secondary_rad) / (primary_rad - secondary_rad)).clamp(0.0, 1.0);
            (light, part * part * (3.0 - 2.0 * part))
        };
        let angles = |grid: &AngleGrid| grid.angles_rad.iter().map(at).collect();
        Ok(Self {
            angles: setting.grids.iter().map(angles).collect(),
        })
    }

    fn parts(&self, light: &[[f64; 2]], grid_index: usize) -> Vec<Part> {
        let angles = &self.angles[grid_index];
        let beyond_rays = |weight: &dyn Fn(f64) -> f64| {
            let at = |(light, (rays, primary)): (&[f64; 2], &([f64; 2], f64))| {
                [0, 1].map(|j| weight(*primary) * (light[j] - rays[j]))
            };
            light.iter().zip(angles).map(at).collect()
        };
        vec![
            Part {
                moved: None,
                light: angles.iter().map(|(rays, _)| *rays).collect(),
            },
            Part {
                moved: Some(MOVED_ORDERS[0]),
                light: beyond_rays(&|primary| primary),
            },
            Part {
                moved: Some(MOVED_ORDERS[1]),
                light: beyond_rays(&|primary| 1.0 - primary),
            },
        ]
    }
}

fn sphere(setting: &Setting, radius: Micrometers) -> Result<Sphere, Error> {
    let index = RefractiveIndex {
        n: setting.bin.index,
        k: 0.0,
    };
    Sphere::from_radius(radius, setting.bin.center, index)
        .map_err(|error| Error::Drop(error.to_string()))
}
