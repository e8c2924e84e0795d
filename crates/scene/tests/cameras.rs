//! The section `[camera]` in all its forms, and meshes among the occluders.

#![allow(clippy::unwrap_used, reason = "tests stop at what they did not expect")]

use glam::DVec3;
use niji_geometry::Camera;
use niji_scene::Projection;
use niji_scene::Scene;
use niji_scene::SceneError;

/// A scene with a camera and more.
fn with(camera: &str, more: &str) -> String {
    format!(
        r#"
format = 1
name = "mist"
[sun]
elevation_deg = 20.0
azimuth_deg = 180.0
[camera]
{camera}
width_px = 64
height_px = 32
[drops]
shape = "uniform"
box_min_m = [-50.0, 0.0, -120.0]
box_max_m = [50.0, 50.0, -20.0]
voxel_m = 5.0
law = {{ monodisperse = {{ radius_um = 20.0 }} }}
number_density_m3 = 1e7
{more}
"#
    )
}

const POSE: &str = "position_m = [0.0, 1.6, 0.0]\nazimuth_deg = 30.0\nelevation_deg = 10.0\n";

fn posed(lens: &str) -> String {
    with(&format!("{POSE}{lens}"), "")
}

fn refused(text: &str) -> SceneError {
    Scene::from_toml(text).unwrap_err()
}

fn camera(text: &str) -> Camera {
    Scene::from_toml(text).unwrap().camera.camera().unwrap()
}

#[test]
fn every_projection_is_read_and_written_back() {
    for (lens, projection) in [
        ("horizontal_fov_deg = 60.0", Projection::Pinhole),
        (
            "projection = \"pinhole\"\nfocal_length_mm = 24.0\nsensor_width_mm = 36.0",
            Projection::Pinhole,
        ),
        (
            "projection = \"fisheye-equidistant\"\nhorizontal_fov_deg = 360.0",
            Projection::FisheyeEquidistant,
        ),
        (
            "projection = \"fisheye-equisolid\"\nfocal_length_mm = 8.0\nsensor_width_mm = 36.0\n\
             image_circle_deg = 180.0",
            Projection::FisheyeEquisolid,
        ),
        ("projection = \"panorama\"", Projection::Panorama),
    ] {
        let scene = Scene::from_toml(&posed(lens)).unwrap();
        assert_eq!(scene.camera.projection, projection);
        let again = Scene::from_json(&scene.canonical_json()).unwrap();
        assert_eq!(again, scene);
        let forward = scene.camera.camera().unwrap().forward();
        let expected = camera(&posed("horizontal_fov_deg = 60.0")).forward();
        assert!(forward.distance(expected) < 1e-15);
    }
}

/// 24 mm on 36 mm: 73.7 degrees across, as tables of lenses say.
#[test]
fn a_focal_length_is_a_field_of_view() {
    let lens = "focal_length_mm = 24.0\nsensor_width_mm = 36.0";
    let scene = Scene::from_toml(&posed(lens)).unwrap();
    let fov_deg = scene.camera.horizontal_fov_deg.unwrap();
    assert!((fov_deg - 73.7).abs() < 0.05, "{fov_deg}");
    let camera = scene.camera.pinhole().unwrap();
    let edges = [0.0, 64.0].map(|x| camera.ray(x, 16.0).direction);
    let between_deg = edges[0].angle_between(edges[1]).to_degrees();
    assert!((between_deg - fov_deg).abs() < 1e-9);
}

#[test]
fn scenes_of_pinholes_keep_the_json_that_their_hashes_are_made_of() {
    let scene = Scene::from_toml(&posed("horizontal_fov_deg = 60.0")).unwrap();
    let camera = r#""camera":{"azimuth_deg":30.0,"elevation_deg":10.0,"height_px":32,"horizontal_fov_deg":60.0,"position_m":[0.0,1.6,0.0],"roll_deg":0.0,"width_px":64}"#;
    let json = scene.canonical_json();
    assert!(json.contains(camera), "{json}");
    assert!(!json.contains("\"occluders\":{"));
}

