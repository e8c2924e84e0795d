//! Tables survive the way through a file, and what is no table is refused by name.

#![allow(clippy::unwrap_used, reason = "tests stop at what they did not expect")]

use std::collections::BTreeMap;
use std::fs;
use std::io::Cursor;
use std::path::Path;

use ndarray::Array2;
use ndarray::Array4;
use ndarray::Array5;
use ndarray::s;
use niji_exchange::AttributeValue;
use niji_exchange::Attributes;
use niji_exchange::Axis;
use niji_exchange::AxisError;
use niji_exchange::BowShift;
use niji_exchange::Channel;
use niji_exchange::Error;
use niji_exchange::FallingDrops;
use niji_exchange::InterpolationError;
use niji_exchange::MovedBows;
use niji_exchange::MovedOrder;
use niji_exchange::Provenance;
use niji_exchange::RowUse;
use niji_exchange::ScatteringTable;
use niji_exchange::TableFile;
use niji_exchange::TablePart;
use niji_exchange::contents;
use niji_exchange::read_provenance;
use niji_radiometry::Water;
use niji_radiometry::WavelengthGrid;

fn provenance() -> Provenance {
    Provenance {
        tool: "niji scatter".to_owned(),
        version: "0.1.0".to_owned(),
        // Beyond Latin-1.
        settings: r#"{"scene":"虹","theory":"airy"}"#.to_owned(),
        inputs: BTreeMap::from([("airy".to_owned(), "0f".repeat(32))]),
    }
}

/// Values of many magnitudes, none of them round.
fn sample(index: usize) -> f32 {
    let phase = index as f32 * 0.7231;
    phase.sin() * 10.0_f32.powf(8.0 * (0.31 * phase).cos())
}

fn small_part(name: &str) -> TablePart {
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

fn small_file() -> TableFile {
    let quantity = "airy".to_owned();
    let parts = vec![small_part("first"), small_part("second")];
    TableFile {
        quantity,
        parts,
        provenance: provenance(),
    }
}

fn scattering_table() -> ScatteringTable {
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
        interpolation_error: Some(InterpolationError {
            theta: AxisError {
                rms: 1.25e-4,
                max: 5e-4,
            },
            ..InterpolationError::default()
        }),
    }
}

fn bytes(file: &TableFile) -> Vec<u8> {
    let mut cursor = Cursor::new(Vec::new());
    file.write(&mut cursor).unwrap();
    cursor.into_inner()
}

fn read(bytes: &[u8]) -> Result<TableFile, Error> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("table.exr");
    fs::write(&path, bytes).unwrap();
    TableFile::read(&path)
}

/// Writes a file after a change, or reads it back where the change can be written.
fn changed(change: impl Fn(&mut TableFile)) -> Result<TableFile, Error> {
    let mut file = small_file();
    change(&mut file);
    let mut cursor = Cursor::new(Vec::new());
    file.write(&mut cursor)?;
    read(&cursor.into_inner())
}

#[test]
fn salt_stands_in_the_header_where_there_is_any() {
    let file = |water| {
        let table = ScatteringTable {
            water,
            ..scattering_table()
        };
        table.to_file(provenance())
    };
    let names = |file: &TableFile| -> Vec<String> {
        let names = file.parts[0].attributes.keys();
        names
            .filter(|name| name.contains("Water") || name.contains("water"))
            .cloned()
            .collect()
    };
    let (pure, sea) = (file(Water::pure(15.0)), file(Water::of_the_sea(15.0)));
    assert_eq!(names(&pure), ["niji:waterTemperatureC"]);
    assert_eq!(
        names(&sea),
        ["niji:waterSalinityPerMille", "niji:waterTemperatureC"]
    );
    for (file, water) in [(pure, Water::pure(15.0)), (sea, Water::of_the_sea(15.0))] {
        let found = ScatteringTable::from_file(read(&bytes(&file)).unwrap()).unwrap();
        assert_eq!(found.water, water);
    }
}

