//! A waterfall: curtain, splash and mist, a mode each. Plausible, not measured.
//!
//! curtain   F sqrt(2 H/g)                                       falling sheet (`waterfall_curtain.rs`)
//! splash    f F sqrt(2 pi h0/g)                                 thrown up again (`waterfall_splash.rs`)
//! mist      k F s0/(0.06 U) [(b/s0)^(1 - m) - 1]/(1 - m)        drifting away (`waterfall_mist.rs`)
//! water in the air [kg], each the flow times the time that it stays. `F` flow over the lip that falls
//! as drops [kg/s], `f` and `k` the shares of it that splash up again and that become mist at the foot,
//! `H` height [m], `g` gravity; the other symbols stand in the files named.
//!
//! total drops = sum over the modes of water/((4/3) pi rho_w <r³>)
//! with gamma laws of the given effective radii and of effective variances of 0.2 for curtain and
//! splash and 0.1 for mist, both chosen. 1000 kg/s over 20 m, 60 m high, with k = 1e-4, have 2 g/m³ of
//! mist at the foot, as much as a dense cloud.
//!
//! No number-density profile of a waterfall has been published: laws of the parts are published ones of
//! overfalls, jets, plunge pools and plumes, and their constants are chosen where the files say so.

use glam::DVec2;
use glam::DVec3;
use niji_dropfield::DropMode;
use niji_dropfield::DropVolume;
use niji_dropfield::GridBox;
use niji_radiometry::Micrometers;
use niji_sizes::Amount;
use niji_sizes::GammaSizes;
use niji_sizes::HansenTravis;
use niji_sizes::SizeMoments;
use schemars::JsonSchema;
use serde::Deserialize;
use serde::Serialize;

use crate::Error;
use crate::Turbulence;
use crate::drag::terminal_speed_m_s;
use crate::error::require_finite;
use crate::error::require_in;
use crate::error::require_not_negative;
use crate::error::require_positive;
use crate::gusts;
use crate::parcels::Parcels;
use crate::strands::Strands;
use crate::waterfall_curtain::Curtain;
use crate::waterfall_frame::Frame;
use crate::waterfall_frame::Part;
use crate::waterfall_mist::Mist;
use crate::waterfall_splash::Splash;

/// Effective variance of curtain and splash.
const SPRAY_VARIANCE: f64 = 0.2;

/// Effective variance of the mist.
const MIST_VARIANCE: f64 = 0.1;

/// Part of a voxel that is roundoff when the box is made a whole number of voxels.
const WHOLE_VOXEL_SLACK: f64 = 1e-6;

/// A waterfall. Plausible, not measured: no profile of number density was ever published.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Waterfall {
    /// Middle of the foot of the curtain (m).
    pub foot_m: [f64; 3],
    /// Direction into which the water leaves the lip, clockwise from north (degrees).
    pub azimuth_deg: f64,
    /// Height of the lip above the foot (m).
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub height_m: f64,
    /// Width of the curtain (m).
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub width_m: f64,
    /// Flow of water over the lip that falls as drops; splash and mist are shares of it (kg/s).
    #[schemars(range(min = 0.0))]
    pub flow_kg_s: f64,
    /// Share of the flow that splashes up again at the foot, 0..1.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub splash_fraction: f64,
    /// Share of the flow that drifts away as mist, 0..1.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub mist_fraction: f64,
    /// Effective radius of the drops of the curtain (um).
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub curtain_effective_radius_um: f64,
    /// Effective radius of the splash (um).
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub splash_effective_radius_um: f64,
    /// Effective radius of the mist (um).
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub mist_effective_radius_um: f64,
    /// Wind at the foot, x and z (m/s).
    pub wind_xz_m_s: [f64; 2],
    /// Strands and clumps of the curtain; an even sheet without.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub strands: Option<Strands>,
    /// Gusts in splash and mist.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub turbulence: Option<Turbulence>,
    /// Edge length of a voxel (m).
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub voxel_m: f64,
}

/// A part of a fall with its drops.
struct Population {
    name: &'static str,
    part: Box<dyn Part>,
    moments: SizeMoments,
    gusts: Option<Turbulence>,
}

impl Waterfall {
    /// Check all parameters.
    ///
    /// # Errors
    /// The parameter that is wrong, what was found and what was expected.
    pub fn validate(&self) -> Result<(), Error> {
        let [x, y, z] = self.foot_m;
        [x, y, z]
            .into_iter()
            .try_for_each(|place| require_finite("foot_m", place))?;
        let [x, z] = self.wind_xz_m_s;
        [x, z]
            .into_iter()
            .try_for_each(|wind| require_finite("wind_xz_m_s", wind))?;
        require_finite("azimuth_deg", self.azimuth_deg)?;
        require_positive("height_m", self.height_m)?;
        require_positive("width_m", self.width_m)?;
        require_positive("voxel_m", self.voxel_m)?;
        require_not_negative("flow_kg_s", self.flow_kg_s)?;
        let shares = 0.0..=1.0;
        require_in(
            shares.clone(),
            "splash_fraction",
            self.splash_fraction,
            "0..=1",
        )?;
        require_in(shares.clone(), "mist_fraction", self.mist_fraction, "0..=1")?;
        let both = self.splash_fraction + self.mist_fraction;
        require_in(shares, "splash_fraction + mist_fraction", both, "at most 1")?;
        for (name, radius_um, variance) in [
            (
                "curtain_effective_radius_um",
                self.curtain_effective_radius_um,
                SPRAY_VARIANCE,
            ),
            (
                "splash_effective_radius_um",
                self.splash_effective_radius_um,
                SPRAY_VARIANCE,
            ),
            (
                "mist_effective_radius_um",
                self.mist_effective_radius_um,
                MIST_VARIANCE,
            ),
        ] {
            require_positive(name, radius_um)?;
            GammaSizes::new(Micrometers(radius_um), variance)?;
        }
        self.strands.map_or(Ok(()), |it| it.validate())?;
        gusts::check(self.turbulence)?;
        self.grid().n_nodes()?;
        Ok(())
    }

