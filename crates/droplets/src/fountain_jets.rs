//! The jets of a fountain: which drops fly, and where to.
//!
//! Directions: the flow per solid angle falls from the axis to the edge of the cone, at angle s, as
//! 1 - q,   q = (1 - cos(theta))/(1 - cos(s));   q = 1 - sqrt(1 - u), u even in 0..1
//! Sizes: a gamma law without the smallest drops, which together have 1/1000 of the cross-section and
//! would drift beyond any box, and without the largest, which have 1/10000 of the mass. This changes
//! r_e by 0.1 % and v_e by 1 %.
//!
//! Flight i of n has the i-th of n sizes and a direction of the additive recurrence
//! u_k = frac(1/2 + i a_k),   a_k = x^-k,   x^(d+1) = x + 1, x > 1, d dimensions
//! (Kronecker's sequence with powers of the plastic number and its kin), as in a Hammersley set: any
//! run of neighboring sizes has its directions spread evenly, and the noise of a voxel falls nearly
//! as 1/n, where random directions give 1/sqrt(n).
//! [Nie92] Niederreiter, Random Number Generation and Quasi-Monte Carlo Methods, SIAM (1992), ch. 3.

use std::f64::consts::TAU;

use glam::DVec3;
use niji_dropfield::GridBox;
use niji_radiometry::Micrometers;
use niji_sizes::gamma_area_quadrature;

use crate::Fountain;
use crate::fountain_flight::Launch;
use crate::fountain_lattice::Stream;

/// Cross-section of the smallest drops, which are left out, as a share of the whole.
const LOST_AREA: f64 = 1e-3;

/// Mass of the largest drops, which are left out, as a share of the whole.
const LOST_MASS: f64 = 1e-4;

/// Nodes of the size law by which these two are cut off.
const N_LAW_NODES: usize = 4096;

/// Steps of the additive recurrence for a jet: a_k = x^-k with x³ = x + 1; the third is not used.
/// The first two of a ring's steps would leave twice the noise.
const JET_RECURRENCE: [f64; 3] = [0.754_877_666_246_692_8, 0.569_840_290_998_053_3, 0.0];

/// The same for a ring, with x⁴ = x + 1.
const RING_RECURRENCE: [f64; 3] = [
    0.819_172_513_396_164_4,
    0.671_043_606_703_789_2,
    0.549_700_477_901_970_3,
];

/// Flights of a jet per node of a face of the box, that is per (number of nodes)^(2/3). The extinction
/// of a node is then 0.7..1.3 % off in the mean, that of a line of sight 0.3..0.5 %, and falls in
/// proportion to the flights.
const JET_FLIGHTS_PER_FACE_NODE: f64 = 6.0;

/// The same for a ring: 5..8 % and 1..1.5 %, since its flights have one dimension more.
const RING_FLIGHTS_PER_FACE_NODE: f64 = 16.0;

/// Places on a ring, evenly spaced, from which every drop size flies in the same way: a ring in calm
/// air is then symmetric. 1 to 32 places have the same noise for as many flights in all.
const PLACES_ON_RING: u32 = 24;

/// Fewest flights.
const FEWEST_FLIGHTS: f64 = 4096.0;

/// Sizes, and directions around a jet and a ring, of the flights that bound the box.
const N_EXTREME_SIZES: u32 = 9;
const N_EXTREME_AROUND: u32 = 24;

/// How many flights are laid out.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FlightPlan {
    /// Sizes of drops, each with its direction.
    pub(crate) n_sizes: usize,
    /// Places on the ring from which each of them flies; 1 for a jet.
    pub(crate) n_around: u32,
}

impl FlightPlan {
    /// Flights for a box.
    pub(crate) fn of(fountain: &Fountain, grid: &GridBox) -> Self {
        let n_nodes = grid.n_nodes().unwrap_or([1; 3]).map(f64::from);
        let face_nodes = n_nodes.into_iter().product::<f64>().powf(2.0 / 3.0);
        let (per_face_node, n_around) = if fountain.ring_radius_m > 0.0 {
            (RING_FLIGHTS_PER_FACE_NODE, PLACES_ON_RING)
        } else {
            (JET_FLIGHTS_PER_FACE_NODE, 1)
        };
        let n_flights = (per_face_node * face_nodes).max(FEWEST_FLIGHTS);
        Self {
            n_sizes: (n_flights / f64::from(n_around)).ceil() as usize,
            n_around,
        }
    }
}

impl Fountain {
    /// The flights of a plan.
    pub(crate) fn streams(&self, plan: &FlightPlan) -> Vec<Stream> {
        let turns = f64::from(plan.n_around);
        let steps = if self.ring_radius_m > 0.0 {
            RING_RECURRENCE
        } else {
            JET_RECURRENCE
        };
        let mut streams = Vec::new();
        for (index, (radius_m, share)) in self.sizes(plan.n_sizes).into_iter().enumerate() {
            let [off_axis, around, first] = steps.map(|step| (0.5 + index as f64 * step).fract());
            streams.extend((0..plan.n_around).map(|turn| {
                let along_ring = (f64::from(turn) + first) / turns;
                Stream {
                    launch: self.launch(radius_m, [off_axis, around, along_ring]),
                    flow_kg_s: self.flow_kg_s * share / turns,
                }
            }));
        }
        streams
    }

