//! `niji composite` for compositors: the bow alone over a plate, primaries, windows, depth.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod support;

use std::fs::File;
use std::path::Path;

use ndarray::Array2;
use niji_exchange::ImageWindows;
use niji_exchange::Provenance;
use niji_geometry::PixelRegion;
use niji_photo::Frame;
use niji_photo::LinearPicture;
use niji_photo::Plate;
use niji_photo::PremultipliedPicture;
use niji_photo::write_depth_map;
use niji_radiometry::RgbPrimaries;
use support::niji_ends_with;
use support::text;
use support::variant;

const WIDTH: u32 = 48;
const HEIGHT: u32 = 32;
/// f32 in files, and sums of a few of them: worst found 1e-7 of the value.
const ROUNDING: f32 = 2e-6;

/// A rendered bow, from 100 m on.
fn image(folder: &Path) -> String {
    image_of("paper-c-figure-3.toml", folder)
}

/// A shipped scene in the size of the plate.
fn image_of(scene: &str, folder: &Path) -> String {
    let scene = variant(
        scene,
        folder,
        &[
            ("camera.width_px", &WIDTH.to_string()),
            ("camera.height_px", &HEIGHT.to_string()),
            ("accuracy.preset", "\"draft\""),
            ("picture.primaries", "\"acescg\""),
        ],
    );
    let out = folder.join("out");
    niji_ends_with(0, &["run", text(&scene), "-o", text(&out), "-q"]);
    text(&out.join("image.exr")).to_owned()
}

/// A plate of ACEScg that holds another part of the frame than the image does.
fn plate() -> (LinearPicture, Frame) {
    let data = PixelRegion {
        x_px: -3,
        y_px: 2,
        width_px: WIDTH,
        height_px: HEIGHT,
    };
    let frame = Frame {
        primaries: RgbPrimaries::AcesCg,
        windows: ImageWindows {
            data,
            display: PixelRegion::frame(WIDTH, HEIGHT),
        },
    };
    let size = (HEIGHT as usize, WIDTH as usize);
    let light = Array2::from_shape_fn(size, |(y, x)| [0.3, 0.02 * x as f32, 0.5 + 0.1 * y as f32]);
    (light, frame)
}

fn write_plate(path: &Path, light: &LinearPicture, frame: Frame) {
    let picture = PremultipliedPicture {
        light,
        alpha: None,
        frame,
    };
    let file = File::create(path).unwrap();
    picture.write_exr(&Provenance::default(), file).unwrap();
}

