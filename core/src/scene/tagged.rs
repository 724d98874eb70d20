//! Tagged unions whose errors keep their place.
//!
//! serde's own `tag = "kind"` buffers the object, which loses the path of an error inside it.
//! Here the members behind `kind` are read straight from the input, so that the path stays exact.
//! Members written before `kind` are read from a buffer; their errors carry the rest of their
//! path in the message, and [`split_error`] takes it out again.

use super::strict::Strict;
use serde::de::{self, DeserializeSeed, Deserializer, IntoDeserializer, MapAccess};
use serde_json::Value;
use std::fmt;
use std::marker::PhantomData;

/// Starts and ends a path inside an error message; cannot occur in serde's own words.
const MARK: char = '\u{1f}';

/// A union of structs told apart by the member `kind`.
pub trait Tagged: Sized {
    /// The accepted kinds, in the order of the documentation.
    const KINDS: &'static [&'static str];

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
        write!(f, "an object whose `kind` is one of {}", T::KINDS.join(", "))
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<T, A::Error> {
        let mut early = Vec::new();
        while let Some(key) = map.next_key::<String>()? {
            if key == "kind" {
                let kind: String = map.next_value()?;
                if !T::KINDS.contains(&kind.as_str()) {
                    return Err(at("kind", &format_args!("{}", Unknown(&kind, T::KINDS))));
                }
                let members = Members { early: early.into_iter(), value: None, rest: map };
                return T::read(&kind, de::value::MapAccessDeserializer::new(members));
            }
            early.push((key, map.next_value::<Value>()?));
        }
        Err(de::Error::missing_field("kind"))
    }
}

struct Unknown<'a>(&'a str, &'static [&'static str]);

impl fmt::Display for Unknown<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let shown: String = self.0.chars().take(64).collect();
        write!(f, "unknown kind `{shown}`, expected one of {}", self.1.join(", "))
    }
}

/// The buffered members, then those still in the input.
struct Members<A> {
    early: std::vec::IntoIter<(String, Value)>,
    value: Option<(String, Value)>,
    rest: A,
}

impl<'de, A: MapAccess<'de>> MapAccess<'de> for Members<A> {
    type Error = A::Error;

    fn next_key_seed<K: DeserializeSeed<'de>>(
        &mut self,
        seed: K,
    ) -> Result<Option<K::Value>, A::Error> {
        let Some((key, value)) = self.early.next() else {
            return self.rest.next_key_seed(seed);
        };
        let read = seed.deserialize(key.clone().into_deserializer());
        let read = read.map_err(|e: de::value::Error| at(&escape(&key), &e))?;
        self.value = Some((key, value));
        Ok(Some(read))
    }

    fn next_value_seed<V: DeserializeSeed<'de>>(&mut self, seed: V) -> Result<V::Value, A::Error> {
        let Some((key, value)) = self.value.take() else {
            return self.rest.next_value_seed(seed);
        };
        let mut track = serde_path_to_error::Track::new();
        let tracked = serde_path_to_error::Deserializer::new(Strict(value), &mut track);
        seed.deserialize(tracked).map_err(|error| {
            let inner = pointer_of(&track.path());
            at(&format!("{}{inner}", escape(&key)), &error)
        })
    }
}

fn at<E: de::Error>(path: &str, detail: &dyn fmt::Display) -> E {
    E::custom(format_args!("{MARK}/{path}{MARK}{detail}"))
}

/// Parts an error's text into the pointer below where it was raised and its words.
pub fn split_error(text: &str) -> (String, String) {
    let mut pointer = String::new();
    let mut words = String::new();
    for (i, part) in text.split(MARK).enumerate() {
        if i % 2 == 1 { &mut pointer } else { &mut words }.push_str(part);
    }
    (pointer, words)
}

/// A serde path as a JSON pointer (RFC 6901).
pub fn pointer_of(path: &serde_path_to_error::Path) -> String {
    use serde_path_to_error::Segment;
    let mut pointer = String::new();
    for segment in path.iter() {
        match segment {
            Segment::Seq { index } => pointer.push_str(&format!("/{index}")),
            Segment::Map { key } => pointer.push_str(&format!("/{}", escape(key))),
            Segment::Enum { .. } | Segment::Unknown => {}
        }
    }
    pointer
}

/// A member's name as a token of a JSON pointer.
pub fn escape(key: &str) -> String {
    key.replace('~', "~0").replace('/', "~1")
}

/// Declares a union told apart by `kind`: one struct a variant, schema and errors included.
macro_rules! tagged {
    ($(#[$doc:meta])* $name:ident { $($(#[$vdoc:meta])* $variant:ident = $kind:literal),+ $(,)? }) => {
        $(#[$doc])*
        #[derive(Clone, Debug, PartialEq, serde::Serialize, schemars::JsonSchema)]
        #[serde(tag = "kind")]
        pub enum $name {
            $($(#[$vdoc])* #[serde(rename = $kind)] $variant($variant),)+
        }

        impl $crate::scene::tagged::Tagged for $name {
            const KINDS: &'static [&'static str] = &[$($kind),+];

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
                $crate::scene::tagged::deserialize(input)
            }
        }
    };
}
pub(crate) use tagged;
