//! What all rays of a picture share, decided once before the first ray.

use std::borrow::Cow;

use glam::DVec3;
use niji_exchange::ScatteringTable;
use niji_geometry::Aabb;
use niji_geometry::PixelRegion;
use niji_radiometry::Colorimetry;
use rayon::prelude::*;

use crate::air::Air;
use crate::air_glow::AirGlow;
use crate::air_slabs::DimmedBy;
use crate::deadline::Deadline;
use crate::drop_orders::Diffraction;
use crate::drop_orders::FirstOrder;
use crate::drop_orders::MultipleLight;
use crate::drop_orders::OrdersRequest;
use crate::drop_orders::SeenDirections;
use crate::drop_orders::SunAxes;
use crate::drop_orders::kept_radii;
use crate::error::Error;
use crate::footprint::apron;
use crate::footprint::offsets;
use crate::footprint::rays_along;
use crate::levels::PixelFootprint;
use crate::march::March;
use crate::moved_rows::Blur;
use crate::moved_rows::MovedRows;
use crate::piece_rule::PieceRule;
use crate::progress::Progress;
use crate::reflection::Reflection;
use crate::reflection::mirrored_sun;
use crate::request::RenderRequest;
use crate::scattering_angle::scattering_angle_rad;
use crate::scattering_rows::ScatteringRows;
use crate::seen_water::SeenWater;
use crate::shadow_error::ShadowError;
use crate::size_nodes::SizeNodes;
use crate::size_nodes::table_of_laws;
use crate::surface_light::SurfaceLight;
use crate::surround::mean_surround;

/// Part of the tolerance for the rays of a pixel that nobody sees.
const UNSEEN: f64 = 0.1;

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
    /// How wrong the sun's optical depth is, and the efficiency Q by which it counts.
    pub(crate) shadow_error: Option<(&'a ShadowError, f64)>,
    /// How drops scatter; `None` where no bow is wanted.
    pub(crate) rows: Option<ScatteringRows<'a>>,
    /// The part of them that flattening moves.
    pub(crate) moved: Option<MovedRows>,
    /// From a spectrum of the table's unit to luminance.
    pub(crate) luminance_weights: Vec<f64>,
    /// The bows that are wanted.
    pub(crate) sides: BowSides,
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
    /// Index of the wavelength that adds most to luminance in the sun.
    pub(crate) brightest: usize,
    /// Mean of the surroundings for unit irradiance [1/sr], where it lights the drops.
    pub(crate) surround: Option<Vec<f32>>,
    /// Light that drops scatter more than once, where it is wanted.
    pub(crate) multiple: Option<MultipleLight>,
    /// What diffraction changes in the bows, where that light is wanted.
    pub(crate) diffraction: Option<Diffraction<'a>>,
    /// Seconds that both took.
    pub(crate) further_orders_s: f64,
    /// A change of a pixel's luminance that nobody sees at the tolerance of the picture [cd/m²].
    pub(crate) unseen_cd_m2: f64,
    /// Light of the drops in the sun that water mirrors.
    pub(crate) reflection: Option<Reflection<'a>>,
    /// Water that is seen.
    pub(crate) water: Option<SeenWater<'a>>,
    /// Light of surfaces, where it is wanted.
    pub(crate) lit: Option<SurfaceLight<'a>>,
}

/// Which bows are wanted, on both sides of the angle between them.
#[derive(Clone, Copy)]
pub(crate) struct BowSides {
    /// Between secondary and primary bow.
    split_theta_rad: f64,
    /// Below the split and above it.
    wanted: (bool, bool),
}

impl BowSides {
    /// Whether a scattering angle is on the side of the primary.
    pub(crate) fn is_primary(self, theta_rad: f64) -> bool {
        theta_rad >= self.split_theta_rad
    }

    /// Whether a bow is wanted at a scattering angle.
    pub(crate) fn wants(self, theta_rad: f64) -> bool {
        if self.is_primary(theta_rad) {
            self.wanted.1
        } else {
            self.wanted.0
        }
    }
}

/// What is known before any light of drops is: the way through drops and air, and the rays that count.
pub(crate) struct FrameBasis<'a> {
    pub(crate) bounds: Option<Aabb>,
    pub(crate) march: March<'a>,
    pub(crate) sides: BowSides,
    pub(crate) air: Option<Air<'a>>,
    pub(crate) dimmed_by: DimmedBy,
    pub(crate) glows: (bool, bool),
    pub(crate) luminance_weights: Vec<f64>,
    pub(crate) brightest: usize,
}

