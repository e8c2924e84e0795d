//! Sunlight that the air and the ground send along a view ray.
//!
//! L = E_sun sum_c int beta_s,c rho_c(h(s)) P_c(theta) exp(-tau(sun -> s -> eye)) T_drops(s) ds
//!     + E_sun mu_sun A/pi exp(-tau(sun -> ground -> eye)) T_drops
//!
//! `beta_s,c` scattering coefficient of constituent c [1/m], `rho_c` its relative density, `P_c` its
//! phase function [1/sr], `A` albedo of the ground, `mu_sun` cosine of the sun's zenith angle there,
//! `T_drops` what the drops in front let pass, without diffraction. At the level of multiple
//! scattering the source of diffuse light is added at every node (`air_diffuse`), and skylight on the
//! ground. The ground has the shadow of drops and surfaces where surfaces are lit (`surface_light`); the shadow of
//! both on the air is left out.
//! \[NMN87\] Nishita, Miyawaki, Nakamae, Computer Graphics 21(4), 303-310 (1987), and the same sum
//! with constant steps as published for rainbows.
//!
//! The light of the air is smooth, so it has its own few Gauss nodes; what the drops between them and
//! the eye let pass need not be ([`FrontTransmittance`]). How many nodes a level takes is said in [`AirGlow`], and
//! what they err by is measured on a few rays of every picture (`air_error`).

use std::num::NonZeroUsize;

use niji_geometry::Ray;

use crate::air::Air;
use crate::air::Lengths;
use crate::air_diffuse::PointOfRay;
use crate::deep_air;
use crate::front_transmittance::FrontRoom;
use crate::front_transmittance::FrontTransmittance;
use crate::front_transmittance::NodeTransmittance;
use crate::gauss_nodes::AirStretch;
use crate::gauss_nodes::GaussRule;
use crate::gauss_nodes::RayNode;
use crate::levels::AirPath;
use crate::march::Probe;
use crate::surface_light::Shade;

/// How far errors exceed the difference from twice as many nodes, or parts among the drops, at kinks.
pub(crate) const DOUBT: f64 = 1.5;

/// Nodes on long stretches where nobody says how many, and the fewest that are tried where a tolerance does.
const N_NODES: usize = 10;
const N_FIRST: usize = N_NODES / 2;

/// Stretches up to here have the fewest nodes (m).
pub(crate) const SHORT_M: f64 = 300.0;

/// Whose light is wanted on a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct GlowRange {
    /// The way through the drops (m); `None` where there are none.
    pub(crate) drops_m: Option<(f64, f64)>,
    /// Distance of the surface that ends the ray (m); infinite where there is none.
    pub(crate) surface_m: f64,
    /// Whether air from the eye to the far side of the drops counts.
    pub(crate) in_front: bool,
    /// Whether air and ground beyond the drops count.
    pub(crate) beyond: bool,
    /// Whether it is asked where among the drops the view ends ([`GlowNodes::lost_at_m`]).
    pub(crate) lost: bool,
}

/// A ray along which the light of the air is gathered.
#[derive(Clone, Copy)]
pub(crate) struct GlowRay<'a> {
    pub(crate) air: &'a Air<'a>,
    pub(crate) rules: &'a AirGlow,
    pub(crate) ray: &'a Ray,
    /// Scattering angle.
    pub(crate) theta_rad: f64,
    /// What all drops on it let pass; `None` if they dim nothing.
    pub(crate) dimmed_by_drops: Option<f64>,
    /// What of its light reaches the ground.
    pub(crate) ground_shade: Shade,
}

/// Nodes of a ray in the air.
#[derive(Clone, Debug, Default)]
pub(crate) struct GlowNodes {
    nodes: Vec<RayNode>,
    /// Nodes up to here are in front of the drops.
    n_before: usize,
    /// Nodes up to here are in front of the far side of the drops.
    n_in_front: usize,
    /// Stretches with nodes that lie among the drops.
    among: Vec<AirStretch>,
    ground_m: Option<f64>,
    /// Where the march through the drops is to tell their depth: at the parts of each stretch among
    /// them, and at the ground where it is seen.
    pub(crate) probes: Vec<Probe>,
}

impl GlowNodes {
    /// Distance of the ground where it is seen (m).
    pub(crate) fn ground_m(&self) -> Option<f64> {
        self.ground_m
    }

