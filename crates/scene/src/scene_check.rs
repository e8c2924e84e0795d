//! What a scene of the right form must still obey: ranges, and parts that contradict each other.

use std::collections::BTreeMap;
use std::error::Error as _;

use niji_radiometry::OBSERVER_RANGE_NM;
use niji_render::AirPath;
use niji_render::DropOrders;
use niji_render::Integration;
use niji_render::PixelFootprint;
use niji_render::SunPath;
use niji_scatter::Theory;

use crate::accuracy::Accuracy;
use crate::camera_section;
use crate::camera_section::Projection;
use crate::check::Check;
use crate::check::TURNS_DEG;
use crate::document::section_of;
use crate::drops::DropSource;
use crate::drops::Population;
use crate::effect::Effect;
use crate::effect::Role;
use crate::effect_rows::Row;
use crate::effect_switches::Switch;
use crate::error::SceneError;
use crate::levels_for_tolerance::LEAST_TOLERANCE;
use crate::occluders::Along;
use crate::occluders::MAX_MESHES;
use crate::photo::PhotoExposure;
use crate::scene::FORMAT;
use crate::scene::Scene;
use crate::sections::Body;

/// Instants of a shutter: of fewer nothing tells what lies between them.
const INSTANTS: (u32, u32) = (3, 256);

/// Largest settings of the levels that count something.
const MAX_STEPS: usize = 1_000_000;
const MAX_NODES: usize = 256;
const MAX_DIRECTIONS: usize = 128;
const MAX_PATHS: usize = 1 << 20;
const MAX_RAYS_PER_SIDE: u32 = 64;
const MAX_DEBYE_ORDER: u32 = 7;

/// Most points of a bow that are picked.
const MAX_PICKS: usize = 1000;

/// Checks everything; `lines` says where the keys stand.
pub(crate) fn check(scene: &Scene, lines: &BTreeMap<String, usize>) -> Result<(), SceneError> {
    let check = Check { lines };
    values(scene, &check)?;
    effects(scene, &check)
}

/// Checks everything but whether switches of effects go together.
pub(crate) fn values(scene: &Scene, check: &Check<'_>) -> Result<(), SceneError> {
    if scene.format != FORMAT {
        let found = scene.format.to_string();
        return Err(check.out_of_range("format", found, &format!("{FORMAT}, the only format yet")));
    }
    check.number("sun.elevation_deg", scene.sun.elevation_deg, (-90.0, 90.0))?;
    check.number("sun.azimuth_deg", scene.sun.azimuth_deg, TURNS_DEG)?;
    moon(scene, check)?;
    camera_section::check(&scene.camera, check)?;
    spectrum(scene, check)?;
    drops(scene, check)?;
    let water = scene.water().check();
    water.map_err(|error| check.refused("water", &error))?;
    let surface = scene.water_surface;
    surface.map_or(Ok(()), |surface| surface.check(check))?;
    let motion = scene.drop_motion.validate();
    motion.map_err(|error| check.refused("drop_motion", &error))?;
    scene.ground.albedo.check("ground.albedo", check)?;
    check.number(
        "picture.exposure_ev",
        scene.picture.exposure_ev,
        (-40.0, 40.0),
    )?;
    accuracy(&scene.accuracy, check)?;
    air(scene, check)?;
    photo(scene, check)
}

fn moon(scene: &Scene, check: &Check<'_>) -> Result<(), SceneError> {
    let Some(phase_deg) = scene.sun.phase_angle_deg else {
        return Ok(());
    };
    let key = "sun.phase_angle_deg";
    match scene.sun.body {
        Body::Moon => check.number(key, phase_deg, (-150.0, 150.0)),
        Body::Sun => {
            let expected = "no phase without body = \"moon\"";
            Err(check.out_of_range(key, phase_deg.to_string(), expected))
        }
    }
}

/// Errors are parts of display white, which is dark where the eye sees nothing.
fn spectrum(scene: &Scene, check: &Check<'_>) -> Result<(), SceneError> {
    let grid = &scene.spectrum;
    let (first, last) = (grid.edges(0).0, grid.edges(grid.len() - 1).1);
    let (first_seen_nm, last_seen_nm) = OBSERVER_RANGE_NM;
    if first.0 < last_seen_nm && last.0 > first_seen_nm {
        return Ok(());
    }
    let expected = format!(
        "wavelengths of which the eye sees some, of {first_seen_nm} to {last_seen_nm} nm: errors are measured in \
         display white, which has none of these"
    );
    Err(check.out_of_range(
        "spectrum",
        format!("{} to {} nm", first.0, last.0),
        &expected,
    ))
}