impl<'a> FrameBasis<'a> {
    fn new(request: &RenderRequest<'a>, colorimetry: &Colorimetry) -> Self {
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
        let is_lit = effects.lit_surfaces.is_on();
        let needs_air = glows.0 || glows.1 || !dimmed_by.nothing() || is_lit;
        let eye = request.camera.position();
        let air = request
            .air
            .filter(|_| needs_air)
            .map(|table| Air::new(table, levels.air_path, request.sun_direction, eye))
            .map(|air| air.with_light_of(levels.sky_model));
        let luminance_weights = luminance_weights(request, colorimetry);
        Self {
            bounds: request.drops_seen(),
            march: March {
                bricks: request.drops.bricks(),
                rule,
                integration: levels.integration,
            },
            sides: BowSides {
                split_theta_rad: request.table.map_or(0.0, |table| table.split_theta_rad),
                wanted: request.wanted_sides(),
            },
            air,
            dimmed_by,
            glows,
            brightest: brightest(&luminance_weights),
            luminance_weights,
        }
    }
}

/// Everything that rays share.
pub(crate) fn frame<'a>(
    request: &RenderRequest<'a>,
    colorimetry: &Colorimetry,
    (progress, deadline): (Progress, Deadline),
) -> Result<Frame<'a>, Error> {
    let basis = FrameBasis::new(request, colorimetry);
    let drops = request.drops;
    let shadow_error = drops
        .shadow_error()
        .filter(|_| request.effects.drop_shadow.is_on());
    let efficiency = request.levels.drop_extinction_model.efficiency();
    let surround = match (&basis.air, basis.bounds) {
        (Some(air), Some(bounds)) if request.wants_skylit_drops() => {
            let middle = 0.5 * (bounds.min + bounds.max);
            Some(mean_surround(air, middle, request.wavelengths.len()))
        }
        (Some(_) | None, _) => None,
    };
    let rows = rows(request, &basis)?;
    let reflection = match mirrored_sun(request) {
        Some(sun_direction) => range_seen(request, &basis, sun_direction)?
            .and_then(|range_rad| Reflection::new(request, &basis, range_rad)),
        None => None,
    };
    let water = request
        .water
        .map(|water| SeenWater::new(request, (&basis, water), rows.as_ref()));
    let table = request.table.filter(|_| rows.is_some());
    let moved = table.and_then(|table| {
        let nodes = SizeNodes::of_drops(table, drops.size_range());
        let tables = std::slice::from_ref(table);
        MovedRows::new(tables, &nodes, &basis.luminance_weights, Blur::Pixel)
    });
    let start_s = (deadline.now_s)();
    let multiple = multiple(request, &basis, (progress, deadline))?;
    let of_diffraction = rows.as_ref().filter(|_| multiple.is_some());
    let diffraction = of_diffraction.and_then(|rows| diffraction(request, &basis, rows));
    let further_orders_s = (deadline.now_s)() - start_s;
    let is_lit = request.effects.lit_surfaces.is_on();
    Ok(Frame {
        lit: is_lit.then(|| SurfaceLight::new(request)),
        diffraction,
        further_orders_s,
        sun_direction: request.sun_direction,
        irradiance: request
            .sun_irradiance
            .iter()
            .map(|value| *value as f32)
            .collect(),
        bounds: basis.bounds,
        march: basis.march,
        shadow_error: shadow_error.map(|error| (error, efficiency)),
        rows,
        moved,
        luminance_weights: basis.luminance_weights,
        sides: basis.sides,
        drops_dim: request.effects.drop_extinction.is_on(),
        air: basis.air,
        dimmed_by: basis.dimmed_by,
        glows: basis.glows,
        glow: AirGlow::of(request.levels.air_path, request.tolerance_cd_m2.is_some()),
        brightest: basis.brightest,
        surround,
        unseen_cd_m2: UNSEEN * request.tolerance_cd_m2.unwrap_or_default(),
        multiple,
        reflection,
        water,
    })
}

impl Frame<'_> {
    /// Take twice as many nodes of the air's light and on each way through the air.
    pub(crate) fn refine_air(&mut self) {
        self.glow = self.glow.finer();
        self.air = self.air.as_ref().map(Air::finer);
        if let Some(reflection) = &mut self.reflection {
            reflection.refine_air();
        }
    }

    /// Refuse a table in which rays have met a value that none can have.
    pub(crate) fn check_rows(&self) -> Result<(), Error> {
        let of_diffraction = self.diffraction.iter().flat_map(Diffraction::rows);
        let mirrored = self.reflection.iter().flat_map(Reflection::rows);
        let in_water = self.water.iter().flat_map(SeenWater::rows);
        let all = self.rows.iter().chain(of_diffraction);
        let mut all = all.chain(mirrored).chain(in_water);
        all.try_for_each(ScatteringRows::check)
    }
}

