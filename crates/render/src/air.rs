//! The air as a ray meets it: how much of each constituent lies on a path.
//!
//! tau(lambda) = sum_c beta_c(lambda) l_c,   l_c = int rho_c(h(s)) ds
//!
//! `beta_c` extinction coefficient of constituent c at relative density 1 [1/m], `rho_c` its relative
//! density, `l_c` its equivalent length [m]. Lengths do not depend on the wavelength: paths are
//! walked once, and spectra are taken of their lengths.

use glam::DVec3;
use niji_exchange::AtmosphereTable;
use niji_geometry::Planet;
use pulp::Arch;
use pulp::Simd;
use pulp::WithSimd;

use crate::air_diffuse::DiffuseAir;
use crate::exponential::transmittance;
use crate::gauss_nodes::AirRay;
use crate::gauss_nodes::AirStretch;
use crate::gauss_nodes::GaussRule;
use crate::levels::AirPath;
use crate::levels::SkyModel;
use crate::water_surface::WaterSurface;

/// Constituents that a path keeps apart.
pub(crate) const MAX_CONSTITUENTS: usize = 8;

/// Equivalent length of each constituent on a path (m); 0 beyond the constituents there are.
pub(crate) type Lengths = [f64; MAX_CONSTITUENTS];

/// The air of a picture.
#[derive(Clone)]
pub(crate) struct Air<'a> {
    table: &'a AtmosphereTable,
    planet: Planet,
    level: AirPath,
    sun_direction: DVec3,
    /// Nodes of [`AirPath::Quadrature`].
    rule: Option<GaussRule>,
    /// Lengths from the eye to the sun, for [`AirPath::Constant`].
    eye_to_sun: Option<Lengths>,
    /// Relative densities at the eye, for [`AirPath::Constant`].
    eye_density: Lengths,
    /// beta by constituent [1/m]. f32: spectra leave in f32.
    extinction_m1: Vec<Vec<f32>>,
    /// Largest extinction at any height and wavelength, at most [1/m].
    largest_extinction_m1: f64,
    /// Scattering coefficients by constituent [1/m].
    scattering_m1: Vec<Vec<f32>>,
    /// Phase functions by constituent and angle, wavelength fastest [1/sr].
    phase_sr1: Vec<Vec<f32>>,
    /// Light of higher orders, where the level wants it.
    diffuse: Option<DiffuseAir<'a>>,
    /// The water by which sunlight comes; `None` for the sun itself.
    mirror: Option<&'a WaterSurface>,
}

impl<'a> Air<'a> {
    /// The air around an eye.
    pub(crate) fn new(
        table: &'a AtmosphereTable,
        level: AirPath,
        sun_direction: DVec3,
        eye: DVec3,
    ) -> Self {
        let to_f32 = |values: &[f64]| values.iter().map(|value| *value as f32).collect();
        let constituents = &table.constituents;
        let mut air = Self {
            table,
            planet: Planet {
                radius_m: table.planet_radius_m,
            },
            level,
            sun_direction,
            rule: rule(level),
            eye_to_sun: None,
            eye_density: [0.0; MAX_CONSTITUENTS],
            extinction_m1: constituents
                .iter()
                .map(|air| to_f32(&air.extinction_m1))
                .collect(),
            largest_extinction_m1: 0.0,
            scattering_m1: constituents
                .iter()
                .map(|air| to_f32(&air.scattering_m1))
                .collect(),
            phase_sr1: constituents
                .iter()
                .map(|air| {
                    air.phase_sr1
                        .t()
                        .iter()
                        .map(|value| *value as f32)
                        .collect()
                })
                .collect(),
            diffuse: None,
            mirror: None,
        };
        let eye_height_m = air.planet.height_m(eye);
        air.eye_density = air.densities(eye_height_m);
        air.eye_to_sun = air.table_to_sun(eye);
        let densest = |index: usize| {
            let densities = table.constituents[index].density.iter().copied();
            densities.fold(0.0, f64::max)
        };
        air.largest_extinction_m1 = air.largest_depth(&air.each(densest));
        air
    }

    /// The same air with twice as many places on each path.
    pub(crate) fn finer(&self) -> Self {
        let level = self.level.finer();
        Self {
            level,
            rule: rule(level),
            ..self.clone()
        }
    }

    /// The same air with the light that a level wants in it.
    pub(crate) fn with_light_of(self, sky_model: SkyModel) -> Self {
        let diffuse = match sky_model {
            SkyModel::None | SkyModel::SingleScattering => None,
            SkyModel::MultipleScattering => DiffuseAir::new(self.table, self.sun_direction),
        };
        Self { diffuse, ..self }
    }

    /// The same air for sunlight that comes by way of water.
    pub(crate) fn by_way_of(self, water: &'a WaterSurface) -> Self {
        Self {
            mirror: Some(water),
            ..self
        }
    }

