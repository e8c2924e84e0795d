//! References for the tests: adaptive quadrature that shares no formula with the crate.

#![allow(dead_code, reason = "every test target uses a part of it")]

pub(crate) mod adaptive_sky;

use niji_atmosphere::Aerosol;
use niji_atmosphere::AirModel;
use niji_atmosphere::BodhaineAir;
use niji_atmosphere::Constituent;
use niji_atmosphere::NishitaAir;
use niji_atmosphere::OzoneLayer;
use niji_atmosphere::STANDARD_PRESSURE_PA;
use niji_atmosphere::USUAL_TOP_M;
use niji_exchange::AtmosphereTable;
use niji_geometry::EARTH;
use niji_radiometry::Reflectance;
use niji_radiometry::WavelengthGrid;

/// Radius of the planet in all tests, m.
pub(crate) const RADIUS_M: f64 = 6_371_000.0;
/// Scale height of the papers' air, m.
pub(crate) const NISHITA_HEIGHT_M: f64 = 7994.0;

/// 450, 550 and 650 nm.
pub(crate) fn grid() -> WavelengthGrid {
    WavelengthGrid::new(450.0, 100.0, 3).expect("within the tables")
}

/// Air molecules as measured.
pub(crate) fn molecules(grid: &WavelengthGrid) -> Constituent {
    let air = BodhaineAir::at_pressure(STANDARD_PRESSURE_PA);
    air.constituent(grid).expect("usual air")
}

/// The papers' molecules.
pub(crate) fn nishita_molecules() -> Constituent {
    let air = NishitaAir::PUBLISHED.constituent(&grid());
    air.expect("published air")
}

pub(crate) fn ozone(column_dobson: f64) -> Constituent {
    let layer = OzoneLayer::of_column(column_dobson);
    layer.constituent(&grid()).expect("ozone like the Earth's")
}

pub(crate) fn haze(aerosol: Aerosol, grid: &WavelengthGrid) -> Constituent {
    aerosol.constituent(grid).expect("usual haze")
}

/// Air of the given constituents at 450, 550 and 650 nm under a sun of irradiance 1.
pub(crate) fn unit_sun_air(constituents: Vec<Constituent>) -> AtmosphereTable {
    let model = AirModel {
        planet: EARTH,
        top_height_m: USUAL_TOP_M,
        wavelengths: grid(),
        sun_scale: 1.0,
        ground: Reflectance::Even(0.0),
        constituents,
    };
    let mut air = model.tabulate().expect("usual air");
    air.sun_irradiance = vec![1.0; 3];
    air
}

/// The papers' air.
pub(crate) fn nishita() -> AtmosphereTable {
    unit_sun_air(vec![nishita_molecules()])
}

/// Integral by adaptive Simpson quadrature, relative to `scale`.
pub(crate) fn adaptive(f: &dyn Fn(f64) -> f64, [from, to]: [f64; 2], tolerance: f64) -> f64 {
    // Panels first, so that a narrow peak is not missed.
    let n_panels = 32;
    let width = (to - from) / f64::from(n_panels);
    let panel = |i: i32| {
        let a = from + f64::from(i) * width;
        let b = a + width;
        let (fa, fm, fb) = (f(a), f(0.5 * (a + b)), f(b));
        let whole = (b - a) / 6.0 * (fa + 4.0 * fm + fb);
        refine(
            f,
            [a, b],
            [fa, fm, fb],
            whole,
            tolerance / f64::from(n_panels),
            16,
        )
    };
    (0..n_panels).map(panel).sum()
}

#[allow(clippy::too_many_arguments, reason = "a recursion carries its state")]
fn refine(
    f: &dyn Fn(f64) -> f64,
    [a, b]: [f64; 2],
    [fa, fm, fb]: [f64; 3],
    whole: f64,
    tolerance: f64,
    depth: u32,
) -> f64 {
    let m = 0.5 * (a + b);
    let (fl, fr) = (f(0.5 * (a + m)), f(0.5 * (m + b)));
    let left = (m - a) / 6.0 * (fa + 4.0 * fl + fm);
    let right = (b - m) / 6.0 * (fm + 4.0 * fr + fb);
    let change = left + right - whole;
    if depth == 0 || change.abs() <= 15.0 * tolerance {
        return left + right + change / 15.0;
    }
    refine(f, [a, m], [fa, fl, fm], left, 0.5 * tolerance, depth - 1)
        + refine(f, [m, b], [fm, fr, fb], right, 0.5 * tolerance, depth - 1)
}

/// Height on a ray by the difference of two radii: 1e-9 m of rounding in f64.
pub(crate) fn height(height_m: f64, mu: f64, s: f64) -> f64 {
    let r0 = RADIUS_M + height_m;
    (r0 * r0 + 2.0 * r0 * mu * s + s * s).sqrt() - RADIUS_M
}

/// Distance to a shell from below, by the quadratic formula.
pub(crate) fn exit(height_m: f64, mu: f64, shell_m: f64) -> f64 {
    let r0 = RADIUS_M + height_m;
    let rt = RADIUS_M + shell_m;
    -r0 * mu + (r0 * r0 * (mu * mu - 1.0) + rt * rt).sqrt()
}

/// Integral of a density over `from..to` of a ray, by adaptive quadrature in pieces of the ray that
/// grow away from its lowest point.
pub(crate) fn length(density: &dyn Fn(f64) -> f64, [h, mu]: [f64; 2], [from, to]: [f64; 2]) -> f64 {
    let lowest = (-(RADIUS_M + h) * mu).clamp(from, to);
    let value = |s: f64| density(height(h, mu, s));
    // Substitution s = lowest +- t^2.
    let outwards = |end: f64, sign: f64| {
        let f = |t: f64| 2.0 * t * value(lowest + sign * t * t);
        let last = (end - lowest).abs().sqrt();
        let middle = 0.5 * (end + lowest);
        let largest = value(lowest).max(value(middle)).max(value(end));
        let scale = largest * (end - lowest).abs().min(1e4);
        adaptive(&f, [0.0, last], 1e-9 * scale.max(1e-30))
    };
    outwards(to, 1.0) + outwards(from, -1.0)
}
