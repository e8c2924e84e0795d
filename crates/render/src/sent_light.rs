//! Light that surfaces send each other.
//!
//! E_s = (E_1 + E_2)/(1 - r^2),   E_1 = sum_k f_k A_k e_k,   E_2 = sum_k f_k A_k A_j e_j,   r = sum_k f_k A_k A_j/sum_k f_k A_k
//! e_k = (n_k . w) S_k E_sun + (1 + n_k,y)/2 E_sky + (1 - n_k,y)/2 A_g E_g
//! over what a place looks at (`sky_view`): `f_k` share of an even sphere's light that would come from there, `A_k` mean albedo
//! of the material that is met, `n_k` its normal, `w` towards the sun, `S_k` 1 where no surface stands between, `E_sun` on a
//! face across the sun, `E_sky` of the sky on level ground, `E_g` of both, `A_g` albedo of the ground: all of these as the place
//! itself has them. From k one ray goes on, by the cosine to n_k; where it meets a surface j, this sends its e_j in place of the
//! part of sky or ground that it hides. So two reflections are followed, the second one by a ray for each look; of those
//! before them each has r^2 of the light of the second but it, as between two walls of which one has more sun.
//!
//! Told as error is half of what was before these two; by how much E_1 gives more along half of the azimuths than along the
//! other half; and 2 s of E_2, s^2 = sum_k (f_k A_k A_j e_j)^2: two standard errors of rays that mostly miss.

use std::f64::consts::TAU;

use glam::DVec3;
use niji_radiometry::Reflectance;
use niji_radiometry::WavelengthGrid;

use crate::air::Air;
use crate::paint::SurfaceColor;
use crate::sky_view::Look;
use crate::surfaces::Face;

/// Share of its light that a white cave lets out at two reflections.
const LEAST_LEAVING: f32 = 0.05;

/// Which solid, and which material of it.
type Color = (u32, u32);

/// What reaches a place by way of materials.
// f32: nodes of terrain keep these.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Sender {
    /// The last one that sends it, and the one before.
    colors: (Color, Option<Color>),
    /// Share of all light that would come from there.
    share: f32,
    /// Shares of light from across the sun, of the sky on level ground and of the ground on a face turned down.
    shares: [f32; 3],
    /// By how much more of these comes by even azimuths than by odd ones; by way of two, the sum of their squares.
    spread: [f32; 3],
}

impl Sender {
    /// A face that is looked at, with the cosine of its sunlight.
    pub(crate) fn of(face: &Face, look: Look, cos_sun: f64) -> Self {
        let up = 0.5 * (1.0 + face.normal.y);
        let shares = [cos_sun, up, 1.0 - up].map(|part| (look.share * part) as f32);
        Self {
            colors: (color(face), None),
            share: look.share as f32,
            shares,
            spread: shares.map(|share| parity(look) * share),
        }
    }

    /// The same where a surface hides sky or ground along a direction.
    pub(crate) fn less(mut self, look: Look, towards: DVec3) -> Self {
        let part = if towards.y > 0.0 { 1 } else { 2 };
        self.shares[part] -= look.share as f32;
        self.spread[part] -= parity(look) * look.share as f32;
        self
    }

    /// The same by way of a face.
    pub(crate) fn by(mut self, face: &Face) -> Self {
        self.colors = (color(face), Some(self.colors.0));
        self.spread = self.shares.map(|share| share.powi(2));
        self
    }
}

fn color(face: &Face) -> Color {
    (face.solid as u32, face.painted.0)
}

fn parity(look: Look) -> f32 {
    if look.azimuth.is_multiple_of(2) {
        1.0
    } else {
        -1.0
    }
}

/// A direction by the cosine to a unit vector, another one for each number.
pub(crate) fn scattered(normal: DVec3, number: u32) -> DVec3 {
    // Fractions of multiples of these fill a square evenly.
    let [across, along] = [0.754_877_666_246_692_8, 0.569_840_290_998_053_3]
        .map(|step| (f64::from(number) * step + 0.5).fract());
    let (sin, cos) = (TAU * along).sin_cos();
    let (a, b) = normal.any_orthonormal_pair();
    across.sqrt() * (cos * a + sin * b) + (1.0 - across).sqrt() * normal
}