/// The part of the scattering table that the picture sees; `None` where it sees none.
fn rows<'a>(
    request: &RenderRequest<'a>,
    basis: &FrameBasis,
) -> Result<Option<ScatteringRows<'a>>, Error> {
    let Some(table) = request.table.filter(|_| request.wants_bow()) else {
        return Ok(None);
    };
    let Some(range_rad) = range_seen(request, basis, request.sun_direction)? else {
        return Ok(None);
    };
    let nodes = SizeNodes::of_drops(table, request.drops.size_range());
    let source = (Cow::Borrowed(table), nodes);
    let rows = ScatteringRows::new(source, range_rad, &basis.luminance_weights);
    Ok(Some(rows))
}

/// Smallest and largest scattering angle from a sun of the rays that see drops, pixels and their neighbors
/// whole; `None` if there are none.
fn range_seen(
    request: &RenderRequest,
    basis: &FrameBasis,
    sun_direction: DVec3,
) -> Result<Option<(f64, f64)>, Error> {
    let seen_in = |region: PixelRegion| directions_seen(request, basis, (sun_direction, region));
    let seen = seen_in(request.region);
    if let (Some(table), Some(seen)) = (request.table, &seen) {
        check_coverage(table, seen)?;
    }
    // What estimates an error looks at neighbors too, and at rays all over the frame, which may lie beyond the table:
    // there its last angle stands for them.
    let camera = request.camera;
    let frame = PixelRegion::frame(camera.width_px(), camera.height_px());
    let frame = (request.region != frame).then_some(frame);
    let regions = frame.into_iter().chain([request.region]);
    let beside = frame.into_iter().chain(regions.flat_map(apron));
    let all = seen.into_iter().chain(beside.filter_map(seen_in));
    let Some(seen) = all.reduce(Seen::union) else {
        return Ok(None);
    };
    // The footprint of a pixel reaches beyond its center.
    let margin_rad = match (request.levels.pixel_footprint, request.tolerance_cd_m2) {
        (PixelFootprint::Prefiltered, _) | (_, Some(_)) => request.camera.pixel_angle().0,
        (PixelFootprint::Center | PixelFootprint::Grid { .. }, None) => 0.0,
    };
    let margin_rad = margin_rad + request.water.map_or(0.0, |water| water.streak_reach().0);
    let (low_rad, high_rad) = seen.theta_rad;
    Ok(Some((low_rad - margin_rad, high_rad + margin_rad)))
}

/// From a spectrum for unit irradiance to luminance in the sun.
fn luminance_weights(request: &RenderRequest, colorimetry: &Colorimetry) -> Vec<f64> {
    let weights = colorimetry.weights().iter().zip(request.sun_irradiance);
    weights
        .map(|([_, y, _], irradiance)| y * irradiance)
        .collect()
}

/// Index of the largest weight.
fn brightest(weights: &[f64]) -> usize {
    let by_weight = |a: &(usize, &f64), b: &(usize, &f64)| a.1.total_cmp(b.1);
    let largest = weights.iter().enumerate().max_by(by_weight);
    largest.map_or(0, |(index, _)| index)
}

/// What diffraction changes in the bows that are seen, where further orders are wanted.
fn diffraction<'a>(
    request: &RenderRequest,
    basis: &FrameBasis<'a>,
    rows: &ScatteringRows,
) -> Option<Diffraction<'a>> {
    let range_rad = rows.angles().theta_range_rad();
    let first_order = FirstOrder {
        march: basis.march,
        extinction: request.levels.drop_extinction_model,
        luminance_weights: basis.luminance_weights.clone(),
    };
    let table = table_of_laws(request.table?, request.drops.size_range(), kept_radii);
    Some(Diffraction::new(&table, range_rad, &first_order))
}