#[test]
fn the_bow_over_a_plate_is_the_composite() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let image = image(folder.path());
    let (light, frame) = plate();
    let background = at("plate.exr");
    write_plate(&background, &light, frame);
    let composite = |name: &str, extra: &[&str]| {
        let (element, over) = (at(&format!("{name}.exr")), at(&format!("{name}-over.exr")));
        let fixed = ["composite", text(&background), "--image", &image, "-q"];
        let to = ["-o", text(&element), "--over", text(&over)];
        niji_ends_with(0, &[&fixed[..], &to, extra].concat());
        [element, over].map(|path| Plate::read(&path, None).unwrap())
    };

    let [element, over] = composite("bow", &["--exposure", "1"]);
    let alpha = element.alpha.as_ref().unwrap();
    assert_eq!(
        (element.primaries, element.windows),
        (frame.primaries, frame.windows)
    );
    assert_eq!(
        (over.primaries, over.windows),
        (frame.primaries, frame.windows)
    );
    let mut n_lit = 0;
    for ((y, x), bow) in element.light.indexed_iter() {
        for channel in 0..3 {
            let expected = bow[channel] + (1.0 - alpha[[y, x]]) * light[[y, x]][channel];
            let found = over.light[[y, x]][channel];
            assert!(
                (found - expected).abs() <= ROUNDING * expected.abs(),
                "{x} {y}"
            );
        }
        n_lit += u32::from(bow.iter().any(|value| *value > 1e-4));
        // The image ends where its frame ends.
        assert!(x >= 3 || bow.iter().all(|value| *value <= 0.0), "{x} {y}");
    }
    assert!(n_lit > 100, "{n_lit} pixels of bow");

    // Twice the exposure is twice the light of bow and veil; that of the plate is as it was.
    let [double, triple] = ["2", "3"].map(|card| composite(card, &["--exposure", card])[0].clone());
    for ((first, second), third) in element.light.iter().zip(&double.light).zip(&triple.light) {
        for channel in 0..3 {
            let steps = [
                second[channel] - first[channel],
                third[channel] - second[channel],
            ];
            assert!(steps[0] >= 0.0 && (steps[1] - steps[0]).abs() <= 1e-6 * third[channel]);
        }
    }
    assert_eq!(double.alpha, element.alpha);

    // Everything at 10 m: before the drops nothing is added.
    let near = at("near.exr");
    let depth_m = Array2::from_elem(light.dim(), 10.0);
    let file = File::create(&near).unwrap();
    write_depth_map(&depth_m, &Provenance::default(), file).unwrap();
    let hidden = ["--exposure", "1", "--depth", text(&near)];
    let [nothing, same] = composite("hidden", &hidden);
    assert!(nothing.light.iter().flatten().all(|value| *value <= 0.0));
    assert!(nothing.alpha.unwrap().iter().all(|alpha| *alpha <= 0.0));
    assert_eq!(same.light, light);

    // The same plate as Rec.709 shows the same colors.
    let [_, rec709] = composite(
        "rec709",
        &[&hidden[..], &["--primaries", "rec709"]].concat(),
    );
    assert_eq!(rec709.primaries, RgbPrimaries::Rec709);
    for (found, own) in rec709.light.iter().zip(&light) {
        let back = RgbPrimaries::AcesCg.of_linear_rec709(found.map(f64::from));
        for (back, own) in back.into_iter().zip(own) {
            assert!((back - f64::from(*own)).abs() < 1e-6 * f64::from(*own).max(1.0));
        }
    }
    // A plate that is said to hold Rec.709 keeps its numbers.
    let said = ["--plate-primaries", "rec709"];
    let [_, kept] = composite("said", &[&hidden[..], &said].concat());
    assert_eq!((kept.primaries, kept.light), (RgbPrimaries::Rec709, light));
}

#[test]
fn drops_before_a_plate_of_one_color_do_not_darken_it() {
    let folder = tempfile::tempdir().unwrap();
    let image = image_of("rain-shaft-25-mm-h.toml", folder.path());
    let [plate_file, element, over] =
        ["plate.exr", "bow.exr", "over.exr"].map(|name| folder.path().join(name));
    let (light, frame) = plate();
    let light = light.mapv(|_| [0.5, 0.75, 1.5]);
    write_plate(&plate_file, &light, frame);
    // A bow so dim that it adds nothing.
    let fixed = ["composite", text(&plate_file), "--image", &image, "-q"];
    let to = ["-o", text(&element), "--over", text(&over)];
    niji_ends_with(0, &[&fixed[..], &to, &["--exposure", "1e-12"]].concat());
    let alpha = Plate::read(&element, None).unwrap().alpha.unwrap();
    assert!(alpha.iter().any(|alpha| *alpha > 0.05), "there are drops");
    let over = Plate::read(&over, None).unwrap();
    for (found, expected) in over.light.iter().flatten().zip(light.iter().flatten()) {
        assert!(
            (found - expected).abs() <= ROUNDING * expected,
            "{found} {expected}"
        );
    }
}

#[test]
fn the_plain_image_is_written_in_the_primaries_of_the_scene() {
    let folder = tempfile::tempdir().unwrap();
    let image = image(folder.path());
    let plain = Path::new(&image).with_extension("layers.exr");
    let plate = Plate::read(&plain, None).unwrap();
    assert_eq!(plate.primaries, RgbPrimaries::AcesCg);
    assert!(plate.light.iter().flatten().all(|value| *value >= 0.0));
    // Its own depth lies where its light comes from: the bow is not hidden.
    assert!(plate.surface_m.is_some());
}

#[test]
fn a_damaged_plate_is_bad_input() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let image = image(folder.path());
    let (light, frame) = plate();
    let whole = at("plate.exr");
    write_plate(&whole, &light, frame);
    let bytes = std::fs::read(&whole).unwrap();
    let cut = at("cut.exr");
    std::fs::write(&cut, &bytes[..bytes.len() / 2]).unwrap();
    let to = at("bow.exr");
    let arguments = ["composite", text(&cut), "--image", &image, "-o", text(&to)];
    let message = String::from_utf8(niji_ends_with(3, &arguments).stderr).unwrap();
    assert!(message.contains("not a sound picture"), "{message}");
    assert!(!to.exists());
}