/// What surfaces send to a place.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Senders(Vec<Sender>);

impl Senders {
    pub(crate) const NONE: Self = Self(Vec::new());

    /// Whether nothing is sent.
    pub(crate) fn are_none(&self) -> bool {
        self.0.is_empty()
    }

    /// One more, times a weight.
    pub(crate) fn add(&mut self, sender: &Sender, weight: f32) {
        let mut part = *sender;
        part.share *= weight;
        for value in part.shares.iter_mut().chain(&mut part.spread) {
            *value *= weight;
        }
        let known = self.0.iter_mut().find(|it| it.colors == part.colors);
        let Some(known) = known else {
            self.0.push(part);
            return;
        };
        known.share += part.share;
        for index in 0..part.shares.len() {
            known.shares[index] += part.shares[index];
            known.spread[index] += part.spread[index];
        }
    }

    /// All of others, times a weight.
    pub(crate) fn add_all(&mut self, others: &Self, weight: f32) {
        for sender in &others.0 {
            self.add(sender, weight);
        }
    }
}

/// Albedos of all materials by solid, material and wavelength; none of what is black.
#[derive(Default)]
pub(crate) struct SenderColors(Vec<Vec<Vec<f32>>>);

impl SenderColors {
    /// Of solids.
    pub(crate) fn of<'a>(
        colors: impl Iterator<Item = Option<&'a SurfaceColor>>,
        grid: &WavelengthGrid,
    ) -> Self {
        let spectra = |color: Option<&SurfaceColor>| {
            let means = match color {
                None => Vec::new(),
                Some(SurfaceColor::Plain(reflectance)) => vec![*reflectance],
                Some(SurfaceColor::Painted(paint)) => paint.means(),
            };
            let spectrum =
                |it: Reflectance| it.on(grid).into_iter().map(|value| value as f32).collect();
            means.into_iter().map(spectrum).collect()
        };
        Self(colors.map(spectra).collect())
    }

    fn get(&self, (solid, material): (u32, u32)) -> Option<&Vec<f32>> {
        let materials = &self.0[solid as usize];
        // A solid of one color may have a mesh with materials.
        materials.get(material as usize).or(match &materials[..] {
            [only] => Some(only),
            _ => None,
        })
    }
}

/// Light around a place, by wavelength, for unit sun irradiance.
#[derive(Clone, Debug)]
pub(crate) struct LightAround {
    /// On a face across the sun.
    pub(crate) sun: Vec<f32>,
    /// Of the sky on level ground.
    pub(crate) sky: Vec<f32>,
    /// Of the ground on a face turned down.
    pub(crate) ground: Vec<f32>,
}

impl LightAround {
    /// Darkness at so many wavelengths.
    pub(crate) fn new(n_wavelengths: usize) -> Self {
        let [sun, sky, ground] = [(); 3].map(|()| vec![0.0; n_wavelengths]);
        Self { sun, sky, ground }
    }

    /// Take the light at a point, to which drops leave a share of the sky but all of the sun, and the ground's albedo in
    /// place of its light.
    pub(crate) fn look(&mut self, (point, skylit): (DVec3, f64), air: Option<&Air>) {
        self.sky.fill(0.0);
        self.ground.fill(0.0);
        let Some(air) = air else {
            self.sun.fill(1.0);
            return;
        };
        match air.to_sun(point) {
            Some(to_sun) => air.transmit(&to_sun, &mut self.sun),
            None => self.sun.fill(0.0),
        }
        if let Some(diffuse) = air.diffuse() {
            for (sky, light) in self.sky.iter_mut().zip(diffuse.on_level(point)) {
                *sky = skylit as f32 * light;
            }
        }
        for (ground, albedo) in self.ground.iter_mut().zip(air.ground_albedo()) {
            *ground = *albedo as f32;
        }
    }

    /// Make it the light that others around have, where drops leave shares of sunlight straight and, of that on level ground,
    /// scattered; `sine` of the sun's elevation.
    pub(crate) fn spread(&mut self, [straight, scattered]: [f64; 2], sine: f64) {
        let Self { sun, sky, ground } = self;
        for ((sun, sky), ground) in sun.iter_mut().zip(sky).zip(ground) {
            let on_level = sine as f32 * *sun;
            *ground *= *sky + (straight + scattered) as f32 * on_level;
            *sky += scattered as f32 * on_level;
            *sun *= straight as f32;
        }
    }