/// Blender: a camera at (1, -3, 2) that was turned by 90 degrees about x and looks level to the north,
/// its y.
#[test]
fn the_matrix_of_blender_is_a_pose_here() {
    let matrix = "horizontal_fov_deg = 60.0\nmatrix_up = \"z\"\nmatrix = [[1.0, 0.0, 0.0, 1.0], \
                  [0.0, 0.0, -1.0, -3.0], [0.0, 1.0, 0.0, 2.0], [0.0, 0.0, 0.0, 1.0]]";
    let camera = camera(&with(matrix, ""));
    assert!(camera.position().distance(DVec3::new(1.0, 2.0, 3.0)) < 1e-14);
    assert!(camera.forward().distance(DVec3::NEG_Z) < 1e-14);
    let right = camera.world_to_camera().inverse().x_axis.truncate();
    assert!(right.distance(DVec3::X) < 1e-14);
    // The same in a program with y up looks down.
    let y_up = matrix.replace("\"z\"", "\"y\"");
    let camera = self::camera(&with(&y_up, ""));
    assert!(camera.forward().distance(DVec3::Y) < 1e-14);
    assert!(camera.position().distance(DVec3::new(1.0, -3.0, 2.0)) < 1e-14);
}

#[test]
fn matrices_that_are_no_pose_say_why_at_their_line() {
    let sound = "matrix_up = \"z\"\nhorizontal_fov_deg = 60.0\nmatrix = [[1.0, 0.0, 0.0, 1.0], \
                 [0.0, 0.0, -1.0, -3.0], [0.0, 1.0, 0.0, 2.0], [0.0, 0.0, 0.0, 1.0]]";
    for (right, wrong, why) in [
        ("[1.0, 0.0, 0.0, 1.0]", "[2.0, 0.0, 0.0, 1.0]", "lengths"),
        ("[1.0, 0.0, 0.0, 1.0]", "[-1.0, 0.0, 0.0, 1.0]", "mirrors"),
        (
            "[1.0, 0.0, 0.0, 1.0]",
            "[1.0, 0.5, 0.0, 1.0]",
            "right angles",
        ),
        ("[0.0, 0.0, 0.0, 1.0]", "[0.0, 0.0, 0.0, 2.0]", "last row"),
        ("[0.0, 0.0, 0.0, 1.0]", "[0.0, 0.0, 1.0]", "array"),
        ("[1.0, 0.0, 0.0, 1.0]", "[nan, 0.0, 0.0, 1.0]", "finite"),
    ] {
        let text = with(&sound.replace(right, wrong), "");
        let line = text
            .lines()
            .position(|line| line.starts_with("matrix = "))
            .unwrap()
            + 1;
        let error = refused(&text);
        assert_eq!(error.line(), Some(line), "{error}");
        assert!(error.to_string().contains(why), "{error}");
    }
    let transposed = with(
        "matrix_up = \"y\"\nhorizontal_fov_deg = 60.0\nmatrix = [[1.0, 0.0, 0.0, 0.0], \
         [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [5.0, 2.0, 0.0, 1.0]]",
        "",
    );
    assert!(refused(&transposed).to_string().contains("transpose it"));
}

