//! Tables for tests, and their way through a file.

#![allow(
    clippy::unwrap_used,
    dead_code,
    reason = "tests stop at what they did not expect, and each takes what it needs"
)]

pub(crate) mod air;

use std::collections::BTreeMap;
use std::fs;
use std::io::Cursor;

use ndarray::Array2;
use ndarray::Array5;
use niji_exchange::AttributeValue;
use niji_exchange::Attributes;
use niji_exchange::Axis;
use niji_exchange::AxisError;
use niji_exchange::Channel;
use niji_exchange::Error;
use niji_exchange::InterpolationError;
use niji_exchange::Provenance;
use niji_exchange::RowUse;
use niji_exchange::ScatteringTable;
use niji_exchange::TableFile;
use niji_exchange::TablePart;
use niji_radiometry::Water;
use niji_radiometry::WavelengthGrid;

pub(crate) fn provenance() -> Provenance {
    Provenance {
        tool: "niji scatter".to_owned(),
        version: "0.1.0".to_owned(),
        // Beyond Latin-1.
        settings: r#"{"scene":"虹","theory":"airy"}"#.to_owned(),
        inputs: BTreeMap::from([("airy".to_owned(), "0f".repeat(32))]),
    }
}

/// Values of many magnitudes, none of them round.
pub(crate) fn sample(index: usize) -> f32 {
    let phase = index as f32 * 0.7231;
    phase.sin() * 10.0_f32.powf(8.0 * (0.31 * phase).cos())
}

pub(crate) fn small_part(name: &str) -> TablePart {
    TablePart {
        name: name.to_owned(),
        column_axis: Axis::new("z", "-", vec![-3.0, 0.1, 1.0 / 3.0, 2e300, f64::MAX]),
        row_axes: vec![
            Axis::new("height", "m", vec![-0.0, f64::MIN_POSITIVE, 1e5]),
            Axis::new("mu", "-", vec![-1.0, 0.5]),
        ],
        channels: ["f", "f.prime"]
            .map(|name| Channel {
                name: name.to_owned(),
                values: Array2::from_shape_fn((6, 5), |(y, x)| sample(5 * y + x)),
            })
            .into(),
        attributes: Attributes::from([
            (
                "niji:meaning".to_owned(),
                AttributeValue::Text("Süßwasser, a=b".to_owned()),
            ),
            (
                "niji:temperatureC".to_owned(),
                AttributeValue::Number(0.1 + 0.2),
            ),
        ]),
    }
}

pub(crate) fn scattering_table() -> ScatteringTable {
    let wavelengths = WavelengthGrid::new(381.0 / 0.97, 10.0 / 3.0, 4).unwrap();
    let theta_rad: Vec<f64> = (0..=30)
        .map(|i| f64::from(i) * std::f64::consts::PI / 30.0)
        .collect();
    ScatteringTable {
        theory: "airy".to_owned(),
        orders: "2,3".to_owned(),
        wavelengths,
        values: Array5::from_shape_fn((2, 3, 2, 4, 31), |(j, r, v, l, t)| {
            sample(((((j * 3 + r) * 2 + v) * 4) + l) * 31 + t).abs()
        }),
        theta_rad,
        effective_radius_um: vec![10.0, 100.0, 1000.0],
        effective_variance: vec![0.0, 0.1],
        moved: None,
        row_use: RowUse::Laws,
        relative_error: 5e-3,
        sun_disc_diameter_rad: 0.533_f64.to_radians(),
        split_theta_rad: 2.2,
        forward_fraction_left_out: 0.5,
        water: Water::pure(20.0),
        phase_functions: None,
        interpolation_error: Some(InterpolationError {
            theta: AxisError {
                rms: 1.25e-4,
                max: 5e-4,
            },
            ..InterpolationError::default()
        }),
    }
}

pub(crate) fn bytes(file: &TableFile) -> Vec<u8> {
    let mut cursor = Cursor::new(Vec::new());
    file.write(&mut cursor).unwrap();
    cursor.into_inner()
}

pub(crate) fn read(bytes: &[u8]) -> Result<TableFile, Error> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("table.exr");
    fs::write(&path, bytes).unwrap();
    TableFile::read(&path)
}
