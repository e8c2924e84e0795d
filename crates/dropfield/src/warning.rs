//! Drop volumes that nature does not make, or that nobody would see.
//!
//! None of these is an error: a picture may want them. The limits are round numbers outside of what
//! is observed: rain of 100 mm/h has 4.3 g/m³ (Marshall-Palmer), fogs and clouds have 1e7 to 1e9
//! drops per cubic metre and effective radii of 4 to 20 um, the largest raindrops have a radius of
//! about 4 mm and heavy rain an effective radius of 1 mm.
//! [PK97] Pruppacher and Klett, Microphysics of Clouds and Precipitation, 2nd ed., Kluwer (1997),
//! chapters 2 and 10.

use std::fmt;

use crate::AreaMoments;
use crate::DropMode;
use crate::DropVolume;

/// More liquid water than this is not found in the air (g/m³).
const MOST_LIQUID_WATER_G_M3: f64 = 5.0;

/// Effective radius up to which drops are those of fog and cloud (um).
const LARGEST_FOG_RADIUS_UM: f64 = 30.0;

/// Smaller drops than this do not last in nature (um): below it someone has taken metres.
const SMALLEST_RADIUS_UM: f64 = 0.05;

/// Fewest drops of a fog that can be seen at all (1/m³).
const FEWEST_FOG_DROPS_M3: f64 = 1e6;

/// Largest effective radius of heavy rain, with room to spare (um).
const LARGEST_RAIN_RADIUS_UM: f64 = 2000.0;

/// Optical depth below which a bow has a contrast of far less than a percent against a sky.
const FAINTEST_OPTICAL_DEPTH: f64 = 1e-3;

/// Optical depth above which light is scattered many times and a bow washes out.
const OPAQUE_OPTICAL_DEPTH: f64 = 30.0;

/// Something about a volume that its author should know.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Warning {
    /// There are no drops at all.
    Empty,
    /// More water than the air holds in nature.
    LiquidWater {
        /// Name of the mode.
        mode: String,
        /// Largest liquid water content (g/m³).
        found_g_m3: f64,
    },
    /// Drops smaller than any that last, as from a radius in other units.
    TinyDrops {
        /// Name of the mode.
        mode: String,
        /// Largest effective radius (um).
        effective_radius_um: f64,
    },
    /// Fog-sized drops, but too few of them to be seen.
    ThinFog {
        /// Name of the mode.
        mode: String,
        /// The effective radius of such a place (um).
        effective_radius_um: f64,
        /// The largest number density among such places (1/m³).
        number_density_m3: f64,
    },
    /// Drops larger than rain has.
    LargeDrops {
        /// Name of the mode.
        mode: String,
        /// Largest effective radius (um).
        effective_radius_um: f64,
    },
    /// So little scattering that no bow will be seen.
    Invisible {
        /// Largest optical depth without diffraction across the volume.
        optical_depth: f64,
    },
    /// So much scattering that a bow comes from the outermost drops only.
    Opaque {
        /// Largest optical depth without diffraction across the volume.
        optical_depth: f64,
    },
}

impl Warning {
    /// Everything that should be said about a volume, in a fixed order.
    pub(crate) fn of_volume(volume: &DropVolume, optical_depth: f64) -> Vec<Self> {
        if volume
            .modes
            .iter()
            .all(|mode| mode.nodes().next().is_none())
        {
            return vec![Self::Empty];
        }
        let mut warnings: Vec<Self> = volume.modes.iter().flat_map(of_mode).collect();
        if optical_depth < FAINTEST_OPTICAL_DEPTH {
            warnings.push(Self::Invisible { optical_depth });
        }
        if optical_depth > OPAQUE_OPTICAL_DEPTH {
            warnings.push(Self::Opaque { optical_depth });
        }
        warnings
    }
}

fn of_mode(mode: &DropMode) -> Vec<Warning> {
    let mut most_water_g_m3 = 0.0_f64;
    let mut largest_um = 0.0_f64;
    let mut densest_fog = None;
    for (_, drops) in mode.nodes() {
        let radius_um = 1e6 * f64::from(drops.effective_radius_m);
        let number_m3 = f64::from(drops.number_density_m3);
        most_water_g_m3 = most_water_g_m3.max(AreaMoments::from_drops(&drops).liquid_water_g_m3());
        largest_um = largest_um.max(radius_um);
        let denser = densest_fog.is_none_or(|(_, most)| number_m3 > most);
        if radius_um <= LARGEST_FOG_RADIUS_UM && denser {
            densest_fog = Some((radius_um, number_m3));
        }
    }
    let name = || mode.name.clone();
    let mut warnings = Vec::new();
    if most_water_g_m3 > MOST_LIQUID_WATER_G_M3 {
        warnings.push(Warning::LiquidWater {
            mode: name(),
            found_g_m3: most_water_g_m3,
        });
    }
    if largest_um > 0.0 && largest_um < SMALLEST_RADIUS_UM {
        warnings.push(Warning::TinyDrops {
            mode: name(),
            effective_radius_um: largest_um,
        });
    } else if let Some((effective_radius_um, number_density_m3)) = densest_fog
        && number_density_m3 < FEWEST_FOG_DROPS_M3
    {
        warnings.push(Warning::ThinFog {
            mode: name(),
            effective_radius_um,
            number_density_m3,
        });
    }
    if largest_um > LARGEST_RAIN_RADIUS_UM {
        warnings.push(Warning::LargeDrops {
            mode: name(),
            effective_radius_um: largest_um,
        });
    }
    warnings
}

/// `: ` after the name of a mode that has one.
fn prefix(mode: &str) -> String {
    if mode.is_empty() {
        String::new()
    } else {
        format!("{mode}: ")
    }
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Empty => write!(f, "there are no drops"),
            Self::LiquidWater { mode, found_g_m3 } => write!(
                f,
                "{}{found_g_m3:.2} g/m³ of liquid water, more than the {MOST_LIQUID_WATER_G_M3} \
                 g/m³ that the air holds in nature",
                prefix(mode)
            ),
            Self::TinyDrops {
                mode,
                effective_radius_um,
            } => write!(
                f,
                "{}drops of {effective_radius_um:.1e} um, smaller than any that last: radii are in \
                 micrometres in flags and scenes, in metres in VDB files",
                prefix(mode)
            ),
            Self::ThinFog {
                mode,
                effective_radius_um,
                number_density_m3,
            } => write!(
                f,
                "{}drops of {effective_radius_um:.1} um as in fog, but at most \
                 {number_density_m3:.3e} of them per cubic metre: a fog that can be seen has more \
                 than {FEWEST_FOG_DROPS_M3:.0e}",
                prefix(mode)
            ),
            Self::LargeDrops {
                mode,
                effective_radius_um,
            } => write!(
                f,
                "{}an effective radius of {:.2} mm: larger drops than {} mm break up, sizes in [drops] are \
                 in the unit that a key ends with",
                prefix(mode),
                1e-3 * effective_radius_um,
                1e-3 * LARGEST_RAIN_RADIUS_UM
            ),
            Self::Invisible { optical_depth } => write!(
                f,
                "optical depth {optical_depth:.1e} across the volume: a bow will hardly be seen"
            ),
            Self::Opaque { optical_depth } => write!(
                f,
                "optical depth {optical_depth:.1} across the volume: light is scattered many times \
                 and a bow comes from the outermost drops only"
            ),
        }
    }
}
