//! What a surface gives back: as much of all light, a color, what was measured, or what its file says.

use std::fmt;

use niji_radiometry::GroundCover;
use niji_radiometry::Reflectance;
use schemars::JsonSchema;
use serde::Deserialize;
use serde::Deserializer;
use serde::Serialize;
use serde::de::IntoDeserializer;
use serde::de::SeqAccess;
use serde::de::Unexpected;
use serde::de::Visitor;
use serde::de::value::StrDeserializer;

use crate::check::Check;
use crate::error::SceneError;

/// Share of the light that a surface gives back, as much in all directions: a number, 0..1, or red, green and blue of
/// linear Rec.709, for which a smooth spectrum is taken, or the name of a ground whose spectrum was measured.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
#[serde(untagged)]
pub enum Albedo {
    /// As much of every wavelength.
    Even(#[schemars(range(min = 0.0, max = 1.0))] f64),
    /// Red, green, blue.
    Rgb(#[schemars(inner(range(min = 0.0, max = 1.0)))] [f64; 3]),
    /// As measured.
    Measured(GroundCover),
}

impl Albedo {
    /// Its spectrum.
    pub fn reflectance(self) -> Reflectance {
        match self {
            Self::Even(value) => Reflectance::Even(value),
            Self::Rgb(rgb) => Reflectance::of_rgb(rgb),
            Self::Measured(cover) => Reflectance::Measured(cover),
        }
    }

    /// Red, green and blue.
    fn rgb(self) -> [f64; 3] {
        match self {
            Self::Even(value) => [value; 3],
            Self::Rgb(rgb) => rgb,
            Self::Measured(_) => self.reflectance().rgb(),
        }
    }

    /// The largest of its colors.
    pub(crate) fn largest(self) -> f64 {
        self.rgb().into_iter().fold(0.0, f64::max)
    }

    /// Checks that all are shares.
    pub(crate) fn check(self, key: &str, check: &Check<'_>) -> Result<(), SceneError> {
        self.rgb()
            .into_iter()
            .try_for_each(|it| check.number(key, it, (0.0, 1.0)))
    }
}

/// What a mesh gives back: its albedo, or `"materials"`: the base colors and base color textures of its file (glTF, or
/// OBJ with `Kd` and `map_Kd`), as much in all directions whatever else its materials are; alpha is ignored.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
#[serde(untagged)]
pub enum MeshAlbedo {
    /// As much everywhere.
    Plain(Albedo),
    /// By its own materials.
    OfFile(OfFile),
}

/// The word for a mesh's own materials.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum OfFile {
    /// Those of its file.
    Materials,
}

impl MeshAlbedo {
    /// The largest of its numbers; 1 where only the file knows.
    pub(crate) fn largest(self) -> f64 {
        match self {
            Self::Plain(albedo) => albedo.largest(),
            Self::OfFile(OfFile::Materials) => 1.0,
        }
    }

    /// Checks that all are shares.
    pub(crate) fn check(self, key: &str, check: &Check<'_>) -> Result<(), SceneError> {
        match self {
            Self::Plain(albedo) => albedo.check(key, check),
            Self::OfFile(OfFile::Materials) => Ok(()),
        }
    }
}

impl<'de> Deserialize<'de> for MeshAlbedo {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(OrMaterials)
    }
}

struct OrMaterials;

impl<'de> Visitor<'de> for OrMaterials {
    type Value = MeshAlbedo;

    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let names = GroundCover::ALL.map(|cover| format!("\"{}\"", cover.name()));
        let names = names.join(", ");
        write!(
            formatter,
            "a number, a list of red, green and blue, \"materials\", or one of {names}"
        )
    }

    fn visit_f64<E: serde::de::Error>(self, value: f64) -> Result<MeshAlbedo, E> {
        Either.visit_f64(value).map(MeshAlbedo::Plain)
    }

    fn visit_i64<E: serde::de::Error>(self, value: i64) -> Result<MeshAlbedo, E> {
        Either.visit_i64(value).map(MeshAlbedo::Plain)
    }

    fn visit_u64<E: serde::de::Error>(self, value: u64) -> Result<MeshAlbedo, E> {
        Either.visit_u64(value).map(MeshAlbedo::Plain)
    }

    fn visit_str<E: serde::de::Error>(self, word: &str) -> Result<MeshAlbedo, E> {
        if word == "materials" {
            return Ok(MeshAlbedo::OfFile(OfFile::Materials));
        }
        let albedo = Either
            .visit_str(word)
            .map_err(|_: E| E::invalid_value(Unexpected::Str(word), &self))?;
        Ok(MeshAlbedo::Plain(albedo))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, items: A) -> Result<MeshAlbedo, A::Error> {
        Either.visit_seq(items).map(MeshAlbedo::Plain)
    }
}

/// By hand: serde's own way with untagged enums loses lines.
impl<'de> Deserialize<'de> for Albedo {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(Either)
    }
}

struct Either;

impl<'de> Visitor<'de> for Either {
    type Value = Albedo;

    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("a number, a list of red, green and blue, or the name of a ground")
    }

    fn visit_f64<E>(self, value: f64) -> Result<Albedo, E> {
        Ok(Albedo::Even(value))
    }

    fn visit_i64<E>(self, value: i64) -> Result<Albedo, E> {
        Ok(Albedo::Even(value as f64))
    }

    fn visit_u64<E>(self, value: u64) -> Result<Albedo, E> {
        Ok(Albedo::Even(value as f64))
    }

    fn visit_str<E: serde::de::Error>(self, word: &str) -> Result<Albedo, E> {
        let word: StrDeserializer<'_, E> = word.into_deserializer();
        GroundCover::deserialize(word).map(Albedo::Measured)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut items: A) -> Result<Albedo, A::Error> {
        let mut rgb = Vec::new();
        while let Some(channel) = items.next_element::<f64>()? {
            rgb.push(channel);
        }
        let n = rgb.len();
        let rgb = rgb.try_into();
        rgb.map(Albedo::Rgb)
            .map_err(|_| serde::de::Error::invalid_length(n, &self))
    }
}
