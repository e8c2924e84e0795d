//! A fountain: drops thrown upwards, sorted by drag, laid out by the time they stay.
//!
//! Drops of all sizes leave a nozzle, or a ring of nozzles, at one speed within a cone about the
//! axis of the jet, and fly through a wind that is the same everywhere until they fall into the
//! basin (`fountain_jets`, `fountain_flight`). Drag sorts them: large drops rise highest and fly
//! farthest, so that the effective radius grows with height on the axis; the wind carries those small
//! ones away that fall far. Where drops linger there are many (`fountain_lattice`):
//! total water = `F <T>`,   total drops = sum F_i T_i/m_i
//! `F` flow [kg/s], `T` time of flight, `<T>` its mean over the flow, `m` mass of a drop. Without
//! drag T = 2 v sin(e)/g and the apex is at (v sin(e))²/(2 g); `v` speed, `e` elevation.
//!
//! Plausible, not measured: jets break up at some way from the nozzle, drag the air along, and drops
//! collide. All this is left out, so that mist below 0.2 mm stops nearer to the nozzle than in
//! nature, and the voxels at the nozzle are as dense as the jet.

use std::f64::consts::PI;

use glam::DVec3;
use niji_dropfield::AreaMoments;
use niji_dropfield::DropMode;
use niji_dropfield::DropVolume;
use niji_dropfield::Drops;
use niji_dropfield::GridBox;
use niji_radiometry::Micrometers;
use niji_sizes::GammaSizes;
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::Deserialize;
use serde::Serialize;

use crate::Error;
use crate::Turbulence;
use crate::drag::WATER_DENSITY_KG_M3;
use crate::error::require_finite;
use crate::error::require_in;
use crate::error::require_not_negative;
use crate::error::require_positive;
use crate::fountain_flight::Launch;
use crate::fountain_jets::FlightPlan;
use crate::fountain_lattice::Lattice;
use crate::fountain_lattice::Stream;
use crate::gusts;

/// Part of the box that is added on every side: two of the flights that bound it leave up to 0.9 % of
/// a radius between them.
const MARGIN: f64 = 0.01;

/// Nodes along an edge of the box, at most: a flight takes as many steps.
const LONGEST_EDGE: i32 = 1 << 14;

/// Fastest jet, m/s: that of a cutter. Flights of faster drops take ever more steps.
const FASTEST_M_S: f64 = 1000.0;

/// A fountain: one nozzle, or a ring of them.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Fountain {
    /// The nozzle, or the middle of a ring of nozzles (m).
    pub nozzle_m: [f64; 3],
    /// Radius of the ring of jets; 0 is one jet (m).
    #[serde(default)]
    #[schemars(range(min = 0.0))]
    pub ring_radius_m: f64,
    /// Speed at which the drops leave (m/s).
    #[schemars(extend("exclusiveMinimum" = 0.0, "maximum" = 1000.0))]
    pub speed_m_s: f64,
    /// Elevation of the jets; those of a ring lean outwards (degrees).
    #[serde(default = "upright")]
    #[schemars(range(min = 0.0, max = 90.0))]
    pub elevation_deg: f64,
    /// Direction into which a single jet leans, clockwise from north (degrees); rings have none.
    #[serde(default)]
    pub azimuth_deg: f64,
    /// Half angle of the cone into which a jet sprays (degrees).
    #[schemars(range(min = 0.0, max = 90.0))]
    pub spread_deg: f64,
    /// Flow of water in drops (kg/s).
    #[schemars(range(min = 0.0))]
    pub flow_kg_s: f64,
    /// Effective radius of the drops at the nozzle (um).
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub effective_radius_um: f64,
    /// Effective variance at the nozzle.
    #[schemars(extend("minimum" = 0.0, "exclusiveMaximum" = 0.5))]
    pub effective_variance: f64,
    /// Wind, x and z (m/s).
    #[serde(default)]
    pub wind_xz_m_s: [f64; 2],
    /// Height at which drops are lost: the basin (m).
    pub basin_y_m: f64,
    /// Gusts.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub turbulence: Option<Turbulence>,
    /// Edge length of a voxel (m).
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub voxel_m: f64,
}

fn upright() -> f64 {
    90.0
}

impl Fountain {
    /// Check all parameters.
    ///
    /// # Errors
    /// The parameter that is wrong, what was found and what was expected.
    pub fn validate(&self) -> Result<(), Error> {
        self.checked_grid().map(|_| ())
    }

