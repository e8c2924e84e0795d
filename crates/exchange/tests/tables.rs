//! Tables survive the way through a file, and what is no table is refused by name.

#![allow(clippy::unwrap_used, reason = "tests stop at what they did not expect")]

mod common;

use std::fs;
use std::io::Cursor;
use std::path::Path;

use common::*;
use niji_exchange::AttributeValue;
use niji_exchange::Axis;
use niji_exchange::Channel;
use niji_exchange::Error;
use niji_exchange::PlainPart;
use niji_exchange::ScatteringTable;
use niji_exchange::TableFile;
use niji_exchange::TablePart;
use niji_exchange::contents;
use niji_exchange::read_plain;
use niji_exchange::read_provenance;
use niji_exchange::write_plain;
use niji_radiometry::Water;
use niji_radiometry::WavelengthGrid;

fn small_file() -> TableFile {
    let quantity = "airy".to_owned();
    let parts = vec![small_part("first"), small_part("second")];
    TableFile {
        quantity,
        parts,
        provenance: provenance(),
    }
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
fn numbers_of_headers_that_are_not_finite_are_rejected_by_name() {
    for value in [f64::NAN, f64::INFINITY] {
        let number = (
            "niji:splitThetaRad".to_owned(),
            AttributeValue::Number(value),
        );
        let error = changed(|file| file.parts[1].attributes.extend([number.clone()]));
        assert_eq!(
            error.unwrap_err().to_string(),
            format!(
                "found {value} in part \"second\", attribute \"niji:splitThetaRad\", expected a finite number"
            )
        );
    }
}

#[test]
fn an_only_part_needs_no_name() {
    let unnamed = |channel: &str| {
        let values = ndarray::array![[0.5, 1.0]];
        let name = channel.to_owned();
        PlainPart {
            name: String::new(),
            channels: vec![Channel { name, values }],
        }
    };
    let written = |parts: &[PlainPart]| {
        let mut bytes = Cursor::new(Vec::new());
        write_plain(parts, &mut bytes).map(|()| bytes.into_inner())
    };
    // What is read of it is written again, and has no name then either.
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("unnamed.exr");
    let bytes = written(&[unnamed("Y")]).unwrap();
    assert!(!bytes.windows(12).any(|it| it == b"name\0string\0"));
    fs::write(&path, &bytes).unwrap();
    let again = read_plain(&path).unwrap();
    assert_eq!(again, [unnamed("Y")]);
    assert_eq!(written(&again).unwrap(), bytes);
    let error = written(&[unnamed("Y"), unnamed("Z")]).unwrap_err();
    assert!(matches!(error, Error::Name { kind: "part", .. }), "{error}");
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
    let duplicate = error.unwrap_err();
    assert!(matches!(duplicate, Error::Duplicate { kind: "axis", .. }));
    assert!(
        duplicate
            .to_string()
            .starts_with("found two axes of the name"),
        "{duplicate}"
    );
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
    let nameless = (String::new(), AttributeValue::Number(1.0));
    let error = changed(|file| file.parts[0].attributes.extend([nameless.clone()])).unwrap_err();
    assert!(
        error.to_string().contains("as the name of an attribute"),
        "{error}"
    );
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
