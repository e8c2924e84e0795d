//! What all rays of a picture share, decided once before the first ray.

use glam::DVec3;
use niji_exchange::ScatteringTable;
use niji_geometry::Aabb;
use niji_geometry::Ray;
use niji_radiometry::Colorimetry;
use rayon::prelude::*;

use crate::air::Air;
use crate::air_glow::AirGlow;
use crate::air_slabs::DimmedBy;
use crate::error::Error;
use crate::flattening::flattening_along;
use crate::footprint::offsets;
use crate::footprint::rays_along;
use crate::levels::PixelFootprint;
use crate::march::March;
use crate::piece_rule::PieceRule;
use crate::request::RenderRequest;
use crate::scattering_angle::scattering_angle_rad;
use crate::scattering_rows::ScatteringRows;
use crate::surround::mean_surround;

/// What all rays of a picture share.
pub(crate) struct Frame<'a> {
    /// Direction towards the sun.
    pub(crate) sun_direction: DVec3,
    /// E_sun [W m^-2 nm^-1].
    pub(crate) irradiance: Vec<f32>,
    /// The drops' box.
    pub(crate) bounds: Option<Aabb>,
    /// The way through the drops.
    pub(crate) march: March<'a>,
    /// How drops scatter; `None` where no bow is wanted.
    pub(crate) rows: Option<ScatteringRows>,
    /// Between secondary and primary bow.
    pub(crate) split_theta_rad: f64,
    /// Which side of the split is wanted: below, above.
    pub(crate) sides: (bool, bool),
    /// Whether what lies behind drops is dimmed.
    pub(crate) drops_dim: bool,
    /// The air, where any of its effects is on.
    pub(crate) air: Option<Air<'a>>,
    /// Air in front of and above the drops.
    pub(crate) dimmed_by: DimmedBy,
    /// Whether the air in front, and what lies beyond, send light.
    pub(crate) glows: (bool, bool),
    /// Nodes of the air's light.
    pub(crate) glow: AirGlow,
    /// Mean of the surroundings for unit irradiance [1/sr], where it lights the drops.
    pub(crate) surround: Option<Vec<f32>>,
}

/// Everything that rays share.
pub(crate) fn frame<'a>(
    request: &RenderRequest<'a>,
    colorimetry: &Colorimetry,
) -> Result<Frame<'a>, Error> {
    let (effects, levels) = (request.effects, request.levels);
    let efficiency = levels.drop_extinction_model.efficiency();
    let when = |on: bool| if on { efficiency } else { 0.0 };
    let rule = PieceRule::new(
        when(effects.drop_extinction.is_on()),
        when(effects.drop_shadow.is_on()),
        levels.integration,
    );
    let glows = (effects.air_inscatter.is_on(), request.wants_sky());
    let dimmed_by = DimmedBy {
        sunlight: effects.sunlight_through_air.is_on(),
        view: effects.air_extinction.is_on(),
    };
    let needs_air = glows.0 || glows.1 || !dimmed_by.nothing();
    let eye = request.camera.position();
    let air = request
        .air
        .filter(|_| needs_air)
        .map(|table| Air::new(table, levels.air_path, request.sun_direction, eye))
        .map(|air| air.with_light_of(levels.sky_model));
    let glow = AirGlow::new();
    let bounds = request.drops.bounds();
    let surround = match (&air, bounds) {
        (Some(air), Some(bounds)) if request.wants_skylit_drops() => {
            let middle = 0.5 * (bounds.min + bounds.max);
            Some(mean_surround(air, &glow, middle, request.wavelengths.len()))
        }
        (Some(_) | None, _) => None,
    };
    let bricks = request.drops.bricks();
    let split_theta_rad = request.table.map_or(0.0, |table| table.split_theta_rad);
    let mut frame = Frame {
        sun_direction: request.sun_direction,
        irradiance: request
            .sun_irradiance
            .iter()
            .map(|value| *value as f32)
            .collect(),
        bounds,
        march: March {
            bricks,
            rule,
            integration: levels.integration,
        },
        rows: None,
        split_theta_rad,
        sides: request.wanted_sides(),
        drops_dim: effects.drop_extinction.is_on(),
        air,
        dimmed_by,
        glows,
        glow,
        surround,
    };
    frame.rows = rows(request, &frame, colorimetry)?;
    Ok(frame)
}

