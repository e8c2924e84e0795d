//! What a picture errs by beside what is estimated with it is told by small pictures before it; the ground is one.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use std::path::Path;

use ndarray::Array2;
use niji_exchange::SpectralImage;
use niji_picture::DROP_SPACING;
use niji_picture::PictureParts;
use niji_picture::PictureSettings;
use niji_picture::PictureWork;
use niji_picture::PlanRequest;
use niji_picture::PlannedScene;
use niji_picture::SKY;
use niji_picture::air;
use niji_picture::scene_from_toml;
use niji_picture::unwatched;
use niji_scene::DropSpacing;
use niji_scene::SkyLevel;

/// A wall of drops on the ground before a low sun's sky, at few wavelengths; lines of its sections may be added.
fn wall(drops: &str, air: &str, tail: &str) -> String {
    format!(
        "format = 1\nname = \"wall\"\n\
         [sun]\nelevation_deg = 18.0\nazimuth_deg = 180.0\n\
         [camera]\nposition_m = [0.0, 3.0, 0.0]\nazimuth_deg = 0.0\nelevation_deg = 8.0\n\
         horizontal_fov_deg = 60.0\nwidth_px = 30\nheight_px = 24\n\
         [spectrum]\nfirst_nm = 450.0\nstep_nm = 100.0\nn_wavelengths = 2\n\
         [drops]\n{drops}\n\
         [air]\nconstituents = [\"rayleigh\", \"aerosol\"]\naerosol = \"rural\"\n{air}\n\
         [effects]\nmultiple_scattering = \"off\"\ndrop_flattening = \"off\"\nair_extinction = \"on\"\n\
         sunlight_through_air = \"on\"\nair_inscatter = \"on\"\n{tail}"
    )
}

/// Without the rays that edges get.
const CENTERS: &str = "[accuracy]\npixel_footprint = \"center\"\nintegration = \"cell-exact\"\n";

fn uniform(bottom_m: f64, voxel_m: f64) -> String {
    format!(
        "shape = \"uniform\"\nbox_min_m = [-300.0, {bottom_m:.1}, -500.0]\n\
         box_max_m = [300.0, 160.0, -300.0]\nvoxel_m = {voxel_m:.1}\nnumber_density_m3 = 3000.0\n\
         law = {{ hansen-travis = {{ effective_radius_um = 250.0, effective_variance = 0.1 }} }}"
    )
}

fn planned(text: &str) -> PlannedScene {
    let scene = scene_from_toml(text, Path::new("")).unwrap();
    PlannedScene::new(scene, PlanRequest::default()).unwrap()
}

/// Its picture, with light of the sky that is solved so finely.
fn picture(planned: &PlannedScene, sky: SkyLevel) -> SpectralImage {
    let parts = PictureParts {
        drops: planned.drops().unwrap(),
        table: planned
            .scattering(planned.airy().unwrap().as_ref(), &unwatched)
            .unwrap(),
        air: air::table(&planned.scene, Some(sky.orders()), &unwatched).unwrap(),
        surfaces: None,
    };
    let settings = PictureSettings::of(planned);
    let whole = settings.whole().unwrap();
    let work = PictureWork::new(settings, parts, &unwatched).unwrap();
    work.render(whole, &unwatched).unwrap()
}

/// Luminance of every pixel over display white.
fn luminance(planned: &PlannedScene, image: &SpectralImage) -> Array2<f64> {
    niji_exchange::luminance(&image.radiance, &image.wavelengths) / planned.plan.display_white_cd_m2
}

fn rms(values: &Array2<f64>) -> f64 {
    (values.mapv(|it| it * it).sum() / values.len() as f64).sqrt()
}

/// RMS of a part of the told error, over display white.
fn told(planned: &PlannedScene, image: &SpectralImage, cause: &str) -> f64 {
    let error = image.aovs.iter().find(|aov| aov.name == "error").unwrap();
    let mut channels = error.channels.iter();
    let values = &channels.find(|(name, _)| name == cause).unwrap().1;
    rms(&values.mapv(|it| f64::from(it) / planned.plan.display_white_cd_m2))
}

