//! What the rays of a pixel add up to.

use glam::Vec4;

use crate::air_error::AirError;
use crate::error_parts::RayErrors;
use crate::footprint_error::PixelLight;
use crate::picture_layers::N_CAUSES;
use crate::picture_layers::PictureLayer;
use crate::ray_light::RayLight;
use crate::spectra::weighted_sum;

/// The most that a pixel which stands for another may differ by in the light of a wavelength, relatively, and in what
/// it lets pass.
const MOST_OF_SPECTRUM: f64 = 0.02;
const MOST_TRANSMITTED: f64 = 2e-3;

/// Sums over the rays of a pixel.
#[derive(Clone)]
pub(crate) struct Pixel {
    pub(crate) radiance: Vec<f32>,
    pub(crate) bow_primary: Vec4,
    pub(crate) bow_secondary: Vec4,
    pub(crate) bow_multiple: Vec4,
    pub(crate) bow_reflected: Vec4,
    pub(crate) inscatter: Vec4,
    pub(crate) skylit: Vec4,
    pub(crate) sky: Vec4,
    pub(crate) lit_surface: Vec4,
    pub(crate) water: Vec4,
    pub(crate) transmittance: f64,
    pub(crate) light: f64,
    pub(crate) light_m: f64,
    pub(crate) light_tau_sun: f64,
    /// Luminance of all light that is not a bow's [cd/m²].
    pub(crate) beside_cd_m2: f32,
    /// What its rays differ by, as of `footprint_error::ray_steps`.
    pub(crate) ray_steps: [f32; 2],
    pub(crate) errors: RayErrors,
}

impl Pixel {
    pub(crate) fn dark(n_wavelengths: usize) -> Self {
        Self {
            radiance: vec![0.0; n_wavelengths],
            bow_primary: Vec4::ZERO,
            bow_secondary: Vec4::ZERO,
            bow_multiple: Vec4::ZERO,
            bow_reflected: Vec4::ZERO,
            inscatter: Vec4::ZERO,
            skylit: Vec4::ZERO,
            sky: Vec4::ZERO,
            lit_surface: Vec4::ZERO,
            water: Vec4::ZERO,
            transmittance: 0.0,
            light: 0.0,
            light_m: 0.0,
            light_tau_sun: 0.0,
            beside_cd_m2: 0.0,
            ray_steps: [0.0; 2],
            errors: RayErrors::default(),
        }
    }

    /// Darkness again, in the same memory.
    pub(crate) fn clear(&mut self) {
        let mut radiance = std::mem::take(&mut self.radiance);
        radiance.fill(0.0);
        *self = Self {
            radiance,
            ..Self::dark(0)
        };
    }

    /// Add part of another pixel: of its light `share`, of what must not leave the range of those it is made of, its
    /// errors and where its light comes from, `part`.
    pub(crate) fn add_pixel(&mut self, other: &Self, share: f32, part: f32) {
        for (sum, value) in self.radiance.iter_mut().zip(&other.radiance) {
            *sum += share * value;
        }
        for (sum, value) in self.layers_mut().into_iter().zip(other.layers()) {
            *sum += share * value;
        }
        self.beside_cd_m2 += share * other.beside_cd_m2;
        self.transmittance += f64::from(share) * other.transmittance;
        let part = f64::from(part);
        self.light += part * other.light;
        self.light_m += part * other.light_m;
        self.light_tau_sun += part * other.light_tau_sun;
        self.errors.add(part, 1.0, &other.errors);
    }

    /// Take back what a sum with negative shares puts below darkness, or above clear sight.
    pub(crate) fn keep_positive(&mut self) {
        for value in &mut self.radiance {
            *value = value.max(0.0);
        }
        for layer in self.layers_mut() {
            *layer = layer.max(Vec4::ZERO);
        }
        self.beside_cd_m2 = self.beside_cd_m2.max(0.0);
        self.transmittance = self.transmittance.clamp(0.0, 1.0);
    }

    /// How much another pixel differs from it [cd/m²]: the largest change of X, Y, Z, or as many times `most_cd_m2` as light
    /// of any wavelength, or what it lets pass, differs by times the most that they may.
    pub(crate) fn differs(&self, other: &Self, most_cd_m2: f64) -> f64 {
        let sum = |pixel: &Self| pixel.layers().into_iter().sum::<Vec4>();
        let xyz = f64::from((sum(self) - sum(other)).abs().max_element());
        let spectra = self.radiance.iter().zip(&other.radiance);
        let relative = spectra.map(|(a, b)| {
            let change = (a - b).abs();
            if change > 0.0 {
                change / a.max(*b)
            } else {
                0.0
            }
        });
        let relative = f64::from(relative.fold(0.0, f32::max));
        let transmitted = (self.transmittance - other.transmittance).abs();
        let times = (relative / MOST_OF_SPECTRUM).max(transmitted / MOST_TRANSMITTED);
        xyz.max(most_cd_m2 * times)
    }

    /// Its light by layers.
    fn layers(&self) -> [Vec4; 9] {
        [
            self.bow_primary,
            self.bow_secondary,
            self.bow_multiple,
            self.bow_reflected,
            self.inscatter,
            self.skylit,
            self.sky,
            self.lit_surface,
            self.water,
        ]
    }

    /// The same, to be changed.
    fn layers_mut(&mut self) -> [&mut Vec4; 9] {
        [
            &mut self.bow_primary,
            &mut self.bow_secondary,
            &mut self.bow_multiple,
            &mut self.bow_reflected,
            &mut self.inscatter,
            &mut self.skylit,
            &mut self.sky,
            &mut self.lit_surface,
            &mut self.water,
        ]
    }