    fn frame(&self) -> Frame {
        let azimuth_rad = self.azimuth_deg.to_radians();
        Frame {
            foot: DVec3::from(self.foot_m),
            // Clockwise from north, which is -z.
            forward: DVec2::new(azimuth_rad.sin(), -azimuth_rad.cos()),
            height_m: self.height_m,
            width_m: self.width_m,
            voxel_m: self.voxel_m,
        }
    }

    /// Curtain, splash and mist.
    fn populations(&self) -> [Population; 3] {
        let (frame, flow_g_s) = (self.frame(), 1e3 * self.flow_kg_s);
        let curtain = Curtain {
            frame,
            flow_g_s,
            strands: self.strands,
        };
        let splash = Splash {
            frame,
            flow_g_s: flow_g_s * self.splash_fraction,
        };
        let mist = Mist {
            frame,
            flow_g_s: flow_g_s * self.mist_fraction,
            wind_m_s: DVec2::from(self.wind_xz_m_s),
            settling_m_s: terminal_speed_m_s(1e-6 * self.mist_effective_radius_um),
        };
        let moments = |radius_um, variance| {
            HansenTravis::untruncated(Micrometers(radius_um), variance).moments()
        };
        [
            Population {
                name: "curtain",
                part: Box::new(curtain),
                moments: moments(self.curtain_effective_radius_um, SPRAY_VARIANCE),
                gusts: None,
            },
            Population {
                name: "splash",
                part: Box::new(splash),
                moments: moments(self.splash_effective_radius_um, SPRAY_VARIANCE),
                gusts: self.turbulence,
            },
            Population {
                name: "mist",
                part: Box::new(mist),
                moments: moments(self.mist_effective_radius_um, MIST_VARIANCE),
                gusts: self.turbulence,
            },
        ]
    }

    /// The populations that have water; the curtain alone of a fall that has run dry.
    fn wet_populations(&self) -> Vec<Population> {
        let dry = self.flow_kg_s <= 0.0;
        let wet = |population: &Population| {
            population.part.water_g() > 0.0 || dry && population.name == "curtain"
        };
        self.populations().into_iter().filter(wet).collect()
    }

    /// The box around all modes and its voxels, a whole number of them.
    pub fn grid(&self) -> GridBox {
        let extents = self
            .wet_populations()
            .into_iter()
            .map(|population| population.part.extent());
        let (min, max) = extents
            .reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
            .unwrap_or_default();
        let n_cells = ((max - min) / self.voxel_m - WHOLE_VOXEL_SLACK).ceil();
        GridBox {
            min,
            max: min + n_cells * self.voxel_m,
            voxel_m: self.voxel_m,
        }
    }

    /// Lay the shape out as a volume of the modes `curtain`, `splash` and `mist`.
    ///
    /// # Errors
    /// As [`Waterfall::validate`].
    pub fn volume(&self) -> Result<DropVolume, Error> {
        self.validate()?;
        let lay = |population: Population| -> Result<DropMode, Error> {
            let mut parcels = Parcels::new(self.grid())?;
            if population.part.water_g() > 0.0 {
                population.part.lay(&mut parcels);
            }
            let mode = parcels.into_mode(population.name, &population.moments)?;
            gusts::stir(population.gusts, mode)
        };
        let modes: Result<Vec<DropMode>, Error> = self.populations().into_iter().map(lay).collect();
        Ok(DropVolume { modes: modes? })
    }

    /// Smallest and largest effective radius (um).
    pub fn effective_radius_range_um(&self) -> (f64, f64) {
        self.range(|moments| moments.effective_radius().0)
    }

    /// Smallest and largest effective variance.
    pub fn effective_variance_range(&self) -> (f64, f64) {
        self.range(|moments| moments.effective_variance)
    }

    fn range(&self, value: impl Fn(&SizeMoments) -> f64) -> (f64, f64) {
        let values = self
            .wet_populations()
            .into_iter()
            .map(|population| value(&population.moments));
        values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
            (low.min(value), high.max(value))
        })
    }

    /// Upper bound on the extinction without diffraction (1/m): the densest places of all modes, as
    /// if they were one.
    pub fn max_extinction_m1_q1(&self) -> f64 {
        let bound = |population: Population| {
            let water = Amount::LiquidWater(population.part.densest_g_m3());
            let number_m3 = water.number_density_m3(&population.moments);
            let bulk = population.moments.bulk_properties(number_m3);
            0.5 * bulk.extinction_m1 * gusts::max_factor(population.gusts)
        };
        self.wet_populations().into_iter().map(bound).sum()
    }

    /// Drops in the air.
    pub fn total_drops(&self) -> f64 {
        let drops = |population: Population| {
            Amount::LiquidWater(population.part.water_g()).number_density_m3(&population.moments)
        };
        self.populations().into_iter().map(drops).sum()
    }

    /// Water in the air (g).
    pub fn total_water_g(&self) -> f64 {
        let water = |population: Population| population.part.water_g();
        self.populations().into_iter().map(water).sum()
    }
}

#[cfg(test)]
#[path = "waterfall_tests.rs"]
mod tests;
