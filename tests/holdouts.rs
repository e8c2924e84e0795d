//! Edges of held-out surfaces: a depth map finer than the picture antialiases them, in light and in alpha alike.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod support;

use std::fs;
use std::fs::File;
use std::path::Path;

use ndarray::Array2;
use niji_exchange::Provenance;
use niji_exchange::read_plain;
use niji_photo::write_depth_map;
use support::niji_ends_with;
use support::text;
use support::variant;

const WIDTH: usize = 64;
const HEIGHT: usize = 36;
/// A wall this far away (m), in front of the rain.
const WALL_M: f32 = 100.0;
/// Places along a side of a pixel that tell how much of it the wall covers.
const N_PLACES: usize = 32;

/// Whether a point of the picture shows the wall: below a slanted line.
fn is_wall(x: f64, y: f64) -> bool {
    y > 12.3 + 0.3 * x
}

/// R, G, B and A of the picture with distances of n x n places a pixel, of the wall where `shows` says so.
fn picture(folder: &Path, n: usize, shows: impl Fn(f64, f64) -> bool) -> [Array2<f32>; 4] {
    let place = |index: usize| (index as f64 + 0.5) / n as f64;
    let depth_m = Array2::from_shape_fn((n * HEIGHT, n * WIDTH), |(y, x)| {
        if shows(place(x), place(y)) {
            WALL_M
        } else {
            f32::INFINITY
        }
    });
    let file = File::create(folder.join("depth.exr")).unwrap();
    write_depth_map(&depth_m, &Provenance::default(), file).unwrap();
    let small = [
        ("camera.width_px", WIDTH.to_string()),
        ("camera.height_px", HEIGHT.to_string()),
    ];
    let small = small.each_ref().map(|(key, value)| (*key, value.as_str()));
    let scene = variant("rain-cell-8-km.toml", folder, &small);
    let held_out = fs::read_to_string(&scene).unwrap()
        + "\n[occluders]\ndepth = \"depth.exr\"\nalong = \"ray\"\n";
    fs::write(&scene, held_out).unwrap();
    let out = folder.join("out");
    let run = ["run", text(&scene), "-o", text(&out), "--force", "-q"];
    niji_ends_with(0, &run);
    let parts = read_plain(&out.join("image.layers.exr")).unwrap();
    ["R", "G", "B", "A"].map(|name| {
        let channels = &parts[0].channels;
        let found = channels.iter().find(|it| it.name == name).unwrap();
        found.values.clone()
    })
}

#[test]
fn slanted_edges_are_antialiased_in_light_and_alpha_by_a_map_of_any_fineness() {
    let folder = tempfile::tempdir().unwrap();
    let open = picture(folder.path(), 1, |_, _| false);
    let wall = picture(folder.path(), 1, |_, _| true);
    let covered = Array2::from_shape_fn((HEIGHT, WIDTH), |(y, x)| {
        let place = |index: usize| (index as f64 + 0.5) / N_PLACES as f64;
        let places = (0..N_PLACES * N_PLACES).map(|it| [it / N_PLACES, it % N_PLACES].map(place));
        let n = places.filter(|[down, across]| is_wall(x as f64 + across, y as f64 + down));
        n.count() as f32 / (N_PLACES * N_PLACES) as f32
    });
    // RMS over pixels at the edge of what the mean of both sides by their areas says otherwise.
    let errors = |found: &[Array2<f32>; 4]| {
        let at_edge = covered
            .indexed_iter()
            .filter(|it| *it.1 > 0.0 && *it.1 < 1.0);
        let at_edge: Vec<_> = at_edge.collect();
        assert!(at_edge.len() > 60, "{}", at_edge.len());
        [0, 1, 2, 3].map(|channel: usize| {
            let squares = at_edge.iter().map(|(place, covered)| {
                let [open, wall, found] =
                    [&open, &wall, found].map(|it| f64::from(it[channel][*place]));
                let covered = f64::from(**covered);
                (found - covered * wall - (1.0 - covered) * open).powi(2)
            });
            (squares.sum::<f64>() / at_edge.len() as f64).sqrt()
        })
    };
    let [fine, coarse] = [4, 1].map(|n| errors(&picture(folder.path(), n, is_wall)));
    // 1 is a white card in the sun, and what drops cover wholly.
    for (found, light, alpha) in [(fine, 0.01, 0.02), (coarse, 0.025, 0.12)] {
        assert!(found[..3].iter().all(|error| *error < light), "{found:?}");
        assert!(found[3] < alpha, "{found:?}");
    }
}
