//! The scene as a plan sees it: geometry, drops and light.

use std::collections::BTreeSet;

use glam::DVec3;
use niji_atmosphere::ScatteringOrders;
use niji_atmosphere::Suns;
use niji_atmosphere::with_diffuse_light_of;
use niji_exchange::AtmosphereTable;
use niji_geometry::Camera;
use niji_radiometry::Colorimetry;
use niji_radiometry::Nanometers;
use niji_radiometry::WavelengthGrid;
use niji_radiometry::solar_irradiance;
use niji_render::SkyModel;
use niji_scatter::Band;
use niji_scatter::dark_band_rad;

use crate::accuracy::Levels;
use crate::drops::DropSource;
use crate::effect::Effect;
use crate::effect_facts::Facts;
use crate::levels_for_tolerance::TableErrors;
use crate::scene::Scene;

use super::air_light::AirLight;
use super::air_light::AirRequest;
use super::bounds::BoundScene;
use super::bounds::Ground;
use super::bounds::LitBy;
use super::bounds::SKYLIT;
use super::bounds::Waves;
use super::bounds::Way;
use super::decide::weighs_further_orders;
use super::decided::View;
use super::depth::largest_sun_depth;
use super::drop_summary::DropSummary;
use super::error::PlanError;
use super::flat_drops::FlatDrops;
use super::light_curves::CurvesRequest;
use super::light_curves::LightCurves;
use super::luminance::Line;
use super::theory_by_size;
use super::theory_by_size::table_theory;
use super::view;
use super::view::Block;

/// Most wavelengths that bounds are computed with.
const MAX_LINES: usize = 11;

/// Effective radii between the smallest and the largest that bounds are computed with.
const N_RADII: usize = 4;

/// A scene, measured.
pub(super) struct Situation {
    pub(super) camera: Camera,
    pub(super) sun: DVec3,
    pub(super) grid: WavelengthGrid,
    pub(super) drops: DropSummary,
    pub(super) levels: Levels,
    pub(super) view: View,
    /// Smallest and largest rise of rays that may meet drops; `None` where there are none.
    pub(super) rise: Option<(f64, f64)>,
    pub(super) display_white_cd_m2: f64,
    /// Scattering angle of the rainbow rays of order 2 and 3, rad.
    pub(super) bows_rad: (f64, f64),
    /// The sun in the water, where there is water and a sun above it.
    pub(super) mirrored: Option<MirroredSun>,
    /// Largest albedo of a surface; 0 where none is lit.
    lit_albedo: f64,
    ground: Ground,
    /// Whether rays of the camera may meet water.
    sees_water: bool,
    /// The spectrum of bounds.
    pub(super) bins: WavelengthGrid,
    lines: Vec<Line>,
    blocks: Vec<Block>,
    /// Rows and columns of those of the picture.
    n_blocks: (usize, usize),
}

/// The sun that water mirrors, as a plan sees it.
pub(super) struct MirroredSun {
    blocks: Vec<Block>,
    /// Scattering angles in view of the drops, with those that waves bring into view, rad.
    pub(super) theta_rad: Option<(f64, f64)>,
    sun_depth: f64,
    /// Largest share of the sun's light that it has.
    pub(super) share: f64,
    /// How far waves spread it, rad.
    reach_rad: f64,
    waves: Option<Waves>,
}

/// Where the light of one sun is seen.
struct SeenFrom {
    /// Scattering angles, rad.
    theta_rad: Option<(f64, f64)>,
    rise: Option<(f64, f64)>,
    flat: FlatDrops,
}

