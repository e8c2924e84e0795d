//! The section `[air]` of a scene as a table.

use niji_atmosphere::ScatteringOrders;
use niji_atmosphere::Suns;
use niji_atmosphere::diffuse_light_while;
use niji_exchange::AtmosphereTable;
use niji_radiometry::Reflectance;
use niji_radiometry::WavelengthGrid;
use niji_scene::Air;
use niji_scene::Scene;
use niji_scene::Stage;
use niji_scene::Sun;
use niji_scene::canonical_json;

use crate::error::Error;
use crate::watch::Watch;
use crate::watch::go_on;

/// Air over ground.
#[derive(Clone, Copy, Debug)]
pub struct AirRequest<'a> {
    /// What it is.
    pub air: &'a Air,
    /// For which wavelengths.
    pub wavelengths: WavelengthGrid,
    /// What the ground gives back.
    pub ground: Reflectance,
    /// What shines on it.
    pub sun: &'a Sun,
    /// How finely light that the air scatters more than once is solved; `None` for one order.
    pub orders: Option<ScatteringOrders>,
    /// For which suns that light is.
    pub suns: Suns,
}

impl<'a> AirRequest<'a> {
    /// That of a scene, with light of the orders that are asked for beyond the first; `None` in a vacuum.
    pub fn of(scene: &'a Scene, orders: Option<ScatteringOrders>) -> Option<Self> {
        let air = scene.air.as_ref()?;
        Some(Self {
            air,
            wavelengths: scene.spectrum,
            ground: scene.ground.albedo.reflectance(),
            sun: &scene.sun,
            orders,
            suns: Suns::All,
        })
    }

    /// Its table.
    ///
    /// # Errors
    /// Parameters out of their range; [`Error::Stopped`].
    pub fn table(&self, watch: Watch) -> Result<AtmosphereTable, Error> {
        let model = (self.air).model(self.wavelengths, self.ground, self.sun)?;
        let table = model.tabulate()?;
        let go_on = |part| go_on(watch, Stage::Atmosphere, part);
        let solve = |orders| diffuse_light_while(go_on, &table, orders, self.suns);
        let diffuse = self.orders.map(solve).transpose()?;
        Ok(AtmosphereTable { diffuse, ..table })
    }
}

/// The air of a scene, tabulated, with light of the orders that are asked for beyond the first; `None` in a
/// vacuum.
///
/// # Errors
/// Parameters out of their range, of a scene that was built in code; [`Error::Stopped`].
pub fn table(
    scene: &Scene,
    orders: Option<ScatteringOrders>,
    watch: Watch,
) -> Result<Option<AtmosphereTable>, Error> {
    let request = AirRequest::of(scene, orders);
    request.map(|request| request.table(watch)).transpose()
}

/// What the table of a scene's air depends on, as JSON.
pub fn settings(scene: &Scene, orders: Option<ScatteringOrders>) -> String {
    // A table that does not depend on the sun serves every sun.
    let depends_on = |air: &Air| air.depends_on(&scene.sun);
    let air = scene.air.as_ref();
    let sun = air.is_some_and(depends_on).then_some(scene.sun);
    let orders = orders.map(|orders| {
        let sizes = [orders.n_layers, orders.n_zeniths, orders.max_degree];
        (sizes, orders.tolerance)
    });
    canonical_json(&(&scene.air, scene.ground, scene.spectrum, sun, orders))
}
