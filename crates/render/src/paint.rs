//! Colors of a mesh by place: a reflectance a material, or a texture.
//!
//! R = sum_k w_k R_k,   x = u W - 1/2,  y = v H - 1/2,   w = (1 - {x}, {x}) (1 - {y}, {y})
//! `u`, `v` texture coordinates of the place, `W` x `H` texels with middles at whole x and y, `{x}` what is left of x over
//! a whole number, `R_k` smooth spectra of the colors of the four texels around (`niji_radiometry::Reflectance`).
//! Spectra are mixed, so that the color between texels is that of light and as linear as it is in their red, green and
//! blue. A texture is not averaged over a pixel: its rays are, as many as the estimate of their error asks for.
//! OpenGL 4.6 Core Profile Specification (2022), section 8.14: texels, weights and what lies beyond the sides.
//!
//! A spectrum takes microseconds to find, so each color of a texture has one, found when a ray first meets it.

use std::collections::HashMap;
use std::sync::OnceLock;

use glam::DVec2;
use ndarray::Array2;
use niji_geometry::TextureWrap;
use niji_radiometry::Nanometers;
use niji_radiometry::Reflectance;

/// What a surface gives back.
#[derive(Clone, Debug, PartialEq)]
pub enum SurfaceColor {
    /// As much everywhere.
    Plain(Reflectance),
    /// As its materials say, of a mesh that has some.
    Painted(Paint),
}

impl From<Reflectance> for SurfaceColor {
    fn from(reflectance: Reflectance) -> Self {
        Self::Plain(reflectance)
    }
}

/// What a mesh gives back by the materials of its triangles.
#[derive(Clone, Debug, PartialEq)]
pub struct Paint {
    /// By the number that triangles have.
    pub materials: Vec<Material>,
    /// By the number that materials have.
    pub textures: Vec<Texture>,
}

/// What a material gives back.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Material {
    /// As much everywhere.
    Even(Reflectance),
    /// A texture of the paint.
    Texture(usize),
}

/// A picture on a surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Texture {
    size: (u32, u32),
    /// Numbers of their colors, row by row.
    texels: Vec<u32>,
    colors: Vec<Color>,
    wraps: [TextureWrap; 2],
}

#[derive(Clone, Debug)]
struct Color {
    rgb: [f64; 3],
    reflectance: OnceLock<Reflectance>,
}

/// What was found of it follows from it.
impl PartialEq for Color {
    fn eq(&self, other: &Self) -> bool {
        self.rgb == other.rgb
    }
}

impl Color {
    fn reflectance(&self) -> Reflectance {
        *self
            .reflectance
            .get_or_init(|| Reflectance::of_rgb(self.rgb))
    }
}

/// A place on a painted mesh: its material, and texture coordinates right and down.
pub(crate) type Painted = (u32, DVec2);

/// Spectra and how much of each.
pub(crate) struct Mix {
    parts: [(f64, Reflectance); 4],
}

impl Mix {
    fn of(reflectance: Reflectance) -> Self {
        let nothing = (0.0, Reflectance::Even(0.0));
        Self {
            parts: [(1.0, reflectance), nothing, nothing, nothing],
        }
    }

    /// What is given back of a wavelength, 0..1.
    pub(crate) fn at(&self, wavelength: Nanometers) -> f64 {
        let parts = self.parts.iter().filter(|(weight, _)| *weight > 0.0);
        parts.map(|(weight, it)| weight * it.at(wavelength)).sum()
    }
}

impl Paint {
    /// What a place gives back; nothing where its material is none of these.
    pub(crate) fn at(&self, (material, uv): Painted) -> Mix {
        let nothing = Mix::of(Reflectance::Even(0.0));
        match self.materials.get(material as usize) {
            Some(Material::Even(reflectance)) => Mix::of(*reflectance),
            Some(Material::Texture(index)) => {
                (self.textures.get(*index)).map_or(nothing, |texture| texture.at(uv))
            }
            None => nothing,
        }
    }

    /// What each of its materials gives back in the mean.
    pub(crate) fn means(&self) -> Vec<Reflectance> {
        let mean = |material: &Material| match material {
            Material::Even(reflectance) => *reflectance,
            Material::Texture(index) => {
                (self.textures.get(*index)).map_or(Reflectance::Even(0.0), Texture::mean)
            }
        };
        self.materials.iter().map(mean).collect()
    }
}

impl Texture {
    /// Bytes that a texel takes, and a color.
    pub const BYTES: [usize; 2] = [size_of::<u32>(), size_of::<Color>()];

    /// A picture of linear Rec.709, 0..1, first row on top, times a color.
    ///
    /// # Panics
    /// If it has no pixel.
    #[must_use]
    pub fn new(light: &Array2<[f32; 3]>, factor: [f64; 3], wraps: [TextureWrap; 2]) -> Self {
        let (height, width) = light.dim();
        assert!(width > 0 && height > 0, "a picture has pixels");
        let mut numbers = HashMap::new();
        let mut colors = Vec::new();
        let texels = light.iter().map(|rgb| {
            *numbers.entry(rgb.map(f32::to_bits)).or_insert_with(|| {
                let rgb = [0, 1, 2].map(|channel| factor[channel] * f64::from(rgb[channel]));
                let reflectance = OnceLock::new();
                colors.push(Color { rgb, reflectance });
                colors.len() as u32 - 1
            })
        });
        Self {
            size: (width as u32, height as u32),
            texels: texels.collect(),
            colors,
            wraps,
        }
    }

