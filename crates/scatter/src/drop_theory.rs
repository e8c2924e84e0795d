//! One drop after the other at one wavelength: its light, in parts that flattening moves differently.
//!
//! Theories by orders give a part for each order with a bow and one for all others. The exact solution
//! knows no orders: what it has beyond reflected and transmitted rays (orders 0 and 1) counts as
//! secondary below the dark band, as primary above, with a smooth passage between. It is so divided only
//! where drops are flattened.

use std::f64::consts::TAU;

use niji_airy::AiryForm;
use niji_airy::AiryTable;
use niji_airy::BowDirection;
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
use crate::bow_light::BowTheory;
use crate::bow_light::Order;
use crate::error::Error;
use crate::moebius_shift::scattering_angle_shift;

/// Orders with the two bows one sees.
const BOWS: [u32; 2] = [2, 3];
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
    /// dθ/d(m e) in radians, see [`crate::moebius_shift`].
    pub(crate) shift_rad: f64,
    pub(crate) light: Vec<[f64; 2]>,
}

/// A theory, ready for drops of any size at one wavelength.
pub(crate) enum DropTheory<'a> {
    /// The exact solution, with the shifts of primary and secondary and the parts of its light that
    /// count as secondary, by grid, where drops are flattened.
    Mie {
        setting: Setting<'a>,
        division: Option<Division>,
    },
    /// Debye orders, in groups that move alike.
    Debye {
        setting: Setting<'a>,
        groups: Vec<(f64, Vec<u32>)>,
    },
    /// Bows of rays, Airy's or the uniform theory.
    Bows {
        setting: Setting<'a>,
        airy_table: Option<&'a AiryTable>,
        form: AiryForm,
        orders: Vec<BowOrder>,
    },
}

/// How the exact solution is divided.
pub(crate) struct Division {
    shifts_rad: [f64; 2],
    /// By grid and angle: light of rays, and the weight of the primary.
    angles: Vec<Vec<([f64; 2], f64)>>,
}

/// One order at the angles of every grid.
pub(crate) struct BowOrder {
    shift_rad: f64,
    directions: Vec<Vec<BowDirection>>,
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
        let mut groups: Vec<(f64, Vec<u32>)> = Vec::new();
        for &p in orders {
            let shift_rad = shift_rad(&setting, p);
            match groups.iter_mut().find(|(shift, _)| *shift == shift_rad) {
                Some((_, group)) => group.push(p),
                None => groups.push((shift_rad, vec![p])),
            }
        }
        Self::Debye { setting, groups }
    }

    pub(crate) fn bows(
        setting: Setting<'a>,
        theory: BowTheory,
        orders: &[u32],
        airy_table: Option<&'a AiryTable>,
    ) -> Result<Self, Error> {
        let order = |&p: &u32| {
            let no_order = || Error::Orders {
                found: orders.to_vec(),
            };
            let order = theory.order(setting.bin, p).ok_or_else(no_order)?;
            let directions = |grid: &AngleGrid| directions(&order, grid);
            Ok(BowOrder {
                shift_rad: shift_rad(&setting, p),
                directions: setting.grids.iter().map(directions).collect(),
            })
        };
        Ok(Self::Bows {
            setting,
            airy_table,
            form: theory.form(),
            orders: orders.iter().map(order).collect::<Result<_, _>>()?,
        })
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
                    None => vec![Part {
                        shift_rad: 0.0,
                        light,
                    }],
                })
            }
            Self::Debye { setting, groups } => {
                let angles = &setting.grids.at(grid_index).folded;
                let series = sphere(setting, radius)?.debye_series();
                let part = |(shift_rad, orders): &(f64, Vec<u32>)| Part {
                    shift_rad: *shift_rad,
                    light: series.incoherent_cross_sections(orders, angles),
                };
                Ok(groups.iter().map(part).collect())
            }
            Self::Bows {
                setting,
                airy_table,
                form,
                orders,
            } => {
                let x = TAU * 1e3 * radius.0 / setting.bin.center.0;
                let scale = (x * x).cbrt();
                let factor = form.size_factor(radius, setting.bin.center);
                let light = |direction: &BowDirection| {
                    let z = scale * direction.argument;
                    let (f, slope) =
                        airy_table.map_or((0.0, 0.0), |table| table.value_with_derivative(z));
                    let squares = [factor * f * f, factor / scale * slope * slope];
                    [0, 1].map(|j| {
                        direction.strength[j] * squares[0]
                            + direction.derivative_strength[j] * squares[1]
                            + direction.rays[j]
                    })
                };
                let part = |order: &BowOrder| Part {
                    shift_rad: order.shift_rad,
                    light: order.directions[grid_index].iter().map(light).collect(),
                };
                Ok(orders.iter().map(part).collect())
            }
        }
    }
}

impl Division {
    fn new(setting: &Setting) -> Result<Self, Error> {
        let no_bow = || Error::Orders {
            found: BOWS.to_vec(),
        };
        let bows: Vec<RainbowRay> = BOWS
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
            shifts_rad: [
                scattering_angle_shift(&bows[0]),
                scattering_angle_shift(&bows[1]),
            ],
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
                shift_rad: 0.0,
                light: angles.iter().map(|(rays, _)| *rays).collect(),
            },
            Part {
                shift_rad: self.shifts_rad[0],
                light: beyond_rays(&|primary| primary),
            },
            Part {
                shift_rad: self.shifts_rad[1],
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

/// How the bow of an order moves; 0 where nothing does.
fn shift_rad(setting: &Setting, p: u32) -> f64 {
    let bow = rainbow_ray(setting.bin.index, p).filter(|_| setting.is_flattened);
    bow.map_or(0.0, |ray| scattering_angle_shift(&ray))
}

/// An order at the angles of a grid; rays as means over its steps, which need no clipped caustic.
fn directions(order: &Order, grid: &AngleGrid) -> Vec<BowDirection> {
    let at = |&theta: &f64| {
        let half = 0.5 * grid.step_rad;
        let step = (Radians(theta - half), Radians(theta + half));
        match order {
            Order::Airy(bow, AiryForm::Absolute) => bow.direction(Radians(theta)),
            Order::Airy(bow, AiryForm::Published) => bow.published_direction(Radians(theta)),
            Order::Uniform(bow) => bow.direction(Radians(theta)),
            Order::Rays(rays) => rays_alone(rays.mean_over_ring(step.0, step.1)),
            Order::Colors(bow) => rays_alone(bow.mean_over_ring(step.0, step.1)),
        }
    };
    grid.angles_rad.iter().map(at).collect()
}

fn rays_alone(rays: [f64; 2]) -> BowDirection {
    BowDirection {
        argument: 0.0,
        strength: [0.0; 2],
        derivative_strength: [0.0; 2],
        rays,
    }
}
