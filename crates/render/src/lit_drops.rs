//! Drops that know how much of the sun reaches them.
//!
//! tau_sun(x) = int_0^inf pi M2(x + s w) ds   at Q = 1, `w` unit vector towards the sun
//!
//! stands at every node of the bricks and is interpolated there like a moment, before the
//! exponential: exp(-tau) of a mean is right along a straight shadow edge where the mean of exp(-tau)
//! is not. All modes dim each other. The level's efficiency Q multiplies it later.

use glam::DVec3;
use niji_dropfield::Bricks;
use niji_dropfield::NodeValues;
use niji_dropfield::SizeRange;
use niji_geometry::Aabb;
use niji_geometry::Ray;

use crate::error::Error;
use crate::levels::SunPath;
use crate::mirrored_drops::Mirror;
use crate::mirrored_drops::MirroredDrops;
use crate::piece::EXTINCTION_PER_M2;
use crate::progress::Progress;
use crate::progress::tell;
use crate::progress::unwatched;
use crate::shadow_error::ShadowError;
use crate::sun_sweep::SunSweep;
use crate::water_surface::MirroredLight;
use crate::water_surface::WaterSurface;

/// Fractions of the way through a cell of the two Gauss points: exact for cubics.
const GAUSS: [f32; 2] = [0.211_324_87, 0.788_675_1];

/// More steps than this from a node to the sun are a mistake in the step's length.
const MAX_STEPS: f64 = 1e6;

/// Drop volumes with the sun's optical depth at their nodes.
///
/// A renderer takes drops only in this form, so that no picture is made with shadows of another sun
/// or of none.
#[derive(Clone, Debug)]
pub struct LitDrops {
    bricks: Vec<Bricks>,
    shadow: Shadow,
    bounds: Option<Aabb>,
    size_range: Option<SizeRange>,
    shadow_error: Option<ShadowError>,
    sun_path: SunPath,
    mirrored: Option<Box<MirroredDrops>>,
}

/// Where the shadows in the bricks fall.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Shadow {
    None,
    From { sun_direction: DVec3 },
}

impl LitDrops {
    /// No drops at all.
    pub fn none() -> Self {
        Self {
            bricks: Vec::new(),
            shadow: Shadow::None,
            bounds: None,
            size_range: None,
            shadow_error: None,
            sun_path: SunPath::Ignore,
            mirrored: None,
        }
    }

    /// Find the optical depth towards the sun at the nodes of all modes.
    ///
    /// # Errors
    /// [`Error::SunDirection`] if the direction is not a unit vector; [`Error::Level`] if a length
    /// of the level is not above zero; [`Error::SunVolumeTooLarge`] if it asks for too many nodes.
    pub fn new(
        bricks: Vec<Bricks>,
        sun_direction: DVec3,
        sun_path: SunPath,
    ) -> Result<Self, Error> {
        Self::watched(bricks, sun_direction, sun_path, &unwatched)
    }