impl Situation {
    pub(super) fn new(scene: &Scene, drops: Option<DropSummary>) -> Result<Self, PlanError> {
        let drops = summary(scene, drops)?;
        let camera = scene.camera.camera()?;
        let grid = scene.spectrum;
        let sun = scene.sun.direction();
        let extent = view::Extent {
            whole: drops.bounds(),
            extinction_m1: drops.max_extinction_m1_q1,
            parts: &drops.parts,
        };
        let seen_water = scene.seen_water();
        let all_blocks = |region, sun| {
            let mut blocks = view::blocks(&camera, region, sun, &extent);
            let n_straight = blocks.len();
            if let Some(water) = &seen_water {
                blocks.extend(view::blocks_in_water(
                    &camera,
                    region,
                    sun,
                    (&extent, water),
                ));
            }
            (blocks, n_straight)
        };
        let region = scene.camera.region()?;
        let n_blocks = view::n_blocks(&camera, region);
        let (blocks, n_straight) = all_blocks(region, sun);
        let sees_water = blocks.len() > n_straight;
        let sun_depth = sun_depth(&drops, sun);
        // By moonlight everything is as much weaker, but the white of the picture stays the sun's.
        let line_albedo = white_albedo(scene) / scene.sun.irradiance_scale();
        let bins = grid.in_wider_bins(MAX_LINES);
        let view = seen(&blocks, sun_depth);
        let mirrored = scene.water_surface.as_ref().and_then(|water| {
            let surface = water.surface();
            let share = surface.largest_share(sun, &grid)?;
            let towards = DVec3::new(sun.x, -sun.y, sun.z);
            let (blocks, _) = all_blocks(region, towards);
            let reach_rad = surface.streak_reach().0;
            let seen = seen(&blocks, 0.0).theta_deg;
            Some(MirroredSun {
                theta_rad: seen.map(|(low, high)| {
                    let (low_rad, high_rad) = (low.to_radians(), high.to_radians());
                    (
                        (low_rad - reach_rad).max(0.0),
                        (high_rad + reach_rad).min(std::f64::consts::PI),
                    )
                }),
                // Down to the water and up to the sun.
                sun_depth: sun_depth + self::sun_depth(&drops, towards),
                blocks,
                share,
                reach_rad,
                waves: (surface.slope > 0.0).then_some(Waves {
                    slope: surface.slope,
                    sine: sun.y,
                }),
            })
        });
        Ok(Self {
            levels: levels(scene, (&drops, &view), None),
            view,
            rise: rise_seen(&blocks),
            camera,
            sun,
            drops,
            display_white_cd_m2: display_white_cd_m2(scene),
            bows_rad: dark_band_rad(scene.water()).into(),
            mirrored,
            sees_water,
            lit_albedo: scene.albedos().fold(0.0, f64::max),
            ground: ground(scene, sun, sun_depth),
            lines: lines(&bins, line_albedo),
            bins,
            grid,
            blocks,
            n_blocks,
        })
    }

    /// Sees the angles of another frame too; levels do not know of it yet.
    pub(super) fn see(&mut self, other: &Self) {
        let is_in = |of: Option<(f64, f64)>, other| of.into_iter().chain(other).reduce(wider);
        self.view.theta_deg = is_in(self.view.theta_deg, other.view.theta_deg);
        self.rise = is_in(self.rise, other.rise);
        if let (Some(sun), Some(other)) = (&mut self.mirrored, &other.mirrored) {
            sun.theta_rad = is_in(sun.theta_rad, other.theta_rad);
        }
    }

    /// The levels that its scene has by what is seen now, where errors of the table are parts of so much light.
    pub(super) fn levels_by(&self, scene: &Scene, bright_drops: Option<f64>) -> Levels {
        levels(scene, (&self.drops, &self.view), bright_drops)
    }

    /// The air at the wavelengths of bounds; `None` is a vacuum.
    pub(super) fn air_table(&self, scene: &Scene) -> Result<Option<AtmosphereTable>, PlanError> {
        let Some(air) = &scene.air else {
            return Ok(None);
        };
        let model = air.model(self.bins, scene.ground.albedo.reflectance(), &scene.sun)?;
        let table = model.tabulate()?;
        // The plan has no time for more than a glance; bounds are widened for it.
        Ok(Some(match scene.sky_level_where_seen() {
            Some(_) => {
                let suns = Suns::seen_from(self.camera.position(), self.sun);
                with_diffuse_light_of(table, ScatteringOrders::DRAFT, suns)
            }
            None => table,
        }))
    }