/// The part of the scattering table that the picture sees; `None` where it sees none.
fn rows(
    request: &RenderRequest,
    frame: &Frame,
    colorimetry: &Colorimetry,
) -> Result<Option<ScatteringRows>, Error> {
    let Some(table) = request.table.filter(|_| request.wants_bow()) else {
        return Ok(None);
    };
    let Some(seen) = directions_seen(request, frame) else {
        return Ok(None);
    };
    check_coverage(table, &seen)?;
    let luminance_weights: Vec<f64> = colorimetry
        .weights()
        .iter()
        .zip(request.sun_irradiance)
        .map(|([_, y, _], irradiance)| y * irradiance)
        .collect();
    // The footprint of a pixel reaches beyond its center.
    let margin_rad = match request.levels.pixel_footprint {
        PixelFootprint::Prefiltered => request.camera.pixel_angle().0,
        PixelFootprint::Center | PixelFootprint::Grid { .. } => 0.0,
    };
    let range_rad = (seen.theta_rad.0 - margin_rad, seen.theta_rad.1 + margin_rad);
    ScatteringRows::new(table, range_rad, &luminance_weights).map(Some)
}

/// Smallest and largest scattering angle and flattening of the rays that cross the drops' box and
/// want a bow.
#[derive(Clone, Copy)]
struct Seen {
    theta_rad: (f64, f64),
    flattening: (f64, f64),
}

impl Seen {
    fn by(ray: &Ray, sun_direction: DVec3) -> Self {
        let theta_rad = scattering_angle_rad(ray.direction, sun_direction);
        let flattening = flattening_along(ray.direction, sun_direction);
        Self {
            theta_rad: (theta_rad, theta_rad),
            flattening: (flattening, flattening),
        }
    }

    fn union(self, other: Self) -> Self {
        let union = |a: (f64, f64), b: (f64, f64)| (a.0.min(b.0), a.1.max(b.1));
        Self {
            theta_rad: union(self.theta_rad, other.theta_rad),
            flattening: union(self.flattening, other.flattening),
        }
    }
}

fn directions_seen(request: &RenderRequest, frame: &Frame) -> Option<Seen> {
    let n = rays_along(request.levels.pixel_footprint);
    let eye = request.eye();
    (0..request.camera.height_px())
        .into_par_iter()
        .filter_map(|y| {
            let pixels =
                (0..request.camera.width_px()).flat_map(|x| offsets(n).map(move |o| (x, o)));
            pixels
                .map(|(x, (dx, dy))| eye.sight(f64::from(x) + dx, f64::from(y) + dy))
                .filter(|sight| frame.range_m(sight).is_some())
                .map(|sight| Seen::by(&sight.ray, request.sun_direction))
                .filter(|seen| frame.wants(seen.theta_rad.0))
                .reduce(Seen::union)
        })
        .reduce_with(Seen::union)
}

/// Refuse a table that lacks directions which the picture needs. A single flattening stands for all.
fn check_coverage(table: &ScatteringTable, seen: &Seen) -> Result<(), Error> {
    // Rounding of angles that were computed in two ways.
    let slack = 1e-7;
    let ends = |axis: &[f64]| (axis[0], axis[axis.len() - 1]);
    let lacks = |found: (f64, f64), expected: (f64, f64)| {
        expected.0 < found.0 - slack || expected.1 > found.1 + slack
    };
    let covered_rad = ends(&table.theta_rad);
    if lacks(covered_rad, seen.theta_rad) {
        let degrees = |(low, high): (f64, f64)| (low.to_degrees(), high.to_degrees());
        return Err(Error::AngleRange {
            found_deg: degrees(covered_rad),
            expected_deg: degrees(seen.theta_rad),
        });
    }
    let (found, expected) = (ends(&table.flattening), seen.flattening);
    if table.flattening.len() > 1 && lacks(found, expected) {
        return Err(Error::FlatteningRange { found, expected });
    }
    Ok(())
}