    /// How many different colors it has.
    #[must_use]
    pub fn n_colors(&self) -> usize {
        self.colors.len()
    }

    fn at(&self, uv: DVec2) -> Mix {
        let (width, height) = self.size;
        let (columns, across) = around(uv.x * f64::from(width) - 0.5, (self.wraps[0], width));
        let (rows, down) = around(uv.y * f64::from(height) - 0.5, (self.wraps[1], height));
        let texel = |row: u32, column: u32| {
            let index = row as usize * width as usize + column as usize;
            self.texels[index] as usize
        };
        let corners = [(0, 0), (0, 1), (1, 0), (1, 1)];
        let colors = corners.map(|(row, column)| texel(rows[row], columns[column]));
        // One color is itself to the last bit.
        if colors.iter().all(|color| *color == colors[0]) {
            return Mix::of(self.colors[colors[0]].reflectance());
        }
        let part = |index: usize| {
            let (row, column) = corners[index];
            let weight = down[row] * across[column];
            let color = &self.colors[colors[index]];
            (weight, color.reflectance())
        };
        Mix {
            parts: [0, 1, 2, 3].map(part),
        }
    }

    fn mean(&self) -> Reflectance {
        let mut sum = [0.0; 3];
        for texel in &self.texels {
            let rgb = self.colors[*texel as usize].rgb;
            sum = [0, 1, 2].map(|channel| sum[channel] + rgb[channel]);
        }
        Reflectance::of_rgb(sum.map(|sum| sum / self.texels.len() as f64))
    }
}

/// The two of `n` texels around a place along a side, and their weights.
fn around(place: f64, (wrap, n): (TextureWrap, u32)) -> ([u32; 2], [f64; 2]) {
    // Beyond 2^52 all places are whole.
    let first = place.floor().clamp(-4.5e15, 4.5e15);
    let over = (place - first).clamp(0.0, 1.0);
    let texels = [0, 1].map(|next| wrap.texel(first as i64 + next, n));
    (texels, [1.0 - over, over])
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::array;

    const RED: [f32; 3] = [0.5, 0.1, 0.1];
    const GREEN: [f32; 3] = [0.1, 0.6, 0.2];

    fn texture(wrap: TextureWrap) -> Texture {
        Texture::new(&array![[RED, GREEN, GREEN, GREEN]], [1.0; 3], [wrap; 2])
    }

    #[test]
    fn texels_have_their_color_in_their_middle_and_the_mean_between_them() {
        let texture = texture(TextureWrap::Repeat);
        let at = |u: f64| texture.at(DVec2::new(u, 0.3)).at(Nanometers(620.0));
        let [red, green] =
            [RED, GREEN].map(|rgb| Reflectance::of_rgb(rgb.map(f64::from)).at(Nanometers(620.0)));
        assert!(red > 2.0 * green);
        for (u, expected) in [
            (0.125, red),
            (0.375, green),
            (0.25, 0.5 * (red + green)),
            (0.1875, 0.75 * red + 0.25 * green),
            // Beyond the sides the picture goes on.
            (1.125, red),
            (-0.875, red),
            (0.0, 0.5 * (red + green)),
            (1e3 + 0.5, green),
        ] {
            assert!(
                (at(u) - expected).abs() < 1e-12,
                "{u}: {} {expected}",
                at(u)
            );
        }
    }

    #[test]
    fn wraps_differ_beyond_the_sides_and_huge_coordinates_are_some_texel() {
        let at = |wrap, u: f64| texture(wrap).at(DVec2::new(u, 0.0)).at(Nanometers(620.0));
        let red = at(TextureWrap::Repeat, 0.125);
        assert_eq!(at(TextureWrap::Clamp, -3.0), red);
        assert_eq!(at(TextureWrap::Mirror, -0.125), red);
        assert!(at(TextureWrap::Clamp, 1.125) < 0.5 * red);
        for wrap in [TextureWrap::Repeat, TextureWrap::Clamp, TextureWrap::Mirror] {
            for u in [3e38, -3e38, 1e17] {
                assert!((0.0..=1.0).contains(&at(wrap, u)), "{wrap:?} {u}");
            }
        }
    }

    #[test]
    fn colors_are_multiplied_and_found_once() {
        let plain = array![[RED, RED], [GREEN, RED]];
        let texture = Texture::new(&plain, [0.5, 1.0, 0.0], [TextureWrap::Repeat; 2]);
        assert_eq!(texture.n_colors(), 2);
        let found = texture.at(DVec2::new(0.5, 0.25)).at(Nanometers(550.0));
        let expected = Reflectance::of_rgb([0.25, f64::from(RED[1]), 0.0]).at(Nanometers(550.0));
        assert_eq!(found, expected);
    }
}
