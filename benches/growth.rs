//! How `niji run` grows: seconds of its stages with pixels, voxels, wavelengths, sizes and threads.
//!
//! A shower with air, sky and gusts (`benches/scenes/rain-cell.toml`, at 240 x 180 pixels), of which one number at a time
//! changes. What else it takes is chosen for each run, as a person has it. Runs are cold, each a process of its own; of
//! several each figure is the least.
//!
//! T ~ x^p between the two largest x,   T(n) = T(1) (s + (1 - s)/n)
//! The first for what grows: `p` is 1 where it is linear. The second for threads: `s`, which they do not share, from one
//! and all of them (Amdahl's law); what it says of more, up to 64, is no measurement.
//!
//!     cargo bench --bench growth -- [--runs N] [-o FOLDER]
//!
//! Writes `growth.csv` and `growth.svg` into the folder, `data/measurements` if none is named.

#[path = "support/processor_time.rs"]
mod processor_time;
#[path = "support/whole_run.rs"]
mod whole_run;

use std::fs;
use std::path::Path;
use std::path::PathBuf;

use niji_exchange::ScatteringTable;
use niji_exchange::TableFile;
use plotters::prelude::*;
use toml_edit::DocumentMut;
use toml_edit::Item;
use toml_edit::value;

use whole_run::MEASURE;
use whole_run::Result;
use whole_run::WholeRun;
use whole_run::circumstances;
use whole_run::measured_here;
use whole_run::whole_run;

const SCENE: &str = include_str!("scenes/rain-cell.toml");
const STAGES: [&str; 4] = ["drops", "scatter", "atmosphere", "render"];
const N_RUNS: usize = 2;
/// Threads up to which the law is continued.
const MOST_THREADS: u32 = 64;
/// First and last wavelength.
const BAND_NM: [f64; 2] = [380.0, 780.0];

const PIXELS: [[i64; 2]; 5] = [[60, 45], [120, 90], [240, 180], [480, 360], [960, 720]];
const VOXELS_M: [f64; 4] = [120.0, 60.0, 30.0, 15.0];
const WAVELENGTHS: [i64; 4] = [11, 21, 41, 81];
const TABLE_ERRORS: [f64; 3] = [0.03, 0.01, 0.003];

/// What grows.
struct Line {
    name: &'static str,
    /// Stages whose growth is told and drawn; none of threads, which serve all.
    drawn: &'static [&'static str],
    points: Vec<Point>,
}

/// A scene, and what it took.
struct Point {
    /// How many there are of what grows.
    x: f64,
    least: WholeRun,
}

fn main() -> Result<()> {
    // Cargo adds `--bench`.
    let mut arguments: Vec<String> = std::env::args().skip(1).collect();
    arguments.retain(|it| it != "--bench");
    if arguments.first().is_some_and(|it| it == MEASURE) {
        return measured_here(&arguments[1..]);
    }
    let mut n_runs = N_RUNS;
    let mut folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/measurements");
    let mut arguments = arguments.into_iter();
    while let Some(argument) = arguments.next() {
        match (argument.as_str(), arguments.next()) {
            ("--runs", Some(n)) => n_runs = n.parse()?,
            ("-o", Some(path)) => folder = PathBuf::from(path),
            _ => return Err("expected --runs and a number, or -o and a folder".into()),
        }
    }
    let about = circumstances();
    println!("{about}");
    let lines = [
        pixels(n_runs)?,
        voxels(n_runs)?,
        wavelengths(n_runs)?,
        sizes(n_runs)?,
        threads(n_runs)?,
    ];
    for line in &lines[..4] {
        for stage in line.drawn {
            println!("{:12} {stage:8} {:.2}", line.name, exponent(line, stage));
        }
    }
    let shared = shared_by_threads(&lines[4]);
    println!("threads share {:.0} % of the time", 100.0 * shared);
    fs::write(folder.join("growth.csv"), table(&lines, shared)?)?;
    fs::write(folder.join("growth.svg"), plot(&lines[..4], &about)?)?;
    Ok(())
}

