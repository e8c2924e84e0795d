//! The scattering table, laid out for rays.
//!
//! With the sun in one direction the scattering angle theta is the same all along a ray. So a ray needs one
//! row of the table, t(lambda; r_e, v_e) at its theta, and of that only the sizes it meets: natural light at the
//! angles that the picture sees, turned size by size when a ray first meets it (see `size_rows`). f32 as in
//! the file.

use std::borrow::Cow;
use std::sync::OnceLock;
use std::sync::atomic::AtomicBool;
use std::sync::atomic::AtomicU64;
use std::sync::atomic::Ordering;

use niji_exchange::ScatteringTable;
use pulp::Arch;
use pulp::Simd;
use pulp::WithSimd;

use crate::angle_axis::AngleAxis;
use crate::angle_axis::RayPlace;
use crate::angle_axis::RowTerm;
use crate::error::Error;
use crate::error::Input;
use crate::size_axes::SizeAxes;
use crate::size_axes::SizeBins;
use crate::size_nodes::SizeNodes;
use crate::size_rows::RowSource;

/// Rows by size and angle.
#[derive(Debug)]
pub(crate) struct ScatteringRows<'a> {
    axes: SizeAxes,
    angles: AngleAxis,
    source: RowSource<'a>,
    n_wavelengths: usize,
    /// Spectra of the sizes that a ray has met, [angle, wavelength] [1/sr].
    sizes: Vec<OnceLock<Vec<f32>>>,
    /// Their luminance in sunlight [cd/m² per unit of light], [angle, size]: a ray looks at
    /// many sizes at few angles. The low 32 bits are the value, the high ones how it bends over the angle; 0 is
    /// not computed yet.
    luminance: Vec<AtomicU64>,
    /// Whether all that rays have met is 0 or more, and finite.
    are_sound: AtomicBool,
}

/// What a ray asks of the rows: nodes of the angle, with weights that sum to 1, and the sizes
/// that it has light of.
#[derive(Clone, Debug, Default)]
pub(crate) struct RowStencil {
    terms: Vec<RowTerm>,
    /// The node above the last ray, from which the search for the next one starts.
    near: usize,
    /// Bins that hold light and how much, in ascending order.
    lit: Vec<(usize, f32)>,
    /// Room for the luminance of a stretch of bins.
    luminance: Vec<f64>,
}

/// Luminance of the light of a ray [cd/m²], and how its rows bend between sizes.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct SunlitLuminance {
    pub(crate) value: f64,
    /// Second difference over the nodes of the table's radius axis, of all light.
    pub(crate) bend: f64,
    /// The same of the light at each node by itself, signs left out.
    pub(crate) kinks: f64,
    /// What the rows of all light lie off their straight lines between angles, signs left out; twice that where they bend evenly [cd/m²].
    pub(crate) off_lines: f64,
}

impl SunlitLuminance {
    /// Add that of a share of other light.
    pub(crate) fn add(&mut self, share: f64, other: &Self) {
        self.value += share * other.value;
        self.bend += share * other.bend;
        self.kinks += share * other.kinks;
        self.off_lines += share * other.off_lines;
    }
}

impl RowStencil {
    /// The light that was taken note of.
    pub(crate) fn light(&self) -> &[(usize, f32)] {
        &self.lit
    }

    /// Take note of the light of a ray.
    pub(crate) fn set_light(&mut self, bins: &SizeBins) {
        self.lit.clear();
        self.lit.extend(bins.iter());
    }
}

