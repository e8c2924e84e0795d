//! Light of air of any thickness, at twilight and midnight, seen from below the sea and from space.

use std::f64::consts::PI;

use niji_atmosphere::AerosolKind;
use niji_atmosphere::AirLight;
use niji_atmosphere::BodhaineAir;
use niji_atmosphere::Constituent;
use niji_atmosphere::DensityProfile;
use niji_atmosphere::DiffuseSky;
use niji_atmosphere::InScattering;
use niji_atmosphere::PhaseFunction;
use niji_atmosphere::STANDARD_PRESSURE_PA;
use niji_atmosphere::SUN_RADIUS;
use niji_atmosphere::ScatteringOrders;
use niji_atmosphere::SingleScattering;
use niji_atmosphere::SkyDirection;
use niji_atmosphere::SkyDome;
use niji_atmosphere::SkyObserver;
use niji_atmosphere::ViewRay;
use niji_atmosphere::sun_transmittance;
use niji_atmosphere::with_diffuse_light;
use niji_exchange::AtmosphereTable;
use niji_geometry::EARTH;
use niji_radiometry::Radians;

use crate::atmosphere::air;
use crate::atmosphere::grid;
use crate::atmosphere::nishita;
use crate::hard_case::HardCase;
use crate::hard_case::relative;
use crate::hard_case::violations;
use crate::hard_case::worst;

pub(crate) const CASES: &[HardCase] = &[
    HardCase {
        claim: "air of an optical depth of 1e-12 scatters in proportion",
        measure: "relative error of the radiance tau P",
        allowed: 1e-5,
        error: thin_air,
    },
    HardCase {
        claim: "air of an optical depth of 1e3 is a wall",
        measure: "relative error of the radiance of a half-space",
        allowed: 0.01,
        error: thick_air,
    },
    HardCase {
        claim: "a sky under the horizon's sun is finite and dark at midnight",
        measure: "radiances that are not",
        allowed: 0.0,
        error: night,
    },
    HardCase {
        claim: "twilight is cut at the wall of the shadow",
        measure: "relative difference of 16 nodes from 96",
        allowed: 1e-3,
        error: twilight,
    },
    HardCase {
        claim: "observers above the air see it from outside, wherever they are",
        measure: "relative difference of 100 km and 36000 km, straight down",
        allowed: 2e-5,
        error: seen_from_space,
    },
    HardCase {
        claim: "40 m below sea level is still air",
        measure: "relative difference from the light at the sea",
        allowed: 0.02,
        error: below_the_sea,
    },
    HardCase {
        claim: "a vacuum is black and clear",
        measure: "largest radiance or loss",
        allowed: 1e-8,
        error: vacuum,
    },
    HardCase {
        claim: "a dome's zenith, nadir and horizon are directions like others",
        measure: "relative error of the radiance",
        allowed: 3e-4,
        error: ends_of_the_sphere,
    },
    HardCase {
        claim: "domes over midnight, in space and towards NaN are black",
        measure: "directions that are not",
        allowed: 0.0,
        error: black_domes,
    },
    HardCase {
        claim: "a fog that takes nothing, over white ground, shines as Hopf's half-space",
        measure: "relative error of the radiance deep in it, sun at 30 and 90 degrees",
        // Of 14 layers; measured 3.9 %, of 40 layers 0.7 %.
        allowed: 0.05,
        error: white_fog,
    },
    HardCase {
        claim: "a sun in the zenith shines alike on all azimuths",
        measure: "relative difference of the sky's radiance",
        allowed: 1e-5,
        error: sun_in_the_zenith,
    },
];

const QUADRATURES: [InScattering; 2] = [
    InScattering::Quadrature { n_nodes: 16 },
    InScattering::STANDARD,
];

/// His Rayleigh scattering at 550 nm, 1/m.
const SCATTERING_M1: f64 = 1.278535e-5;

/// Nishita's air, denser by a factor.
fn denser(factor: f64) -> AtmosphereTable {
    let mut air = nishita();
    let rayleigh = &mut air.constituents[0];
    for spectrum in [&mut rayleigh.extinction_m1, &mut rayleigh.scattering_m1] {
        for value in spectrum {
            *value *= factor;
        }
    }
    air
}

/// Elevations of view and sun and the azimuth between them, radians from degrees.
fn angles(view_deg: f64, sun_deg: f64, azimuth_deg: f64) -> [f64; 3] {
    [view_deg, sun_deg, azimuth_deg].map(f64::to_radians)
}

fn whole_ray(height_m: f64, degrees: [f64; 3]) -> ViewRay {
    let [view, sun, azimuth] = degrees;
    ViewRay::from_angles(height_m, angles(view, sun, azimuth), f64::INFINITY)
}

/// Rayleigh's phase function, 1/sr.
fn phase(cos_scattering: f64) -> f64 {
    3.0 / (16.0 * PI) * (1.0 + cos_scattering * cos_scattering)
}