    /// The box of a fountain whose parameters are sound: flights are followed for it, once.
    fn checked_grid(&self) -> Result<GridBox, Error> {
        GammaSizes::new(
            Micrometers(self.effective_radius_um),
            self.effective_variance,
        )?;
        for place in self.nozzle_m {
            require_finite("nozzle_m", place)?;
        }
        for wind in self.wind_xz_m_s {
            require_finite("wind_xz_m_s", wind)?;
        }
        require_not_negative("ring_radius_m", self.ring_radius_m)?;
        require_positive("speed_m_s", self.speed_m_s)?;
        require_in(
            0.0..=FASTEST_M_S,
            "speed_m_s",
            self.speed_m_s,
            "at most 1000 m/s",
        )?;
        let degrees = "an angle in 0..=90 degrees";
        require_in(0.0..=90.0, "elevation_deg", self.elevation_deg, degrees)?;
        require_in(0.0..=90.0, "spread_deg", self.spread_deg, degrees)?;
        require_finite("azimuth_deg", self.azimuth_deg)?;
        require_not_negative("flow_kg_s", self.flow_kg_s)?;
        require_finite("basin_y_m", self.basin_y_m)?;
        require_not_negative("nozzle_m[1] - basin_y_m", self.nozzle_m[1] - self.basin_y_m)?;
        gusts::check(self.turbulence)?;
        let grid = self.grid();
        let longest = grid.n_nodes()?.into_iter().max().unwrap_or(0);
        if longest > LONGEST_EDGE {
            return Err(Error::Parameter {
                parameter: "voxel_m",
                found: self.voxel_m,
                expected: "at most 16384 voxels along the flight of the drops: larger voxels, \
                           larger drops or less wind",
            });
        }
        Ok(grid)
    }

    /// The box around all flights, and its voxels.
    ///
    /// Found from a few hundred to thousand flights, with a margin for those between them.
    pub fn grid(&self) -> GridBox {
        let mut low = DVec3::from(self.nozzle_m);
        let mut high = low;
        for launch in self.extreme_launches() {
            launch.fly(|step| {
                for share in [0.25, 0.5, 0.75, 1.0] {
                    low = low.min(step.place(share));
                    high = high.max(step.place(share));
                }
            });
        }
        let margin = MARGIN * (high - low) + self.voxel_m;
        low -= margin;
        high += margin;
        low.y = self.basin_y_m;
        let size = ((high - low) / self.voxel_m).ceil() * self.voxel_m;
        // What is added to make whole voxels is added on both sides: calm air stays symmetric.
        let beside = 0.5 * (size - (high - low)) * DVec3::new(1.0, 0.0, 1.0);
        GridBox {
            min: low - beside,
            max: low - beside + size,
            voxel_m: self.voxel_m,
        }
    }

    /// Lay the shape out as a volume.
    ///
    /// # Errors
    /// As [`Fountain::validate`].
    pub fn volume(&self) -> Result<DropVolume, Error> {
        let grid = self.checked_grid()?;
        let streams = self.streams(&FlightPlan::of(self, &grid));
        let mode = Lattice::of_streams(grid, &streams)?.mode()?;
        let mode = gusts::stir(self.turbulence, mode)?;
        Ok(DropVolume { modes: vec![mode] })
    }

    /// Smallest and largest drops (um), between which the effective radius of every mixture lies.
    pub fn effective_radius_range_um(&self) -> (f64, f64) {
        let (smallest_m, largest_m) = self.radius_limits_m();
        (1e6 * smallest_m, 1e6 * largest_m)
    }

    /// Smallest and largest effective variance at the nodes, found by laying the shape out.
    pub fn effective_variance_range(&self) -> (f64, f64) {
        self.range_over_nodes(|drops| f64::from(drops.effective_variance))
    }

    /// Largest extinction without diffraction of a node (1/m), found by laying the shape out.
    pub fn max_extinction_m1_q1(&self) -> f64 {
        let extinction = |drops: &Drops| AreaMoments::from_drops(drops).extinction_m1_q1();
        self.range_over_nodes(extinction).1
    }

    /// Smallest and largest value over the nodes that have drops; zeros without any.
    fn range_over_nodes(&self, value: impl Fn(&Drops) -> f64) -> (f64, f64) {
        let Ok(volume) = self.volume() else {
            return (0.0, 0.0);
        };
        let nodes = volume.modes.iter().flat_map(DropMode::nodes);
        let values = nodes
            .map(|(_, drops)| value(&drops))
            .map(|value| (value, value));
        let wider = |a: (f64, f64), b: (f64, f64)| (a.0.min(b.0), a.1.max(b.1));
        values.reduce(wider).unwrap_or((0.0, 0.0))
    }

    /// Drops in the air: flow by number times time of flight.
    pub fn total_drops(&self) -> f64 {
        self.sum_over_flights(|launch, water_kg| {
            let drop_kg = 4.0 / 3.0 * PI * WATER_DENSITY_KG_M3 * launch.radius_m.powi(3);
            water_kg / drop_kg
        })
    }

    /// Water in the air (g): flow times the mean time of flight.
    pub fn total_water_g(&self) -> f64 {
        self.sum_over_flights(|_, water_kg| 1e3 * water_kg)
    }

    /// Sum, in their order, of a value of the flights and of the water (kg) on the way.
    fn sum_over_flights(&self, value: impl Fn(&Launch, f64) -> f64 + Sync) -> f64 {
        let Ok(grid) = self.checked_grid() else {
            return 0.0;
        };
        let of_stream = |stream: &Stream| {
            let mut time_s = 0.0;
            stream.launch.fly(|step| time_s += step.time_s);
            value(&stream.launch, stream.flow_kg_s * time_s)
        };
        let streams = self.streams(&FlightPlan::of(self, &grid));
        let values: Vec<f64> = streams.par_iter().map(of_stream).collect();
        values.iter().sum()
    }
}

#[cfg(test)]
#[path = "fountain_tests.rs"]
mod tests;
