//! Hard cases of scattering tables: exactly 0 and 180 degrees, laws of no width, drops beyond the
//! range of the exact theory, tables larger than memory.

use std::f64::consts::PI;

use niji_exchange::ScatteringTable;
use niji_radiometry::Water;
use niji_radiometry::WavelengthGrid;
use niji_scatter::SizeRows;
use niji_scatter::TableRequest;
use niji_scatter::Theory;
use niji_scatter::adaptive_table;
use niji_scatter::scattering_table;
use niji_scatter::unwatched;

use crate::hard_case::HardCase;
use crate::hard_case::violations;
use crate::hard_case::worst;

pub(crate) const CASES: &[HardCase] = &[
    HardCase {
        claim: "every theory is finite at exactly 0 and 180 degrees",
        measure: "values that are not, or negative",
        allowed: 0.0,
        error: poles,
    },
    HardCase {
        claim: "a law that narrows to nothing ends in the single size",
        measure: "difference over the peak, v_e = 1e-12 and 1e-8",
        allowed: 2e-3,
        error: vanishing_variance,
    },
    HardCase {
        claim: "drops beyond the largest size parameter scatter as that one",
        measure: "values that are not above 0",
        allowed: 0.0,
        error: beyond_the_largest_drop,
    },
    HardCase {
        claim: "a table that no machine should hold is refused before it is made",
        measure: "accepted tables",
        allowed: 0.0,
        error: table_without_end,
    },
    HardCase {
        claim: "requests of no radius, of NaN, of order 8 and of flat discs are refused",
        measure: "accepted requests",
        allowed: 0.0,
        error: impossible_requests,
    },
];

/// Diameter of the sun, radians.
const DISC_RAD: f64 = 0.533 * PI / 180.0;

/// Both bows at 560 nm.
fn request(theory: Theory, radius_um: f64, effective_variance: f64) -> TableRequest<'static> {
    TableRequest {
        theory,
        orders: vec![2, 3],
        theta_range_rad: (125.0_f64.to_radians(), 143.0_f64.to_radians()),
        tolerance: 2e-3,
        wavelengths: WavelengthGrid::new(560.0, 10.0, 1).expect("one wavelength of light"),
        effective_radius_um: vec![radius_um],
        effective_variance: vec![effective_variance],
        rows: SizeRows::Laws,
        motion: None,
        sun_disc_diameter_rad: DISC_RAD,
        water: Water::pure(20.0),
        airy_table: None,
    }
}

fn table(request: &TableRequest) -> ScatteringTable {
    scattering_table(request, &unwatched).expect("the cases ask for sound tables")
}

/// Natural light of the only row.
fn row(table: &ScatteringTable) -> Vec<f64> {
    let at = |j, angle| f64::from(table.values[[j, 0, 0, 0, angle]]);
    let angles = 0..table.theta_rad.len();
    angles
        .map(|angle| 0.5 * (at(0, angle) + at(1, angle)))
        .collect()
}

/// The row at an angle, linear between those of the table.
fn at(table: &ScatteringTable, row: &[f64], theta_rad: f64) -> f64 {
    let angles = &table.theta_rad;
    let above = angles.partition_point(|angle| *angle <= theta_rad);
    let above = above.clamp(1, angles.len() - 1);
    let part = (theta_rad - angles[above - 1]) / (angles[above] - angles[above - 1]);
    row[above - 1] * (1.0 - part) + row[above] * part
}

fn poles() -> f64 {
    let theories = [
        Theory::GeometricPublished,
        Theory::Geometric,
        Theory::AiryPublished,
        Theory::Airy,
        Theory::Uniform,
        Theory::Debye { max_order: 7 },
        Theory::Mie,
        Theory::BySize,
    ];
    let requests = theories.into_iter().flat_map(|theory| {
        [0.0, DISC_RAD].map(|sun_disc_diameter_rad| TableRequest {
            orders: (0..8).collect(),
            theta_range_rad: (0.0, PI),
            tolerance: 0.5,
            sun_disc_diameter_rad,
            ..request(theory, 4.0, 0.0)
        })
    });
    let n_violations = requests.map(|request| {
        let table = table(&request);
        let diffracts = request.theory.is_exact();
        let left_out = if diffracts { 0.0 } else { 0.5 };
        let ends = [
            table.theta_rad[0],
            table.theta_rad[table.theta_rad.len() - 1],
        ];
        violations(table.values.iter().map(|t| t.is_finite() && *t >= 0.0))
            + violations([
                ends == [0.0, PI],
                table.forward_fraction_left_out == left_out,
            ])
    });
    n_violations.sum()
}

fn vanishing_variance() -> f64 {
    let theories = [Theory::Uniform, Theory::Debye { max_order: 3 }].into_iter();
    worst(theories.flat_map(|theory| {
        let single = table(&request(theory, 60.0, 0.0));
        let expected = row(&single);
        let peak = expected.iter().copied().fold(0.0, f64::max);
        [1e-12, 1e-8].map(|variance| {
            let narrow = table(&request(theory, 60.0, variance));
            let found = row(&narrow);
            let off = single.theta_rad.iter().zip(&expected);
            worst(
                off.map(|(theta, expected)| (at(&narrow, &found, *theta) - expected).abs() / peak),
            )
        })
    }))
}

fn beyond_the_largest_drop() -> f64 {
    let huge = TableRequest {
        sun_disc_diameter_rad: 0.0,
        theta_range_rad: (2.4, 2.4001),
        tolerance: 1.0,
        ..request(Theory::Mie, 9500.0, 0.0)
    };
    violations(row(&table(&huge)).into_iter().map(|value| value > 0.0))
}

fn table_without_end() -> f64 {
    let huge = TableRequest {
        effective_radius_um: (1..=20_000).map(|i| 0.1 * f64::from(i)).collect(),
        wavelengths: WavelengthGrid::new(310.0, 0.3, 2000).expect("a sound grid"),
        ..request(Theory::Uniform, 100.0, 0.0)
    };
    violations([adaptive_table(&huge, &unwatched).is_err()])
}

fn impossible_requests() -> f64 {
    let sound = || request(Theory::Airy, 100.0, 0.0);
    let radii = [vec![], vec![-1.0], vec![2.0, 1.0], vec![f64::NAN]];
    let radii = radii.map(|effective_radius_um| TableRequest {
        effective_radius_um,
        ..sound()
    });
    let ranges = [(1.0, 4.0), (2.0, 1.0), (f64::NAN, 2.0)];
    let ranges = ranges.map(|theta_range_rad| TableRequest {
        theta_range_rad,
        ..sound()
    });
    let orders = [vec![], vec![8], vec![2, 2]];
    let orders = orders.map(|orders| TableRequest { orders, ..sound() });
    let bins = |ln_step| SizeRows::Bins {
        ln_step,
        narrowest_variance: 0.1,
    };
    let others = [
        TableRequest {
            rows: bins(f64::NAN),
            ..sound()
        },
        TableRequest {
            rows: bins(0.02),
            effective_variance: vec![0.1],
            ..sound()
        },
        TableRequest {
            effective_variance: vec![0.5],
            ..sound()
        },
        TableRequest {
            tolerance: f64::NAN,
            ..sound()
        },
        TableRequest {
            sun_disc_diameter_rad: 1.0,
            ..sound()
        },
    ];
    let requests = radii.into_iter().chain(ranges).chain(orders);
    let requests = requests.chain(others);
    violations(requests.map(|request| scattering_table(&request, &unwatched).is_err()))
}