fn thin_air() -> f64 {
    let depth = 1e-12;
    let air = denser(depth / (SCATTERING_M1 * 1000.0));
    let ray = ViewRay::from_angles(0.0, angles(0.0, 30.0, 90.0), 1000.0);
    // Over 1 km the density along a level ray varies by 5e-6.
    let expected = depth * phase(ray.cos_scattering);
    worst(QUADRATURES.map(|level| {
        let light = SingleScattering::new(&air, level).solve(&ray);
        let loss = violations([(1.0 - light.transmittance[1]).abs() < 2.0 * depth]);
        relative(light.radiance[1], expected) + loss
    }))
}

fn thick_air() -> f64 {
    let air = denser(1e3 / (SCATTERING_M1 * 100e3));
    let ray = ViewRay::from_angles(0.0, angles(0.0, 90.0, 0.0), 100e3);
    // integral beta P exp(-beta s) ds = P, dimmed by the air above.
    let expected = phase(0.0) * (-air.optical_depth_at(1, 0.0, 1.0)).exp();
    worst(QUADRATURES.map(|level| {
        let light = SingleScattering::new(&air, level).solve(&ray);
        let is_opaque = violations([light.transmittance[1] < 1e-26]);
        relative(light.radiance[1], expected) + is_opaque
    }))
}

fn night() -> f64 {
    let air = nishita();
    let levels = [
        QUADRATURES[0],
        QUADRATURES[1],
        InScattering::Midpoint { n_steps: 20 },
    ];
    let n_violations = levels.map(|level| {
        let solver = SingleScattering::new(&air, level);
        let suns = [-1.0, -6.0, -18.0, -90.0].into_iter();
        violations(suns.flat_map(|sun_deg| {
            [-90.0, -1.0, 0.0, 0.1, 10.0, 90.0].map(|view_deg| {
                let light = solver.solve(&whole_ray(0.0, [view_deg, sun_deg, 20.0]));
                let is_right =
                    |l: &f64| l.is_finite() && *l >= 0.0 && (sun_deg > -90.0 || *l == 0.0);
                light.radiance.iter().all(is_right)
            })
        }))
    });
    n_violations.into_iter().sum()
}

fn twilight() -> f64 {
    // Sun 4 degrees down: the shadow's edge stands at 15 km over the observer.
    let air = nishita();
    let coarse = SingleScattering::new(&air, QUADRATURES[0]);
    let fine = SingleScattering::new(&air, InScattering::Quadrature { n_nodes: 96 });
    let views = [
        (90.0, 0.0),
        (30.0, 0.0),
        (5.0, 0.0),
        (20.0, 90.0),
        (60.0, 180.0),
    ];
    worst(views.into_iter().flat_map(|(view_deg, azimuth_deg)| {
        let ray = whole_ray(0.0, [view_deg, -4.0, azimuth_deg]);
        let (coarse, fine) = (coarse.solve(&ray).radiance, fine.solve(&ray).radiance);
        [0, 1, 2].map(|wavelength| relative(coarse[wavelength], fine[wavelength]))
    }))
}

fn seen_from_space() -> f64 {
    let air = nishita();
    let solver = SingleScattering::new(&air, QUADRATURES[0]);
    let see =
        |height_m: f64, view_deg: f64| solver.solve(&whole_ray(height_m, [view_deg, 50.0, 0.0]));
    let (low, high) = (see(100.001e3, -90.0), see(36_000e3, -90.0));
    let errors = [0, 1, 2].map(|w| relative(low.radiance[w], high.radiance[w]));
    // Above the limb there is nothing.
    let is_empty = |light: AirLight| {
        light.radiance.iter().all(|l| *l == 0.0) && light.transmittance.iter().all(|t| *t == 1.0)
    };
    worst(errors) + violations([is_empty(see(400e3, -10.0)), is_empty(see(150e3, 45.0))])
}

fn below_the_sea() -> f64 {
    let air = nishita();
    let solver = SingleScattering::new(&air, QUADRATURES[0]);
    let light = |height_m: f64, view_deg: f64| {
        let ray = ViewRay::from_angles(height_m, angles(view_deg, 20.0, 180.0), 1e3);
        solver.solve(&ray).radiance[1]
    };
    worst(
        [-1.0, 0.0, 1.0]
            .map(|view_deg: f64| relative(light(-40.0, view_deg), light(0.0, view_deg.max(0.0)))),
    )
}

fn vacuum() -> f64 {
    let air = air(Vec::new());
    let light =
        SingleScattering::new(&air, QUADRATURES[0]).solve(&whole_ray(0.0, [10.0, 20.0, 0.0]));
    let shares = sun_transmittance(&air, 0.0, 0.2, SUN_RADIUS);
    let losses = light.transmittance.iter().chain(&shares);
    worst(
        losses
            .map(|share| (1.0 - share).abs())
            .chain(light.radiance.iter().copied()),
    )
}

fn hazy() -> AtmosphereTable {
    let constituents = [
        BodhaineAir::at_pressure(STANDARD_PRESSURE_PA).constituent(&grid()),
        AerosolKind::Clear.aerosol().constituent(&grid()),
    ];
    let mut air = air(constituents.map(|one| one.expect("usual air")).to_vec());
    air.ground_albedo = vec![0.2; 3];
    air
}

