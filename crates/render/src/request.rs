//! What a picture is made of, and whether it can be.

use glam::DVec3;
use niji_exchange::AirConstituent;
use niji_exchange::AtmosphereTable;
use niji_exchange::DensityLaw;
use niji_exchange::ScatteringTable;
use niji_geometry::Aabb;
use niji_geometry::Camera;
use niji_geometry::PixelRegion;
use niji_radiometry::Bytes;
use niji_radiometry::WavelengthGrid;
use niji_radiometry::memory_limit;

use crate::air::MAX_CONSTITUENTS;
use crate::effects::RenderEffects;
use crate::error::Error;
use crate::error::Input;
use crate::error::Wavelengths;
use crate::footprint_error::PixelLight;
use crate::levels::AirPath;
use crate::levels::DropOrders;
use crate::levels::Integration;
use crate::levels::PixelFootprint;
use crate::levels::RenderLevels;
use crate::levels::SkyModel;
use crate::lit_drops::LitDrops;
use crate::picture_layers::PictureLayer;
use crate::picture_layers::Rendered;
use crate::sun_direction::UNIT_TOLERANCE;
use crate::sun_direction::check_sun_direction;
use crate::surfaces::Eye;
use crate::surfaces::Surfaces;
use crate::water_surface::WaterSurface;

/// How far drops may be outside the table's sizes: the rounding of files in f32.
const SIZE_TOLERANCE: f64 = 1e-5;

/// Steps in which a picture is made to be written, at least: threads wait for each other at the end of each.
pub const LEAST_STEPS: u32 = 10;

/// Most steps of a literal march, or of a path through air.
const MAX_STEPS: f64 = 1e6;

/// Everything that a picture is made of.
#[derive(Clone, Copy)]
pub struct RenderRequest<'a> {
    /// The camera.
    pub camera: &'a Camera,
    /// The pixels to render, of the camera's frame or beyond it. The value of a pixel does not depend
    /// on the region that it is rendered in.
    pub region: PixelRegion,
    /// Unit vector towards the sun.
    pub sun_direction: DVec3,
    /// Wavelength bins of the picture and of every table.
    pub wavelengths: WavelengthGrid,
    /// Irradiance of the sun by wavelength above the air, mean over each bin [W m^-2 nm^-1].
    pub sun_irradiance: &'a [f64],
    /// The drops, lit by this sun.
    pub drops: &'a LitDrops,
    /// How drops scatter; needed where light of drops is on and there are drops.
    pub table: Option<&'a ScatteringTable>,
    /// The air; needed where an effect of the air is on.
    pub air: Option<&'a AtmosphereTable>,
    /// Surfaces that hide what is behind them; `None` where nothing stands in the way.
    pub surfaces: Option<&'a Surfaces>,
    /// Water that is seen: it mirrors the light of drops, air, surfaces and sun. `None` where there is none, or nobody
    /// looks at it; it is seen from above only.
    pub water: Option<WaterSurface>,
    /// What takes part.
    pub effects: RenderEffects,
    /// How accurately.
    pub levels: RenderLevels,
    /// Largest estimated error of a pixel's luminance [cd/m²]: pixels above it get more rays, up to
    /// 256, and a finer quadrature. `None` leaves all pixels at their level.
    pub tolerance_cd_m2: Option<f64>,
    /// What the light of further orders may err by, noise and what lies between directions, RMS over these [cd/m²]: paths
    /// are followed in rounds until it is no more, or sixteen times those of the level. `None` follows those of the level.
    pub orders_error_cd_m2: Option<f64>,
    /// How many times larger the error of a pixel may be before it gets more rays: 1, or what a
    /// [`Deadline`](crate::Deadline) left.
    pub coarser_rays: f64,
}

impl<'a> RenderRequest<'a> {
    /// Whether any drop can send sunlight into the picture.
    pub(crate) fn wants_bow(&self) -> bool {
        let (below, above) = self.wanted_sides();
        (below || above) && self.drops.bounds().is_some()
    }

