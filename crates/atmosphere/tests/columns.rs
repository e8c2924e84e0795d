//! Equivalent lengths against adaptive quadrature and against values from mpmath.

mod common;

use common::NISHITA_HEIGHT_M;
use common::RADIUS_M;
use common::exit;
use common::length;
use common::nishita;
use common::unit_sun_air;
use niji_atmosphere::AerosolKind;
use niji_atmosphere::AirComponent;
use niji_atmosphere::OpticalLength;
use niji_atmosphere::optical_length_m;

#[test]
fn scan() {
    let air = unit_sun_air(vec![
        AirComponent::RayleighNishita,
        AirComponent::Aerosol(AerosolKind::Clear.aerosol()),
        AirComponent::Ozone { column_dobson: 300.0 },
    ]);
    for c in 0..3 {
        let con = &air.constituents[c];
        let top = con.height_m[con.height_m.len() - 1];
        let density = |h: f64| con.density_at(h);
        for h in [-100.0, 0.0, 2.0, 137.0, 1500.0, 4321.0, 9e3, 13e3, 22e3, 26e3, 31e3, 39e3, 47e3, 73e3, 90e3, 99e3] {
            if h >= top { continue; }
            let mut worst = (0.0f64, 0.0, 0.0);
            let mut mus: Vec<f64> = (0..60).map(|i| (f64::from(i) / 59.3f64).powi(2)).collect();
            let dip = if h > 0.0 { ((2.0 * RADIUS_M + h) * h).sqrt() / (RADIUS_M + h) } else { 0.0 };
            if h > 0.0 { mus.extend((0..20).map(|i| -dip * (f64::from(i) + 0.3) / 20.1)); }
            for mu in mus {
                let mut refl = 0.0;
                let mut breaks = vec![0.0, exit(h, mu, top)];
                if c == 2 {
                    for k in [10e3, 25e3] {
                        let r0 = RADIUS_M + h;
                        let rt = RADIUS_M + k;
                        let d = r0 * r0 * (mu * mu - 1.0) + rt * rt;
                        if d > 0.0 {
                            for s in [-r0 * mu - d.sqrt(), -r0 * mu + d.sqrt()] {
                                if s > 0.0 && s < breaks[1] { breaks.push(s); }
                            }
                        }
                    }
                    breaks.sort_by(f64::total_cmp);
                }
                for w in breaks.windows(2) { refl += length(&density, [h, mu], [w[0], w[1]]); }
                for m in [OpticalLength::Table, OpticalLength::GaussLegendre { n_nodes: 16 }] {
                    let found = optical_length_m(&air, c, m, [h, mu]);
                    let e = (found / refl - 1.0).abs();
                    if m == OpticalLength::Table && e > worst.0 { worst = (e, mu, refl); }
                    if m != OpticalLength::Table && e > 1e-6 { println!("GL16 c{c} h{h} mu {mu}: {e:e}"); }
                }
            }
            println!("c{c} h {h}: worst {:e} at mu {} (ref {})", worst.0, worst.1, worst.2);
        }
    }
}
