//! Tagged unions whose errors keep their place.
//!
//! serde's own `tag = "kind"` copies the object into a tree first. Here the members behind `kind` are
//! read straight from the input, and those before it wait as slices of the text.

use super::strict::Strict;
use serde::de::{self, DeserializeSeed, Deserializer, IntoDeserializer, MapAccess};
use serde_json::value::RawValue;
use std::fmt;
use std::marker::PhantomData;

/// Members that may stand before `kind`: more than any variant has.
const MOST_EARLY: usize = 32;

/// A union of structs told apart by a member, most often `kind`.
pub trait Tagged: Sized {
    /// The member that tells them apart.
    const TAG: &'static str;
    /// The accepted kinds, in the order of the documentation.
    const KINDS: &'static [&'static str];

    /// The kind of this one.
    fn word(&self) -> &'static str;

    /// Reads the variant named `kind` from the other members.
    fn read<'de, D: Deserializer<'de>>(kind: &str, members: D) -> Result<Self, D::Error>;
}

/// Deserializes any [`Tagged`] union.
pub fn deserialize<'de, T: Tagged, D: Deserializer<'de>>(input: D) -> Result<T, D::Error> {
    input.deserialize_map(Visitor(PhantomData))
}

struct Visitor<T>(PhantomData<T>);

impl<'de, T: Tagged> de::Visitor<'de> for Visitor<T> {
    type Value = T;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "an object whose `{}` is one of {}", T::TAG, T::KINDS.join(", "))
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<T, A::Error> {
        let mut early = Vec::new();
        while let Some(key) = map.next_key::<String>()? {
            if key == T::TAG {
                let kind: String = map.next_value()?;
                let members = Members { early: early.into_iter(), value: None, rest: map };
                return T::read(&kind, de::value::MapAccessDeserializer::new(members));
            }
            if early.len() == MOST_EARLY {
                return Err(de::Error::custom(format_args!(
                    "too many members before `{}`",
                    T::TAG
                )));
            }
            early.push((key, map.next_value::<&RawValue>()?));
        }
        Err(de::Error::missing_field(T::TAG))
    }
}

/// The members that came before `kind`, then those still in the input.
struct Members<'de, A> {
    early: std::vec::IntoIter<(String, &'de RawValue)>,
    value: Option<&'de RawValue>,
    rest: A,
}

impl<'de, A: MapAccess<'de>> MapAccess<'de> for Members<'de, A> {
    type Error = A::Error;

    fn next_key_seed<K: DeserializeSeed<'de>>(
        &mut self,
        seed: K,
    ) -> Result<Option<K::Value>, A::Error> {
        let Some((key, value)) = self.early.next() else {
            return self.rest.next_key_seed(seed);
        };
        self.value = Some(value);
        seed.deserialize(key.into_deserializer()).map(Some)
    }

    fn next_value_seed<V: DeserializeSeed<'de>>(&mut self, seed: V) -> Result<V::Value, A::Error> {
        let Some(value) = self.value.take() else {
            return self.rest.next_value_seed(seed);
        };
        let mut input = serde_json::Deserializer::from_str(value.get());
        seed.deserialize(Strict(&mut input)).map_err(de::Error::custom)
    }
}

/// Declares a union told apart by `kind`, or by another member: one struct a variant, schema and errors
/// included.
macro_rules! tagged {
    ($(#[$doc:meta])* $name:ident $variants:tt) => {
        $crate::json::tagged::tagged!(by "kind" $(#[$doc])* $name $variants);
    };
    (by $tag:literal $(#[$doc:meta])* $name:ident { $($(#[$vdoc:meta])* $variant:ident = $kind:literal),+ $(,)? }) => {
        $(#[$doc])*
        #[derive(Clone, Debug, PartialEq, serde::Serialize, schemars::JsonSchema)]
        #[serde(tag = $tag)]
        pub enum $name {
            $($(#[$vdoc])* #[serde(rename = $kind)] $variant($variant),)+
        }

        impl $crate::json::tagged::Tagged for $name {
            const TAG: &'static str = $tag;
            const KINDS: &'static [&'static str] = &[$($kind),+];

            fn word(&self) -> &'static str {
                match self { $(Self::$variant(_) => $kind),+ }
            }

            fn read<'de, D: serde::Deserializer<'de>>(
                kind: &str,
                members: D,
            ) -> Result<Self, D::Error> {
                match kind {
                    $($kind => <$variant as serde::Deserialize>::deserialize(members)
                        .map(Self::$variant),)+
                    _ => Err(serde::de::Error::unknown_variant(kind, Self::KINDS)),
                }
            }
        }

        impl<'de> serde::Deserialize<'de> for $name {
            fn deserialize<D: serde::Deserializer<'de>>(input: D) -> Result<Self, D::Error> {
                $crate::json::tagged::deserialize(input)
            }
        }
    };
}
pub(crate) use tagged;