    /// Which sides of the table's split are wanted: smaller angles, larger angles.
    pub(crate) fn wanted_sides(&self) -> (bool, bool) {
        let effects = &self.effects;
        let both = effects.higher_orders.is_on();
        (
            both || effects.secondary_bow.is_on(),
            both || effects.primary_bow.is_on(),
        )
    }

    /// Directions across and paths for each, where light of orders beyond the first is wanted and
    /// there are drops.
    pub(crate) fn wanted_orders(&self) -> Option<(usize, usize)> {
        match self.levels.drop_orders {
            DropOrders::SingleScattering => None,
            DropOrders::MultipleScattering {
                nodes_across,
                paths_per_node,
            } => self.drops.bounds().map(|_| (nodes_across, paths_per_node)),
        }
    }

    /// Whether sky and ground stand behind the drops.
    pub(crate) fn wants_sky(&self) -> bool {
        self.effects.shows_sky(self.levels.sky_model)
    }

    /// The box outside of which no drops are seen: the ground hides those below it.
    pub(crate) fn drops_seen(&self) -> Option<Aabb> {
        let bounds = self.drops.bounds()?;
        let eye = self.camera.position();
        if !self.effects.ground_hides(self.levels.sky_model, eye) {
            return Some(bounds);
        }
        let min = bounds.min.with_y(bounds.min.y.max(0.0));
        (min.y < bounds.max.y).then_some(Aabb { min, ..bounds })
    }

    /// Whether the surroundings light the drops.
    pub(crate) fn wants_skylit_drops(&self) -> bool {
        let effects = self.effects;
        effects.skylit_drops.is_on() && effects.drop_extinction.is_on() && self.wants_sky()
    }