    /// Launches whose flights reach farthest: smallest to largest drops, along the axis and the edge
    /// of the cone, from all sides of a ring.
    pub(crate) fn extreme_launches(&self) -> Vec<Launch> {
        let (smallest_m, largest_m) = self.radius_limits_m();
        let n_ring = if self.ring_radius_m > 0.0 {
            N_EXTREME_AROUND
        } else {
            1
        };
        let share = |index: u32, n: u32| f64::from(index) / f64::from(n);
        let mut launches = Vec::new();
        for size in 0..N_EXTREME_SIZES {
            let ratio = (largest_m / smallest_m).powf(share(size, N_EXTREME_SIZES - 1));
            for place in (0..n_ring).map(|index| share(index, n_ring)) {
                launches.push(self.launch(smallest_m * ratio, [0.0, 0.0, place]));
                let edge = (0..N_EXTREME_AROUND).map(|index| share(index, N_EXTREME_AROUND));
                launches.extend(edge.map(|at| self.launch(smallest_m * ratio, [1.0, at, place])));
            }
        }
        launches
    }

    /// Radii of the smallest and the largest drops (m); 0 for a law that is not sound.
    pub(crate) fn radius_limits_m(&self) -> (f64, f64) {
        let nodes = self.law_nodes(N_LAW_NODES);
        let mass: f64 = nodes.iter().map(|(radius_m, area)| radius_m * area).sum();
        let (mut smaller, mut larger) = (0.0, 0.0);
        let smallest = nodes.iter().find(|(_, area)| {
            smaller += area;
            smaller > LOST_AREA
        });
        let largest = nodes.iter().rev().find(|(radius_m, area)| {
            larger += radius_m * area;
            larger > LOST_MASS * mass
        });
        let radius = |node: Option<&(f64, f64)>| node.map_or(0.0, |(radius_m, _)| *radius_m);
        (radius(smallest), radius(largest))
    }

    /// Radii (m), ascending, and shares of the cross-section of the whole law.
    fn law_nodes(&self, n: usize) -> Vec<(f64, f64)> {
        let radius = Micrometers(self.effective_radius_um);
        let nodes = gamma_area_quadrature(radius, self.effective_variance, n).unwrap_or_default();
        let in_meters = |(radius_um, area)| (1e-6 * radius_um, area);
        nodes.into_iter().map(in_meters).collect()
    }

    /// Radii (m), ascending, and shares of the flow.
    pub(crate) fn sizes(&self, n: usize) -> Vec<(f64, f64)> {
        let (smallest_m, largest_m) = self.radius_limits_m();
        // Against the exact 0 that stands for a single size, whose flights differ in direction only.
        if self.effective_variance == 0.0 {
            return vec![(smallest_m, 1.0 / n as f64); n];
        }
        let mut sizes = self.law_nodes(n);
        sizes.retain(|(radius_m, _)| (smallest_m..=largest_m).contains(radius_m));
        let mass: f64 = sizes.iter().map(|(radius_m, area)| radius_m * area).sum();
        for (radius_m, share) in &mut sizes {
            *share *= *radius_m / mass;
        }
        sizes
    }

    /// A drop's start by three shares in 0..1: from the axis to the edge of the cone, around the
    /// axis, and around the ring.
    fn launch(&self, radius_m: f64, [off_axis, around, along_ring]: [f64; 3]) -> Launch {
        let azimuth = if self.ring_radius_m > 0.0 {
            TAU * along_ring
        } else {
            self.azimuth_deg.to_radians()
        };
        let outward = DVec3::new(azimuth.sin(), 0.0, -azimuth.cos());
        let aside = DVec3::new(azimuth.cos(), 0.0, azimuth.sin());
        let (sin, cos) = self.elevation_deg.to_radians().sin_cos();
        let axis = outward * cos + DVec3::Y * sin;

        let q = 1.0 - (1.0 - off_axis).sqrt();
        let versine = q * (1.0 - self.spread_deg.to_radians().cos());
        let sin_theta = (versine * (2.0 - versine)).sqrt();
        let (side, across) = (TAU * around).sin_cos();
        let off = aside * side + axis.cross(aside) * across;
        Launch {
            radius_m,
            position: DVec3::from(self.nozzle_m) + outward * self.ring_radius_m,
            velocity: (axis * (1.0 - versine) + off * sin_theta) * self.speed_m_s,
            wind: DVec3::new(self.wind_xz_m_s[0], 0.0, self.wind_xz_m_s[1]),
            basin_y_m: self.basin_y_m,
        }
    }
}
