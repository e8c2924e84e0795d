use super::*;

const SUN_RADIUS_RAD: f64 = 0.004_65;

/// Light of single drops of a bow, averaged over the sun's disc with a number of rings across it.
fn averaged(bow: (Bin, u32), radius: Micrometers, rings_per_disc: f64) -> Vec<f64> {
    let (bin, p) = bow;
    let order = BowTheory::Uniform.order(bin, p).unwrap();
    let middle_rad = match &order {
        Order::Uniform(bow) => bow.ray().theta_rad(),
        _ => unreachable!("the theory is uniform"),
    };
    let theta_rad: Vec<f64> = (-300..300)
        .map(|step| middle_rad + 3e-4 * f64::from(step))
        .collect();
    let range = (middle_rad - 0.12, middle_rad + 0.12);
    let step_rad = 2.0 * SUN_RADIUS_RAD / rings_per_disc;
    let places = Places::Rings(Rings::over(range, step_rad, SUN_RADIUS_RAD));
    let light_of_bow = BowLight::new(&order, &places);
    let mut light = vec![[0.0; 2]; places.n()];
    let single = MeanSquare::Single;
    let drops = LawDrops::new(BowTheory::Uniform, radius, bin.center, &single);
    light_of_bow.add_to(&mut light, &drops);
    let row = |rings: &Rings, theta_rad| rings.disc_row(theta_rad, SUN_RADIUS_RAD);
    let means = places.disc_average(&theta_rad, row).of_both(&light);
    means.into_iter().map(|[s, _]| s).collect()
}

#[test]
fn coarse_tables_average_the_sun_to_a_part_of_their_tolerance() {
    let red = Bin {
        center: Nanometers(650.0),
        width: Nanometers(10.0),
        index: 1.3312,
    };
    for (p, radius_um) in [(2, 1200.0), (3, 900.0), (3, 300.0)] {
        let radius = Micrometers(radius_um);
        let fine = averaged((red, p), radius, 160.0);
        let peak = fine.iter().copied().fold(0.0, f64::max);
        for tolerance in [1e-3, 5e-3, 2e-2] {
            let coarse = averaged((red, p), radius, rings_per_disc(tolerance));
            let squares = coarse.iter().zip(&fine).map(|(a, b)| (a - b).powi(2));
            let rms = (squares.sum::<f64>() / fine.len() as f64).sqrt();
            assert!(
                rms < 0.3 * tolerance * peak,
                "p = {p}, {radius_um} um, {tolerance}: {:e}",
                rms / peak
            );
        }
    }
}