/// The light of orders beyond the first, for all directions of the camera's frame whatever its region:
/// beyond the frame the nearest direction stands for others.
fn multiple(
    request: &RenderRequest,
    basis: &FrameBasis,
    (progress, deadline): (Progress, Deadline),
) -> Result<Option<MultipleLight>, Error> {
    let (Some((nodes_across, paths_per_node)), Some(table), Some(bounds)) =
        (request.wanted_orders(), request.table, basis.bounds)
    else {
        return Ok(None);
    };
    let (camera, axes) = (request.camera, SunAxes::of(request.sun_direction));
    let seen = (0..=camera.height_px())
        .into_par_iter()
        .map(|y| {
            let mut seen = SeenDirections::none();
            for x in 0..=camera.width_px() {
                let ray = camera.ray(f64::from(x), f64::from(y));
                let Some(ray) = ray else { continue };
                let in_water = request.water.and_then(|water| water.continued(&ray));
                for ray in [Some(ray), in_water].into_iter().flatten() {
                    if bounds.intersect(&ray).is_some() {
                        seen.add(&axes, ray.direction);
                    }
                }
            }
            seen
        })
        .reduce(SeenDirections::none, |a, b| a.union(&b));
    let air = |dims: bool| basis.air.as_ref().filter(|_| dims);
    // A table without any may hold all angles itself.
    let phase_functions = table.phase_functions.as_deref().unwrap_or(table);
    MultipleLight::new(&OrdersRequest {
        drops: request.drops,
        table: &table_of_laws(phase_functions, request.drops.size_range(), kept_radii),
        sun_direction: request.sun_direction,
        eye: camera.position(),
        seen: &seen,
        sunlight_air: air(basis.dimmed_by.sunlight),
        view_air: air(basis.dimmed_by.view),
        luminance_weights: &basis.luminance_weights,
        nodes_across,
        paths_per_node,
        allowed_cd_m2: request.orders_error_cd_m2,
        deadline,
        progress,
    })
}

/// Smallest and largest scattering angle of the rays that cross the drops' box and want a bow.
#[derive(Clone, Copy, Debug)]
struct Seen {
    theta_rad: (f64, f64),
}

impl Seen {
    fn union(self, other: Self) -> Self {
        let union = |a: (f64, f64), b: (f64, f64)| (a.0.min(b.0), a.1.max(b.1));
        Self {
            theta_rad: union(self.theta_rad, other.theta_rad),
        }
    }
}

/// The directions of a row between which all others lie. Cosines tell which: an angle for each
/// would take as long as the rays.
#[derive(Clone, Copy, Debug)]
struct Extremes {
    /// Cosine of the scattering angle and direction, of the smallest and the largest angle.
    theta: [(f64, DVec3); 2],
}

impl Extremes {
    fn of(direction: DVec3, sun_direction: DVec3) -> Self {
        let cosine = sun_direction.dot(direction);
        Self {
            theta: [(cosine, direction); 2],
        }
    }

    fn union(self, other: Self) -> Self {
        let [(a_near, a_far), (b_near, b_far)] =
            [self.theta, other.theta].map(|[near, far]| (near, far));
        Self {
            theta: [
                if b_near.0 > a_near.0 { b_near } else { a_near },
                if b_far.0 < a_far.0 { b_far } else { a_far },
            ],
        }
    }

    fn seen(&self, sun_direction: DVec3) -> Seen {
        let [near, far] =
            (self.theta).map(|(_, direction)| scattering_angle_rad(direction, sun_direction));
        Seen {
            theta_rad: (near, far),
        }
    }
}

fn directions_seen(
    request: &RenderRequest,
    basis: &FrameBasis,
    (sun_direction, region): (DVec3, PixelRegion),
) -> Option<Seen> {
    let n = rays_along(request.levels.pixel_footprint);
    let drops = basis.bounds?;
    let wants = |direction: DVec3| {
        basis.sides.wanted == (true, true)
            || basis
                .sides
                .wants(scattering_angle_rad(direction, sun_direction))
    };
    (0..region.height_px)
        .into_par_iter()
        .filter_map(|row| {
            let y = f64::from(region.y_px) + f64::from(row);
            let mut extremes: Option<Extremes> = None;
            // Loops: in a chain of iterators `flat_map` stayed a call for every pixel.
            for x in 0..region.width_px {
                let x = f64::from(region.x_px) + f64::from(x);
                for (dx, dy) in offsets(n) {
                    let Some(ray) = request.camera.ray(x + dx, y + dy) else {
                        continue;
                    };
                    // Whatever hides them: that is asked once, when a ray is traced.
                    let in_water = request.water.and_then(|water| water.continued(&ray));
                    for ray in [Some(ray), in_water].into_iter().flatten() {
                        if drops.intersect(&ray).is_some() && wants(ray.direction) {
                            let of_ray = Extremes::of(ray.direction, sun_direction);
                            extremes = Some(extremes.map_or(of_ray, |all| all.union(of_ray)));
                        }
                    }
                }
            }
            extremes
        })
        .map(|extremes| extremes.seen(sun_direction))
        .reduce_with(Seen::union)
}

/// Refuse a table that lacks directions which the picture needs.
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
    Ok(())
}
