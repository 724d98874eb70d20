//! The vectors of a scene: positions, colours and albedos.

use super::limits;
use glam::DVec3;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::{Deserializer, Error, SeqAccess, Visitor};
use serde::{Deserialize, Serialize};
use std::fmt;

macro_rules! triple {
    ($(#[$doc:meta])* $name:ident, $range:expr) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
        #[serde(transparent)]
        pub struct $name(
            #[schemars(inner(range(min = $range.min, max = $range.max)))] pub [f64; 3],
        );

        impl $name {
            /// The same value in all three components.
            pub const fn splat(value: f64) -> Self {
                Self([value; 3])
            }

            /// The components as a vector of the maths; −0 becomes 0, which it equals as a key but not
            /// in its sign.
            pub fn vector(self) -> DVec3 {
                DVec3::from_array(self.0) + DVec3::ZERO
            }
        }

        impl From<[f64; 3]> for $name {
            fn from(components: [f64; 3]) -> Self {
                Self(components)
            }
        }
    };
}

triple!(
    /// A position or direction `[x, y, z]` in world space, metres, +Y up.
    Vec3,
    limits::COORDINATE
);
triple!(
    /// A colour `[r, g, b]`, linear Rec. 709, in the unit of its field.
    Rgb,
    limits::INTENSITY
);
triple!(
    /// A share per channel `[r, g, b]` between 0 (all absorbed) and 1 (nothing absorbed).
    Albedo,
    limits::FRACTION
);

/// A number that may depend on the colour: one for all channels, or `[r, g, b]`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Spectrum {
    /// The same in all channels.
    Grey(f64),
    /// Red, green and blue.
    Rgb([f64; 3]),
}

impl Spectrum {
    /// The numbers that say it: one, or one a channel.
    pub fn values(&self) -> &[f64] {
        match self {
            Self::Grey(value) => std::slice::from_ref(value),
            Self::Rgb(values) => values,
        }
    }

    /// Its value in each channel.
    pub fn channels(self) -> [f64; 3] {
        match self {
            Self::Grey(value) => [value; 3],
            Self::Rgb(values) => values,
        }
    }

    /// The same, times a number.
    #[must_use]
    pub fn times(self, factor: f64) -> Self {
        match self {
            Self::Grey(value) => Self::Grey(factor * value),
            Self::Rgb(values) => Self::Rgb(values.map(|value| factor * value)),
        }
    }

    /// Whether it is the same in all of them.
    pub fn is_grey(self) -> bool {
        let [r, g, b] = self.channels();
        r == g && g == b
    }

    /// The schema of an extinction [1/m].
    pub fn extinction(_: &mut SchemaGenerator) -> Schema {
        let limits::Range { min, max } = limits::EXTINCTION;
        let number = serde_json::json!({
            "type": "number", "minimum": min, "maximum": max,
            "x-usual": limits::USUAL_EXTINCTION,
        });
        json_schema!({ "anyOf": variants(&number) })
    }

    /// The same where nothing need be said.
    pub fn optional_extinction(generator: &mut SchemaGenerator) -> Schema {
        let mut schema = Self::extinction(generator);
        if let Some(list) = schema.get_mut("anyOf").and_then(serde_json::Value::as_array_mut) {
            list.push(serde_json::json!({ "type": "null" }));
        }
        schema
    }
}

/// A number, or three in a row.
fn variants(number: &serde_json::Value) -> [serde_json::Value; 2] {
    let mut grey = number.clone();
    grey["title"] = "grey".into();
    // How one moves through it belongs to the row as a whole.
    let mut item = number.clone();
    let usual = item.as_object_mut().and_then(|item| item.remove("x-usual"));
    let mut rgb = serde_json::json!({
        "type": "array", "title": "colour", "format": "rgb", "items": item,
        "minItems": 3, "maxItems": 3,
    });
    if let (Some(usual), Some(rgb)) = (usual, rgb.as_object_mut()) {
        rgb.insert("x-usual".into(), usual);
    }
    [grey, rgb]
}

impl JsonSchema for Spectrum {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "Spectrum".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "description": "A number for all channels, or `[r, g, b]`.",
            "anyOf": variants(&serde_json::json!({ "type": "number" })),
        })
    }
}

impl From<f64> for Spectrum {
    fn from(value: f64) -> Self {
        Self::Grey(value)
    }
}

impl<'de> Deserialize<'de> for Spectrum {
    fn deserialize<D: Deserializer<'de>>(input: D) -> Result<Self, D::Error> {
        input.deserialize_any(SpectrumVisitor)
    }
}

struct SpectrumVisitor;

impl<'de> Visitor<'de> for SpectrumVisitor {
    type Value = Spectrum;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a number or [r, g, b]")
    }

    fn visit_f64<E: Error>(self, value: f64) -> Result<Spectrum, E> {
        Ok(Spectrum::Grey(value))
    }

    fn visit_u64<E: Error>(self, value: u64) -> Result<Spectrum, E> {
        Ok(Spectrum::Grey(value as f64))
    }

    fn visit_i64<E: Error>(self, value: i64) -> Result<Spectrum, E> {
        Ok(Spectrum::Grey(value as f64))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut items: A) -> Result<Spectrum, A::Error> {
        let mut values = [0.0; 3];
        for (i, value) in values.iter_mut().enumerate() {
            *value = items.next_element()?.ok_or_else(|| Error::invalid_length(i, &self))?;
        }
        Ok(Spectrum::Rgb(values))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Kept values are found by numbers that compare equal; what is made from them must be the same.
    #[test]
    fn no_vector_has_a_negative_zero() {
        let vector = Vec3([-0.0, 0.0, -1.0]).vector();
        assert_eq!(vector.to_array().map(f64::to_bits), [0.0, 0.0, -1.0].map(f64::to_bits));
    }
}