/// Every population, and that their names differ.
fn drops(scene: &Scene, check: &Check<'_>) -> Result<(), SceneError> {
    let populations = scene.drops.populations();
    let names = scene.drops.mode_names();
    for (index, each) in populations.iter().enumerate() {
        let mut entry = format!("drops[{index}]");
        if populations.len() == 1 && !check.lines.contains_key(&entry) {
            entry.truncate("drops".len());
        }
        let wrong_name = |expected: &str| {
            let found = format!("{:?}", names[index]);
            Err(check.out_of_range(&format!("{entry}.name"), found, expected))
        };
        if let Some(expected) = each.name_fault() {
            return wrong_name(expected);
        }
        if names[..index].contains(&names[index]) {
            return wrong_name("another name than that of the drops before");
        }
        population(each, &entry, check)?;
    }
    Ok(())
}

/// A population at an entry, `drops` or `drops[1]`.
fn population(population: &Population, entry: &str, check: &Check<'_>) -> Result<(), SceneError> {
    let named = |file: &str| {
        let key = format!("{entry}.file");
        let missing = || check.out_of_range(&key, "empty".to_string(), "a path");
        (!file.trim().is_empty()).then_some(()).ok_or_else(missing)
    };
    let refused = |error| drops_error(&error, entry, check);
    match &population.source {
        DropSource::Shape(shape) => shape.validate().map_err(refused),
        DropSource::File(drops) => named(&drops.file),
        DropSource::FromVdb(density) => {
            named(&density.file)?;
            let import = density.validate();
            import.map_err(|error| refused(error.into()))
        }
    }
}

/// A shape's own error at the line of the key that it names.
fn drops_error(error: &niji_droplets::Error, entry: &str, check: &Check<'_>) -> SceneError {
    let named = match error {
        niji_droplets::Error::Parameter {
            parameter,
            found,
            expected,
        }
        | niji_droplets::Error::Size(niji_sizes::Error::Parameter {
            parameter,
            found,
            expected,
        })
        | niji_droplets::Error::Volume(niji_dropfield::Error::BadSetting {
            parameter,
            found,
            expected,
        }) => Some((*parameter, found.to_string(), *expected)),
        _ => None,
    };
    if let Some((parameter, found, expected)) = named {
        let (beginning, ending) = (format!("{entry}."), format!(".{parameter}"));
        let key = check
            .lines
            .keys()
            .find(|key| key.starts_with(&beginning) && key.ends_with(&ending));
        let key = key.cloned().unwrap_or_else(|| format!("{entry}{ending}"));
        return check.out_of_range(&key, found, expected);
    }
    let mut message = error.to_string();
    let mut source = error.source();
    while let Some(inner) = source {
        message = format!("{message}: {inner}");
        source = inner.source();
    }
    SceneError::Drops {
        line: check.line(entry),
        section: section_of(entry),
        message,
    }
}

fn accuracy(accuracy: &Accuracy, check: &Check<'_>) -> Result<(), SceneError> {
    if let Some(tolerance) = accuracy.tolerance {
        check.number("accuracy.tolerance", tolerance, (LEAST_TOLERANCE, 1.0))?;
    }
    if let Some(error) = accuracy.table_relative_error {
        check.number("accuracy.table_relative_error", error, (1e-6, 0.5))?;
    }
    if let Some(n_instants) = accuracy.shutter_instants {
        check.count("accuracy.shutter_instants", &n_instants, INSTANTS)?;
    }
    if let Some(Theory::Debye { max_order }) = accuracy.theory {
        check.count(
            "accuracy.theory.max_order",
            &max_order,
            (2, MAX_DEBYE_ORDER),
        )?;
    }
    match accuracy.integration {
        Some(Integration::FixedStep { step_m }) => {
            check.positive("accuracy.integration.step_m", step_m)?;
        }
        Some(Integration::Adaptive { relative_error }) => {
            check.number(
                "accuracy.integration.relative_error",
                relative_error,
                (1e-12, 1.0),
            )?;
        }
        Some(Integration::CellExact) | None => (),
    }
    match accuracy.sun_path {
        Some(SunPath::Volume { voxel_m }) => {
            check.positive("accuracy.sun_path.voxel_m", voxel_m)?;
        }
        Some(SunPath::March { step_m }) => check.positive("accuracy.sun_path.step_m", step_m)?,
        Some(SunPath::Ignore) | None => (),
    }
    match accuracy.air_path {
        Some(AirPath::Midpoint { n_steps }) => {
            check.count("accuracy.air_path.n_steps", &n_steps, (1, MAX_STEPS))?;
        }
        Some(AirPath::Quadrature { n_nodes }) => {
            check.count("accuracy.air_path.n_nodes", &n_nodes, (1, MAX_NODES))?;
        }
        Some(AirPath::Constant | AirPath::Table) | None => (),
    }
    match accuracy.drop_orders {
        Some(DropOrders::MultipleScattering {
            nodes_across,
            paths_per_node,
        }) => {
            let key = "accuracy.drop_orders.nodes_across";
            check.count(key, &nodes_across, (2, MAX_DIRECTIONS))?;
            let key = "accuracy.drop_orders.paths_per_node";
            check.count(key, &paths_per_node, (2, MAX_PATHS))?;
        }
        Some(DropOrders::SingleScattering) => {
            let expected = "\"multiple-scattering\"; effects.multiple_scattering switches it off";
            let found = "single-scattering".to_string();
            return Err(check.out_of_range("accuracy.drop_orders", found, expected));
        }
        None => (),
    }
    match accuracy.pixel_footprint {
        Some(PixelFootprint::Grid { n }) => {
            check.count("accuracy.pixel_footprint.n", &n, (1, MAX_RAYS_PER_SIDE))
        }
        Some(PixelFootprint::Center | PixelFootprint::Prefiltered) | None => Ok(()),
    }
}