#[test]
fn cameras_that_contradict_themselves_are_refused() {
    let matrix = "matrix = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], \
                  [0.0, 0.0, 0.0, 1.0]]";
    for (text, why) in [
        (posed(""), "either horizontal_fov_deg"),
        (posed("focal_length_mm = 24.0"), "either horizontal_fov_deg"),
        (
            posed("horizontal_fov_deg = 60.0\nfocal_length_mm = 24.0\nsensor_width_mm = 36.0"),
            "either horizontal_fov_deg",
        ),
        (
            posed("projection = \"panorama\"\nhorizontal_fov_deg = 60.0"),
            "all directions",
        ),
        (
            posed("horizontal_fov_deg = 60.0\nimage_circle_deg = 60.0"),
            "for a fisheye only",
        ),
        (
            posed(&format!(
                "horizontal_fov_deg = 60.0\n{matrix}\nmatrix_up = \"y\""
            )),
            "either position_m",
        ),
        (
            with(&format!("horizontal_fov_deg = 60.0\n{matrix}"), ""),
            "matrix_up",
        ),
        (with("horizontal_fov_deg = 60.0", ""), "either position_m"),
    ] {
        let error = refused(&text);
        let said = error.to_string();
        assert!(said.contains("`camera` cannot be used: expected"), "{said}");
        assert!(said.contains(why), "{said}");
        assert_eq!(error.line(), Some(7), "the line of [camera]: {said}");
    }
    for (lens, key) in [
        (
            "projection = \"fisheye-equisolid\"\nhorizontal_fov_deg = 361.0",
            "horizontal_fov_deg",
        ),
        (
            "focal_length_mm = 0.0\nsensor_width_mm = 36.0",
            "horizontal_fov_deg",
        ),
        (
            "projection = \"fisheye-equisolid\"\nfocal_length_mm = -8.0\nsensor_width_mm = 36.0",
            "focal_length_mm",
        ),
        (
            "projection = \"fisheye-equisolid\"\nhorizontal_fov_deg = 90.0\nimage_circle_deg = 400.0",
            "image_circle_deg",
        ),
    ] {
        let error = refused(&posed(lens));
        assert!(matches!(error, SceneError::OutOfRange { .. }), "{error}");
        assert!(error.to_string().contains(key), "{error}");
    }
    let square = posed("projection = \"panorama\"").replace("height_px = 32", "height_px = 64");
    assert!(
        refused(&square)
            .to_string()
            .contains("twice as wide as high")
    );
    let misspelt = posed("projection = \"fisheye-equisolide\"\nhorizontal_fov_deg = 90.0");
    assert!(
        refused(&misspelt)
            .to_string()
            .contains("did you mean `fisheye-equisolid`")
    );
}

#[test]
fn photographs_and_depths_along_the_axis_need_a_pinhole() {
    let lens = "projection = \"fisheye-equidistant\"\nhorizontal_fov_deg = 180.0";
    let lens = format!("{POSE}{lens}");
    for (section, why) in [
        (
            "[photo]\npicture = \"p.jpg\"",
            "\"pinhole\" for a photograph",
        ),
        (
            "[occluders]\ndepth = \"d.exr\"\nalong = \"axis\"",
            "no pinhole",
        ),
    ] {
        let error = refused(&with(&lens, section));
        assert!(error.to_string().contains(why), "{error}");
    }
    let along_rays = with(&lens, "[occluders]\ndepth = \"d.exr\"");
    assert!(Scene::from_toml(&along_rays).is_ok());
}

#[test]
fn meshes_stand_among_the_occluders() {
    let lens = format!("{POSE}horizontal_fov_deg = 60.0");
    let meshes = "[[occluders.meshes]]\nfile = \"ship.obj\"\n[[occluders.meshes]]\n\
                  file = \"rock.stl\"\nup = \"z\"\nscale = 0.01\nturn_deg = 30.0\n\
                  position_m = [0.0, 0.0, -90.0]";
    let scene = Scene::from_toml(&with(&lens, meshes)).unwrap();
    let occluders = scene.occluders.clone().unwrap();
    assert_eq!((occluders.depth, occluders.meshes.len()), (None, 2));
    assert_eq!(Scene::from_json(&scene.canonical_json()).unwrap(), scene);
    for (right, wrong, found) in [
        ("scale = 0.01", "scale = 0.0", "scale"),
        ("scale = 0.01", "scale = -1.0", "scale"),
        ("turn_deg = 30.0", "turn_deg = 1e4", "turn_deg"),
        ("scale = 0.01", "scal = 0.01", "did you mean `scale`"),
        ("-90.0]", "-1e9]", "position_m"),
        ("\"rock.stl\"", "\" \"", "file"),
    ] {
        let text = with(&lens, &meshes.replace(right, wrong));
        let line = text.lines().position(|line| line.contains(wrong)).unwrap() + 1;
        let error = refused(&text);
        assert_eq!(error.line(), Some(line), "{error}");
        assert!(error.to_string().contains(found), "{error}");
    }
    let nothing = refused(&with(&lens, "[occluders]\nalong = \"ray\""));
    assert!(nothing.to_string().contains("depth or meshes"), "{nothing}");
    let many = "[[occluders.meshes]]\nfile = \"a.obj\"\n".repeat(9);
    assert!(refused(&with(&lens, &many)).to_string().contains("0 to 8"));
}