    /// All light [cd/m²].
    pub(crate) fn luminance(&self) -> f64 {
        f64::from(self.bows_cd_m2() + self.beside_cd_m2)
    }

    /// Light of the bows [cd/m²].
    fn bows_cd_m2(&self) -> f32 {
        self.bow_primary.y + self.bow_secondary.y + self.bow_reflected.y
    }

    /// Add what the air's nodes err by at the pixel's place.
    pub(crate) fn add_air_error(&mut self, error: &AirError, place_px: (f64, f64)) {
        let air_cd_m2 = f64::from(self.beside_cd_m2 - self.bow_multiple.y);
        let bows_cd_m2 = f64::from(self.bows_cd_m2());
        self.errors.air += error.at(place_px) * air_cd_m2 + error.relative_of_bows * bows_cd_m2;
    }

    /// What an estimate of a footprint's error looks at; `surface_m` as there.
    pub(crate) fn seen_light(&self, surface_m: f32) -> PixelLight {
        PixelLight {
            surface_m,
            ray_steps: self.ray_steps,
            bow: self.bows_cd_m2(),
            beside: self.beside_cd_m2,
            light: self.light as f32,
        }
    }

    /// What a layer holds of it, channel by channel; nothing of what rays do not know: surfaces, and what their
    /// pixel misses.
    pub(crate) fn channels(&self, layer: PictureLayer) -> Channels {
        let xyz = |xyz: Vec4| Channels::of(&xyz.to_array()[..3]);
        let mean = |sum: f64| {
            if self.light > 0.0 {
                sum / self.light
            } else {
                0.0
            }
        };
        let single = |value: f64| Channels::of(&[value as f32]);
        match layer {
            PictureLayer::BowPrimary => xyz(self.bow_primary),
            PictureLayer::BowSecondary => xyz(self.bow_secondary),
            PictureLayer::BowMultiple => xyz(self.bow_multiple),
            PictureLayer::BowReflected => xyz(self.bow_reflected),
            PictureLayer::Inscatter => xyz(self.inscatter),
            PictureLayer::Skylit => xyz(self.skylit),
            PictureLayer::Sky => xyz(self.sky),
            PictureLayer::LitSurface => xyz(self.lit_surface),
            PictureLayer::Water => xyz(self.water),
            PictureLayer::Transmittance => single(self.transmittance),
            PictureLayer::TauSun => single(mean(self.light_tau_sun)),
            PictureLayer::Depth => single(mean(self.light_m)),
            PictureLayer::Surface => Channels::of(&[]),
            PictureLayer::Error => {
                let [a, b, c, d, e, f, g] = self.errors.parts();
                let all = [self.errors.together(), a, b, c, d, e, f, g];
                Channels::of(&all.map(|error| error as f32))
            }
        }
    }

    /// Add a ray that stands for `share` of the pixel.
    pub(crate) fn add(&mut self, light: &RayLight, share: f64, xyz_weights: &[Vec4]) {
        let share_f32 = share as f32;
        for (sum, bow) in self.radiance.iter_mut().zip(&light.bow) {
            *sum += share_f32 * bow;
        }
        for (sum, multiple) in self.radiance.iter_mut().zip(&light.multiple) {
            *sum += share_f32 * multiple;
        }
        let multiple = share_f32 * weighted_sum(&light.multiple, xyz_weights);
        self.bow_multiple += multiple;
        self.beside_cd_m2 += multiple.y;
        for (sum, reflected) in self.radiance.iter_mut().zip(light.reflected()) {
            *sum += share_f32 * reflected;
        }
        self.bow_reflected += share_f32 * weighted_sum(light.reflected(), xyz_weights);
        if light.glows {
            let parts = light.beside();
            for part in parts {
                for (sum, value) in self.radiance.iter_mut().zip(part) {
                    *sum += share_f32 * value;
                }
            }
            let parts = parts.map(|part| share_f32 * weighted_sum(part, xyz_weights));
            self.beside_cd_m2 += parts.iter().map(|part| part.y).sum::<f32>();
            let [inscatter, sky, skylit, lit_surface, water] = parts;
            self.errors.air += light.front_error * f64::from(inscatter.y);
            self.inscatter += inscatter;
            self.sky += sky;
            self.skylit += skylit;
            self.lit_surface += lit_surface;
            self.water += water;
        }
        let mut transmitted = 1.0;
        if light.light > 0.0 {
            let bow = weighted_sum(&light.bow, xyz_weights);
            if light.sunlit_cd_m2 > 0.0 {
                transmitted = f64::from(bow.y) / light.sunlit_cd_m2;
            }
            let bow = share_f32 * bow;
            if light.is_primary {
                self.bow_primary += bow;
            } else {
                self.bow_secondary += bow;
            }
        }
        self.transmittance += share * light.transmittance;
        self.light += share * light.light;
        self.light_m += share * light.light_m;
        self.light_tau_sun += share * light.light_tau_sun;
        self.errors.add(share, transmitted, &light.errors);
    }
}

/// A few values.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Channels {
    values: [f32; 1 + N_CAUSES],
    n: usize,
}

impl Channels {
    fn of(given: &[f32]) -> Self {
        let mut values = [0.0; 1 + N_CAUSES];
        values[..given.len()].copy_from_slice(given);
        Self {
            values,
            n: given.len(),
        }
    }

    pub(crate) fn iter(&self) -> impl Iterator<Item = &f32> {
        self.values[..self.n].iter()
    }
}
