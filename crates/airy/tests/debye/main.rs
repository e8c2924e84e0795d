//! Airy's and the uniform theory against the exact Debye series.

mod references;

use std::f64::consts::PI;
use std::f64::consts::TAU;

use niji_airy::AiryBow;
use niji_airy::BowDirection;
use niji_airy::UniformBow;
use niji_airy::airy_squares;
use niji_radiometry::Micrometers;
use niji_radiometry::Nanometers;
use niji_radiometry::Radians;
use references::BOWS;
use references::FAR;
use references::N;

/// Exact |S|² of one order for drops of one size.
struct Reference {
    x: f64,
    order: u32,
    /// Scattering angle in degrees, (|S1|², |S2|²).
    intensities: &'static [(f64, [f64; 2])],
}

/// |S_j|² = π x² t_j.
fn intensity(direction: BowDirection, x: f64) -> [f64; 2] {
    let wavelength = Nanometers(1000.0);
    let t = direction.normalized_cross_section(Micrometers(x / TAU), wavelength, airy_squares);
    t.map(|t| PI * x * x * t)
}

/// RMS of the difference over RMS of the reference.
fn rms(
    reference: &Reference,
    model: impl Fn(Radians) -> BowDirection,
    part: impl Fn([f64; 2]) -> f64,
) -> f64 {
    let (mut difference, mut square) = (0.0, 0.0);
    for (theta_deg, exact) in reference.intensities {
        let found = intensity(model(Radians::from_degrees(*theta_deg)), reference.x);
        difference += (part(found) - part(*exact)).powi(2);
        square += part(*exact).powi(2);
    }
    (difference / square).sqrt()
}

#[test]
fn print() {
    for bow in &BOWS {
        let uniform = UniformBow::new(N, bow.order).unwrap();
        let airy = AiryBow::new(N, bow.order).unwrap();
        let u = |t| uniform.direction(t);
        let a = |t| airy.direction(t);
        println!("p {} x {} uniform {:.2e} s {:.2e} p {:.2e} airy {:.2e} s {:.2e} p {:.2e}", bow.order, bow.x,
            rms(bow, u, |[s, p]| s + p), rms(bow, u, |[s, _]| s), rms(bow, u, |[_, p]| p),
            rms(bow, a, |[s, p]| s + p), rms(bow, a, |[s, _]| s), rms(bow, a, |[_, p]| p));
        if bow.x == 967.0 && bow.order < 4 { for (t, e) in bow.intensities {
            let f = intensity(u(Radians::from_degrees(*t)), bow.x);
            println!("   {t} {:?} {:?}", f.map(|x| x), [f[0]/e[0]-1.0, f[1]/e[1]-1.0]);
        } }
    }
    let uniform = UniformBow::new(N, 2).unwrap();
    for (t, e) in FAR[0].intensities {
        let d = uniform.direction(Radians::from_degrees(*t));
        let f = intensity(d, FAR[0].x);
        println!("far {t} {:?} {:?} {:?}", f, [f[0]/e[0]-1.0, f[1]/e[1]-1.0], d.rays);
    }
}
