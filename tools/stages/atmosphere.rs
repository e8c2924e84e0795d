//! The stage `atmosphere`: the section `[air]` of a scene becomes a table.

use std::path::Path;

use niji_atmosphere::ScatteringOrders;
use niji_atmosphere::with_diffuse_light;
use niji_exchange::AtmosphereTable;
use niji_exchange::TableFile;
use niji_radiometry::WavelengthGrid;
use niji_scene::Air;
use niji_scene::Scene;
use niji_scene::Sun;
use niji_scene::canonical_json;

use crate::failure::Failure;
use crate::output;
use crate::stages::Done;
use crate::stages::Manner;
use crate::stages::Request;
use crate::stages::perform;

/// Name of the file in the folder of a run.
pub(crate) const FILE: &str = "atmosphere.exr";

/// How finely light that the air scatters more than once is solved; `None` for one order.
pub(crate) type Orders = Option<ScatteringOrders>;

/// The air of a scene, tabulated; `None` in a vacuum.
///
/// # Errors
/// Parameters out of their range.
pub(crate) fn table(scene: &Scene, orders: Orders) -> Result<Option<AtmosphereTable>, Failure> {
    let wavelengths = scene.spectrum.grid();
    let wavelengths = wavelengths.map_err(|error| Failure::Usage(error.to_string()))?;
    let table = scene
        .air
        .as_ref()
        .map(|air| tabulated(air, wavelengths, scene.ground.albedo, &scene.sun, orders));
    table.transpose()
}

/// Air over a ground of an albedo, with light of the orders that are asked for beyond the first.
///
/// # Errors
/// Parameters out of their range.
pub(crate) fn tabulated(
    air: &Air,
    wavelengths: WavelengthGrid,
    ground_albedo: f64,
    sun: &Sun,
    orders: Orders,
) -> Result<AtmosphereTable, Failure> {
    let usage = |error: niji_atmosphere::Error| Failure::Usage(error.to_string());
    let model = air.model(wavelengths, ground_albedo, sun).map_err(usage)?;
    let table = model.tabulate().map_err(usage)?;
    Ok(match orders {
        Some(orders) => with_diffuse_light(table, orders),
        None => table,
    })
}

/// Writes the table of a scene's air.
///
/// # Errors
/// A scene in a vacuum, an output that exists, or a file that cannot be written.
pub(crate) fn make(
    (scene, orders): (&Scene, Orders),
    to: &Path,
    manner: Manner,
) -> Result<Done, Failure> {
    let request = Request {
        stage: "atmosphere",
        settings: settings(scene, orders),
        inputs: Vec::new(),
        outputs: vec![to],
    };
    perform(&request, manner, |provenance| {
        let vacuum =
            || Failure::Usage("the scene has no section [air]: it lies in a vacuum".to_owned());
        let file = table(scene, orders)?
            .ok_or_else(vacuum)?
            .to_file(provenance);
        output::write_file(to, |writer| file.write(writer))
    })
}

/// What the table of a scene's air depends on.
pub(crate) fn settings(scene: &Scene, orders: Orders) -> String {
    // A table that does not depend on the sun serves every sun.
    let depends_on = |air: &Air| air.depends_on(&scene.sun);
    let sun = scene
        .air
        .as_ref()
        .is_some_and(depends_on)
        .then_some(scene.sun);
    let orders = orders.map(|orders| {
        let sizes = [orders.n_layers, orders.n_zeniths, orders.max_degree];
        (sizes, orders.tolerance)
    });
    canonical_json(&(&scene.air, scene.ground, scene.spectrum, sun, orders))
}

/// Reads a table of the air.
///
/// # Errors
/// A missing or damaged file, or one that holds something else.
pub(crate) fn read(path: &Path) -> Result<AtmosphereTable, Failure> {
    let file = TableFile::read(path).map_err(|error| Failure::bad_input(path, error))?;
    AtmosphereTable::from_file(&file).map_err(|error| Failure::bad_input(path, error))
}
