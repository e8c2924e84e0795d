//! The color of the primary bow by angle and drop radius, as CSV:
//! `cargo run --release -p niji-scatter --example bow-colors > bow.csv`.
//!
//! Linear Rec.709 of light scattered by one drop, over its largest value for that radius: large drops
//! have a red edge and pure colors, small ones a broad white bow further inside.

use std::io::Write;

use niji_radiometry::Colorimetry;
use niji_radiometry::Water;
use niji_radiometry::WavelengthGrid;
use niji_radiometry::solar_irradiance;
use niji_radiometry::xyz_to_linear_rec709;
use niji_scatter::SizeRows;
use niji_scatter::TableRequest;
use niji_scatter::Theory;
use niji_scatter::scattering_table;
use niji_scatter::unwatched;

const RADII_UM: [f64; 4] = [20.0, 50.0, 200.0, 1000.0];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let wavelengths = WavelengthGrid::visible();
    let table = scattering_table(
        &TableRequest {
            theory: Theory::Uniform,
            orders: vec![2],
            theta_range_rad: (135_f64.to_radians(), 148_f64.to_radians()),
            tolerance: 1e-2,
            wavelengths,
            effective_radius_um: RADII_UM.to_vec(),
            effective_variance: vec![0.01],
            rows: SizeRows::Laws,
            motion: None,
            sun_disc_diameter_rad: 0.0093,
            water: Water::pure(15.0),
            airy_table: None,
        },
        &unwatched,
    )?;

    let (sun, colorimetry) = (
        solar_irradiance(&wavelengths),
        Colorimetry::new(&wavelengths),
    );
    let color = |radius: usize, angle: usize| {
        // Polarization, radius, variance, wavelength, angle; natural light is the mean of both
        // polarizations.
        let light = |wavelength: usize| {
            let [s, p] = [0, 1].map(|it| table.values[[it, radius, 0, wavelength, angle]]);
            0.5 * f64::from(s + p)
        };
        let radiance: Vec<f64> = sun
            .iter()
            .enumerate()
            .map(|(i, sun)| sun * light(i))
            .collect();
        xyz_to_linear_rec709(colorimetry.xyz(&radiance))
    };

    let mut out = std::io::stdout().lock();
    writeln!(out, "radius_um,bow_angle_deg,red,green,blue")?;
    for (radius, radius_um) in RADII_UM.iter().enumerate() {
        let colors: Vec<_> = (0..table.theta_rad.len())
            .map(|angle| color(radius, angle))
            .collect();
        let brightest = colors
            .iter()
            .flatten()
            .fold(0.0_f64, |most, it| most.max(*it));
        for (theta_rad, [red, green, blue]) in table.theta_rad.iter().zip(&colors) {
            let bow_angle_deg = 180.0 - theta_rad.to_degrees();
            let [red, green, blue] = [red, green, blue].map(|it| it / brightest);
            writeln!(
                out,
                "{radius_um},{bow_angle_deg:.3},{red:.4},{green:.4},{blue:.4}"
            )?;
        }
    }
    Ok(())
}