    /// Light of higher orders.
    pub(crate) fn diffuse(&self) -> Option<&DiffuseAir<'a>> {
        self.diffuse.as_ref()
    }

    /// The planet under the air.
    pub(crate) fn planet(&self) -> Planet {
        self.planet
    }

    /// Height of the top of the air (m).
    pub(crate) fn top_height_m(&self) -> f64 {
        self.table.top_height_m
    }

    /// Albedo of the ground by wavelength.
    pub(crate) fn ground_albedo(&self) -> &[f64] {
        &self.table.ground_albedo
    }

    /// The direction towards the sun.
    pub(crate) fn sun_direction(&self) -> DVec3 {
        self.sun_direction
    }

    /// A view ray as the air sees it.
    pub(crate) fn ray(&self, origin: DVec3, direction: DVec3) -> AirRay {
        AirRay {
            height_m: self.planet.height_m(origin),
            cos_zenith: self.planet.cos_zenith(origin, direction),
        }
    }

    /// Relative densities at a height.
    pub(crate) fn densities(&self, height_m: f64) -> Lengths {
        self.each(|index| self.table.density_at(index, height_m))
    }

    /// Lengths from the eye to a point of a view ray.
    pub(crate) fn to_eye(&self, ray: AirRay, distance_m: f64) -> Lengths {
        match self.level {
            AirPath::Constant => self.each(|index| self.eye_density[index] * distance_m),
            AirPath::Midpoint { n_steps } => self.midpoint_sum(ray, (0.0, distance_m), n_steps),
            AirPath::Quadrature { .. } => self.gauss_sum(ray, (0.0, distance_m)),
            AirPath::Table => self.through(ray, distance_m),
        }
    }

    /// The same by the table, whatever the level.
    pub(crate) fn through(&self, ray: AirRay, distance_m: f64) -> Lengths {
        self.each(|index| {
            self.table
                .segment_length(index, ray.height_m, ray.cos_zenith, distance_m)
        })
    }

    /// Lengths from a point to the sun; `None` in the planet's shadow.
    pub(crate) fn to_sun(&self, point: DVec3) -> Option<Lengths> {
        let Some(water) = self.mirror else {
            return self.straight_to_sun(point);
        };
        let foot = water.foot(point, self.sun_direction);
        // Lakes may lie below the planet's mean ground.
        let foot = foot.with_y(foot.y.max(0.0));
        let sum = self.straight_to_sun(foot)?;
        let way = point - foot;
        let up = self.ray(foot, way.normalize_or(DVec3::Y));
        let up = self.to_eye(up, way.length());
        Some(std::array::from_fn(|index| sum[index] + up[index]))
    }

    /// The same without water.
    fn straight_to_sun(&self, point: DVec3) -> Option<Lengths> {
        match self.level {
            AirPath::Constant => self.eye_to_sun,
            AirPath::Table => self.table_to_sun(point),
            AirPath::Midpoint { n_steps } => {
                let (ray, range_m) = self.way_to_sun(point)?;
                Some(self.midpoint_sum(ray, range_m, n_steps))
            }
            AirPath::Quadrature { .. } => {
                let (ray, range_m) = self.way_to_sun(point)?;
                Some(self.gauss_sum(ray, range_m))
            }
        }
    }

    /// exp(-tau) of lengths, by wavelength, by the widest vectors that the processor has.
    pub(crate) fn transmit(&self, lengths: &Lengths, out: &mut [f32]) {
        Arch::new().dispatch(Transmission {
            air: self,
            lengths,
            out,
        });
    }

    /// tau by wavelength.
    #[allow(clippy::inline_always, reason = "a part of `Transmission`")]
    #[inline(always)]
    pub(crate) fn optical_depth(&self, lengths: &Lengths, out: &mut [f32]) {
        out.fill(0.0);
        for (extinction, length) in self.extinction_m1.iter().zip(lengths) {
            let length = *length as f32;
            for (depth, beta) in out.iter_mut().zip(extinction) {
                *depth += beta * length;
            }
        }
    }

    /// Largest change of the optical depth over all wavelengths, if each constituent's length
    /// changes by as much as given.
    pub(crate) fn largest_depth(&self, lengths: &Lengths) -> f64 {
        let n_wavelengths = self.extinction_m1.first().map_or(0, Vec::len);
        let depth = |wavelength: usize| -> f64 {
            let terms = self.extinction_m1.iter().zip(lengths);
            terms
                .map(|(beta, length)| f64::from(beta[wavelength]) * length.abs())
                .sum()
        };
        (0..n_wavelengths).map(depth).fold(0.0, f64::max)
    }

    /// Whether no way of a length is deeper than this, wherever it lies.
    pub(crate) fn is_thinner(&self, length_m: f64, depth: f64) -> bool {
        self.largest_extinction_m1 * length_m <= depth
    }

    /// beta_s times phase function by wavelength for each constituent [1/(m sr)], one after another.
    pub(crate) fn scattering_towards(&self, theta_rad: f64, out: &mut Vec<f32>) {
        out.clear();
        for ((air, scattering), phase) in self
            .table
            .constituents
            .iter()
            .zip(&self.scattering_m1)
            .zip(&self.phase_sr1)
        {
            let n = scattering.len();
            let nodes = &air.phase_angle_rad;
            let lower = nodes
                .partition_point(|node| *node <= theta_rad)
                .saturating_sub(1);
            let lower = lower.min(nodes.len().saturating_sub(2));
            let upper = (lower + 1).min(nodes.len() - 1);
            let step = nodes[upper] - nodes[lower];
            let fraction = if step > 0.0 {
                (theta_rad - nodes[lower]) / step
            } else {
                0.0
            };
            let fraction = fraction.clamp(0.0, 1.0) as f32;
            let rows = [
                &phase[lower * n..(lower + 1) * n],
                &phase[upper * n..(upper + 1) * n],
            ];
            out.extend(
                scattering
                    .iter()
                    .zip(rows[0])
                    .zip(rows[1])
                    .map(|((beta, low), high)| beta * (low * (1.0 - fraction) + high * fraction)),
            );
        }
    }

    fn each(&self, length: impl Fn(usize) -> f64) -> Lengths {
        let n = self.table.constituents.len();
        std::array::from_fn(|index| if index < n { length(index) } else { 0.0 })
    }

    fn table_to_sun(&self, point: DVec3) -> Option<Lengths> {
        let ray = self.ray(point, self.sun_direction);
        let lengths = self.each(|index| self.table.column_at(index, ray.height_m, ray.cos_zenith));
        lengths
            .iter()
            .all(|length| length.is_finite())
            .then_some(lengths)
    }

    /// The part in the air of the way from a point to the sun; `None` through the ground.
    fn way_to_sun(&self, point: DVec3) -> Option<(AirRay, (f64, f64))> {
        let ray = self.ray(point, self.sun_direction);
        if self.planet.hits_ground(ray.height_m, ray.cos_zenith) {
            return None;
        }
        let chord = self
            .planet
            .shell_chord(ray.height_m, ray.cos_zenith, self.top_height_m());
        Some((ray, chord.unwrap_or((0.0, 0.0))))
    }

    fn midpoint_sum(&self, ray: AirRay, (from_m, to_m): (f64, f64), n_steps: usize) -> Lengths {
        let step_m = (to_m - from_m) / n_steps as f64;
        let mut sum = [0.0; MAX_CONSTITUENTS];
        for step in 0..n_steps {
            self.add_density(ray, from_m + (step as f64 + 0.5) * step_m, step_m, &mut sum);
        }
        sum
    }

    fn gauss_sum(&self, ray: AirRay, range_m: (f64, f64)) -> Lengths {
        let mut sum = [0.0; MAX_CONSTITUENTS];
        let Some(rule) = &self.rule else { return sum };
        let mut nodes = Vec::with_capacity(2 * rule.nodes().len());
        for stretch in AirStretch::of_range(self.planet, ray, range_m) {
            rule.place(&stretch, &mut nodes);
        }
        for node in nodes {
            self.add_density(ray, node.distance_m, node.weight_m, &mut sum);
        }
        sum
    }

    fn add_density(&self, ray: AirRay, distance_m: f64, weight_m: f64, sum: &mut Lengths) {
        let height_m = self
            .planet
            .height_along_ray(ray.height_m, ray.cos_zenith, distance_m);
        for (sum, density) in sum.iter_mut().zip(self.densities(height_m)) {
            *sum += weight_m * density;
        }
    }
}

/// Nodes of a level's quadrature.
fn rule(level: AirPath) -> Option<GaussRule> {
    match level {
        AirPath::Quadrature { n_nodes } => n_nodes.try_into().ok().map(GaussRule::new),
        AirPath::Constant | AirPath::Midpoint { .. } | AirPath::Table => None,
    }
}

/// A spectrum of transmittances to be found: each wavelength by itself, the same bits for vectors of any
/// width.
struct Transmission<'a> {
    air: &'a Air<'a>,
    lengths: &'a Lengths,
    out: &'a mut [f32],
}

impl WithSimd for Transmission<'_> {
    type Output = ();

    // The compiler makes the vectors, of the width that functions inlined here may have.
    #[allow(clippy::inline_always, reason = "as the line above says")]
    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        self.air.optical_depth(self.lengths, self.out);
        for value in self.out {
            *value = transmittance(*value);
        }
    }
}
