//! From drops to a picture by library calls alone, as a PNG on standard output:
//! `cargo run --release -p niji-scene --example smallest-picture > bow.png`.

use std::f64::consts::PI;

use niji_dropfield::Bricks;
use niji_exchange::Attributes;
use niji_exchange::ImageWindows;
use niji_exchange::Provenance;
use niji_exchange::SpectralImage;
use niji_radiometry::Colorimetry;
use niji_radiometry::solar_irradiance;
use niji_render::LitDrops;
use niji_render::RenderRequest;
use niji_render::render;
use niji_scatter::scattering_table;
use niji_scene::Scene;
use niji_scene::plan;

/// Rain in the north, the sun 20 degrees high in the south; no air.
const SCENE: &str = r#"
format = 1
name = "smallest"
sun = { elevation_deg = 20.0, azimuth_deg = 180.0 }
accuracy = { preset = "draft" }
effects = { drop_flattening = "off", multiple_scattering = "off" }
[camera]
position_m = [0.0, 1.6, 0.0]
azimuth_deg = 0.0
elevation_deg = 12.0
horizontal_fov_deg = 100.0
width_px = 320
height_px = 160
[drops]
shape = "uniform"
box_min_m = [-300.0, 0.0, -300.0]
box_max_m = [300.0, 250.0, -100.0]
voxel_m = 10.0
law = { monodisperse = { radius_um = 300.0 } }
number_density_m3 = 500.0
"#;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // What takes part and how accurately: the plan decides, as `niji plan` would.
    let scene = Scene::from_toml(SCENE)?;
    let plan = plan(&scene, None)?;
    let (wavelengths, sun_direction) = (scene.spectrum.grid()?, scene.sun.direction());
    let sun_irradiance = solar_irradiance(&wavelengths);

    // 1. Drops: where they are, and how much light reaches them.
    let shape = scene.drops.shape().ok_or("these drops are a shape")?;
    let volume = shape.volume()?;
    let build = |mode| Bricks::build(mode, plan.levels.interpolation);
    let bricks = volume.modes.iter().map(build).collect::<Result<_, _>>()?;
    let drops = LitDrops::new(bricks, sun_direction, plan.sun_path())?;

    // 2. Scattering: a table for all sizes and directions that are seen.
    let need = plan.scattering.as_ref().ok_or("a bow is on")?;
    let table = scattering_table(&need.request(wavelengths, None), &|_| ())?;

    // 3. The integral along the rays of the camera.
    let request = RenderRequest {
        camera: &scene.camera.camera()?,
        region: scene.camera.region()?,
        sun_direction,
        wavelengths,
        sun_irradiance: &sun_irradiance,
        drops: &drops,
        table: Some(&table),
        air: None,
        surfaces: None,
        effects: plan.render_effects(),
        levels: plan.levels.render_levels(),
        tolerance_cd_m2: None,
    };
    let picture = render(&request, &|_| ())?;

    // 4. Light as color; white is a white card that faces the sun.
    let image = SpectralImage {
        wavelengths,
        radiance: picture.radiance,
        windows: ImageWindows::whole(320, 160),
        aovs: Vec::new(),
        white_luminance_cd_m2: Colorimetry::new(&wavelengths).xyz(&sun_irradiance)[1] / PI,
        world_to_camera: None,
        attributes: Attributes::new(),
        provenance: Provenance::default(),
    };
    image.write_png(std::io::stdout().lock(), 3.0)?;
    Ok(())
}