fn pixels(n_runs: usize) -> Result<Line> {
    let points = PIXELS.map(|[width, height]| {
        let scene = scene(|scene| {
            scene["camera"]["width_px"] = value(width);
            scene["camera"]["height_px"] = value(height);
        })?;
        point(&scene, &[], n_runs, |_| Ok((width * height) as f64))
    });
    Line::of("pixels", &["render"], points)
}

fn voxels(n_runs: usize) -> Result<Line> {
    let points = VOXELS_M.map(|voxel_m| {
        let scene = scene(|scene| scene["drops"]["voxel_m"] = value(voxel_m))?;
        // Those of the shower's box are as many, but for its borders.
        point(&scene, &[], n_runs, |_| Ok((VOXELS_M[0] / voxel_m).powi(3)))
    });
    Line::of("voxels", &["drops", "render"], points)
}

fn wavelengths(n_runs: usize) -> Result<Line> {
    let points = WAVELENGTHS.map(|n| {
        let scene = scene(|scene| {
            let [first, last] = BAND_NM;
            scene["spectrum"] = Item::Table(toml_edit::Table::new());
            scene["spectrum"]["first_nm"] = value(first);
            scene["spectrum"]["step_nm"] = value((last - first) / (n - 1) as f64);
            scene["spectrum"]["n_wavelengths"] = value(n);
        })?;
        point(&scene, &[], n_runs, |_| Ok(n as f64))
    });
    Line::of("wavelengths", &["scatter", "render"], points)
}

fn sizes(n_runs: usize) -> Result<Line> {
    let points = TABLE_ERRORS.map(|error| {
        let scene = scene(|scene| scene["accuracy"]["table_relative_error"] = value(error))?;
        point(&scene, &[], n_runs, |out| {
            let table = TableFile::read(&out.join("scatter.exr"))?;
            Ok(ScatteringTable::from_file(table)?.effective_radius_um.len() as f64)
        })
    });
    Line::of("sizes", &["scatter"], points)
}

fn threads(n_runs: usize) -> Result<Line> {
    let all = std::thread::available_parallelism()?.get();
    let points = [1, all].map(|n| {
        let flags = ["--threads".to_owned(), n.to_string()];
        let flags = flags.each_ref().map(String::as_str);
        point(&scene(|_| ())?, &flags, n_runs, |_| Ok(n as f64))
    });
    Line::of("threads", &[], points)
}

impl Line {
    fn of<const N: usize>(
        name: &'static str,
        drawn: &'static [&'static str],
        points: [Result<Point>; N],
    ) -> Result<Self> {
        Ok(Self {
            name,
            drawn,
            points: points.into_iter().collect::<Result<_>>()?,
        })
    }
}

/// The scene with a change.
fn scene(change: impl FnOnce(&mut DocumentMut)) -> Result<String> {
    let mut scene: DocumentMut = SCENE.parse()?;
    scene["camera"]["width_px"] = value(240);
    scene["camera"]["height_px"] = value(180);
    change(&mut scene);
    Ok(scene.to_string())
}

/// The least of some runs of a scene, and what it has of what grows by the folder of one.
fn point(
    scene: &str,
    flags: &[&str],
    n_runs: usize,
    x: impl Fn(&Path) -> Result<f64>,
) -> Result<Point> {
    let mut point: Option<Point> = None;
    for _ in 0..n_runs {
        let folder = tempfile::tempdir()?;
        let file = folder.path().join("scene.toml");
        fs::write(&file, scene)?;
        let out = folder.path().join("out");
        let run = whole_run(Path::new(env!("CARGO_BIN_EXE_niji")), &file, &out, flags)?;
        point = Some(Point {
            x: x(&out)?,
            least: match point {
                Some(before) => run.least(&before.least),
                None => run,
            },
        });
    }
    point.ok_or_else(|| "--runs: expected a number from 1".into())
}

/// p of a stage.
fn exponent(line: &Line, stage: &str) -> f64 {
    let [.., before, last] = line.points.as_slice() else {
        return f64::NAN;
    };
    let seconds = |point: &Point| point.least.stage_s(stage);
    (seconds(last) / seconds(before)).ln() / (last.x / before.x).ln()
}

