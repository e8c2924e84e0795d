//! Claims about lattices that collect water.

use super::*;

fn frame() -> Frame {
    let grid = GridBox {
        min: DVec3::new(-2.0, 1.0, 5.0),
        max: DVec3::new(2.0, 3.0, 8.0),
        voxel_m: 0.5,
    };
    Frame {
        grid,
        n_nodes: [8, 4, 6],
    }
}

/// A lattice with some parcels: place in voxels, water (g), radius (um).
fn lattice(parcels: &[([f64; 3], f64, f64)]) -> Lattice {
    let frame = frame();
    let mut sums = vec![[0.0; 3]; 8 * 4 * 6];
    let slab_nodes = frame.slab_planes() * 4 * 6;
    for (slab, nodes) in sums.chunks_mut(slab_nodes).enumerate() {
        for &(place, water_g, radius_um) in parcels {
            let parcel = Parcel {
                place: DVec3::from(place),
                water_g,
                radius_um,
            };
            frame.leave(&parcel, slab, nodes);
        }
    }
    Lattice { frame, sums }
}

#[test]
fn parcels_keep_water_and_center() {
    let mode = lattice(&[([2.3, 1.6, 4.9], 5.0, 300.0), ([7.0, 3.0, 5.0], 2.0, 300.0)])
        .mode()
        .unwrap();
    assert!((mode.total_water_g() / 7.0 - 1.0).abs() < 1e-6);
    // The mean of the nodes, weighted by number, is the mean of the parcels.
    let number = |drops: &Drops| f64::from(drops.number_density_m3);
    let total: f64 = mode.nodes().map(|(_, drops)| number(&drops)).sum();
    let center: DVec3 = mode
        .nodes()
        .map(|(node, drops)| DVec3::from(node.map(f64::from)) * number(&drops) / total)
        .sum();
    let expected = (DVec3::new(2.3, 1.6, 4.9) * 5.0 + DVec3::new(7.0, 3.0, 5.0) * 2.0) / 7.0;
    assert!(center.distance(expected) < 1e-6, "{center}");
}

#[test]
fn a_parcel_on_a_node_stays_there() {
    let mode = lattice(&[([3.0, 2.0, 1.0], 0.125, 250.0)]).mode().unwrap();
    assert_eq!(mode.nodes().count(), 1);
    // 1 g/m³ of drops of (4/3) pi 0.25³ mm³ = 0.06545 mm³.
    let drops = mode.drops([3, 2, 1]);
    assert!((f64::from(drops.number_density_m3) / 15_278.87 - 1.0).abs() < 1e-6);
    assert!((drops.effective_radius_m / 2.5e-4 - 1.0).abs() < 1e-6);
    assert!(drops.effective_variance < 1e-7);
}

#[test]
fn two_sizes_make_the_moments_of_their_mixture() {
    // As many drops of 1 mm as of 0.1 mm: r_e = 1.001/1.01 mm, v_e = 1.0001 1.01/1.001² - 1.
    let place = [4.0, 1.0, 2.0];
    let mode = lattice(&[(place, 1.0, 1000.0), (place, 1e-3, 100.0)])
        .mode()
        .unwrap();
    let drops = mode.drops([4, 1, 2]);
    assert!((f64::from(drops.effective_radius_m) / 0.991_089_109e-3 - 1.0).abs() < 1e-6);
    assert!((f64::from(drops.effective_variance) - 0.008_083_91).abs() < 1e-7);
}

#[test]
fn a_mixture_too_wide_for_a_gamma_law_keeps_area_and_water() {
    let place = [4.0, 1.0, 2.0];
    let mode = lattice(&[(place, 1.0, 2000.0), (place, 0.02, 20.0)])
        .mode()
        .unwrap();
    let drops = mode.drops([4, 1, 2]);
    assert_eq!(drops.effective_variance, MAX_EFFECTIVE_VARIANCE);
    assert!((mode.total_water_g() / 1.02 - 1.0).abs() < 1e-6);
    // r_e = 1.02/(1/2000 + 0.02/20) um.
    assert!((f64::from(drops.effective_radius_m) / 680e-6 - 1.0).abs() < 1e-6);
}