#[test]
fn the_ground_hides_drops_below_it_and_drops_on_it_reach_it() {
    let at = |bottom_m, voxel_m| {
        let planned = planned(&wall(&uniform(bottom_m, voxel_m), "", ""));
        let level = planned.plan.sky_level.unwrap();
        luminance(&planned, &picture(&planned, level))
    };
    let on_ground = at(0.0, 40.0);
    // However deep they go on below it, and however far apart nodes are.
    for (other, most) in [(at(-160.0, 40.0), 5e-4), (at(0.0, 10.0), 3e-3)] {
        let off = &on_ground - &other;
        let worst = off.iter().fold(0.0_f64, |worst, it| worst.max(it.abs()));
        assert!(worst < most, "{worst} of {most}");
    }
    // Below the horizon there is nothing but the ground.
    let none = wall(
        &uniform(0.0, 40.0),
        "",
        "primary_bow = \"off\"\nsecondary_bow = \"off\"\n",
    );
    let bare = planned(&none.replace("= 3000.0", "= 0.000001"));
    let bare = luminance(&bare, &picture(&bare, bare.plan.sky_level.unwrap()));
    for (found, expected) in on_ground.row(23).iter().zip(bare.row(23)) {
        assert!((found - expected).abs() < 2e-4, "{found} {expected}");
    }
}

#[test]
fn the_error_of_the_sky_is_told_and_a_tolerance_solves_it_more_finely() {
    let mut are_finer = false;
    for (air, sun_deg, tight) in [
        ("visibility_km = 12.0", "18.0", "0.002"),
        ("visibility_km = 60.0", "5.0", "0.0005"),
    ] {
        let text = wall(&uniform(0.0, 40.0), air, "");
        let text = text.replace(
            "elevation_deg = 18.0",
            &format!("elevation_deg = {sun_deg}"),
        );
        let mut levels = Vec::new();
        for tolerance in ["0.03", tight] {
            let text = format!("{text}[accuracy]\ntolerance = {tolerance}\n");
            let planned = planned(&text);
            let level = planned.plan.sky_level.unwrap();
            let image = picture(&planned, level);
            let truth = luminance(&planned, &picture(&planned, SkyLevel::Fine));
            let off = rms(&(luminance(&planned, &image) - truth));
            let told = told(&planned, &image, SKY);
            assert!(off < 1.2 * told, "{air} {tolerance}: {off} for {told}");
            assert!(
                told < 0.36 * tolerance.parse::<f64>().unwrap(),
                "{air}: {told}"
            );
            levels.push(level);
        }
        assert!(levels.is_sorted(), "{air}: {levels:?}");
        are_finer |= levels[0] < levels[1];
    }
    assert!(are_finer);
}

fn shaft(voxel_m: f64) -> String {
    format!(
        "shape = \"rain-shaft\"\nrain_rate_mm_h = 20.0\n\
         footprint = {{ column = {{ radius_m = 90.0 }} }}\ncenter_xz_m = [20.0, -450.0]\n\
         base_y_m = 0.0\ntop_y_m = 150.0\nedge_m = 60.0\nvoxel_m = {voxel_m:.1}"
    )
}

#[test]
fn what_lies_between_the_nodes_of_the_drops_is_told() {
    for voxel_m in [24.0, 12.0] {
        let at = |voxel_m| {
            // All by the same table, and without the shadow that finer drops have and coarser ones leave out.
            let tail = format!("drop_shadow = \"off\"\n{CENTERS}table_relative_error = 0.005\n");
            let planned = planned(&wall(&shaft(voxel_m), "", &tail));
            let image = picture(&planned, SkyLevel::Quick);
            let told = told(&planned, &image, DROP_SPACING);
            (luminance(&planned, &image), told)
        };
        let (coarse, told) = at(voxel_m);
        let (fine, _) = at(voxel_m / 4.0);
        let off = rms(&(coarse - fine));
        assert!(
            off < 1.5 * told && told < 5.0 * off,
            "{voxel_m} m: {off} for {told}"
        );
    }
}