fn photo(scene: &Scene, check: &Check<'_>) -> Result<(), SceneError> {
    let named = |key: &str, path: &str| {
        let empty = || check.out_of_range(key, "empty".to_string(), "a path");
        (!path.trim().is_empty()).then_some(()).ok_or_else(empty)
    };
    occluders(scene, check)?;
    terrain(scene, check)?;
    let Some(photo) = &scene.photo else {
        return Ok(());
    };
    named("photo.picture", &photo.picture)?;
    let contradiction = |key: &str, found: &str, expected: &str| {
        Err(check.out_of_range(key, found.to_string(), expected))
    };
    if photo.layers.is_some() != photo.labels.is_some() {
        return contradiction("photo", "one of them", "layers and labels together");
    }
    if scene.camera.projection != Projection::Pinhole {
        let expected = "\"pinhole\" for a photograph";
        return contradiction(
            "camera.projection",
            scene.camera.projection.name(),
            expected,
        );
    }
    if scene.camera.overscan_px > 0 {
        let found = scene.camera.overscan_px.to_string();
        return contradiction(
            "camera.overscan_px",
            &found,
            "0: a photograph ends at its edges",
        );
    }
    let of_occluders = scene.occluders.as_ref().and_then(|it| it.depth.as_ref());
    if photo.layers.is_some() && of_occluders.is_some() {
        let expected = "either layers or the depth of [occluders]: both say how far surfaces are";
        return contradiction("photo.layers", "both", expected);
    }
    if !photo.picks_px.is_empty() {
        check.count("photo.picks_px", &photo.picks_px.len(), (3, MAX_PICKS))?;
    }
    if photo.white_card.is_some() && photo.exposure != PhotoExposure::Match {
        return contradiction("photo.white_card", "both", "either exposure or white_card");
    }
    if let Some(value) = photo.white_card {
        check.positive("photo.white_card", value)?;
    }
    check.number(
        "photo.cloud_cover",
        photo.cloud_cover.unwrap_or(0.0),
        (0.0, 1.0),
    )
}

fn effects(scene: &Scene, check: &Check<'_>) -> Result<(), SceneError> {
    let orders = scene.effects.of(Effect::MultipleScattering);
    if orders == Switch::On && scene.accuracy.sun_path == Some(SunPath::Ignore) {
        let expected = "a level with a shadow where effects.multiple_scattering is \"on\"";
        return Err(check.out_of_range("accuracy.sun_path", "\"ignore\"".to_string(), expected));
    }
    for effect in Effect::ALL {
        let switch = scene.effects.of(effect);
        let refused = |found: &str, expected: &str| {
            Err(check.out_of_range(&format!("effects.{effect}"), found.to_string(), expected))
        };
        let Row { role, section, .. } = effect.row();
        if switch == Switch::Off && *role == Role::Fixed {
            let expected = "\"on\" or \"auto\": surfaces always hide what is behind them";
            return refused("\"off\"", expected);
        }
        let section = section.filter(|section| !scene.has(*section));
        let section = section.map(|section| format!("in a scene without {}", section.name()));
        let mut needs = effect.needs().iter();
        let effect_off = needs.find(|needed| scene.effects.of(**needed) == Switch::Off);
        let lacking = section.or(effect_off.map(|it| format!("while effects.{it} is \"off\"")));
        if let (Switch::On, Some(lacking)) = (switch, lacking) {
            let expected = format!("\"auto\" or \"off\" {lacking}");
            return refused("\"on\"", &expected);
        }
    }
    Ok(())
}