    pub(super) fn air_light(&self, table: Option<&AtmosphereTable>) -> Option<AirLight> {
        let observer = Colorimetry::new(&self.bins);
        let weights = observer.weights().iter();
        let luminance: Vec<f64> = weights
            .map(|[_, y, _]| y / self.display_white_cd_m2)
            .collect();
        let air = |table| {
            AirLight::new(&AirRequest {
                table,
                lines: &self.lines,
                luminance: &luminance,
                eye: self.camera.position(),
                sun: self.sun,
                drops: &self.drops.bounds(),
                blocks: &self.blocks,
            })
        };
        table.map(air)
    }

    /// How flat drops move bows.
    pub(super) fn flat_drops(&self, scene: &Scene) -> FlatDrops {
        FlatDrops::new(self.sun.y, scene.drop_motion, scene.water())
    }

    pub(super) fn curves(&self, scene: &Scene) -> LightCurves<'_> {
        let theta_deg = self.view.theta_deg;
        let seen = SeenFrom {
            theta_rad: theta_deg.map(|(a, b)| (a.to_radians(), b.to_radians())),
            rise: self.rise,
            flat: self.flat_drops(scene),
        };
        self.curves_at(scene, &seen)
    }

    /// The same for the sun in the water.
    pub(super) fn mirrored_curves(&self, scene: &Scene) -> Option<LightCurves<'_>> {
        let mirrored = self.mirrored.as_ref()?;
        let seen = SeenFrom {
            theta_rad: mirrored.theta_rad,
            rise: rise_seen(&mirrored.blocks),
            flat: FlatDrops::new(-self.sun.y, scene.drop_motion, scene.water()),
        };
        Some(self.curves_at(scene, &seen))
    }

    fn curves_at(&self, scene: &Scene, seen: &SeenFrom) -> LightCurves<'_> {
        LightCurves::new(CurvesRequest {
            flat: seen.flat,
            rise: seen.rise.unwrap_or_default(),
            theory: self.levels.theory,
            lines: &self.lines,
            sizes: self.sizes(),
            smallest_um: (self.drops.laws).smallest_radius_um(self.levels.table_relative_error),
            theta_rad: seen.theta_rad,
            split_rad: 0.5 * (self.bows_rad.0 + self.bows_rad.1),
            water: scene.water(),
        })
    }

    pub(super) fn bound_scene<'a>(
        &'a self,
        (light, mirrored): (&'a LightCurves<'a>, Option<&'a LightCurves<'a>>),
        air: Option<&'a AirLight>,
    ) -> BoundScene<'a> {
        BoundScene {
            sun: LitBy {
                way: Way::Straight,
                blocks: &self.blocks,
                light,
                sun_depth: self.view.max_sun_optical_depth,
                share: 1.0,
                reach_rad: 0.0,
                waves: None,
            },
            mirrored: self
                .mirrored
                .as_ref()
                .zip(mirrored)
                .map(|(sun, light)| LitBy {
                    way: Way::ByWater,
                    blocks: &sun.blocks,
                    light,
                    sun_depth: sun.sun_depth,
                    share: sun.share,
                    reach_rad: sun.reach_rad,
                    waves: sun.waves,
                }),
            n_blocks: self.n_blocks,
            lines: &self.lines,
            sees_water: self.sees_water,
            lit_albedo: self.lit_albedo,
            ground: self.ground,
            reaches_ground: self.drops.min_m.y < 0.0,
            air,
            efficiency: self.levels.drop_extinction.efficiency(),
            table_error: self.levels.table_relative_error,
            farthest_m: self.view.distance_m.map_or(0.0, |(_, far_m)| far_m),
        }
    }

    /// Sizes between the smallest and the largest, narrow and broad.
    fn sizes(&self) -> Vec<(f64, f64)> {
        let ((low_um, high_um), (low, high)) = (
            self.drops.effective_radius_um,
            self.drops.effective_variance,
        );
        let n = if high_um > low_um { N_RADII } else { 1 };
        let step = (high_um / low_um).ln() / (n as f64 - 1.0).max(1.0);
        let radii = (0..n).map(|i| low_um * (step * i as f64).exp());
        let variances: &[f64] = if high > low { &[low, high] } else { &[low] };
        radii
            .flat_map(|radius| variances.iter().map(move |variance| (radius, *variance)))
            .collect()
    }

    pub(super) fn facts(
        &self,
        scene: &Scene,
        (air, on): (Option<&AirLight>, &BTreeSet<Effect>),
    ) -> Facts {
        let lost = air.map(AirLight::sunlight_lost).unwrap_or_default();
        Facts {
            is_for_photograph: scene.photo.is_some(),
            weighs_further_orders: weighs_further_orders(&scene.effects, &scene.accuracy),
            has_air: scene.air.is_some(),
            has_surfaces: scene.has_surfaces(),
            n_lit: scene.albedos().count(),
            is_ground_shaded: self.ground.is_shaded(&self.blocks, on),
            sun_elevation_deg: scene.sun.elevation_deg,
            theta_deg: self.view.theta_deg,
            distance_m: self.view.distance_m,
            depth: self.view.max_optical_depth,
            sun_depth: self.view.max_sun_optical_depth,
            sunlight_lost: lost.into_iter().fold(0.0, f64::max),
            effective_variance: self.drops.effective_variance.1,
            largest_radius_um: self.drops.effective_radius_um.1,
            smallest_radius_um: self.drops.effective_radius_um.0,
            theory: table_theory(self.levels.theory, on),
            sees_water: self.sees_water,
            mirrored_share: (scene.water_surface)
                .map(|_| self.mirrored.as_ref().map_or(0.0, |sun| sun.share)),
        }
    }
}

