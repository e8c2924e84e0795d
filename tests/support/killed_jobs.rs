//! What is killed: jobs of commands on small scenes.

use std::fs;

use super::super::support::TINY;
use super::super::support::repository;
use super::super::support::text;
use super::Job;

fn job(name: &'static str, scene: &str, lines: &[&'static str]) -> Job {
    let words = |line: &&'static str| line.split(' ').collect();
    Job {
        name,
        scenes: vec![("s.toml", scene.to_owned())],
        commands: lines.iter().map(words).collect(),
    }
}

/// The jobs: a run, a sequence, tiles that are merged, rows that are saved, ice, a sweep.
pub fn jobs() -> Vec<Job> {
    // The stage of the air beside the others.
    let dark = "sky = \"off\"\nair_inscatter = \"off\"\nair_extinction = \"off\"\nsunlight_through_air = \"off\"\n";
    let air = "[air]\nconstituents = [\"rayleigh\"]\n[accuracy]\nsky = \"single-scattering\"\n";
    let rain = TINY.replace(dark, "").replace("[accuracy]\n", air);
    let rising = format!("{TINY}\n[sequence]\nsun.elevation_deg = [[1, 19.5], [3, 20.5]]\n");
    let tiles = [
        "render --scene s.toml --drops d.vdb --table t.exr --tiles 1/3 -o 1.exr -q",
        "render --scene s.toml --drops d.vdb --table t.exr --tiles 2/3 -o 2.exr -q",
        "render --scene s.toml --drops d.vdb --table t.exr --tiles 3/3 -o 3.exr -q",
        "merge 1.exr 2.exr 3.exr -o image.exr -q",
    ];
    vec![
        job("run", &rain, &["run s.toml -o out -q"]),
        job("sequence", &rising, &["run s.toml -o out --frames 1-3 -q"]),
        job(
            "tiles",
            &TINY.replace("height_px = 12", "height_px = 24"),
            &[&CHAIN[..], &tiles].concat(),
        ),
        rows(),
        job("ice", &ice("192"), &["ice s.toml -o ice.exr -q"]),
        job("sweep", &least(), &["sweep s.toml -o out -q"]),
    ]
}

/// What a picture is rendered from.
const CHAIN: [&str; 3] = [
    "drops --scene s.toml -o d.vdb -q",
    "airy -o a.exr -q",
    "scatter --scene s.toml --airy a.exr -o t.exr -q",
];
const RENDER: &str =
    "render --scene s.toml --drops d.vdb --table t.exr --threads 1 -o image.exr -q";

/// A picture that takes a second or two, whose rows are saved meanwhile.
pub fn rows() -> Job {
    job("rows", &slow(), &[&CHAIN[..], &[RENDER]].concat())
}

/// A picture of a second or two on one thread, whose rows are saved meanwhile.
fn slow() -> String {
    let fine = "[accuracy]\npixel_footprint = { level = \"grid\", n = 4 }\n\
                integration = { level = \"fixed-step\", step_m = 0.7 }\n";
    TINY.replace("width_px = 16", "width_px = 2")
        .replace("height_px = 12", "height_px = 300")
        .replace("fov_deg = 90.0", "fov_deg = 0.2")
        .replace("elevation_deg = 10.0", "elevation_deg = 22.0")
        .replace("[accuracy]\n", fine)
}

fn ice(paths_per_pixel: &str) -> String {
    let ice = fs::read_to_string(repository("data/scenes/ice-cube-0.1-m.toml")).unwrap();
    ice.replace("width_px = 640", "width_px = 32")
        .replace("height_px = 480", "height_px = 24")
        .replace("= 192", &format!("= {paths_per_pixel}"))
}

/// A narrow view of one bow, every level of which takes some milliseconds.
fn least() -> String {
    let off = [
        "secondary_bow",
        "higher_orders",
        "supernumeraries",
        "sun_disc",
    ];
    let off = off.map(|effect| format!("{effect} = \"off\"\n")).concat();
    TINY.replace("width_px = 16", "width_px = 4")
        .replace("height_px = 12", "height_px = 3")
        .replace("fov_deg = 90.0", "fov_deg = 10.0")
        .replace("elevation_deg = 10.0", "elevation_deg = 22.0")
        .replace("voxel_m = 100.0", "voxel_m = 300.0")
        .replace("[effects]\n", &format!("[effects]\n{off}"))
}

/// Every stage by itself but the sweep, which takes long: each long enough to be asked to end while it works.
pub fn stages() -> Job {
    let photo = text(&repository("data/photos/pavilion.jpg")).to_owned();
    let photo: &'static str = photo.leak();
    let wide = TINY
        .replace("width_px = 16", "width_px = 640")
        .replace("height_px = 12", "height_px = 427");
    let air = TINY.replace(
        "[accuracy]\n",
        "[air]\nconstituents = [\"rayleigh\"]\n[accuracy]\nsky = \"single-scattering\"\n",
    );
    let air = air.replace("sky = \"off\"\n", "");
    let mut job = job(
        "stages",
        TINY,
        &[
            "drops --scene fine.toml -o fine.vdb -q",
            "drops --scene s.toml -o d.vdb -q",
            "airy -o a.exr -q",
            "atmosphere --scene air.toml -o air.exr -q",
            "scatter --scene s.toml --airy a.exr --accuracy reference -o fine.exr -q",
            "scatter --scene s.toml --airy a.exr -o t.exr -q",
            "scatter --scene wide.toml --airy a.exr -o w.exr -q",
            "render --scene wide.toml --drops d.vdb --table w.exr --tiles 1/2 -o 1.exr -q",
            "render --scene wide.toml --drops d.vdb --table w.exr --tiles 2/2 -o 2.exr -q",
            "merge 1.exr 2.exr -o wide.exr -q",
            "ice ice.toml -o ice.exr -q",
            "lee --spectrum 450,100,3 --size-px 60,50 -o lee.exr -q",
        ],
    );
    for command in [
        &["depth", photo, "--fov-deg", "60", "-o", "depth.exr", "-q"][..],
        &[
            "composite",
            photo,
            "--image",
            "wide.exr",
            "-o",
            "bow.png",
            "-q",
        ],
    ] {
        job.commands.push(command.to_vec());
    }
    job.scenes.extend([
        (
            "fine.toml",
            TINY.replace("voxel_m = 100.0", "voxel_m = 8.0"),
        ),
        ("air.toml", air),
        ("wide.toml", wide),
        ("ice.toml", ice("192")),
    ]);
    job
}
