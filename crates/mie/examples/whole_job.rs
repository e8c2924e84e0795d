//! Time and result of one sphere of water by each set of vector instructions, for comparisons with
//! other programs.
//!
//! `whole-job X N_ANGLES N_CALLS [INDEX ...]`: coefficients, efficiencies, and S1 and S2 at N
//! angles equally spaced from 0 to 180 degrees, in one thread, m = 1.333. Prints a line for each
//! set of instructions that this processor has: its name, the shortest of the calls in seconds, and
//! p11 at the angles of the given indices, separated by commas.

use std::error::Error;
use std::hint::black_box;
use std::time::Duration;
use std::time::Instant;

use niji_mie::RefractiveIndex;
use niji_mie::ScatteringAngles;
use niji_mie::Sphere;
use pulp::Arch;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [x, n_angles, n_calls, indices @ ..] = arguments.as_slice() else {
        return Err("expected: X N_ANGLES N_CALLS [INDEX ...]".into());
    };
    let (x, n_angles): (f64, u32) = (x.parse()?, n_angles.parse()?);
    let n_calls: u32 = n_calls.parse()?;
    let indices: Vec<usize> = indices
        .iter()
        .map(|index| index.parse())
        .collect::<Result<_, _>>()?;
    let last = f64::from(n_angles) - 1.0;
    let angles_deg: Vec<f64> = (0..n_angles).map(|i| 180.0 * f64::from(i) / last).collect();
    let angles = ScatteringAngles::from_degrees(&angles_deg)?;
    for (name, arch) in instructions() {
        let job = || -> Result<_, niji_mie::Error> {
            let sphere = Sphere::new(black_box(x), RefractiveIndex::from(1.333))?;
            let amplitudes = sphere.waves().amplitudes_by(&angles, arch);
            Ok((sphere, amplitudes))
        };
        let (sphere, amplitudes) = job()?;
        let mut shortest = Duration::MAX;
        for _ in 0..n_calls {
            let start = Instant::now();
            black_box(job()?);
            shortest = shortest.min(start.elapsed());
        }
        let p11 = sphere.p11(&amplitudes);
        let values: Vec<String> = indices
            .iter()
            .map(|index| p11.get(*index).map(|value| format!("{value:e}")))
            .collect::<Option<_>>()
            .ok_or("an index is not below N_ANGLES")?;
        println!("{name},{:e},{}", shortest.as_secs_f64(), values.join(","));
    }
    Ok(())
}

/// What can be chosen here, from plain products to the longest vectors.
fn instructions() -> Vec<(&'static str, Arch)> {
    let mut instructions = vec![("without dispatch", Arch::Scalar)];
    #[cfg(target_arch = "x86_64")]
    {
        let avx2 = pulp::x86::V3::try_new().map(Arch::V3);
        let avx512 = pulp::x86::V4::try_new().map(Arch::V4);
        instructions.extend(avx2.map(|arch| ("AVX2", arch)));
        instructions.extend(avx512.map(|arch| ("AVX-512", arch)));
    }
    #[cfg(target_arch = "aarch64")]
    {
        let neon = pulp::aarch64::Neon::try_new().map(Arch::Neon);
        instructions.extend(neon.map(|arch| ("NEON", arch)));
    }
    instructions
}