    /// Mean distance at which the view loses light to the drops: int s dT / int dT (m); `None` where it
    /// loses none, or was not asked.
    pub(crate) fn lost_at_m(&self) -> Option<f64> {
        let n_grounds = usize::from(self.ground_m.is_some());
        let n_among = self.probes.len().saturating_sub(n_grounds);
        let ends = self.probes[..n_among].windows(2).map(|ends| {
            let [near, far] = [&ends[0], &ends[1]].map(|probe| (-probe.depth).exp());
            let lost = near - far;
            (lost, 0.5 * lost * (ends[0].distance_m + ends[1].distance_m))
        });
        let (lost, lost_m) = ends.fold((0.0, 0.0), |sum, of| (sum.0 + of.0, sum.1 + of.1));
        (lost > 0.0).then(|| lost_m / lost)
    }
}

/// A Gauss rule and how drops count at its nodes.
struct AirRule {
    gauss: GaussRule,
    front: FrontTransmittance,
}

impl AirRule {
    fn new(n_nodes: usize, n_parts: usize) -> Self {
        let gauss = GaussRule::new(NonZeroUsize::new(n_nodes).unwrap_or(NonZeroUsize::MIN));
        let front = FrontTransmittance::new(&gauss, n_parts);
        Self { gauss, front }
    }
}

/// Rules for the air's light on stretches that are long or lead far up, on others, and on short ones.
///
/// With 6, 10 and 24 nodes on long stretches the light of whole skies, hazy and clear, has a relative
/// RMSE of 1e-4 to 1e-3, 5e-7 to 2e-4 and 4e-8 to 4e-5, the larger where an ozone layer has kinks.
pub(crate) struct AirGlow {
    n_nodes: usize,
    long: AirRule,
    even: AirRule,
    short: AirRule,
}

impl AirGlow {
    /// The rules of a level: light is smoother than the ways through the air that nodes were asked for. Where a
    /// tolerance says whether more are taken, the fewest nodes come first.
    pub(crate) fn of(air_path: AirPath, has_tolerance: bool) -> Self {
        Self::new(match air_path {
            AirPath::Quadrature { n_nodes } => (3 * n_nodes / 4).max(1),
            AirPath::Table if has_tolerance => N_FIRST,
            AirPath::Constant | AirPath::Midpoint { .. } | AirPath::Table => N_NODES,
        })
    }

    /// The rules with `n_nodes` on long stretches.
    pub(crate) fn new(n_nodes: usize) -> Self {
        // Even, and so many more where more is asked for.
        let n_parts = (2 * n_nodes).next_power_of_two();
        let rule = |n_nodes: usize| AirRule::new(n_nodes, n_parts);
        Self {
            n_nodes,
            long: rule(n_nodes),
            even: rule(1 + n_nodes / 4),
            short: rule(n_nodes / 8),
        }
    }

    /// Nodes on long stretches.
    pub(crate) fn n_nodes(&self) -> usize {
        self.n_nodes
    }

    /// Twice as many nodes: next to their error that of these is small.
    pub(crate) fn finer(&self) -> Self {
        Self::new(2 * self.n_nodes)
    }

    /// Choose the nodes of a ray.
    pub(crate) fn lay_out(&self, air: &Air, ray: &Ray, range: &GlowRange, out: &mut GlowNodes) {
        out.nodes.clear();
        out.among.clear();
        out.probes.clear();
        (out.n_before, out.n_in_front, out.ground_m) = (0, 0, None);
        let planet = air.planet();
        let air_ray = air.ray(ray.origin, ray.direction);
        let ground_m = planet.distance_to_ground(air_ray.height_m, air_ray.cos_zenith);
        let chord = planet.shell_chord(air_ray.height_m, air_ray.cos_zenith, air.top_height_m());
        let far_side_m = range.drops_m.map_or(0.0, |(_, leave_m)| leave_m);
        if let Some((enter_m, leave_m)) = chord {
            let end_m = ground_m.map_or(leave_m, |ground_m| ground_m.min(leave_m));
            let end_m = end_m.min(range.surface_m);
            let stretches = |range_m: (f64, f64)| deep_air::stretches(air, air_ray, range_m);
            let looks = range.in_front || range.lost;
            if let (true, Some((drops_m, _))) = (looks, range.drops_m) {
                let cut = |distance_m: f64| distance_m.clamp(enter_m, end_m.max(enter_m));
                for stretch in stretches((enter_m, cut(drops_m))).filter(|_| range.in_front) {
                    self.rule(&stretch).gauss.place(&stretch, &mut out.nodes);
                }
                out.n_before = out.nodes.len();
                for stretch in stretches((cut(drops_m), cut(far_side_m))) {
                    let rule = self.rule(&stretch);
                    if range.in_front {
                        rule.gauss.place(&stretch, &mut out.nodes);
                        out.among.push(stretch);
                    }
                    let places = rule.front.places();
                    out.probes
                        .extend(places.map(|place| Probe::at(stretch.distance_m(place))));
                }
            }
            out.n_in_front = out.nodes.len();
            if range.beyond {
                for stretch in stretches((enter_m.max(far_side_m), end_m)) {
                    self.rule(&stretch).gauss.place(&stretch, &mut out.nodes);
                }
            }
        }
        // Not before the last stretch among the drops: that ends there at the latest.
        out.ground_m = ground_m.filter(|ground_m| range.beyond && *ground_m < range.surface_m);
        out.probes.extend(out.ground_m.map(Probe::at));
    }