/// 1 - s.
fn shared_by_threads(line: &Line) -> f64 {
    let [one, .., all] = line.points.as_slice() else {
        return f64::NAN;
    };
    (1.0 - all.least.wall_s / one.least.wall_s) / (1.0 - 1.0 / all.x)
}

fn table(lines: &[Line], shared: f64) -> Result<Vec<u8>> {
    let mut table = csv::Writer::from_writer(Vec::new());
    let heads = [
        "grows",
        "x",
        "is_measured",
        "wall_s",
        "processor_s",
        "peak_mb",
    ];
    let stages = STAGES.map(|stage| format!("{stage}_s"));
    table.write_record(heads.map(str::to_owned).iter().chain(&stages))?;
    for line in lines {
        for point in &line.points {
            let run = &point.least;
            let mut row = vec![line.name.to_owned(), point.x.to_string(), "true".to_owned()];
            row.extend([run.wall_s, run.processor_s].map(|it| format!("{it:.2}")));
            row.push(format!("{:.0}", run.peak_bytes / 1e6));
            row.extend(STAGES.map(|stage| format!("{:.3}", run.stage_s(stage))));
            table.write_record(row)?;
        }
    }
    let threads = &lines[lines.len() - 1];
    let (one, all) = (
        &threads.points[0],
        &threads.points[threads.points.len() - 1],
    );
    let more = (1..=MOST_THREADS.ilog2()).map(|power| f64::from(1_u32 << power));
    for n in more.filter(|n| *n > all.x) {
        let wall_s = one.least.wall_s * (1.0 - shared + shared / n);
        let mut row = vec![threads.name.to_owned(), n.to_string(), "false".to_owned()];
        row.push(format!("{wall_s:.2}"));
        row.resize(heads.len() + STAGES.len(), String::new());
        table.write_record(row)?;
    }
    Ok(table.into_inner()?)
}

/// Seconds over how many times the least there is of what grows.
fn plot(lines: &[Line], about: &str) -> Result<String> {
    let curves: Vec<(String, Vec<(f64, f64)>)> = lines
        .iter()
        .flat_map(|line| {
            line.drawn.iter().map(|stage| {
                let points = line.points.iter();
                let points = points.map(|it| (it.x / line.points[0].x, it.least.stage_s(stage)));
                let label = format!("{} ({stage}) ^ {:.2}", line.name, exponent(line, stage));
                (label, points.collect())
            })
        })
        .collect();
    let all = || curves.iter().flat_map(|(_, points)| points);
    let right = all().fold(1.0, |most: f64, it| most.max(it.0));
    let top = all().fold(0.0, |most: f64, it| most.max(it.1));
    let bottom = all().fold(top, |least: f64, it| least.min(it.1));
    let mut svg = String::new();
    {
        let area = SVGBackend::with_string(&mut svg, (960, 600)).into_drawing_area();
        area.fill(&WHITE)?;
        let mut chart = ChartBuilder::on(&area)
            .caption(format!("Seconds of stages: {about}"), ("sans-serif", 16))
            .margin(12)
            .x_label_area_size(44)
            .y_label_area_size(80)
            .build_cartesian_2d(
                (0.9..1.1 * right).log_scale(),
                (0.8 * bottom..1.3 * top).log_scale(),
            )?;
        chart
            .configure_mesh()
            .x_desc("times the least")
            .y_desc("s")
            .y_label_formatter(&|value| format!("{value}"))
            .light_line_style(RGBColor(236, 236, 236))
            .draw()?;
        for (index, (label, points)) in curves.into_iter().enumerate() {
            let color = Palette99::pick(index).to_rgba();
            let circles = points
                .iter()
                .map(|point| Circle::new(*point, 3, color.filled()));
            chart.draw_series(circles.collect::<Vec<_>>())?;
            chart
                .draw_series(LineSeries::new(points, color.stroke_width(2)))?
                .label(label)
                .legend(move |(x, y)| PathElement::new([(x, y), (x + 18, y)], color));
        }
        chart
            .configure_series_labels()
            .position(SeriesLabelPosition::LowerRight)
            .background_style(WHITE.mix(0.85))
            .border_style(RGBColor(200, 200, 200))
            .draw()?;
        area.present()?;
    }
    Ok(svg)
}
