//! Luminance of spectral pictures.

use ndarray::Array2;
use ndarray::Array3;
use ndarray::Axis;
use niji_radiometry::Colorimetry;
use niji_radiometry::WavelengthGrid;

/// Luminance by row and column [cd/m²] of radiance by wavelength, row and column [W m^-2 sr^-1 nm^-1].
///
/// # Panics
/// If `radiance` has not one plane for each wavelength.
///
/// ```
/// use ndarray::Array3;
/// use niji_exchange::luminance;
/// use niji_radiometry::WavelengthGrid;
///
/// let flat = Array3::from_elem((41, 1, 2), 1e-3);
/// let luminance_cd_m2 = luminance(&flat, &WavelengthGrid::visible());
/// assert!(luminance_cd_m2.iter().all(|it| (it - 72.98).abs() < 0.01));
/// ```
pub fn luminance(radiance: &Array3<f32>, wavelengths: &WavelengthGrid) -> Array2<f64> {
    let observer = Colorimetry::new(wavelengths);
    let weights = observer.weights();
    assert_eq!(
        radiance.dim().0,
        weights.len(),
        "one plane for each wavelength"
    );
    radiance.map_axis(Axis(0), |spectrum| {
        let terms = spectrum.into_iter().zip(weights);
        terms.map(|(value, [_, y, _])| f64::from(*value) * y).sum()
    })
}