    /// What the eye sees.
    pub(crate) fn eye(&self) -> Eye<'a> {
        Eye {
            camera: self.camera,
            surfaces: self.surfaces,
            water: self.water,
        }
    }

    /// Whether anything may end a ray.
    pub(crate) fn has_ends(&self) -> bool {
        self.surfaces.is_some() || self.water.is_some()
    }

    /// Check everything but angles, which need the rays.
    pub(crate) fn check(&self) -> Result<(), Error> {
        self.region.checked().map_err(Error::Region)?;
        check_sun_direction(self.sun_direction)?;
        self.check_irradiance()?;
        self.check_levels()?;
        self.check_shadow()?;
        if let Some(surfaces) = self.surfaces {
            surfaces.check_shape(self.camera)?;
        }
        self.water.map_or(Ok(()), |water| water.check())?;
        self.check_orders()?;
        if self.wants_bow() {
            let effect = "a bow";
            let input = Input::ScatteringTable;
            self.check_table(self.table.ok_or(Error::MissingInput { effect, input })?)?;
        }
        let effects = &self.effects;
        for (on, effect) in [
            (effects.sunlight_through_air.is_on(), "sunlight through air"),
            (effects.air_extinction.is_on(), "air extinction"),
            (effects.air_inscatter.is_on(), "air in-scatter"),
            (self.wants_sky(), "the sky"),
        ] {
            if on {
                let input = Input::AtmosphereTable;
                self.check_air(self.air.ok_or(Error::MissingInput { effect, input })?)?;
            }
        }
        if effects.air_inscatter.is_on() || self.wants_sky() {
            self.check_diffuse_light()?;
        }
        // In a vacuum surfaces have the sun.
        match self.air.filter(|_| effects.lit_surfaces.is_on()) {
            Some(air) => {
                self.check_air(air)?;
                self.check_diffuse_light()
            }
            None => Ok(()),
        }
    }

    /// Ask for the memory of rows of the picture before a ray is followed: a refusal later would end the program.
    pub(crate) fn check_memory(&self, n_rows: u32) -> Result<(), Error> {
        let n_pixels = u64::from(self.region.width_px) * u64::from(n_rows);
        let bytes = n_pixels.saturating_mul(self.bytes_per_pixel());
        ask_for_memory((self.region.width_px, n_rows), bytes)
    }

    /// The picture without rows.
    #[must_use]
    pub fn no_rows(&self) -> Rendered {
        let size = [self.wavelengths.len(), 0, self.region.width_px as usize];
        Rendered::dark(size, self.layers())
    }

    /// What the picture holds beside its spectra; of an effect that is off nothing.
    pub(crate) fn layers(&self) -> impl Iterator<Item = PictureLayer> {
        PictureLayer::all().filter(|layer| match layer {
            PictureLayer::BowMultiple => self.wanted_orders().is_some(),
            PictureLayer::Skylit => self.wants_skylit_drops(),
            PictureLayer::BowReflected => self.drops.mirrored().is_some(),
            PictureLayer::Sky => self.wants_sky(),
            PictureLayer::LitSurface => self.has_lit_surfaces(),
            PictureLayer::Surface => self.has_ends(),
            PictureLayer::Water => self.water.is_some(),
            _ => true,
        })
    }

    /// Whether a surface sends light, not the ground alone.
    fn has_lit_surfaces(&self) -> bool {
        let mut colors = self.surfaces.into_iter().flat_map(Surfaces::albedos);
        self.effects.lit_surfaces.is_on() && colors.any(|it| it.is_some())
    }

    /// What all arrays of the picture, and the light of neighbors that its error is estimated from, take.
    pub fn bytes_per_pixel(&self) -> u64 {
        let n_channels: usize = self.layers().map(|layer| layer.channels().len()).sum();
        let n_planes = self.wavelengths.len() + n_channels;
        (n_planes * size_of::<f32>() + size_of::<PixelLight>()) as u64
    }

    /// Orders beyond the first need a table, and the extinction and shadow that feed them.
    fn check_orders(&self) -> Result<(), Error> {
        let Some((nodes_across, paths_per_node)) = self.wanted_orders() else {
            return Ok(());
        };
        for (level, found, most, expected) in [
            ("drop orders: nodes_across", nodes_across, 128, "2 to 128"),
            (
                "drop orders: paths_per_node",
                paths_per_node,
                1 << 20,
                "2 to 2^20",
            ),
        ] {
            if !(2..=most).contains(&found) {
                let found = found as f64;
                return Err(Error::Level {
                    level,
                    found,
                    expected,
                });
            }
        }
        for (on, without) in [
            (self.effects.drop_extinction.is_on(), "drop extinction"),
            (self.effects.drop_shadow.is_on(), "drop shadow"),
        ] {
            if !on {
                return Err(Error::OrdersWithout { without });
            }
        }
        let (effect, input) = ("multiple scattering", Input::ScatteringTable);
        let table = self.table.ok_or(Error::MissingInput { effect, input })?;
        self.check_table(table.phase_functions.as_deref().unwrap_or(table))
    }

    /// The light of higher orders is part of the air's table, if the level wants it.
    fn check_diffuse_light(&self) -> Result<(), Error> {
        match self.levels.sky_model {
            SkyModel::None | SkyModel::SingleScattering => return Ok(()),
            SkyModel::MultipleScattering => (),
        }
        let (Some(air), input) = (self.air, Input::AtmosphereTable) else {
            return Ok(());
        };
        let Some(light) = &air.diffuse else {
            let (effect, input) = ("multiple scattering by the air", Input::DiffuseLight);
            return Err(Error::MissingInput { effect, input });
        };
        if light.is_sound(air.constituents.len(), self.wavelengths.len()) {
            return Ok(());
        }
        let reason = "its diffuse light does not fit its axes";
        Err(Error::BadTable { input, reason })
    }

    fn check_irradiance(&self) -> Result<(), Error> {
        let (found, expected) = (self.sun_irradiance.len(), self.wavelengths.len());
        let sound = self
            .sun_irradiance
            .iter()
            .all(|value| value.is_finite() && *value >= 0.0);
        if sound && found == expected {
            Ok(())
        } else {
            Err(Error::SunIrradiance { found, expected })
        }
    }

    fn check_shadow(&self) -> Result<(), Error> {
        let mirrored = self.drops.mirrored();
        let sun = mirrored.map(|drops| drops.mirror.sun_direction);
        if sun.is_some_and(|sun| sun.distance(self.sun_direction) > UNIT_TOLERANCE) {
            let expected = self.sun_direction.to_array();
            return Err(Error::ShadowOfAnotherSun { expected });
        }
        if !self.effects.drop_shadow.is_on() || self.drops.bounds().is_none() {
            return Ok(());
        }
        if !self.drops.has_shadow() {
            return Err(Error::NoShadow);
        }
        if self.drops.contradicts(self.sun_direction) {
            let expected = self.sun_direction.to_array();
            return Err(Error::ShadowOfAnotherSun { expected });
        }
        Ok(())
    }

    fn check_levels(&self) -> Result<(), Error> {
        let check = |sound: bool, level, found, expected| {
            if sound {
                Ok(())
            } else {
                Err(Error::Level {
                    level,
                    found,
                    expected,
                })
            }
        };
        if let Some(tolerance) = self.tolerance_cd_m2 {
            let sound = tolerance.is_finite() && tolerance > 0.0;
            check(sound, "tolerance", tolerance, "above 0 cd/m²")?;
        }
        let coarser = self.coarser_rays;
        let sound = coarser.is_finite() && coarser > 0.0;
        check(sound, "coarser_rays", coarser, "a factor above 0")?;
        match self.levels.integration {
            Integration::FixedStep { step_m } => {
                let longest_m = self
                    .drops
                    .bounds()
                    .map_or(0.0, |bounds| (bounds.max - bounds.min).length());
                let sound = step_m.is_finite() && step_m > 0.0 && longest_m / step_m <= MAX_STEPS;
                let expected = "a length above 0 m of which the drops take at most a million";
                check(sound, "integration: step_m", step_m, expected)?;
            }
            Integration::CellExact => (),
            Integration::Adaptive { relative_error } => {
                let sound = (1e-12..=1.0).contains(&relative_error);
                check(
                    sound,
                    "integration: relative_error",
                    relative_error,
                    "1e-12 to 1",
                )?;
            }
        }
        match self.levels.air_path {
            AirPath::Midpoint { n_steps } => {
                let sound = (1..=MAX_STEPS as usize).contains(&n_steps);
                check(sound, "air path: n_steps", n_steps as f64, "1 to 1000000")?;
            }
            AirPath::Quadrature { n_nodes } => {
                let sound = (1..=256).contains(&n_nodes);
                check(sound, "air path: n_nodes", n_nodes as f64, "1 to 256")?;
            }
            AirPath::Constant | AirPath::Table => (),
        }
        match self.levels.pixel_footprint {
            PixelFootprint::Grid { n } => {
                let sound = (1..=64).contains(&n);
                check(sound, "pixel footprint: n", f64::from(n), "1 to 64")
            }
            PixelFootprint::Center | PixelFootprint::Prefiltered => Ok(()),
        }
    }

    fn check_wavelengths(&self, input: Input, found: WavelengthGrid) -> Result<(), Error> {
        if found == self.wavelengths {
            return Ok(());
        }
        let (found, expected) = (Wavelengths(found), Wavelengths(self.wavelengths));
        Err(Error::Wavelengths {
            input,
            found,
            expected,
        })
    }

    fn check_table(&self, table: &ScatteringTable) -> Result<(), Error> {
        let input = Input::ScatteringTable;
        self.check_wavelengths(input, table.wavelengths)?;
        let (radii, variances) = (&table.effective_radius_um, &table.effective_variance);
        let shape = (
            2,
            radii.len(),
            variances.len(),
            table.wavelengths.len(),
            table.theta_rad.len(),
        );
        let bad = |reason| Err(Error::BadTable { input, reason });
        if table.values.dim() != shape {
            return bad("its values do not fit its axes");
        }
        if ![&table.theta_rad, radii, variances]
            .into_iter()
            .all(|axis| is_axis(axis))
        {
            return bad("an axis is empty or does not ascend");
        }
        if radii[0] <= 0.0 || variances[0] < 0.0 {
            return bad("an effective radius or variance is negative");
        }
        if let Some(moved) = &table.moved {
            let n_wavelengths = table.wavelengths.len();
            let fits = moved.orders.iter().all(|order| {
                let shape = (2, moved.drops.len(), n_wavelengths, order.theta_rad.len());
                let have_ends = order.theta_rad.first() == table.theta_rad.first()
                    && order.theta_rad.last() == table.theta_rad.last();
                order.values.dim() == shape
                    && order.shifts.len() == n_wavelengths
                    && is_axis(&order.theta_rad)
                    && order.theta_rad.len() > 1
                    && have_ends
            });
            // Compared with the value that stands for single sizes.
            if !fits || moved.drops.len() > radii.len() || *variances != [0.0] {
                return bad("the orders that move do not fit its axes");
            }
        }
        let found_um = (radii[0], radii[radii.len() - 1]);
        match self
            .drops
            .size_range()
            .map(|drops| drops.effective_radius_um)
        {
            Some(expected_um)
                if expected_um.0 < found_um.0 * (1.0 - SIZE_TOLERANCE)
                    || expected_um.1 > found_um.1 * (1.0 + SIZE_TOLERANCE) =>
            {
                Err(Error::SizeRange {
                    found_um,
                    expected_um,
                })
            }
            Some(_) | None => Ok(()),
        }
    }

    fn check_air(&self, air: &AtmosphereTable) -> Result<(), Error> {
        let input = Input::AtmosphereTable;
        self.check_wavelengths(input, air.wavelengths)?;
        let bad = |reason| Err(Error::BadTable { input, reason });
        let n = self.wavelengths.len();
        if air.constituents.len() > MAX_CONSTITUENTS {
            return bad("it has more than 8 constituents");
        }
        if air.ground_albedo.len() != n {
            return bad("its ground albedo does not fit its wavelengths");
        }
        let fits = air.constituents.iter().all(|constituent| {
            constituent.extinction_m1.len() == n
                && constituent.scattering_m1.len() == n
                && constituent.phase_sr1.dim() == (n, constituent.phase_angle_rad.len())
                && is_axis(&constituent.phase_angle_rad)
                && has_profile(constituent)
        });
        if fits {
            Ok(())
        } else {
            bad("a constituent's values do not fit its axes")
        }
    }
}