    fn rule(&self, stretch: &AirStretch) -> &AirRule {
        if stretch.is_dense() {
            &self.long
        } else if stretch.length_m() < SHORT_M {
            &self.short
        } else {
            &self.even
        }
    }

    /// Write what the drops let pass of each node's light; `behind` is their transmittance.
    fn in_front(
        &self,
        nodes: &GlowNodes,
        behind: f64,
        (room, out): (&mut FrontRoom, &mut Vec<NodeTransmittance>),
    ) {
        out.clear();
        out.resize(nodes.n_before, NodeTransmittance::by(1.0));
        let mut depths = nodes.probes.iter().map(|probe| probe.depth);
        for stretch in &nodes.among {
            let front = &self.rule(stretch).front;
            let n_depths = front.places().count();
            front.over(depths.by_ref().take(n_depths), room, out);
        }
        out.resize(nodes.nodes.len(), NodeTransmittance::by(behind));
    }
}

/// Spectra of the air's light, for unit sun irradiance [1/sr].
#[derive(Clone, Debug)]
pub(crate) struct Glow {
    /// From the eye to the far side of the drops.
    pub(crate) in_front: Vec<f32>,
    /// Beyond, dimmed by the drops.
    pub(crate) beyond: Vec<f32>,
    /// Scattering towards the eye by constituent, then wavelength [1/(m sr)].
    towards_eye: Vec<f32>,
    transmitted: Vec<f32>,
    /// What the drops let pass of each node's light.
    transmittances: Vec<NodeTransmittance>,
    front_room: FrontRoom,
    /// Light of the air among the drops that coarser parts of them would let pass besides, at the
    /// wavelength `brightest`.
    front_change: f64,
    brightest: usize,
    /// Diffuse light scattered towards the eye.
    source: Vec<f32>,
    /// For the diffuse light to work in.
    room: Vec<f32>,
}

impl Glow {
    /// Darkness at `n_wavelengths`; by the brightest of them errors are told.
    pub(crate) fn dark(n_wavelengths: usize, brightest: usize) -> Self {
        let dark = vec![0.0; n_wavelengths];
        Self {
            in_front: dark.clone(),
            beyond: dark.clone(),
            towards_eye: Vec::new(),
            transmitted: dark.clone(),
            transmittances: Vec::new(),
            front_room: FrontRoom::default(),
            front_change: 0.0,
            brightest,
            source: dark,
            room: Vec::new(),
        }
    }

    /// Darkness again.
    pub(crate) fn clear(&mut self) {
        self.in_front.fill(0.0);
        self.beyond.fill(0.0);
        self.front_change = 0.0;
    }

    /// Estimated relative error of the light in front because of the drops between it and the eye.
    pub(crate) fn front_error(&self) -> f64 {
        let light = self.in_front.get(self.brightest).copied();
        let light = f64::from(light.unwrap_or_default());
        if light > 0.0 {
            DOUBT * self.front_change.abs() / light
        } else {
            0.0
        }
    }