impl<'a> ScatteringRows<'a> {
    /// The rows between two angles, two nodes beyond each, so that how rows bend does not depend on the
    /// range; `luminance_weights` turn a spectrum of the table's unit into luminance.
    pub(crate) fn new(
        (table, nodes): (Cow<'a, ScatteringTable>, SizeNodes),
        theta_range_rad: (f64, f64),
        luminance_weights: &[f64],
    ) -> Self {
        let angles = &table.theta_rad;
        let first = angles
            .partition_point(|theta| *theta <= theta_range_rad.0)
            .saturating_sub(2);
        let end =
            (angles.partition_point(|theta| *theta < theta_range_rad.1) + 2).min(angles.len());
        let axes = nodes.axes();
        let n_values = (end - first) * axes.n_bins();
        Self {
            n_wavelengths: table.wavelengths.len(),
            sizes: vec![OnceLock::new(); axes.n_bins()],
            luminance: std::iter::repeat_with(AtomicU64::default)
                .take(n_values)
                .collect(),
            axes,
            angles: AngleAxis::new(&angles[first..end]),
            source: RowSource::new((table, nodes), first..end, luminance_weights),
            are_sound: AtomicBool::new(true),
        }
    }

    /// Whether what rays have met of the table is 0 or more, and finite.
    ///
    /// # Errors
    /// [`Error::BadTable`] if not.
    pub(crate) fn check(&self) -> Result<(), Error> {
        if self.are_sound.load(Ordering::Relaxed) {
            return Ok(());
        }
        Err(Error::BadTable {
            input: Input::ScatteringTable,
            reason: "a value is negative or not finite",
        })
    }

    /// Spectra of a size, turned by the first who asks for it.
    #[inline]
    fn size(&self, bin: usize) -> &[f32] {
        self.sizes[bin].get_or_init(|| {
            let rows = self.source.rows(bin);
            self.are_sound.fetch_and(rows.is_sound, Ordering::Relaxed);
            let places = (bin..).step_by(self.axes.n_bins());
            for (place, node) in places.zip(rows.luminance) {
                self.luminance[place].store(packed(node.value, node.bend), Ordering::Relaxed);
            }
            rows.values_sr1
        })
    }

    /// Luminance of a size at weighted nodes of the angle, and what it lies off the straight lines between
    /// them.
    #[inline]
    fn luminance_of(&self, bin: usize, terms: &[RowTerm]) -> (f64, f64) {
        terms.iter().fold((0.0, 0.0), |(sum, off), term| {
            let place = term.node * self.axes.n_bins() + bin;
            let mut bits = self.luminance[place].load(Ordering::Relaxed);
            if bits == 0 {
                self.size(bin);
                bits = self.luminance[place].load(Ordering::Relaxed);
            }
            let (value, bend) = unpacked(bits);
            let off = off + f64::from(term.bend_weight) * f64::from(bend);
            (sum + f64::from(term.weight) * f64::from(value), off)
        })
    }

    /// The size axes.
    pub(crate) fn axes(&self) -> &SizeAxes {
        &self.axes
    }

    /// The axis of angles.
    pub(crate) fn angles(&self) -> &AngleAxis {
        &self.angles
    }

    /// Take note of where a ray stands.
    pub(crate) fn stencil(&self, place: &RayPlace, stencil: &mut RowStencil) {
        let RowStencil { terms, near, .. } = stencil;
        self.angles.set_terms(place, near, terms);
    }

    /// Take note of a Gaussian of angles, by its mean and standard deviation, on which a ray has light.
    pub(crate) fn gaussian_stencil(&self, gaussian_rad: (f64, f64), stencil: &mut RowStencil) {
        let RowStencil { terms, near, .. } = stencil;
        self.angles.set_gaussian_terms(gaussian_rad, near, terms);
    }

    /// Set `spectrum` [1/sr] to the rows of the light of a ray, by the widest vectors that the processor
    /// has.
    pub(crate) fn shade(&self, stencil: &RowStencil, spectrum: &mut [f32]) {
        Arch::new().dispatch(Shading {
            rows: self,
            stencil,
            spectrum,
        });
    }

    /// Luminance in sunlight of the light of a ray.
    pub(crate) fn luminance(&self, stencil: &mut RowStencil) -> SunlitLuminance {
        let RowStencil {
            terms,
            lit,
            luminance,
            ..
        } = stencil;
        let (Some((first, _)), Some((last, _))) = (lit.first(), lit.last()) else {
            return SunlitLuminance::default();
        };
        let (stride, n_bins) = (self.axes.n_variances(), self.axes.n_bins());
        // From the neighbors of the first to those of the last; 0 is not known yet.
        let start = first.saturating_sub(stride);
        luminance.clear();
        luminance.resize(last + stride + 1 - start, 0.0);
        let mut of_light = SunlitLuminance::default();
        for (bin, light) in lit.iter() {
            let (value, off) = self.luminance_of(*bin, terms);
            luminance[bin - start] = value;
            of_light.off_lines += f64::from(*light) * off;
        }
        for &(bin, light) in lit.iter() {
            let (light, here) = (f64::from(light), luminance[bin - start]);
            of_light.value += light * here;
            if bin >= stride && bin + stride < n_bins {
                let [before, after] = [bin - stride, bin + stride].map(|bin| {
                    let known = &mut luminance[bin - start];
                    if *known == 0.0 {
                        *known = self.luminance_of(bin, terms).0;
                    }
                    *known
                });
                let kink = light * (before - 2.0 * here + after);
                of_light.bend += kink;
                of_light.kinks += kink.abs();
            }
        }
        of_light
    }
}

/// Rows to be added up. Each wavelength is summed by itself, with products and sums in one order: the
/// same bits for vectors of any width.
struct Shading<'a> {
    rows: &'a ScatteringRows<'a>,
    stencil: &'a RowStencil,
    spectrum: &'a mut [f32],
}

