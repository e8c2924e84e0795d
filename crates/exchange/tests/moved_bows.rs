//! Orders of flattened drops survive the way through a file, and what does not fit their table is refused.

#![allow(clippy::unwrap_used, reason = "tests stop at what they did not expect")]

mod common;

use common::*;
use ndarray::Array4;
use ndarray::s;
use niji_exchange::AttributeValue;
use niji_exchange::Axis;
use niji_exchange::BowShift;
use niji_exchange::Error;
use niji_exchange::FallingDrops;
use niji_exchange::MovedBows;
use niji_exchange::MovedOrder;
use niji_exchange::ScatteringTable;
use niji_exchange::TablePart;

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