/// The levels of a scene whose drops are seen so, where errors of the table are parts of so much light.
fn levels(
    scene: &Scene,
    (drops, view): (&DropSummary, &View),
    bright_drops: Option<f64>,
) -> Levels {
    let mut levels = scene.levels(drops.voxel_m);
    let seen = bright_drops.and_then(|bright| scene.table_errors(bright));
    let own = levels.table_relative_error;
    let errors = seen.unwrap_or(TableErrors {
        table: own,
        theory: own,
    });
    levels.table_relative_error = errors.table;
    if scene.accuracy.sun_path.is_none() {
        // Fine drops in a corner of a large volume ask for more than there is room for.
        levels.sun_path = levels.sun_path.fitting(drops.bounds());
    }
    let drops_in_light = (drops, view, scene.spectrum);
    let levels = theory_by_size::in_scene(levels, drops_in_light, errors.theory);
    if scene.accuracy.table_relative_error.is_some() {
        levels
    } else {
        theory_by_size::exact_where_quicker(levels, (drops, scene.spectrum))
    }
}

/// White at exposure 0 is a white plane in the sun; every stop makes half of its light white.
fn white_albedo(scene: &Scene) -> f64 {
    (-scene.picture.exposure_ev).exp2()
}

/// What a preview of a scene shows as white (cd/m²).
pub(super) fn display_white_cd_m2(scene: &Scene) -> f64 {
    let sun_luminance: f64 = luminance_of_sun(&scene.spectrum).iter().sum();
    white_albedo(scene) * sun_luminance / std::f64::consts::PI
}