#[test]
fn tables_come_back_bit_for_bit_with_axes_units_attributes_and_provenance() {
    let file = small_file();
    let found = read(&bytes(&file)).unwrap();
    assert_eq!(found, file);
    assert_eq!(
        bytes(&found),
        bytes(&file),
        "writing again gives the same bytes"
    );
    for (found, expected) in found.parts.iter().zip(&file.parts) {
        let bits = |part: &TablePart| part.channels[1].values.mapv(f32::to_bits);
        assert_eq!(bits(found), bits(expected));
        // -0 too.
        assert_eq!(found.row_axes[0].values[0].to_bits(), (-0.0_f64).to_bits());
    }
}

#[test]
fn a_scattering_table_comes_back_exactly_even_on_an_odd_wavelength_grid() {
    let table = scattering_table();
    let file = read(&bytes(&table.to_file(provenance()))).unwrap();
    assert_eq!(file.parts[0].channels.len(), 8);
    assert_eq!(file.provenance, provenance());
    assert_eq!(ScatteringTable::from_file(file).unwrap(), table);
}

/// A table of single sizes of flat drops, with numbers that need all of their digits.
fn table_of_flat_drops() -> ScatteringTable {
    let values = |scale: f32, n_theta: usize| {
        Array4::from_shape_fn((2, 3, 4, n_theta), |(j, r, l, t)| {
            scale * sample(((j * 3 + r) * 4 + l) * n_theta + t).abs()
        })
    };
    let table = scattering_table();
    // Every third angle, every fifth.
    let angles = |order: u32| {
        table
            .theta_rad
            .iter()
            .copied()
            .step_by(2 * order as usize - 1)
    };
    let order = |order: u32| MovedOrder {
        order,
        shifts: [0.1, 1.0 / 3.0, 7e-9, 5e15]
            .map(|unit| BowShift {
                coefficients_rad: [1.0, -0.0, -2.0 / 7.0, f64::MIN_POSITIVE, f64::from(order)]
                    .map(|coefficient| unit * coefficient),
            })
            .into(),
        theta_rad: angles(order).collect(),
        // The smallest stay.
        values: values(order as f32 / 10.0, angles(order).count())
            .slice(s![.., 1.., .., ..])
            .to_owned(),
    };
    let drops = [1e-300, 0.1 + 0.2].map(|eccentricity| FallingDrops {
        eccentricity,
        eccentricity_sd: eccentricity / 3.0,
        mean_sin2: 0.0353,
        mean_sin4: 1.0 / 490.0,
    });
    ScatteringTable {
        effective_variance: vec![0.0],
        values: values(1.0, 31).insert_axis(ndarray::Axis(2)),
        moved: Some(MovedBows {
            drops: drops.into(),
            orders: vec![order(2), order(3)],
        }),
        ..table.clone()
    }
}

#[test]
fn a_table_of_flat_drops_comes_back_bit_for_bit_with_its_orders_shifts_and_drops() {
    let table = table_of_flat_drops();
    let file = read(&bytes(&table.to_file(provenance()))).unwrap();
    let found = ScatteringTable::from_file(file).unwrap();
    assert_eq!(found, table);
    // -0 too.
    let coefficients = |table: &ScatteringTable| -> Vec<u64> {
        let orders = table.moved.iter().flat_map(|moved| &moved.orders);
        let shifts = orders.flat_map(|order| &order.shifts);
        shifts
            .flat_map(|shift| shift.coefficients_rad.map(f64::to_bits))
            .collect()
    };
    assert_eq!(coefficients(&found), coefficients(&table));
    assert_eq!(coefficients(&found).len(), 2 * 4 * 5);
}

