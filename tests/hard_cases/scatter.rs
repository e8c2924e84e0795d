//! Hard cases of scattering tables: exactly 0 and 180 degrees, laws of no width, drops beyond the
//! range of the exact theory, tables larger than memory.

use std::f64::consts::PI;

use niji_exchange::ScatteringTable;
use niji_mie::RefractiveIndex;
use niji_mie::Sphere;
use niji_radiometry::Nanometers;
use niji_radiometry::Water;
use niji_radiometry::WavelengthGrid;
use niji_scatter::SizeRows;
use niji_scatter::TableRequest;
use niji_scatter::Theory;
use niji_scatter::adaptive_table;
use niji_scatter::scattering_table;
use niji_scatter::unwatched;

use crate::hard_case::HardCase;
use crate::hard_case::relative;
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
    HardCase {
        claim: "rays do not know sizes: laws of no spread and of nearly 1/2 have one table",
        measure: "relative difference, drops of 10 um and of 5 mm, 380 and 780 nm",
        allowed: 2e-6,
        error: rays_of_any_law,
    },
    HardCase {
        claim: "a sun of a billionth of a degree is a point",
        measure: "difference over the peak",
        allowed: 1e-6,
        error: smallest_sun,
    },
    HardCase {
        claim: "drops of 1 and of 10 um scatter what they take, from 380 to 780 nm",
        measure: "relative error of the light over all directions",
        allowed: 2e-3,
        error: light_of_all_directions,
    },
    HardCase {
        claim: "one wavelength has the light that it has among others",
        measure: "difference over the peak",
        allowed: 4e-3,
        error: one_wavelength,
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

fn rays_of_any_law() -> f64 {
    worst([380.0, 780.0].map(|nm| {
        let of_law = |radius_um: f64, variance: f64| {
            table(&TableRequest {
                wavelengths: WavelengthGrid::new(nm, 1.0, 1).expect("one wavelength of light"),
                ..request(Theory::Geometric, radius_um, variance)
            })
        };
        let single = of_law(100.0, 0.0);
        let expected = row(&single);
        let laws = [(10.0, 0.0), (10.0, 0.499), (5000.0, 0.0), (5000.0, 0.499)];
        worst(laws.into_iter().flat_map(|(radius_um, variance)| {
            let other = of_law(radius_um, variance);
            let found = row(&other);
            let errors = single.theta_rad.iter().zip(&expected);
            errors
                .filter(|(_, expected)| **expected > 0.0)
                .map(|(theta, expected)| relative(at(&other, &found, *theta), *expected))
                .collect::<Vec<_>>()
        }))
    }))
}

fn smallest_sun() -> f64 {
    worst([Theory::Airy, Theory::Uniform, Theory::Mie].map(|theory| {
        let of_sun = |diameter_rad: f64| {
            table(&TableRequest {
                sun_disc_diameter_rad: diameter_rad,
                ..request(theory, 30.0, 0.0)
            })
        };
        let (point, tiny) = (of_sun(0.0), of_sun(1e-9_f64.to_radians()));
        let (expected, found) = (row(&point), row(&tiny));
        let peak = expected.iter().copied().fold(0.0, f64::max);
        let errors = point.theta_rad.iter().zip(&expected);
        worst(errors.map(|(theta, expected)| (at(&tiny, &found, *theta) - expected).abs() / peak))
    }))
}

fn light_of_all_directions() -> f64 {
    let cases = [1.0, 10.0].into_iter();
    worst(cases.flat_map(|radius_um| {
        [380.0, 780.0].map(|nm| {
            let water = Water::pure(20.0);
            let table = table(&TableRequest {
                theta_range_rad: (0.0, PI),
                // Of the peak, which is the forward lobe.
                tolerance: 2e-6,
                wavelengths: WavelengthGrid::new(nm, 1.0, 1).expect("one wavelength of light"),
                sun_disc_diameter_rad: 0.0,
                water,
                orders: (0..8).collect(),
                ..request(Theory::Mie, radius_um, 0.0)
            });
            let row = row(&table);
            let rings = table.theta_rad.windows(2).zip(row.windows(2));
            // Linear in theta on each step: Simpson's rule with the sine.
            let light: f64 = rings
                .map(|(theta, t)| {
                    let middle = 0.5 * (theta[0] + theta[1]);
                    let ends = t[0] * theta[0].sin() + t[1] * theta[1].sin();
                    let sum = ends + 2.0 * (t[0] + t[1]) * middle.sin();
                    2.0 * PI * (theta[1] - theta[0]) * sum / 6.0
                })
                .sum();
            let x = 2.0 * PI * radius_um * 1000.0 / nm;
            let index = RefractiveIndex::from(water.refractive_index(Nanometers(nm)));
            let drop = Sphere::new(x, index).expect("a drop of water");
            relative(light, drop.efficiencies().q_sca)
        })
    }))
}

fn one_wavelength() -> f64 {
    let of_grid = |grid: WavelengthGrid| {
        table(&TableRequest {
            wavelengths: grid,
            ..request(Theory::Uniform, 60.0, 0.1)
        })
    };
    let grid = |first_nm, step_nm, n| WavelengthGrid::new(first_nm, step_nm, n).expect("light");
    let all = of_grid(grid(380.0, 100.0, 5));
    worst([0, 4].map(|index| {
        let alone = of_grid(grid(380.0 + 100.0 * index as f64, 100.0, 1));
        let expected = row(&alone);
        let peak = expected.iter().copied().fold(0.0, f64::max);
        let natural = |angle: usize| {
            let [s, p] = [0, 1].map(|j| f64::from(all.values[[j, 0, 0, index, angle]]));
            0.5 * (s + p)
        };
        let angles = all.theta_rad.iter().enumerate();
        worst(
            angles.map(|(angle, theta)| {
                (natural(angle) - at(&alone, &expected, *theta)).abs() / peak
            }),
        )
    }))
}