fn observer(height_m: f64, sun_elevation_deg: f64) -> SkyObserver {
    SkyObserver::from_elevation(height_m, Radians::from_degrees(sun_elevation_deg))
}

fn direction(elevation_deg: f64, azimuth_deg: f64) -> SkyDirection {
    let [elevation, azimuth] = [elevation_deg, azimuth_deg].map(Radians::from_degrees);
    SkyDirection::from_elevation(elevation, azimuth)
}

fn look(dome: &SkyDome, direction: SkyDirection) -> [f32; 3] {
    let mut radiance = [f32::NAN; 3];
    dome.write_radiance(direction, &mut radiance);
    radiance
}

fn ends_of_the_sphere() -> f64 {
    let air = hazy();
    let solver = SingleScattering::new(&air, InScattering::STANDARD);
    worst([0.0, 2.0, 12e3].into_iter().flat_map(|height_m| {
        let observer = observer(height_m, 20.0);
        let dome = SkyDome::new(&air, observer, 1e-4);
        let horizon_deg = -EARTH.horizon_dip(height_m).0.to_degrees();
        let elevations = [90.0, horizon_deg + 1e-7, horizon_deg - 1e-3, -90.0].into_iter();
        let directions = elevations.flat_map(|elevation_deg| {
            [0.0, 180.0, 359.0, -40.0].map(|azimuth_deg| direction(elevation_deg, azimuth_deg))
        });
        let errors = directions.flat_map(|direction| {
            let exact = solver.sky_radiance(&observer.ray(direction));
            let found = look(&dome, direction);
            [0, 1, 2].map(|w| relative(f64::from(found[w]), exact[w]))
        });
        errors.collect::<Vec<_>>()
    }))
}

fn black_domes() -> f64 {
    let (hazy, vacuum) = (hazy(), air(Vec::new()));
    let up = direction(30.0, 50.0);
    let midnight = SkyDome::new(&hazy, observer(0.0, -90.0), 1e-3);
    let nothing = SkyDome::new(&vacuum, observer(0.0, 30.0), 1e-3);
    let space = SkyDome::new(&hazy, observer(400e3, 30.0), 1e-2);
    let nowhere = SkyDirection {
        cos_zenith: f64::NAN,
        relative_azimuth: Radians(0.0),
    };
    let black = [
        look(&midnight, up),
        look(&nothing, up),
        look(&space, up),
        look(&space, direction(-10.0, 0.0)),
        look(&space, nowhere),
    ];
    let limb = look(&space, direction(-19.9, 0.0));
    violations(black.map(|light| light == [0.0; 3])) + violations(limb.map(|light| light > 0.0))
}

fn white_fog() -> f64 {
    // Visibility 10 m, optical depth 4.7 straight up.
    let fog = Constituent {
        name: "fog".to_owned(),
        profile: DensityProfile::Exponential {
            scale_height_m: 12.0,
        },
        extinction_m1: vec![0.39; 3],
        scattering_m1: vec![0.39; 3],
        phase: PhaseFunction::Isotropic,
    };
    let mut air = air(vec![fog]);
    air.ground_albedo = vec![1.0; 3];
    let air = with_diffuse_light(air, ScatteringOrders::QUICK);
    let sky = DiffuseSky::new(&air).expect("it has diffuse light");
    let single = SingleScattering::new(&air, InScattering::STANDARD);
    // No net flux leads down: deep in it L = E mu (sqrt(3)/4) H(mu)/pi from everywhere, with H(1) = 2.9078 and
    // H(1/2) = 2.0128 of isotropic scattering without loss (Chandrasekhar, Radiative Transfer, 1960, table XI).
    let suns = [(90.0, 1.0, 2.9078), (30.0, 0.5, 2.0128)];
    worst(suns.into_iter().flat_map(|(sun_deg, mu, h)| {
        let expected = mu * 3_f64.sqrt() / 4.0 * h / PI;
        [-1.0, 0.0].map(|view_deg| {
            let ray = whole_ray(1.6, [view_deg, sun_deg, 70.0]);
            let found = single.sky_radiance(&ray)[1] + sky.radiance_per_sun(&ray)[1];
            relative(found, expected)
        })
    }))
}

fn sun_in_the_zenith() -> f64 {
    let air = with_diffuse_light(hazy(), ScatteringOrders::QUICK);
    let sky = DiffuseSky::new(&air).expect("it has diffuse light");
    let single = SingleScattering::new(&air, QUADRATURES[0]);
    let light = |view_deg: f64, azimuth_deg: f64| {
        let ray = whole_ray(2.0, [view_deg, 90.0, azimuth_deg]);
        single.sky_radiance(&ray)[0] + sky.radiance_per_sun(&ray)[0]
    };
    worst([-30.0, 0.5, 20.0, 89.0].into_iter().flat_map(|view_deg| {
        let north = light(view_deg, 0.0);
        let is_lit = violations([north > 0.01]);
        [37.0, 90.0, 180.0, 271.0]
            .map(|azimuth_deg| relative(light(view_deg, azimuth_deg), north) + is_lit)
    }))
}