#[test]
fn moved_orders_are_parts_of_their_own_that_any_reader_understands() {
    let table = table_of_flat_drops();
    let moved = table.moved.as_ref().unwrap();
    let file = read(&bytes(&table.to_file(provenance()))).unwrap();
    let names: Vec<&str> = file.parts.iter().map(|part| part.name.as_str()).collect();
    assert_eq!(names, ["scattering", "moved.2", "moved.3"]);
    let part = file.part("moved.3").unwrap();
    assert_eq!(part.column_axis.values, moved.orders[1].theta_rad);
    assert_eq!(part.column_axis.values.len(), 7);
    let radii = &file.parts[0].row_axes[0].values;
    assert_eq!(part.row_axes.len(), 1);
    assert_eq!(part.row_axes[0].values, radii[1..]);
    assert_eq!(part.text("niji:theory").unwrap(), "airy");
    let numbers = |name: &str| -> Vec<f64> {
        let texts = part.text(name).unwrap().split(' ');
        texts.map(|text| text.parse().unwrap()).collect()
    };
    let channel = &part.channels[5];
    let wavelength = channel.name.strip_prefix("s.").unwrap();
    assert_eq!(
        channel.values,
        moved.orders[1].values.slice(s![0, .., 1, ..])
    );
    assert_eq!(
        numbers(&format!("niji:bowShiftRad.{wavelength}")),
        moved.orders[1].shifts[1].coefficients_rad
    );
    let eccentricities: Vec<f64> = moved.drops.iter().map(|drops| drops.eccentricity).collect();
    assert_eq!(numbers("niji:eccentricity"), eccentricities);
}

#[test]
fn a_table_of_spheres_has_no_further_part() {
    let mut file = scattering_table().to_file(provenance());
    assert_eq!(file.parts.len(), 1);
    // What others put beside it is no order.
    file.parts.push(small_part("notes"));
    let found = ScatteringTable::from_file(read(&bytes(&file)).unwrap()).unwrap();
    assert_eq!(found, scattering_table());
}

/// Why a table of flat drops is refused after a change.
fn refused_moved(change: impl Fn(&mut Vec<TablePart>)) -> Error {
    let mut file = table_of_flat_drops().to_file(provenance());
    change(&mut file.parts);
    ScatteringTable::from_file(file).unwrap_err()
}

#[test]
fn moved_orders_with_other_axes_or_values_are_refused() {
    type Change = fn(&mut TablePart);
    let missing_axes: [(&str, Change); 3] = [
        ("theta of scattering in moved.3", |part| {
            part.column_axis.values[6] += 1e-9;
        }),
        ("effective_radius of scattering in moved.3", |part| {
            part.row_axes[0].values[0] = 9.0;
        }),
        ("effective_radius of scattering in moved.3", |part| {
            part.row_axes[0].values.clear();
        }),
    ];
    for (expected, change) in missing_axes {
        let error = refused_moved(|parts| change(&mut parts[2]));
        let Error::Missing { kind: "axis", name } = error else {
            panic!("{error}");
        };
        assert_eq!(name, expected);
    }
    let more = Axis::new("effective_variance", "-", vec![0.0]);
    let error = refused_moved(|parts| parts[1].row_axes.push(more.clone()));
    assert_eq!(
        error.to_string(),
        r#"found 3 axes in part "moved.2", expected 2"#
    );
    let error = refused_moved(|parts| drop(parts[2].channels.pop()));
    assert!(
        matches!(
            error,
            Error::Missing {
                kind: "channel",
                ..
            }
        ),
        "{error}"
    );
    let error = refused_moved(|parts| parts[1].channels[3].values[[1, 2]] = -1e-9);
    assert!(
        matches!(error, Error::Negative { x: 2, y: 1, .. }),
        "{error}"
    );
}

