//! Diffuse light survives the way through a file, and what is no light is refused.

#![allow(clippy::unwrap_used, reason = "tests stop at what they did not expect")]

mod common;

use std::f64::consts::PI;
use std::io::Write;

use common::air::MAX_DEGREE;
use common::air::N_WAVELENGTHS;
use common::air::air_table;
use common::air::beam_light;
use niji_exchange::AtmosphereTable;
use niji_exchange::DiffuseView;
use niji_exchange::Error;
use niji_exchange::Provenance;
use niji_exchange::TableFile;
use niji_exchange::harmonics;
use niji_exchange::moment_index;
use niji_exchange::n_moments;

fn through_a_file(file: &TableFile) -> Result<AtmosphereTable, Error> {
    let mut bytes = std::io::Cursor::new(Vec::new());
    file.write(&mut bytes)?;
    let mut on_disk = tempfile::NamedTempFile::new().unwrap();
    on_disk.write_all(bytes.get_ref()).unwrap();
    AtmosphereTable::from_file(&TableFile::read(on_disk.path())?)
}

#[test]
fn diffuse_light_comes_back_bit_by_bit() {
    let written = air_table();
    let read = through_a_file(&written.to_file(Provenance::default())).unwrap();
    assert_eq!(read.diffuse, written.diffuse);
}

#[test]
fn a_table_without_diffuse_light_has_no_part_for_it() {
    let written = AtmosphereTable {
        diffuse: None,
        ..air_table()
    };
    let file = written.to_file(Provenance::default());
    assert!(file.parts.iter().all(|part| part.name != "diffuse_light"));
    assert_eq!(through_a_file(&file).unwrap().diffuse, None);
}

/// The file of the table with something changed.
fn changed(change: impl FnOnce(&mut TableFile)) -> Result<AtmosphereTable, Error> {
    let mut file = air_table().to_file(Provenance::default());
    change(&mut file);
    AtmosphereTable::from_file(&file)
}

fn part<'a>(file: &'a mut TableFile, name: &str) -> &'a mut niji_exchange::TablePart {
    let part = file.parts.iter_mut().find(|part| part.name == name);
    part.unwrap()
}

#[test]
fn what_is_no_light_is_refused() {
    assert!(changed(|_| ()).is_ok());
    for value in [f32::NAN, f32::INFINITY, -1.0] {
        let error = changed(|file| part(file, "diffuse_light").channels[0].values[[1, 1]] = value);
        assert!(
            matches!(error, Err(Error::NotFinite { .. } | Error::Negative { .. })),
            "{error:?}"
        );
        let error = changed(|file| {
            part(file, "diffuse_light_on_ground").channels[0].values[[1, 1]] = value;
        });
        assert!(error.is_err());
    }
    let error = changed(|file| part(file, "phase_moments").channels[0].values[[0, 0]] = f32::NAN);
    assert!(matches!(error, Err(Error::NotFinite { .. })), "{error:?}");
}

#[test]
fn parts_that_disagree_are_refused() {
    let missing = changed(|file| file.parts.retain(|part| part.name != "phase_moments"));
    assert!(matches!(missing, Err(Error::Missing { .. })), "{missing:?}");
    let channel = changed(|file| {
        part(file, "diffuse_light").channels.pop();
    });
    assert!(matches!(channel, Err(Error::Missing { .. })), "{channel:?}");
    let suns = changed(|file| part(file, "diffuse_light_on_ground").row_axes[0].values[1] = 0.6);
    assert!(matches!(suns, Err(Error::Axis { .. })), "{suns:?}");
    let below = changed(|file| {
        part(file, "diffuse_light").row_axes[1].values[0] = -0.1;
        part(file, "diffuse_light_on_ground").row_axes[0].values[0] = -0.1;
    });
    assert!(matches!(below, Err(Error::Axis { .. })), "{below:?}");
    let colors = changed(|file| part(file, "phase_moments").column_axis.values[0] = 440.0);
    assert!(matches!(colors, Err(Error::Axis { .. })), "{colors:?}");
    for degree in [0.0, 2.0, 1e9, f64::NAN] {
        let error = changed(|file| {
            let value = niji_exchange::AttributeValue::Number(degree);
            let attributes = &mut part(file, "diffuse_light").attributes;
            attributes.insert("niji:maxDegree".to_owned(), value);
        });
        assert!(error.is_err(), "{degree}");
    }
}