/// The ground of a scene, which its air shows.
fn ground(scene: &Scene, sun: DVec3, sun_depth: f64) -> Ground {
    let is_shown = scene.air.is_some() && scene.accuracy.sky != Some(SkyModel::None);
    let light = scene.ground.albedo.largest() * (sun.y.max(0.0) + SKYLIT);
    let mut occluders = scene.occluders.iter();
    Ground {
        light: if is_shown { light } else { 0.0 },
        sine: sun.y,
        sun_depth,
        has_surfaces: scene.terrain.is_some() || occluders.any(|it| !it.meshes.is_empty()),
    }
}

fn wider(a: (f64, f64), b: (f64, f64)) -> (f64, f64) {
    (a.0.min(b.0), a.1.max(b.1))
}

fn summary(scene: &Scene, known: Option<DropSummary>) -> Result<DropSummary, PlanError> {
    let of_shapes = || DropSummary::of_shapes(&scene.drops);
    let summary = known.or_else(of_shapes);
    let file = |source: &DropSource| match source {
        DropSource::Shape(shape) => format!("of the shape {}", shape.name()),
        DropSource::FromVdb(density) => density.file.clone(),
        DropSource::File(drops) => drops.file.clone(),
    };
    if summary.is_none() {
        let shapes = scene.drops.populations().iter();
        for shape in shapes.filter_map(|population| population.source.shape()) {
            // Laid out in vain: it says why.
            shape.volume()?;
        }
    }
    summary.ok_or_else(|| {
        let populations = scene.drops.populations().iter();
        let files: Vec<String> = populations.map(|it| file(&it.source)).collect();
        let file = files.join(" and ");
        PlanError::NoDrops { file }
    })
}

/// What each bin has of the sun's illuminance (lx).
fn luminance_of_sun(grid: &WavelengthGrid) -> Vec<f64> {
    let irradiance = solar_irradiance(grid).into_iter();
    let observer = Colorimetry::new(grid);
    let weights = observer.weights().iter();
    weights
        .zip(irradiance)
        .map(|([_, y, _], e)| y * e)
        .collect()
}

/// The bins of bounds with their weights.
fn lines(bins: &WavelengthGrid, white_albedo: f64) -> Vec<Line> {
    let luminance = luminance_of_sun(bins);
    let total: f64 = luminance.iter().sum();
    let scale = std::f64::consts::PI / white_albedo / total.max(f64::MIN_POSITIVE);
    let line = |(index, luminance): (usize, f64)| Line {
        index,
        band: Band {
            center: bins.center(index),
            width: Nanometers(bins.step_nm()),
        },
        weight: luminance * scale,
    };
    luminance.into_iter().enumerate().map(line).collect()
}

/// Smallest and largest rise of the blocks that may meet drops.
fn rise_seen(blocks: &[Block]) -> Option<(f64, f64)> {
    let with_drops = blocks.iter().filter(|block| block.drops.is_some());
    with_drops.map(|block| block.rise).reduce(wider)
}

/// Largest optical depth of the drops towards the sun, Q = 1.
fn sun_depth(drops: &DropSummary, sun: DVec3) -> f64 {
    let longest_m = view::longest_chord_m(&drops.bounds(), sun);
    let of_parts = largest_sun_depth(&drops.parts, &drops.bounds(), sun);
    of_parts.min(drops.max_extinction_m1_q1 * longest_m)
}

fn seen(blocks: &[Block], sun_depth: f64) -> View {
    let (mut theta_deg, mut distance_m) = (None, None);
    let mut depth = 0.0_f64;
    let widen = |range: &mut Option<(f64, f64)>, to: (f64, f64)| {
        *range = Some(range.map_or(to, |range| wider(range, to)));
    };
    for block in blocks {
        let Some(chord) = block.drops else { continue };
        let (low, high) = block.theta_rad;
        widen(&mut theta_deg, (low.to_degrees(), high.to_degrees()));
        widen(&mut distance_m, (chord.enter_m, chord.leave_m));
        depth = depth.max(block.depth);
    }
    View {
        theta_deg,
        distance_m,
        max_optical_depth: depth,
        max_sun_optical_depth: sun_depth,
    }
}