// A type, because closures are inlined as the compiler likes, and a function of its own would have the
// narrowest vectors again.
#[allow(clippy::inline_always, reason = "as the lines above say")]
impl WithSimd for Shading<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) {
        let mut first = 0;
        while first < self.spectrum.len() {
            first += match (self.spectrum.len() - first).div_ceil(S::F32_LANES) {
                // Sums, a factor and a product have 16 registers; rows are read once for 41 and 81
                // wavelengths in vectors of eight.
                9.. => self.add_rows::<S, 12>(simd, first),
                7.. => self.add_rows::<S, 8>(simd, first),
                5.. => self.add_rows::<S, 6>(simd, first),
                3.. => self.add_rows::<S, 4>(simd, first),
                2.. => self.add_rows::<S, 2>(simd, first),
                _ => self.add_rows::<S, 1>(simd, first),
            };
        }
    }
}

#[allow(clippy::inline_always, reason = "as above")]
impl Shading<'_> {
    /// `N` vectors of wavelengths from `first` on, kept in registers over all rows; their number of
    /// wavelengths. A vector may end behind the last wavelength: what it reads there is not kept.
    #[inline(always)]
    fn add_rows<S: Simd, const N: usize>(&mut self, simd: S, first: usize) -> usize {
        let n_wavelengths = N * S::F32_LANES;
        let mut sums = [simd.splat_f32s(0.0); N];
        for &(bin, light) in &self.stencil.lit {
            let size = self.rows.size(bin);
            for term in &self.stencil.terms {
                let start = term.node * self.rows.n_wavelengths + first;
                let row = &size[start..start + n_wavelengths];
                let scale = simd.splat_f32s(light * term.weight);
                for (sum, value) in sums.iter_mut().zip(S::as_simd_f32s(row).0) {
                    *sum = simd.add_f32s(*sum, simd.mul_f32s(scale, *value));
                }
            }
        }
        let left = &mut self.spectrum[first..];
        if let Some(whole) = S::as_mut_simd_f32s(left).0.first_chunk_mut::<N>() {
            *whole = sums;
        } else {
            for (place, sum) in left.chunks_mut(S::F32_LANES).zip(sums) {
                simd.partial_store_f32s(place, sum);
            }
        }
        n_wavelengths
    }
}

/// A value and its bend in one, to be read and written at once.
fn packed(value: f32, bend: f32) -> u64 {
    u64::from(bend.to_bits()) << 32 | u64::from(value.to_bits())
}

#[inline]
fn unpacked(bits: u64) -> (f32, f32) {
    (
        f32::from_bits(bits as u32),
        f32::from_bits((bits >> 32) as u32),
    )
}

#[cfg(test)]
mod tests {
    use ndarray::Array5;
    use niji_radiometry::Water;
    use niji_radiometry::WavelengthGrid;

    use niji_exchange::RowUse;

    use super::*;