/// P_l of the angle between a ray of light and a view, by the addition theorem; measured: 3e-7.
const ROUNDING: f32 = 2e-6;

#[test]
fn each_degree_depends_on_the_angle_to_the_light_alone() {
    let light = beam_light(1, 0.3, 0.7);
    let mut by_degree = vec![0.0; (MAX_DEGREE + 1) * N_WAVELENGTHS];
    let place = light.place(0.0, 0.5_f64.cos()).unwrap();
    for (cos_zenith, azimuth_rad) in [(0.3, 0.7), (-0.8, 2.0), (1.0, 0.0_f64)] {
        let sine = |cosine: f64| (1.0 - cosine * cosine).sqrt();
        let cos_sun_zenith = 0.5_f64.cos();
        let sines = sine(cos_zenith) * sine(cos_sun_zenith);
        let view = DiffuseView {
            cos_zenith,
            cos_sun_zenith,
            cos_scattering: cos_zenith * cos_sun_zenith + sines * azimuth_rad.cos(),
        };
        light.write_by_degree(place, view, &mut by_degree);
        // Light on both sides of the sun's azimuth, half of it on each.
        for (l, row) in by_degree.chunks(N_WAVELENGTHS).enumerate() {
            let legendre = |side: f64| {
                let apart = (azimuth_rad - side * 0.7).cos();
                let cosine = 0.3 * cos_zenith + sine(0.3) * sine(cos_zenith) * apart;
                harmonics(MAX_DEGREE, cosine)[moment_index(l, 0)]
            };
            let mean = 0.5 * (legendre(1.0) + legendre(-1.0));
            let expected = (11.0 * (2.0 * l as f64 + 1.0) / (4.0 * PI) * mean) as f32;
            assert!((row[0] - expected).abs() < ROUNDING * 11.0, "{l}: {row:?}");
        }
    }
}

#[test]
fn light_is_linear_between_nodes_and_ends_with_the_axis_of_the_sun() {
    let light = beam_light(1, 1.0, 0.0);
    let flux = |height_m, zenith_rad: f64| light.net_flux(height_m, zenith_rad.cos())[0];
    // All light comes from the zenith: its flux is what it is at the node.
    for (height_m, zenith_rad, expected) in [
        (0.0, 0.0, 1.0),
        (1e3, 0.0, 1.5),
        (0.0, 0.25, 6.0),
        (1e3, 1.0, 16.5),
        (-50.0, 0.5, 11.0),
        (1e9, 0.5, 13.0),
    ] {
        let found = flux(height_m, zenith_rad);
        assert!((found - expected).abs() < 1e-6 * expected, "{found}");
    }
    assert!(light.place(0.0, 1.6_f64.cos()).is_none());
    assert!(light.place(0.0, f64::NAN).is_none());
    assert!(light.ground_irradiance(-1.0).iter().all(|&f| f == 0.0));
}

#[test]
fn light_of_another_size_is_not_sound() {
    let light = beam_light(1, 0.5, 1.0);
    assert!(light.is_sound(1, N_WAVELENGTHS));
    assert!(!light.is_sound(2, N_WAVELENGTHS));
    assert!(!light.is_sound(1, 3));
    let mut short = light.clone();
    short.moments.truncate(n_moments(MAX_DEGREE));
    assert!(!short.is_sound(1, N_WAVELENGTHS));
    let mut falling = light;
    falling.height_m[2] = 0.0;
    assert!(!falling.is_sound(1, N_WAVELENGTHS));
}
