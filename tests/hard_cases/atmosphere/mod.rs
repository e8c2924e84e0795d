//! Hard cases of the air.

pub(crate) mod light;
pub(crate) mod paths;

use niji_atmosphere::AirModel;
use niji_atmosphere::Constituent;
use niji_atmosphere::NishitaAir;
use niji_atmosphere::USUAL_TOP_M;
use niji_exchange::AtmosphereTable;
use niji_geometry::EARTH;
use niji_radiometry::Reflectance;
use niji_radiometry::WavelengthGrid;

pub(crate) fn grid() -> WavelengthGrid {
    WavelengthGrid::new(450.0, 100.0, 3).expect("three wavelengths of light")
}

/// Air at 450, 550 and 650 nm under a sun of irradiance 1, over black ground.
pub(crate) fn air(constituents: Vec<Constituent>) -> AtmosphereTable {
    let mut air = table(constituents, USUAL_TOP_M);
    air.sun_irradiance = vec![1.0; 3];
    air
}

pub(crate) fn table(constituents: Vec<Constituent>, top_height_m: f64) -> AtmosphereTable {
    let model = AirModel {
        planet: EARTH,
        top_height_m,
        wavelengths: grid(),
        sun_scale: 1.0,
        ground: Reflectance::Even(0.0),
        constituents,
    };
    model.tabulate().expect("air like the Earth's")
}

/// Exponential air of scale height 7994 m, of T. Nishita et al., SIGGRAPH 1993.
pub(crate) fn nishita() -> AtmosphereTable {
    let molecules = NishitaAir::PUBLISHED.constituent(&grid());
    air(vec![molecules.expect("published air")])
}