    /// t = theta (1 + bin) (1 + wavelength) 2, s and p apart by a factor 3.
    fn table() -> ScatteringTable {
        let wavelengths = WavelengthGrid::new(500.0, 50.0, 3).unwrap();
        let theta_rad: Vec<f64> = (0..=20).map(|step| 2.0 + 0.05 * f64::from(step)).collect();
        let values = Array5::from_shape_fn((2, 4, 1, 3, 21), |(j, r, _, w, a)| {
            let of_size = (1 + r) as f64 * (1 + w) as f64;
            ([0.5, 1.5][j] * theta_rad[a] * of_size * 2.0) as f32
        });
        ScatteringTable {
            theory: "test".into(),
            orders: "all".into(),
            wavelengths,
            theta_rad,
            effective_radius_um: vec![10.0, 20.0, 40.0, 80.0],
            effective_variance: vec![0.0],
            values,
            moved: None,
            row_use: RowUse::Laws,
            relative_error: 5e-3,
            sun_disc_diameter_rad: 0.0,
            split_theta_rad: 2.2,
            forward_fraction_left_out: 0.0,
            water: Water::pure(20.0),
            phase_functions: None,
            interpolation_error: None,
        }
    }

    /// The rows of a table between two angles, at its own sizes.
    fn rows_of(table: Cow<ScatteringTable>, range_rad: (f64, f64)) -> ScatteringRows {
        let nodes = SizeNodes::of_table(&table);
        let weights = vec![1.0; table.wavelengths.len()];
        ScatteringRows::new((table, nodes), range_rad, &weights)
    }

