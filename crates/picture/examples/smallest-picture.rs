//! From a scene to a picture by library calls alone, as a PNG on standard output:
//! `cargo run --release -p niji-picture --example smallest-picture > bow.png`.

use niji_picture::PlanRequest;
use niji_picture::PlannedScene;
use niji_picture::Scene;
use niji_picture::unwatched;

/// Rain in the north, the sun 20 degrees high in the south; no air.
const SCENE: &str = r#"
format = 1
name = "smallest"
sun = { elevation_deg = 20.0, azimuth_deg = 180.0 }
accuracy = { preset = "draft" }
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
    let planned = PlannedScene::new(Scene::from_toml(SCENE)?, PlanRequest::default())?;
    let image = planned.picture(&unwatched)?;
    image.write_png(std::io::stdout().lock(), 3.0)?;
    Ok(())
}