    /// The same for somebody who waits.
    ///
    /// # Errors
    /// As [`LitDrops::new`]; [`Error::Stopped`].
    pub fn watched(
        bricks: Vec<Bricks>,
        sun_direction: DVec3,
        sun_path: SunPath,
        progress: Progress,
    ) -> Result<Self, Error> {
        crate::sun_direction::check_sun_direction(sun_direction)?;
        let bounds = union_of_bounds(&bricks);
        let sizes = bricks.iter().filter_map(Bricks::size_range);
        let size_range = sizes.reduce(SizeRange::union);
        let mut lit = Self {
            bricks,
            shadow: Shadow::None,
            bounds,
            size_range,
            shadow_error: None,
            sun_path,
            mirrored: None,
        };
        let Some(bounds) = bounds else { return Ok(lit) };
        match sun_path {
            SunPath::Ignore => store(&mut lit.bricks, progress, |_, _| 0.0)?,
            SunPath::Volume { voxel_m } => {
                check_length("sun path: voxel_m", voxel_m)?;
                let sweep = SunSweep::over(bounds, sun_direction, voxel_m)?;
                let sweep = sweep.through(&lit.bricks, progress)?;
                store(&mut lit.bricks, progress, |_, point| sweep.at(point))?;
                lit.shadow = Shadow::From { sun_direction };
            }
            SunPath::March { step_m } => {
                check_length("sun path: step_m", step_m)?;
                let longest_m = (bounds.max - bounds.min).length();
                if longest_m / step_m > MAX_STEPS {
                    let expected = "steps of which the drops take at most a million";
                    return Err(Error::Level {
                        level: "sun path: step_m",
                        found: step_m,
                        expected,
                    });
                }
                let to_sun = |point| Ray {
                    origin: point,
                    direction: sun_direction,
                };
                store(&mut lit.bricks, progress, |bricks, point| {
                    marched_depth(bricks, bounds, &to_sun(point), step_m)
                })?;
                lit.shadow = Shadow::From { sun_direction };
            }
        }
        if lit.has_shadow() {
            lit.shadow_error = Some(ShadowError::of(&lit.bricks, bounds, sun_direction));
        }
        Ok(lit)
    }

    /// The same drops beside water that mirrors the sun which they were lit with, by the same level. Where
    /// the sun is not above the horizon or no drops above the water, water adds nothing.
    ///
    /// Drops keep a second optical depth, so that they take twice the memory. In it waves do not bend the way
    /// down: shadows are those of still water.
    ///
    /// # Errors
    /// [`Error::Level`] if the water has a number that no water has; as [`LitDrops::new`].
    pub fn beside_water(
        mut self,
        surface: WaterSurface,
        light: MirroredLight,
        sun_direction: DVec3,
    ) -> Result<Self, Error> {
        surface.check()?;
        crate::sun_direction::check_sun_direction(sun_direction)?;
        if self.has_shadow() && self.contradicts(sun_direction) {
            let expected = sun_direction.to_array();
            return Err(Error::ShadowOfAnotherSun { expected });
        }
        let Some(above) = self.bounds.and_then(|bounds| part_above(bounds, &surface)) else {
            return Ok(self);
        };
        if sun_direction.y <= 0.0 {
            return Ok(self);
        }
        let mirror = Mirror {
            surface,
            light,
            sun_direction,
        };
        let drops = MirroredDrops::new(&self.bricks, (mirror, above), self.sun_path)?;
        self.mirrored = Some(Box::new(drops));
        Ok(self)
    }

    /// The drops in mirrored light.
    pub(crate) fn mirrored(&self) -> Option<&MirroredDrops> {
        self.mirrored.as_deref()
    }

    /// The modes.
    pub fn bricks(&self) -> &[Bricks] {
        &self.bricks
    }

    /// The modes, to be lit by another sun.
    #[must_use]
    pub fn into_bricks(self) -> Vec<Bricks> {
        self.bricks
    }

    /// The box outside of which there are no drops.
    pub fn bounds(&self) -> Option<Aabb> {
        self.bounds
    }

    /// Which drops there are; `None` if there are none.
    pub fn size_range(&self) -> Option<SizeRange> {
        self.size_range
    }

    /// Estimated error of the optical depth towards the sun at Q = 1, RMS over the drops that it reaches: light
    /// of drops errs relatively by Q times that. 0 without shadows.
    pub fn shadow_depth_error(&self) -> f64 {
        self.shadow_error.as_ref().map_or(0.0, ShadowError::rms)
    }

    /// How wrong the shadows are.
    pub(crate) fn shadow_error(&self) -> Option<&ShadowError> {
        self.shadow_error.as_ref()
    }

    /// Whether these drops hold shadows of a sun in another direction.
    pub(crate) fn contradicts(&self, sun_direction: DVec3) -> bool {
        match self.shadow {
            Shadow::None => false,
            // Both are stored values; a direction that was computed twice is allowed its rounding.
            Shadow::From {
                sun_direction: of_shadow,
            } => of_shadow.distance(sun_direction) > crate::sun_direction::UNIT_TOLERANCE,
        }
    }