    fn rows() -> ScatteringRows<'static> {
        let table = table();
        let nodes = SizeNodes::of_table(&table);
        ScatteringRows::new((Cow::Owned(table), nodes), (2.3, 2.61), &[0.0, 1.0, 0.0])
    }

    /// The spectrum of twice a unit of light of the third size.
    fn shaded(rows: &ScatteringRows, theta_rad: f64, width_rad: f64) -> Vec<f32> {
        let place = RayPlace {
            theta_rad,
            width_rad,
        };
        let mut stencil = RowStencil::default();
        rows.stencil(&place, &mut stencil);
        let sum: f32 = stencil.terms.iter().map(|term| term.weight).sum();
        assert!((sum - 1.0).abs() < 1e-5);
        let mut bins = SizeBins::new(rows.axes());
        bins.add(rows.axes().place(1.0, 40.0, 1600.0), 2.0);
        let mut spectrum = vec![0.0; 3];
        stencil.set_light(&bins);
        rows.shade(&stencil, &mut spectrum);
        let luminance = rows.luminance(&mut stencil).value;
        assert!((luminance / f64::from(spectrum[1]) - 1.0).abs() < 1e-5);
        spectrum
    }

    fn agrees(spectrum: &[f32], theta_rad: f64) -> bool {
        (1..).zip(spectrum).all(|(wavelength, value)| {
            let expected = 2.0 * theta_rad * 3.0 * f64::from(wavelength) * 2.0;
            (f64::from(*value) / expected - 1.0).abs() < 1e-5
        })
    }

    #[test]
    fn natural_light_of_a_linear_table_is_reproduced() {
        for theta in [2.3, 2.33, 2.5, 2.61] {
            assert!(agrees(&shaded(&rows(), theta, 0.0), theta));
        }
    }

    #[test]
    fn the_mean_of_a_linear_table_over_an_interval_is_its_middle() {
        for width in [0.0, 1e-4, 0.02, 0.2] {
            assert!(agrees(&shaded(&rows(), 2.45, width), 2.45));
        }
    }

    /// A table of a function of the angle over uneven steps.
    fn curved(value: impl Fn(f64) -> f64) -> ScatteringTable {
        let mut table = table();
        table.theta_rad = (0..=20)
            .map(|step| 2.0 + 0.05 * f64::from(step) + 0.01 * f64::from(step % 3))
            .collect();
        let theta = table.theta_rad.clone();
        let at = |(_, _, _, _, a): (usize, usize, usize, usize, usize)| value(theta[a]) as f32;
        table.values = Array5::from_shape_fn(table.values.dim(), at);
        table
    }

    /// Luminance of twice a unit of light between two sizes.
    fn seen(rows: &ScatteringRows, theta_rad: f64, width_rad: f64) -> SunlitLuminance {
        let place = RayPlace {
            theta_rad,
            width_rad,
        };
        let mut bins = SizeBins::new(rows.axes());
        bins.add(rows.axes().place(1.0, 29.0, 29.0 * 29.0), 2.0);
        let mut stencil = RowStencil::default();
        stencil.set_light(&bins);
        rows.stencil(&place, &mut stencil);
        rows.luminance(&mut stencil)
    }

    #[test]
    fn twice_what_a_parabola_is_off_its_chords_is_told() {
        let table = curved(|theta| theta * theta);
        let source = (Cow::Borrowed(&table), SizeNodes::of_table(&table));
        let rows = ScatteringRows::new(source, (2.2, 2.7), &[0.0, 1.0, 0.0]);
        for theta_rad in [2.3, 2.4, 2.43, 2.6_f64] {
            for width_rad in [0.0, 1e-3, 0.02, 0.15_f64] {
                let found = seen(&rows, theta_rad, width_rad);
                let of_angles = theta_rad.powi(2) + width_rad.powi(2) / 12.0;
                let off = found.value - 2.0 * of_angles;
                // Of values in f32 are second differences and means.
                assert!(off > -2e-6, "{off}");
                let told = found.off_lines;
                assert!((told - 2.0 * off).abs() < 8e-6, "{off} {told}");
            }
        }
    }

    #[test]
    fn what_is_told_does_not_depend_on_the_range_of_angles() {
        let table = curved(|theta| 1.0 + (5.0 * theta).sin());
        let [narrow, wide] =
            [(2.31, 2.46), (2.0, 3.0)].map(|range| rows_of(Cow::Borrowed(&table), range));
        for (theta_rad, width_rad) in [(2.31, 0.0), (2.46, 0.0), (2.385, 0.15)] {
            let [narrow, wide] = [&narrow, &wide].map(|rows| seen(rows, theta_rad, width_rad));
            assert!(wide.off_lines > 0.0);
            assert_eq!(narrow.off_lines, wide.off_lines, "{theta_rad}");
        }
    }

    #[test]
    fn spectra_have_the_same_bits_with_and_without_wide_vectors() {
        let values = Array5::from_shape_fn((2, 4, 1, 37, 21), |(j, r, _, w, a)| {
            (1.0 + (7 * a + 3 * w + 5 * r + j) as f32).sqrt()
        });
        let table = ScatteringTable {
            wavelengths: WavelengthGrid::new(400.0, 8.0, 37).unwrap(),
            values,
            ..table()
        };
        let rows = rows_of(Cow::Owned(table), (2.0, 3.0));
        let mut bins = SizeBins::new(rows.axes());
        for (radius, light) in [(11.0, 0.3), (23.0, 0.7), (70.0, 0.2)] {
            bins.add(rows.axes().place(1.0, radius, radius * radius), light);
        }
        // Two, three and eight angles.
        for width_rad in [0.0, 0.04, 0.3] {
            let place = RayPlace {
                theta_rad: 2.51,
                width_rad,
            };
            let mut stencil = RowStencil::default();
            rows.stencil(&place, &mut stencil);
            let (mut wide, mut narrow) = ([0.0; 37], [0.0; 37]);
            stencil.set_light(&bins);
            rows.shade(&stencil, &mut wide);
            let shading = Shading {
                rows: &rows,
                stencil: &stencil,
                spectrum: &mut narrow,
            };
            shading.with_simd(pulp::Scalar::new());
            assert_eq!(wide, narrow);
        }
    }

    #[test]
    fn a_table_with_nan_is_refused_where_a_ray_meets_it() {
        let mut table = table();
        table.values[[1, 2, 0, 1, 8]] = f32::NAN;
        let rows = rows_of(Cow::Owned(table), (2.3, 2.61));
        let meet = |radius_um: f32| {
            let mut bins = SizeBins::new(rows.axes());
            let place = rows.axes().place(1.0, radius_um, radius_um * radius_um);
            bins.add(place, 1.0);
            let mut spectrum = [0.0; 3];
            let mut stencil = RowStencil::default();
            stencil.set_light(&bins);
            rows.shade(&stencil, &mut spectrum);
        };
        meet(10.0);
        assert!(rows.check().is_ok());
        meet(40.0);
        assert!(matches!(rows.check(), Err(Error::BadTable { .. })));
    }
}
