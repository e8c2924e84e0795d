//! Rays for `niji eval air`: by lists that are combined, or one a line from a CSV.

use std::path::Path;
use std::path::PathBuf;

use clap::Args;
use niji_atmosphere::ViewRay;

use crate::failure::Failure;

/// More rays than anybody reads.
const MAX_RAYS: usize = 1_000_000;
/// Columns of a file of rays, and the first columns of the result.
pub(super) const COLUMNS: [&str; 5] = [
    "height_m",
    "view_zenith_deg",
    "azimuth_deg",
    "distance_m",
    "sun_zenith_deg",
];

/// The rays to evaluate.
#[derive(Debug, Args)]
#[command(next_help_heading = "Rays (lists are combined, the last changes fastest)")]
#[group(id = "ray_flags", multiple = true)]
pub(super) struct RayFlags {
    /// Heights of the observer [default: 0].
    #[arg(
        long,
        value_name = "M,M,…",
        value_delimiter = ',',
        allow_negative_numbers = true
    )]
    height_m: Option<Vec<f64>>,
    /// Zenith angles of the view, 0 to 180.
    #[arg(
        long,
        value_name = "DEG,…",
        value_delimiter = ',',
        required_unless_present = "rays_file"
    )]
    view_zenith_deg: Option<Vec<f64>>,
    /// Azimuths of the view from that of the sun [default: 0].
    #[arg(
        long,
        value_name = "DEG,…",
        value_delimiter = ',',
        allow_negative_numbers = true
    )]
    azimuth_deg: Option<Vec<f64>>,
    /// Lengths of the ray; `inf` for all of it. The ground ends it in any case [default: inf].
    #[arg(long, value_name = "M,M,…", value_delimiter = ',')]
    distance_m: Option<Vec<f64>>,
    /// Zenith angles of the sun at the observer, 0 to 180.
    #[arg(
        long,
        value_name = "DEG,…",
        value_delimiter = ',',
        required_unless_present = "rays_file"
    )]
    sun_zenith_deg: Option<Vec<f64>>,
    /// A CSV with these five columns by name, in any order, others are ignored.
    #[arg(
        long,
        value_name = "CSV",
        conflicts_with_all = ["height_m", "view_zenith_deg", "azimuth_deg", "distance_m",
                              "sun_zenith_deg"]
    )]
    rays_file: Option<PathBuf>,
}

/// One ray as it was asked for, in the order of [`COLUMNS`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct AskedRay(pub(super) [f64; 5]);

impl AskedRay {
    pub(super) fn sun_zenith_deg(self) -> f64 {
        self.0[4]
    }

    pub(super) fn view_ray(self) -> ViewRay {
        let [
            height_m,
            view_zenith_deg,
            azimuth_deg,
            distance_m,
            sun_zenith_deg,
        ] = self.0;
        // By elevation: the cosine of 90 degrees would not be 0.
        let angles = [90.0 - view_zenith_deg, 90.0 - sun_zenith_deg, azimuth_deg];
        ViewRay::from_angles(height_m, angles.map(f64::to_radians), distance_m)
    }

    /// What is wrong with it, if anything.
    fn problem(self) -> Option<String> {
        let [
            height_m,
            view_zenith_deg,
            azimuth_deg,
            distance_m,
            sun_zenith_deg,
        ] = self.0;
        let checks = [
            (
                COLUMNS[0],
                height_m,
                (-1000.0..=1e9).contains(&height_m),
                "-1000 to 1e9",
            ),
            (
                COLUMNS[1],
                view_zenith_deg,
                (0.0..=180.0).contains(&view_zenith_deg),
                "0 to 180",
            ),
            (
                COLUMNS[2],
                azimuth_deg,
                (-360.0..=360.0).contains(&azimuth_deg),
                "-360 to 360",
            ),
            (COLUMNS[3], distance_m, distance_m >= 0.0, "at least 0"),
            (
                COLUMNS[4],
                sun_zenith_deg,
                (0.0..=180.0).contains(&sun_zenith_deg),
                "0 to 180",
            ),
        ];
        checks
            .into_iter()
            .find(|check| !check.2)
            .map(|(name, found, _, expected)| format!("{name} {found} found, expected {expected}"))
    }
}

impl RayFlags {
    /// The rays in their order.
    ///
    /// # Errors
    /// A number outside its range, too many rays, or a file that cannot be read.
    pub(super) fn rays(&self) -> Result<Vec<AskedRay>, Failure> {
        if let Some(path) = &self.rays_file {
            return read(path);
        }
        let list = |values: &Option<Vec<f64>>, usual: f64| values.clone().unwrap_or(vec![usual]);
        let lists = [
            list(&self.height_m, 0.0),
            list(&self.view_zenith_deg, 0.0),
            list(&self.azimuth_deg, 0.0),
            list(&self.distance_m, f64::INFINITY),
            list(&self.sun_zenith_deg, 0.0),
        ];
        let n_rays = lists
            .iter()
            .fold(1_usize, |n, list| n.saturating_mul(list.len()));
        if n_rays > MAX_RAYS {
            let message = format!("found {n_rays} rays, expected at most {MAX_RAYS}");
            return Err(Failure::Usage(message));
        }
        let mut rays = Vec::with_capacity(n_rays);
        for mut index in 0..n_rays {
            let mut values = [0.0; 5];
            for (value, list) in values.iter_mut().zip(&lists).rev() {
                *value = list[index % list.len()];
                index /= list.len();
            }
            rays.push(AskedRay(values));
        }
        match rays.iter().find_map(|ray| ray.problem()) {
            Some(problem) => Err(Failure::Usage(problem)),
            None => Ok(rays),
        }
    }
}

fn read(path: &Path) -> Result<Vec<AskedRay>, Failure> {
    let bad = |error: &dyn std::fmt::Display| Failure::bad_input(path, error);
    let mut reader = csv::ReaderBuilder::new()
        .comment(Some(b'#'))
        .trim(csv::Trim::All)
        .from_path(path)
        .map_err(|error| bad(&error))?;
    let headers = reader.headers().map_err(|error| bad(&error))?.clone();
    let mut places = [0; 5];
    for (place, column) in places.iter_mut().zip(COLUMNS) {
        *place = headers
            .iter()
            .position(|name| name == column)
            .ok_or_else(|| bad(&format!("no column {column} found, expected {COLUMNS:?}")))?;
    }
    let mut rays = Vec::new();
    for record in reader.records() {
        let record = record.map_err(|error| bad(&error))?;
        let line = record.position().map_or(0, csv::Position::line);
        let mut values = [0.0; 5];
        for (value, place) in values.iter_mut().zip(places) {
            let text = record.get(place).unwrap_or_default();
            *value = text
                .parse()
                .map_err(|_| bad(&format!("line {line}: {text:?} found, expected a number")))?;
        }
        let ray = AskedRay(values);
        if let Some(problem) = ray.problem() {
            return Err(bad(&format!("line {line}: {problem}")));
        }
        rays.push(ray);
        if rays.len() > MAX_RAYS {
            return Err(bad(&format!("more than {MAX_RAYS} rays found")));
        }
    }
    Ok(rays)
}