    /// Add to irradiances of a place what senders send, and write what that may lack.
    pub(crate) fn add_sent(
        &self,
        (senders, colors): (&Senders, &SenderColors),
        irradiance: &mut [f32],
        lacking: &mut [f32],
    ) {
        let parts = |sender: &Sender| {
            let (last, other) = sender.colors;
            let other = match other {
                Some(other) => Some(colors.get(other)?),
                None => None,
            };
            Some((*sender, colors.get(last)?, other))
        };
        let sum = |weights: [f32; 3], shares: &[f32; 3]| -> f32 {
            weights.iter().zip(shares).map(|(a, b)| a * b).sum()
        };
        let parts: Vec<_> = senders.0.iter().filter_map(parts).collect();
        for (index, (irradiance, lacking)) in irradiance.iter_mut().zip(lacking).enumerate() {
            let light = [self.sun[index], self.sky[index], self.ground[index]];
            let (mut sent, mut told) = (0.0, 0.0);
            let mut given_back = [0.0; 2];
            for (sender, last, other) in &parts {
                let Sender { shares, spread, .. } = sender;
                let albedo = last[index] * other.map_or(1.0, |other| other[index]);
                sent += albedo * sum(light, shares).max(0.0);
                given_back[usize::from(other.is_some())] += albedo * sender.share;
                told += albedo
                    * if other.is_some() {
                        2.0 * sum(light.map(|it| it * it), spread).sqrt()
                    } else {
                        sum(light, spread).abs()
                    };
            }
            let [of_one, of_two] = given_back;
            let square = if of_two > 0.0 {
                (of_two / of_one).powi(2)
            } else {
                0.0
            };
            let before = sent * square / (1.0 - square).max(LEAST_LEAVING);
            *irradiance += sent + before;
            *lacking = told + 0.5 * before;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_are_scattered_by_the_cosine() {
        for normal in [DVec3::Y, -DVec3::Z, DVec3::new(0.6, -0.48, 0.64)] {
            let n = 72;
            let all = (0..n).map(|number| scattered(normal, number));
            let (mut mean, mut square) = (DVec3::ZERO, 0.0);
            for towards in all {
                assert!((towards.length() - 1.0).abs() < 1e-12 && towards.dot(normal) > 0.0);
                mean += towards / f64::from(n);
                square += towards.dot(normal).powi(2) / f64::from(n);
            }
            // Means of c and c^2 by a density of 2 c dc.
            assert!(mean.distance(normal * 2.0 / 3.0) < 0.03, "{mean}");
            assert!((square - 0.5).abs() < 0.03, "{square}");
        }
    }

    #[test]
    fn senders_of_one_material_are_one() {
        let face = |solid, material| Face {
            side: DVec3::Y,
            normal: DVec3::Y,
            solid,
            triangle: 0,
            painted: (material, glam::DVec2::ZERO),
        };
        let look = |azimuth| Look {
            azimuth,
            number: 0,
            towards: DVec3::NEG_Y,
            share: 0.25,
        };
        let mut senders = Senders::default();
        senders.add(&Sender::of(&face(0, 1), look(2), 0.5), 1.0);
        senders.add(&Sender::of(&face(0, 1), look(3), 0.5), 1.0);
        senders.add(&Sender::of(&face(0, 2), look(3), 0.5), 2.0);
        senders.add(&Sender::of(&face(0, 1), look(4), 1.0).by(&face(0, 2)), 1.0);
        let found: Vec<_> = senders
            .0
            .iter()
            .map(|it| (it.share, it.shares, it.spread))
            .collect();
        let expected = [
            (0.5, [0.25, 0.5, 0.0], [0.0; 3]),
            (0.5, [0.25, 0.5, 0.0], [-0.25, -0.5, 0.0]),
            (0.25, [0.25, 0.25, 0.0], [0.0625, 0.0625, 0.0]),
        ];
        assert_eq!(found, expected);
    }
}
