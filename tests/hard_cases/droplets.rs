//! Hard cases of shapes: thinner than a voxel, far from the origin, of drops that hardly fall, of
//! laws too wide, and numbers that cannot be.

use niji_droplets::Fountain;
use niji_droplets::SeaSpray;
use niji_droplets::Shape;
use niji_droplets::Uniform;
use niji_droplets::Waterfall;
use niji_sizes::Monodisperse;
use niji_sizes::SizeLaw;

use crate::hard_case::HardCase;
use crate::hard_case::relative;
use crate::hard_case::violations;
use crate::hard_case::worst;

pub(crate) const CASES: &[HardCase] = &[
    HardCase {
        claim: "a box thinner than a voxel, and one 1000 km away, keeps its water",
        measure: "relative error of the water",
        allowed: 1e-6,
        error: thin_and_far_boxes,
    },
    HardCase {
        claim: "a curtain a hundred times thinner than a voxel keeps its water",
        measure: "relative error of the water",
        allowed: 1e-5,
        error: thin_curtain,
    },
    HardCase {
        claim: "spray too wide for a gamma law keeps its water",
        measure: "relative error of the water",
        allowed: 1e-6,
        error: wide_spray,
    },
    HardCase {
        claim: "a fountain of drops of 5 um, which stop at once, keeps its water",
        measure: "relative error of the water",
        allowed: 1e-3,
        error: fountain_of_mist,
    },
    HardCase {
        claim: "shapes of NaN, of no voxel and of voxels without end are refused",
        measure: "accepted shapes",
        allowed: 0.0,
        error: impossible_shapes,
    },
    HardCase {
        claim: "dry shapes are empty volumes",
        measure: "nodes with drops",
        allowed: 0.0,
        error: dry_shapes,
    },
];

fn fog() -> Uniform {
    Uniform {
        box_min_m: [-10.0, 0.0, -30.0],
        box_max_m: [10.0, 7.0, -10.0],
        voxel_m: 2.0,
        law: SizeLaw::Monodisperse(Monodisperse { radius_um: 100.0 }),
        number_density_m3: Some(1000.0),
    }
}

fn spray() -> SeaSpray {
    SeaSpray {
        box_min_m: [-20.0, 1.0, -60.0],
        box_max_m: [20.0, 13.0, -20.0],
        surface_lwc_g_m3: 0.05,
        scale_height_m: 3.0,
        median_radius_um: 50.0,
        geometric_standard_deviation: 1.5,
        turbulence: None,
        voxel_m: 1.0,
    }
}

fn fall() -> Waterfall {
    Waterfall {
        foot_m: [3.0, 10.0, -80.0],
        azimuth_deg: 250.0,
        height_m: 20.0,
        width_m: 6.0,
        flow_kg_s: 50.0,
        splash_fraction: 0.0,
        mist_fraction: 0.0,
        curtain_effective_radius_um: 1000.0,
        splash_effective_radius_um: 300.0,
        mist_effective_radius_um: 40.0,
        wind_xz_m_s: [1.5, -1.0],
        strands: None,
        turbulence: None,
        voxel_m: 2.0,
    }
}

fn fountain() -> Fountain {
    Fountain {
        nozzle_m: [0.0, 1.0, -10.0],
        ring_radius_m: 0.0,
        speed_m_s: 8.0,
        elevation_deg: 80.0,
        azimuth_deg: 20.0,
        spread_deg: 10.0,
        flow_kg_s: 1.0,
        effective_radius_um: 400.0,
        effective_variance: 0.1,
        wind_xz_m_s: [0.0, 0.0],
        basin_y_m: 0.5,
        turbulence: None,
        voxel_m: 0.25,
    }
}

/// Relative error of the water that a shape lays out.
fn water_error(shape: Shape) -> f64 {
    let expected_g = shape.total_water_g();
    let volume = shape.volume().expect("the cases name sound shapes");
    relative(volume.summary().total_water_g, expected_g)
}

fn thin_and_far_boxes() -> f64 {
    let (min, max) = (fog().box_min_m, fog().box_max_m);
    let thin = Uniform {
        box_max_m: [max[0], min[1] + 1e-6, max[2]],
        ..fog()
    };
    let far = Uniform {
        box_min_m: min.map(|axis| 1e6 + axis),
        box_max_m: max.map(|axis| 1e6 + axis),
        ..fog()
    };
    worst([thin, far].map(|shape| water_error(Shape::Uniform(shape))))
}

fn thin_curtain() -> f64 {
    water_error(Shape::Waterfall(fall()))
}

fn wide_spray() -> f64 {
    worst([3.0, 5.0].map(|geometric_standard_deviation| {
        water_error(Shape::SeaSpray(SeaSpray {
            geometric_standard_deviation,
            ..spray()
        }))
    }))
}

fn fountain_of_mist() -> f64 {
    water_error(Shape::Fountain(Fountain {
        effective_radius_um: 5.0,
        flow_kg_s: 1e-4,
        voxel_m: 0.1,
        ..fountain()
    }))
}

fn impossible_shapes() -> f64 {
    let bad = [f64::NAN, f64::INFINITY, -1.0];
    let shapes = bad.into_iter().flat_map(|bad| {
        [
            Shape::Uniform(Uniform {
                number_density_m3: Some(bad),
                ..fog()
            }),
            Shape::Uniform(Uniform {
                voxel_m: bad,
                ..fog()
            }),
            Shape::SeaSpray(SeaSpray {
                median_radius_um: bad,
                ..spray()
            }),
            Shape::Waterfall(Waterfall {
                height_m: bad,
                ..fall()
            }),
            Shape::Fountain(Fountain {
                speed_m_s: bad,
                ..fountain()
            }),
        ]
    });
    let without_end =
        [1e-3, 1e-300, 0.0].map(|voxel_m| Shape::Uniform(Uniform { voxel_m, ..fog() }));
    violations(
        shapes
            .chain(without_end)
            .map(|shape| shape.validate().is_err()),
    )
}

fn dry_shapes() -> f64 {
    let shapes = [
        Shape::Uniform(Uniform {
            number_density_m3: Some(0.0),
            ..fog()
        }),
        Shape::SeaSpray(SeaSpray {
            surface_lwc_g_m3: 0.0,
            ..spray()
        }),
        Shape::Waterfall(Waterfall {
            flow_kg_s: 0.0,
            ..fall()
        }),
        Shape::Fountain(Fountain {
            flow_kg_s: 0.0,
            ..fountain()
        }),
    ];
    worst(shapes.map(|shape| {
        let volume = shape.volume().expect("dry shapes are sound");
        volume.summary().n_nodes as f64
    }))
}