fn air(scene: &Scene, check: &Check<'_>) -> Result<(), SceneError> {
    let Some(air) = &scene.air else {
        return Ok(());
    };
    let key = "air.constituents";
    if air.constituents.is_empty() {
        let expected = "at least one constituent, or no [air] section for a vacuum";
        return Err(check.out_of_range(key, "empty".to_string(), expected));
    }
    let mut sorted = air.constituents.clone();
    sorted.sort_unstable();
    sorted.dedup();
    if sorted.len() < air.constituents.len() {
        let found = "a constituent twice".to_string();
        return Err(check.out_of_range(key, found, "each constituent once"));
    }
    if let Some((setting, constituent)) = air.idle_setting() {
        let expected = format!(
            "\"{}\" among them, as `{setting}` is given",
            constituent.name()
        );
        return Err(check.out_of_range(key, format!("{:?}", air.constituents), &expected));
    }
    for (key, found, range) in [
        ("air.pressure_hpa", air.pressure_hpa, (1.0, 2000.0)),
        ("air.visibility_km", air.visibility_km, (0.01, 1000.0)),
        ("air.ozone_dobson", air.ozone_dobson, (0.0, 10_000.0)),
        (
            "air.precipitable_water_cm",
            air.precipitable_water_cm,
            (0.0, 20.0),
        ),
    ] {
        found.map_or(Ok(()), |found| check.number(key, found, range))?;
    }
    air.model(
        scene.spectrum,
        scene.ground.albedo.reflectance(),
        &scene.sun,
    )
    .map(|_| ())
    .map_err(|error| check.refused("air", &error))
}

/// Checks ranges and contradictions.
fn occluders(scene: &Scene, check: &Check<'_>) -> Result<(), SceneError> {
    let Some(occluders) = &scene.occluders else {
        return Ok(());
    };
    let refused = |key: &str, found: &str, expected: &str| {
        Err(check.out_of_range(key, found.to_string(), expected))
    };
    match &occluders.depth {
        Some(path) if path.trim().is_empty() => {
            return refused("occluders.depth", "empty", "a path");
        }
        None if occluders.meshes.is_empty() => {
            return refused("occluders", "neither", "depth or meshes");
        }
        Some(_) | None => (),
    }
    let is_pinhole = scene.camera.projection == Projection::Pinhole;
    if occluders.along == Along::Axis && !is_pinhole {
        let expected = "\"ray\" for a camera that is no pinhole";
        return refused("occluders.along", "\"axis\"", expected);
    }
    check.count("occluders.meshes", &occluders.meshes.len(), (0, MAX_MESHES))?;
    for (index, mesh) in occluders.meshes.iter().enumerate() {
        let key = |name: &str| format!("occluders.meshes[{index}].{name}");
        if mesh.file.trim().is_empty() {
            return refused(&key("file"), "empty", "a path");
        }
        check.positive(&key("scale"), mesh.scale)?;
        check.number(&key("turn_deg"), mesh.turn_deg, TURNS_DEG)?;
        for coordinate in mesh.position_m {
            check.coordinate(&key("position_m"), coordinate)?;
        }
        if let Some(albedo) = mesh.albedo {
            albedo.check(&key("albedo"), check)?;
        }
    }
    Ok(())
}

fn terrain(scene: &Scene, check: &Check<'_>) -> Result<(), SceneError> {
    let Some(terrain) = &scene.terrain else {
        return Ok(());
    };
    let refused = |key: &str, found: &str, expected: &str| {
        Err(check.out_of_range(key, found.to_string(), expected))
    };
    let file = terrain.file.trim();
    if file.is_empty() {
        return refused("terrain.file", "empty", "a path");
    }
    let has_metres = file.to_ascii_lowercase().ends_with(".exr");
    if terrain.height_m.is_none() && !has_metres {
        let expected = "the heights of black and of white, for a file that is no EXR";
        return refused("terrain.height_m", "none", expected);
    }
    check.positive("terrain.spacing_m", terrain.spacing_m)?;
    for height_m in terrain.height_m.into_iter().flatten() {
        check.coordinate("terrain.height_m", height_m)?;
    }
    for coordinate in terrain.position_m {
        check.coordinate("terrain.position_m", coordinate)?;
    }
    match terrain.albedo {
        Some(albedo) => albedo.check("terrain.albedo", check),
        None => Ok(()),
    }
}