/// Whether a density stands at every height, and a reach where its law needs them.
fn has_profile(air: &AirConstituent) -> bool {
    let has_reaches = || {
        is_axis(&air.reach_height_m)
            && is_axis(&air.reach_mu)
            && air.reach_m.dim() == (air.reach_height_m.len(), air.reach_mu.len())
    };
    is_axis(&air.height_m)
        && air.density.len() == air.height_m.len()
        && (air.law == DensityLaw::Linear || has_reaches())
}

fn is_axis(values: &[f64]) -> bool {
    !values.is_empty()
        && values.iter().all(|value| value.is_finite())
        && values.windows(2).all(|pair| pair[0] < pair[1])
}

/// Asks for the memory of a picture of this width and height, and gives it back.
///
/// # Errors
/// [`Error::Memory`] if it is more than may be taken, or cannot be had.
pub fn ask_for_memory(size_px: (u32, u32), bytes: u64) -> Result<(), Error> {
    let limit = memory_limit();
    let refused = Error::Memory {
        size_px,
        bytes,
        limit,
    };
    if Bytes(bytes.into()) > limit {
        return Err(refused);
    }
    let mut asked: Vec<u8> = Vec::new();
    let answer = asked.try_reserve_exact(usize::try_from(bytes).unwrap_or(usize::MAX));
    // Else a compiler may leave the question out.
    std::hint::black_box(&asked);
    answer.map_err(|_| refused)
}
