//! The least time that a run could take: multiply-adds and bytes over the rates of this machine.

use std::fmt;
use std::fs;
use std::hint::black_box;
use std::io::Write;
use std::path::Path;
use std::time::Instant;

use niji_exchange::ScatteringTable;
use niji_exchange::SpectralImage;
use niji_exchange::TableFile;
use niji_radiometry::Micrometers;
use niji_radiometry::size_parameter;
use niji_scatter::Theory;
use pulp::Arch;
use pulp::Simd;
use pulp::WithSimd;

use super::Result;

/// Independent sums, enough to hide the latency of a multiply-add.
const N_SUMS: usize = 16;
const N_STEPS: u32 = 4_000_000;
const N_TRIALS: usize = 5;
const N_BYTES: usize = 64 << 20;
/// Of a wave of Lorenz and Mie's series at an angle and its mirror: one for the next angular function, four
/// for the sums.
const PER_WAVE: f64 = 5.0;
/// A F + B G.
const PER_ORDER: f64 = 2.0;

/// What one processor of this machine does in a second.
pub(super) struct Rates {
    multiply_adds: f64,
    written_bytes: f64,
}

impl fmt::Display for Rates {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let (multiply_adds, bytes) = (self.multiply_adds / 1e9, self.written_bytes / 1e9);
        write!(
            f,
            "a processor: {multiply_adds:.1}e9 multiply-adds (f64) and {bytes:.2} GB written a second"
        )
    }
}

/// Multiply-adds in the longest vectors there are; their number a second.
struct MultiplyAdds;

#[allow(
    clippy::inline_always,
    reason = "only what is inlined gets the processor's instructions"
)]
impl WithSimd for MultiplyAdds {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> f64 {
        let start = Instant::now();
        let [factor, term] = [0.999, 0.5].map(|value| simd.splat_f64s(black_box(value)));
        let mut sums = [term; N_SUMS];
        for _ in 0..N_STEPS {
            for sum in &mut sums {
                *sum = simd.mul_add_f64s(*sum, factor, term);
            }
        }
        black_box(sums);
        let n_lanes = size_of::<S::f64s>() / size_of::<f64>();
        (N_SUMS * n_lanes) as f64 * f64::from(N_STEPS) / start.elapsed().as_secs_f64()
    }
}

impl Rates {
    /// The best of some trials.
    pub(super) fn measured() -> Result<Self> {
        let folder = tempfile::tempdir()?;
        let bytes = vec![1_u8; N_BYTES];
        let mut rates = Self {
            multiply_adds: 0.0,
            written_bytes: 0.0,
        };
        for trial in 0..N_TRIALS {
            let done = Arch::new().dispatch(MultiplyAdds);
            rates.multiply_adds = rates.multiply_adds.max(done);
            let start = Instant::now();
            let mut file = fs::File::create(folder.path().join(trial.to_string()))?;
            file.write_all(&bytes)?;
            let done = N_BYTES as f64 / start.elapsed().as_secs_f64();
            rates.written_bytes = rates.written_bytes.max(done);
        }
        Ok(rates)
    }

    /// The least seconds of one processor for some work.
    pub(super) fn bound_s(&self, work: &Work) -> f64 {
        work.multiply_adds / self.multiply_adds + work.written_bytes / self.written_bytes
    }
}

/// What cannot be left out of a run.
pub(super) struct Work {
    multiply_adds: f64,
    written_bytes: f64,
}

impl Work {
    /// That of what a run left in a folder.
    pub(super) fn of(folder: &Path, written_bytes: f64) -> Result<Self> {
        let table = folder.join("scatter.exr");
        let table = if table.is_file() {
            of_table(&ScatteringTable::from_file(TableFile::read(&table)?)?)
        } else {
            0.0
        };
        let picture = SpectralImage::read_spectral(&folder.join("image.exr"))?;
        Ok(Self {
            // Of both polarizations.
            multiply_adds: table + 2.0 * picture.radiance.len() as f64,
            written_bytes,
        })
    }
}

/// Multiply-adds of a table.
fn of_table(table: &ScatteringTable) -> f64 {
    if table.theory != Theory::Mie.name() {
        let n_orders = table.orders.split(',').count();
        return PER_ORDER * n_orders as f64 * table.values.len() as f64;
    }
    let waves = |radius_um: &f64, wavelength| {
        let x = size_parameter(Micrometers(*radius_um), wavelength);
        x + 4.05 * x.cbrt() + 2.0
    };
    let of_wavelength = |wavelength| {
        let radii = table.effective_radius_um.iter();
        radii.map(|radius| waves(radius, wavelength)).sum::<f64>()
    };
    let n_waves: f64 = table.wavelengths.centers().map(of_wavelength).sum();
    PER_WAVE * n_waves * 0.5 * table.theta_rad.len() as f64
}