    /// Whether there are shadows in the bricks.
    pub(crate) fn has_shadow(&self) -> bool {
        self.shadow != Shadow::None
    }
}

/// Set the optical depth of all nodes.
///
/// # Errors
/// [`Error::Stopped`].
pub(crate) fn store(
    bricks: &mut [Bricks],
    progress: Progress,
    depth_at: impl Fn(&[Bricks], DVec3) -> f32 + Sync,
) -> Result<(), Error> {
    let depths_of = |mode: &Bricks| {
        let go_on = || tell(progress, 0);
        mode.at_nodes_while(go_on, |point| depth_at(bricks, point))
    };
    let depths: Vec<NodeValues> = bricks.iter().map(depths_of).collect::<Result<_, _>>()?;
    for (mode, depths) in bricks.iter_mut().zip(&depths) {
        mode.set_tau_sun(depths);
    }
    Ok(())
}

/// What of a box lies above water.
fn part_above(bounds: Aabb, surface: &WaterSurface) -> Option<Aabb> {
    let min = bounds.min.with_y(bounds.min.y.max(surface.height_m));
    (min.y < bounds.max.y).then_some(Aabb { min, ..bounds })
}

/// The box around all modes that have drops.
fn union_of_bounds(bricks: &[Bricks]) -> Option<Aabb> {
    bricks
        .iter()
        .filter_map(Bricks::world_bounds)
        .reduce(|(a_min, a_max), (b_min, b_max)| (a_min.min(b_min), a_max.max(b_max)))
        .map(|(min, max)| Aabb { min, max })
}

/// Sum of the modes' extinction at Q = 1 [1/m].
pub(crate) fn extinction_m1(bricks: &[Bricks], point: DVec3) -> f64 {
    let m2: f64 = bricks.iter().map(|mode| f64::from(mode.m2(point))).sum();
    EXTINCTION_PER_M2 * m2
}

/// Optical depth of all drops from a point on along a unit direction at Q = 1, cell by cell.
pub(crate) fn depth(bricks: &[Bricks], point: DVec3, direction: DVec3) -> f64 {
    let segments = bricks
        .iter()
        .flat_map(|mode| mode.segments(point, direction, (0.0, f64::INFINITY)));
    let columns = segments.map(|segment| {
        let m2: f64 = GAUSS.map(|x| f64::from(segment.sample(x).m2)).iter().sum();
        0.5 * m2 * (segment.t_exit - segment.t_enter)
    });
    EXTINCTION_PER_M2 * columns.sum::<f64>()
}

/// Edge of the modes' finest voxels (m); infinite without any.
pub(crate) fn finest_voxel_m(bricks: &[Bricks]) -> f64 {
    let voxels_m = bricks.iter().map(Bricks::voxel_m);
    voxels_m.fold(f64::INFINITY, f64::min)
}

/// Midpoint rule from a point to the face of the box.
pub(crate) fn marched_depth(bricks: &[Bricks], bounds: Aabb, ray: &Ray, step_m: f64) -> f32 {
    let Some((enter_m, leave_m)) = bounds.intersect(ray) else {
        return 0.0;
    };
    let n_steps = ((leave_m - enter_m) / step_m).ceil().max(1.0);
    let length_m = (leave_m - enter_m) / n_steps;
    let middle = |step: usize| ray.at(enter_m + (step as f64 + 0.5) * length_m);
    let sum: f64 = (0..n_steps as usize)
        .map(|step| extinction_m1(bricks, middle(step)))
        .sum();
    (sum * length_m) as f32
}

fn check_length(level: &'static str, found: f64) -> Result<(), Error> {
    let expected = "a length above 0 m";
    let sound = found.is_finite() && found > 0.0;
    if sound {
        Ok(())
    } else {
        Err(Error::Level {
            level,
            found,
            expected,
        })
    }
}