    /// Gather the light of a ray, whose probes have been answered if drops dim what is behind them.
    pub(crate) fn gather(&mut self, glow_ray: &GlowRay, nodes: &GlowNodes) {
        let GlowRay {
            air,
            rules,
            ray,
            theta_rad,
            dimmed_by_drops,
            ..
        } = *glow_ray;
        air.scattering_towards(theta_rad, &mut self.towards_eye);
        let air_ray = air.ray(ray.origin, ray.direction);
        let planet = air.planet();
        if let Some(transmittance) = dimmed_by_drops {
            rules.in_front(
                nodes,
                transmittance,
                (&mut self.front_room, &mut self.transmittances),
            );
        } else {
            self.transmittances.clear();
            self.transmittances
                .resize(nodes.nodes.len(), NodeTransmittance::by(1.0));
        }
        for (index, node) in nodes.nodes.iter().enumerate() {
            let height_m =
                planet.height_along_ray(air_ray.height_m, air_ray.cos_zenith, node.distance_m);
            let in_front = self.transmittances[index];
            let weight_m = node.weight_m * in_front.transmittance;
            let weighted = air.densities(height_m).map(|density| weight_m * density);
            let is_in_front = index < nodes.n_in_front;
            let before = self.in_front[self.brightest];
            let to_eye = air.to_eye(air_ray, node.distance_m);
            if let Some(to_sun) = air.to_sun(ray.at(node.distance_m)) {
                air.transmit(&both_ways(&to_sun, &to_eye), &mut self.transmitted);
                self.add_scattered_once(&weighted, is_in_front);
            }
            if let Some(diffuse) = air.diffuse() {
                let Self { source, room, .. } = self;
                let at = PointOfRay {
                    ray,
                    distance_m: node.distance_m,
                };
                diffuse.source(at, &weighted, room, source);
                air.transmit(&to_eye, &mut self.transmitted);
                self.add_source(is_in_front);
            }
            if in_front.change != 0.0 && in_front.transmittance != 0.0 {
                let added = f64::from(self.in_front[self.brightest] - before);
                self.front_change += added * in_front.change / in_front.transmittance;
            }
        }
        if let Some(ground_m) = nodes.ground_m {
            let in_front = nodes.probes.last().filter(|_| dimmed_by_drops.is_some());
            let through_drops = in_front.map_or(1.0, |probe| (-probe.depth).exp());
            self.add_ground(glow_ray, (ground_m, through_drops));
        }
    }

    /// Sunlight that densities times a length scatter.
    fn add_scattered_once(&mut self, weighted: &Lengths, is_in_front: bool) {
        let sum = if is_in_front {
            &mut self.in_front
        } else {
            &mut self.beyond
        };
        let n_wavelengths = sum.len();
        for (scattering, density) in self.towards_eye.chunks(n_wavelengths).zip(weighted) {
            let density = *density as f32;
            let spectra = sum.iter_mut().zip(scattering).zip(&self.transmitted);
            for ((sum, beta), transmitted) in spectra {
                *sum += density * beta * transmitted;
            }
        }
    }

    /// The source of diffuse light, transmitted.
    fn add_source(&mut self, is_in_front: bool) {
        let sum = if is_in_front {
            &mut self.in_front
        } else {
            &mut self.beyond
        };
        let spectra = sum.iter_mut().zip(&self.source).zip(&self.transmitted);
        for ((sum, source), transmitted) in spectra {
            *sum += source * transmitted;
        }
    }

    fn add_ground(&mut self, glow_ray: &GlowRay, (ground_m, through_drops): (f64, f64)) {
        let GlowRay {
            air,
            ray,
            ground_shade: shade,
            ..
        } = *glow_ray;
        let air_ray = air.ray(ray.origin, ray.direction);
        let scale = (through_drops * std::f64::consts::FRAC_1_PI) as f32;
        let to_eye = air.to_eye(air_ray, ground_m);
        if let Some(diffuse) = air.diffuse() {
            air.transmit(&to_eye, &mut self.transmitted);
            let irradiance = diffuse.on_ground(ray, ground_m);
            for (transmitted, irradiance) in self.transmitted.iter_mut().zip(irradiance) {
                *transmitted *= irradiance;
            }
            self.add_reflected(air, scale * shade.sky as f32);
        }
        let cos_sun = air
            .planet()
            .cos_zenith(ray.at(ground_m), air.sun_direction());
        let (true, Some(to_sun)) = (cos_sun > 0.0, air.to_sun(ray.at(ground_m))) else {
            return;
        };
        air.transmit(&both_ways(&to_sun, &to_eye), &mut self.transmitted);
        self.add_reflected(air, scale * (shade.sun * cos_sun) as f32);
    }

    /// What is left of the light on the ground on its way to the eye, times albedo and `scale`.
    fn add_reflected(&mut self, air: &Air, scale: f32) {
        let spectra = self.beyond.iter_mut().zip(air.ground_albedo());
        for ((sum, albedo), transmitted) in spectra.zip(&self.transmitted) {
            *sum += scale * *albedo as f32 * transmitted;
        }
    }
}

/// Both ways, one after the other.
pub(crate) fn both_ways(a: &Lengths, b: &Lengths) -> Lengths {
    std::array::from_fn(|index| a[index] + b[index])
}
