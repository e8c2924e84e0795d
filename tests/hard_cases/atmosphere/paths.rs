//! Paths of 20 m and 500 km, grazing columns, rays into the ground and through space, the sun as it
//! sets.

use niji_atmosphere::AerosolKind;
use niji_atmosphere::Constituent;
use niji_atmosphere::DensityProfile;
use niji_atmosphere::NishitaAir;
use niji_atmosphere::OpticalLength;
use niji_atmosphere::OzoneLayer;
use niji_atmosphere::PhaseFunction;
use niji_atmosphere::SUN_RADIUS;
use niji_atmosphere::optical_length_m;
use niji_atmosphere::sun_transmittance;
use niji_geometry::EARTH;
use niji_radiometry::Radians;

use crate::atmosphere::air;
use crate::atmosphere::grid;
use crate::atmosphere::nishita;
use crate::atmosphere::table;
use crate::hard_case::HardCase;
use crate::hard_case::relative;
use crate::hard_case::violations;
use crate::hard_case::worst;

pub(crate) const CASES: &[HardCase] = &[
    HardCase {
        claim: "paths of 20 m and of 500 km agree with 18 digits",
        measure: "relative error of the equivalent length",
        allowed: 1e-5,
        error: path_lengths,
    },
    HardCase {
        claim: "the grazing column of any scale height is the Bessel function",
        measure: "relative error of X e^X K1(X)",
        allowed: 1e-7,
        error: grazing_columns,
    },
    HardCase {
        claim: "a ray that ends on the ground has an infinite column and no NaN",
        measure: "columns that are anything else",
        allowed: 0.0,
        error: columns_into_the_ground,
    },
    HardCase {
        claim: "above the top there is no air, and below it the whole chord",
        measure: "relative error of a chord seen from 400 km",
        allowed: 1e-6,
        error: chord_from_space,
    },
    HardCase {
        claim: "a point sun on the horizon is up",
        measure: "error of its published transmittance 0.157",
        allowed: 5e-4,
        error: point_sun_on_the_horizon,
    },
    HardCase {
        claim: "the sun sets as its disc does and leaves neither light nor NaN",
        measure: "violations",
        allowed: 0.0,
        error: sunset,
    },
];

/// Scale height of Nishita's air, m.
const SCALE_HEIGHT_M: f64 = 7994.0;

fn path_lengths() -> f64 {
    // Height, cosine of the zenith angle, distance; integral of exp(-h/7994 m) in 30-digit arithmetic.
    let paths = [
        ([0.0, 0.0, 20.0], 19.9999999738201601),
        ([0.0, 1.0, 20.0], 19.975002087501823),
        ([0.0, 0.0, 5e5], 275361.431276841185),
        ([2000.0, -0.02, 2e5], 175627.724065307786),
        ([9000.0, -0.05, 5e5], 353546.213857069018),
        ([-50.0, 0.001, 3e4], 30043.2271410961874),
    ];
    let air = nishita();
    worst(paths.map(|([height_m, mu, length_m], expected)| {
        relative(air.segment_length(0, height_m, mu, length_m), expected)
    }))
}

fn grazing_columns() -> f64 {
    // X e^X K1(X) for X = 6371 km/H in 40-digit arithmetic: thin haze, air, and a thermosphere.
    let layers = [
        (1200.0, 91.327_967_062_976_886),
        (SCALE_HEIGHT_M, 35.398_583_995_490_133),
        (60e3, 12.960_289_981_977_592),
    ];
    worst(layers.into_iter().flat_map(|(scale_height_m, bessel)| {
        let layer = Constituent {
            name: "layer".to_owned(),
            profile: DensityProfile::Exponential { scale_height_m },
            extinction_m1: vec![1e-5; 3],
            scattering_m1: vec![0.0; 3],
            phase: PhaseFunction::Isotropic,
        };
        // Above it lies e^-22 of the air.
        let air = table(vec![layer], 22.0 * scale_height_m);
        [
            OpticalLength::GaussLegendre { n_nodes: 24 },
            OpticalLength::Table,
        ]
        .map(|method| {
            let length_m = optical_length_m(&air, 0, method, [0.0, 0.0]);
            relative(length_m / scale_height_m, bessel)
        })
    }))
}

fn columns_into_the_ground() -> f64 {
    let constituents = [
        NishitaAir::PUBLISHED.constituent(&grid()),
        AerosolKind::Clear.aerosol().constituent(&grid()),
        OzoneLayer::of_column(300.0).constituent(&grid()),
    ];
    let air = air(constituents.map(|one| one.expect("usual air")).to_vec());
    let rays = [
        (0.0, -1e-6),
        (-100.0, -0.01),
        (2.0, -0.002),
        (1e4, -0.5),
        (200e3, -1.0),
    ];
    violations(rays.into_iter().flat_map(|(height_m, mu)| {
        let of_each = [0, 1, 2].map(|index| air.column_at(index, height_m, mu).is_infinite());
        let of_all = air.optical_depth_at(1, height_m, mu).is_infinite();
        of_each.into_iter().chain([of_all])
    }))
}

fn chord_from_space() -> f64 {
    let air = nishita();
    let outside = [
        air.column_at(0, 150e3, 1.0),
        air.column_at(0, 150e3, -0.05),
        air.density_at(0, 100.1e3),
    ];
    // A chord with its perigee at 20 km, seen from 400 km: twice the level column there.
    let (r, perigee) = (EARTH.radius_m + 400e3, EARTH.radius_m + 20e3);
    let mu = -(1.0 - (perigee / r) * (perigee / r)).sqrt();
    let chord = air.column_at(0, 400e3, mu);
    let errors = [
        relative(chord, 2.0 * air.column_at(0, 20e3, 0.0)),
        relative(air.segment_length(0, 400e3, mu, 1e9), chord),
    ];
    worst(outside.into_iter().chain(errors))
}

fn point_sun_on_the_horizon() -> f64 {
    (sun_transmittance(&nishita(), 0.0, 0.0, Radians(0.0))[2] - 0.157).abs()
}

fn sunset() -> f64 {
    let air = nishita();
    let sun = |height_m: f64, sun_deg: f64| {
        sun_transmittance(&air, height_m, sun_deg.to_radians().sin(), SUN_RADIUS)
    };
    let is_dark = |share: Vec<f64>| share.iter().all(|share| *share == 0.0);
    let set = [(0.0, -0.3), (-50.0, -0.3), (0.0, -90.0)];
    let set = set.map(|(height_m, sun_deg)| is_dark(sun(height_m, sun_deg)));
    // Half risen: less than half of the light of a sun that stands a disc higher, and not nothing.
    let (rising, risen) = (sun(0.0, 0.0), sun(0.0, 0.533));
    let rising = rising.iter().zip(&risen);
    let rising = rising.map(|(rising, risen)| *rising > 0.0 && *rising < 0.5 * risen);
    // Seen from a mountain the sun is up at -1 degree.
    let from_a_mountain = sun(2000.0, -1.0).into_iter().map(|share| share > 0.0);
    violations(set) + violations(rising) + violations(from_a_mountain)
}