#[test]
fn nodes_are_twice_as_close_where_the_tolerance_asks_for_it() {
    let text = |accuracy: &str| wall(&shaft(48.0), "", &format!("{CENTERS}{accuracy}\n"));
    let tight = text("tolerance = 0.0005");
    let [coarse, fine, named] = [
        &text("tolerance = 0.05"),
        &tight,
        &text("tolerance = 0.0005\ndrop_spacing = \"as-given\""),
    ]
    .map(|text| planned(text));
    let n_nodes = |planned: &PlannedScene| planned.drops().unwrap().summary().n_nodes;
    let seen = told(&coarse, &picture(&coarse, SkyLevel::Quick), DROP_SPACING);
    assert_eq!(fine.plan.levels.drop_spacing, DropSpacing::Halved, "{seen}");
    assert!(n_nodes(&fine) > 5 * n_nodes(&coarse));
    for other in [&coarse, &named] {
        assert_eq!(other.plan.levels.drop_spacing, DropSpacing::AsGiven);
        assert_eq!(n_nodes(other), n_nodes(&coarse));
    }
    let truth = planned(&wall(&shaft(12.0), "", CENTERS));
    let truth = luminance(&truth, &picture(&truth, SkyLevel::Quick));
    let errors = [&named, &fine].map(|planned| {
        let image = picture(planned, SkyLevel::Quick);
        let off = rms(&(luminance(planned, &image) - &truth));
        (off, told(planned, &image, DROP_SPACING))
    });
    let [(off, _), (finer, told_of_finer)] = errors;
    assert!(finer < 0.6 * off, "{errors:?}");
    assert!(
        finer < 2.0 * told_of_finer && told_of_finer < 5.0 * finer,
        "{errors:?}"
    );
    // What was chosen once is the same without measuring, and when planned anew as it stands.
    let again = PlanRequest {
        choice: Some(&fine.choice),
        ..PlanRequest::default()
    };
    let scene = scene_from_toml(&tight, Path::new("")).unwrap();
    assert_eq!(PlannedScene::new(scene, again).unwrap().choice, fine.choice);
    let anew = fine.replanned(fine.scene.clone()).unwrap();
    assert_eq!(n_nodes(&anew), n_nodes(&fine));
}

#[test]
fn a_table_is_as_coarse_as_a_small_picture_shows_that_it_may_be() {
    // A little light of drops, and two hundred times as much.
    let wall_of = |number_density: &str, accuracy: &str| {
        let text = wall(&uniform(0.0, 40.0), "", &format!("{CENTERS}{accuracy}\n"));
        planned(&text.replace("3000.0", number_density))
    };
    let tolerance = 0.0005;
    let mut errors = Vec::new();
    for number_density in ["300.0", "60000.0"] {
        let own = wall_of(number_density, &format!("tolerance = {tolerance}"));
        let error = own.plan.levels.table_relative_error;
        let image = picture(&own, SkyLevel::Quick);
        // The part of half of the tolerance that a table has. Steps that are halved make the small picture's up to four
        // times too fine, of which half is allowed for, and its theory may be another.
        let told = told(&own, &image, "angles");
        let part = 0.5 * tolerance / 6.0_f64.sqrt();
        assert!(told < 3.0 * part, "{number_density}: {told} for {part}");
        let truth = format!("tolerance = {tolerance}\ntable_relative_error = 1e-4");
        let truth = wall_of(number_density, &truth);
        let truth = luminance(&truth, &picture(&truth, SkyLevel::Quick));
        let off = rms(&(luminance(&own, &image) - truth));
        assert!(off < 1.3 * told, "{number_density}: {off} for {told}");
        errors.push(error);
    }
    let [of_little, of_much] = errors[..] else {
        panic!("{errors:?}");
    };
    assert!(of_little >= 2.0 * of_much, "{errors:?}");
    let named = wall_of("300.0", "tolerance = 0.002\ntable_relative_error = 0.003");
    assert_eq!(named.plan.levels.table_relative_error, 0.003);
}