#[test]
fn moved_orders_with_missing_short_or_senseless_lists_are_refused() {
    let wavelength = "niji:bowShiftRad.392,783505nm";
    let refused = |name: &str, value: Option<&str>| {
        let error = refused_moved(|parts| {
            let attributes = &mut parts[2].attributes;
            assert!(attributes.remove(name).is_some(), "{name}");
            let value = value.map(|text| (name.to_owned(), AttributeValue::Text(text.to_owned())));
            attributes.extend(value);
        });
        error.to_string()
    };
    for name in [
        wavelength,
        "niji:eccentricity",
        "niji:meanSquaredSineOfTilt",
    ] {
        let text = r#"in part "moved.3": this file was not written by niji, or by another version"#;
        let missing = format!("found no text attribute {name:?} {text}");
        assert_eq!(refused(name, None), missing);
        let no_numbers = format!("found no numeric attribute {name:?} {text}");
        for bad in ["", "0 1 x", "0 1 NaN", "0 x 0 0", "0 0 inf 0 0 0", "0  1"] {
            assert_eq!(refused(name, Some(bad)), no_numbers, "{bad}");
        }
    }
    assert_eq!(
        refused(wavelength, Some("1 2 3 4")),
        format!(r#"found 4 numbers in attribute "{wavelength}" of part "moved.3", expected 5"#)
    );
    assert_eq!(
        refused("niji:eccentricitySd", Some("0 0 0 0")),
        r#"found 4 numbers in attribute "niji:eccentricitySd" of part "moved.3", expected 2"#
    );
    for bad in ["-0.1", "1.1"] {
        assert_eq!(
            refused("niji:eccentricity", Some(&format!("0 {bad}"))),
            format!(r#"found {bad} on axis "niji:eccentricity", expected values from 0 to 1"#)
        );
    }
    assert_eq!(
        refused("niji:meanSquaredSineOfTilt", Some("0 0")),
        r#"found no attribute "niji:meanSquaredSineOfTilt of moved.2 in moved.3""#
    );
}

#[test]
fn every_order_stands_once_and_in_its_place() {
    let renamed = |name: &str| refused_moved(|parts| parts[2].name = name.to_owned()).to_string();
    let expected = "expected ascending finite numbers";
    for bad in [
        "moved.",
        "moved.x",
        "moved.03",
        "moved.+3",
        "moved.-3",
        "moved.5000000000",
    ] {
        assert_eq!(
            renamed(bad),
            format!(r#"axis "order": found part "{bad}", {expected}"#)
        );
    }
    let twice = format!(r#"axis "order": found 2 after 2, {expected}"#);
    assert_eq!(renamed("moved.2"), twice);
    let error = refused_moved(|parts| parts[1..].reverse());
    let descending = format!(r#"axis "order": found 2 after 3, {expected}"#);
    assert_eq!(error.to_string(), descending);
}

#[test]
fn orders_move_in_tables_of_single_sizes_alone() {
    let error = refused_moved(|parts| parts[0].row_axes[1].values = vec![0.1]);
    assert!(matches!(error, Error::Range { found: 0.1, .. }), "{error}");
}

#[test]
#[should_panic(expected = "shifts are known for each wavelength")]
fn a_table_with_too_few_shifts_is_not_written() {
    let mut table = table_of_flat_drops();
    table.moved.as_mut().unwrap().orders[1].shifts.truncate(3);
    drop(table.to_file(provenance()));
}

/// Rows once went on by the flattening of the drops.
#[test]
fn a_fourth_axis_of_an_older_file_is_refused_by_name() {
    let mut file = scattering_table().to_file(provenance());
    let flattening = Axis::new("flattening", "-", vec![0.0]);
    file.parts[0].row_axes.push(flattening);
    let error = ScatteringTable::from_file(read(&bytes(&file)).unwrap()).unwrap_err();
    assert_eq!(
        error.to_string(),
        r#"found 4 axes in part "scattering", expected 3"#
    );
}

#[test]
fn a_scattering_table_is_never_renormalised() {
    let mut table = scattering_table();
    table.values *= 7.0;
    let file = read(&bytes(&table.to_file(provenance()))).unwrap();
    assert_eq!(
        ScatteringTable::from_file(file).unwrap().values,
        table.values
    );
}

#[test]
fn channels_are_named_by_polarization_and_wavelength() {
    let mut table = scattering_table();
    table.wavelengths = WavelengthGrid::new(547.5, 2.5, 4).unwrap();
    let file = table.to_file(provenance());
    let names: Vec<&str> = file.parts[0]
        .channels
        .iter()
        .map(|c| c.name.as_str())
        .collect();
    assert_eq!(names[..4], ["s.547,5nm", "s.550nm", "s.552,5nm", "s.555nm"]);
    assert_eq!(names[4], "p.547,5nm");
}

#[test]
fn another_quantity_is_refused_by_both_names() {
    let error = ScatteringTable::from_file(small_file()).unwrap_err();
    assert_eq!(
        error.to_string(),
        r#"found a table of "airy", expected "scattering""#
    );
}

#[test]
fn scattering_tables_with_other_axes_units_ranges_or_signs_are_refused() {
    type Change = fn(&mut TablePart);
    let refused = |change: Change| {
        let mut file = scattering_table().to_file(provenance());
        change(&mut file.parts[0]);
        ScatteringTable::from_file(file).unwrap_err()
    };
    let error = refused(|part| part.row_axes.reverse());
    assert!(
        matches!(error, Error::Missing { kind: "axis", .. }),
        "{error}"
    );
    let error = refused(|part| part.row_axes[0].unit = "m".to_owned());
    assert!(
        matches!(error, Error::Unit { expected: "um", .. }),
        "{error}"
    );
    let error = refused(|part| part.column_axis.values[30] = 180.0);
    assert!(
        matches!(error, Error::Range { found: 180.0, .. }),
        "{error}"
    );
    let error = refused(|part| part.row_axes[1].values[1] = 0.6);
    assert!(matches!(error, Error::Range { .. }), "{error}");
    let error = refused(|part| part.channels[3].values[[1, 2]] = -1e-9);
    assert!(
        matches!(error, Error::Negative { x: 2, y: 1, .. }),
        "{error}"
    );
    let error = refused(|part| part.channels[5].values[[0, 7]] = f32::NAN);
    assert!(
        matches!(error, Error::NotFinite { x: 7, y: 0, .. }),
        "{error}"
    );
    let error = refused(|part| drop(part.channels.pop()));
    assert!(
        matches!(
            error,
            Error::Missing {
                kind: "channel",
                ..
            }
        ),
        "{error}"
    );
    let error = refused(|part| drop(part.attributes.remove("niji:theory")));
    assert!(
        matches!(error, Error::Attribute { kind: "text", .. }),
        "{error}"
    );
}

#[test]
fn values_that_are_not_finite_are_rejected_with_part_channel_and_pixel() {
    for value in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let error = changed(|file| file.parts[1].channels[1].values[[4, 3]] = value).unwrap_err();
        let Error::NotFinite {
            part,
            channel,
            x: 3,
            y: 4,
            value: found,
        } = error
        else {
            panic!("{error}");
        };
        assert_eq!((part.as_str(), channel.as_str()), ("second", "f.prime"));
        assert_eq!(found.to_bits(), value.to_bits());
    }
}

#[test]
fn axes_that_are_not_ascending_numbers_are_refused() {
    for values in [
        vec![1.0, 1.0],
        vec![2.0, 1.0],
        vec![0.0, f64::NAN],
        vec![0.0, f64::INFINITY],
    ] {
        let error = changed(|file| file.parts[0].row_axes[1].values.clone_from(&values));
        assert!(matches!(error, Err(Error::Axis { .. })), "{values:?}");
    }
    let error = changed(|file| file.parts[0].row_axes[1].values.clear());
    assert!(matches!(error, Err(Error::Axis { .. })));
    let error = changed(|file| file.parts[0].row_axes[1].name = "height".to_owned());
    assert!(matches!(error, Err(Error::Duplicate { kind: "axis", .. })));
    let error = changed(|file| file.parts[0].row_axes[1].name = "a,b".to_owned());
    assert!(matches!(error, Err(Error::Axis { .. })));
}

#[test]
fn axes_and_pixels_of_different_sizes_are_refused_with_both_sizes() {
    let error = changed(|file| _ = file.parts[0].row_axes[0].values.pop()).unwrap_err();
    assert!(
        matches!(
            error,
            Error::Shape {
                found: 6,
                expected: 4,
                ..
            }
        ),
        "{error}"
    );
    let error = changed(|file| _ = file.parts[0].column_axis.values.pop()).unwrap_err();
    assert!(
        matches!(
            error,
            Error::Shape {
                found: 5,
                expected: 4,
                ..
            }
        ),
        "{error}"
    );
}

#[test]
fn names_that_the_format_cannot_hold_are_refused() {
    for name in [String::new(), "a\0b".to_owned(), "x".repeat(256)] {
        let error = changed(|file| file.parts[0].name.clone_from(&name));
        assert!(matches!(error, Err(Error::Name { kind: "part", .. })));
        let error = changed(|file| file.parts[0].channels[0].name.clone_from(&name));
        assert!(matches!(
            error,
            Err(Error::Name {
                kind: "channel",
                ..
            })
        ));
    }
    let error = changed(|file| file.parts[0].name = "second".to_owned());
    assert!(matches!(error, Err(Error::Duplicate { kind: "part", .. })));
    let error = changed(|file| file.parts[0].channels[0].name = "f.prime".to_owned());
    assert!(matches!(
        error,
        Err(Error::Duplicate {
            kind: "channel",
            ..
        })
    ));
    let error = changed(|file| file.parts[0].channels.clear());
    assert!(matches!(error, Err(Error::Empty { .. })));
    // Names that belong to the format itself.
    let standard = ("compression".to_owned(), AttributeValue::Number(1.0));
    let error = changed(|file| file.parts[0].attributes.extend([standard.clone()]));
    assert!(matches!(error, Err(Error::Unwritable(_))));
    // Up to 255 bytes in any alphabet are fine.
    let long = "虹".repeat(80);
    let found = changed(|file| file.parts[0].name.clone_from(&long)).unwrap();
    assert_eq!(found.parts[0].name, long);
}

#[test]
fn missing_files_folders_and_other_files_are_errors() {
    let folder = tempfile::tempdir().unwrap();
    let missing = TableFile::read(&folder.path().join("none.exr")).unwrap_err();
    assert!(matches!(missing, Error::Io(error) if error.kind() == std::io::ErrorKind::NotFound));
    assert!(TableFile::read(folder.path()).is_err());
    assert!(matches!(read(b""), Err(Error::Damaged(_))));
    assert!(matches!(read(b"P6 1 1 255 abc"), Err(Error::Damaged(_))));
}

#[test]
fn the_header_alone_gives_the_provenance_and_a_short_file_is_noticed() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("table.exr");
    let bytes = bytes(&small_file());
    fs::write(&path, &bytes).unwrap();
    assert_eq!(read_provenance(&path).unwrap(), Some(provenance()));
    fs::write(&path, &bytes[..bytes.len() - 2]).unwrap();
    assert!(matches!(
        read_provenance(&path),
        Err(Error::TooLarge { .. })
    ));
}

#[test]
fn contents_name_parts_channels_and_their_ranges() {
    let folder = tempfile::tempdir().unwrap();
    let path: &Path = &folder.path().join("table.exr");
    let mut file = small_file();
    file.parts[0].channels[0].values.fill(2.5);
    file.parts[0].channels[0].values[[0, 0]] = -1.0;
    fs::write(path, bytes(&file)).unwrap();
    let found = contents(path).unwrap();
    assert_eq!((found.len(), found[0].width, found[0].height), (2, 5, 6));
    let channel = &found[0].channels[0];
    assert_eq!(
        (channel.name.as_str(), channel.min, channel.max),
        ("f", -1.0, 2.5)
    );
    assert!((channel.mean - (29.0 * 2.5 - 1.0) / 30.0).abs() < 1e-12);
}
