//! Lists that stop being read one past their limit, before more is allocated for them.

use crate::shared::Shared;
use serde::de::{Deserialize, Deserializer, Error, SeqAccess, Visitor};
use std::fmt;

/// Deserializes at most `MOST` items.
///
/// # Errors
/// What is wrong with an item, or that there are more.
pub fn list<'de, const MOST: usize, T, D>(input: D) -> Result<Vec<T>, D::Error>
where
    T: Deserialize<'de>,
    D: Deserializer<'de>,
{
    list_in_all::<MOST, T, D>(input, usize::MAX, |_| 0)
}

/// The same, or null.
///
/// # Errors
/// As [`list`].
pub fn list_or_null<'de, const MOST: usize, T, D>(input: D) -> Result<Option<Vec<T>>, D::Error>
where
    T: Deserialize<'de>,
    D: Deserializer<'de>,
{
    Ok(Option::<List<MOST, T>>::deserialize(input)?.map(|list| list.0))
}

/// As [`list`], to be shared.
///
/// # Errors
/// As [`list`].
pub fn shared<'de, const MOST: usize, T, D>(input: D) -> Result<Shared<Vec<T>>, D::Error>
where
    T: Deserialize<'de>,
    D: Deserializer<'de>,
{
    list::<MOST, T, D>(input).map(Shared::from)
}

/// The same, or null.
///
/// # Errors
/// As [`list`].
pub fn shared_or_null<'de, const MOST: usize, T, D>(
    input: D,
) -> Result<Option<Shared<Vec<T>>>, D::Error>
where
    T: Deserialize<'de>,
    D: Deserializer<'de>,
{
    Ok(list_or_null::<MOST, T, D>(input)?.map(Shared::from))
}

/// At most `MOST` rows of at most `MOST` items, which take no more memory than they need.
///
/// # Errors
/// As [`list`].
pub fn rows<'de, const MOST: usize, T, D>(input: D) -> Result<Shared<Vec<Vec<T>>>, D::Error>
where
    T: Deserialize<'de> + Clone,
    D: Deserializer<'de>,
{
    let rows = list::<MOST, Row<MOST, T>, D>(input)?;
    Ok(rows.into_iter().map(|row| row.0).collect())
}

/// At most `MOST` items, of which `part` together gives at most `most_in_all`.
///
/// # Errors
/// As [`list`], and that they have too many parts.
pub fn list_in_all<'de, const MOST: usize, T, D>(
    input: D,
    most_in_all: usize,
    parts: fn(&T) -> usize,
) -> Result<Vec<T>, D::Error>
where
    T: Deserialize<'de>,
    D: Deserializer<'de>,
{
    input.deserialize_seq(Items::<MOST, T> { most_in_all, parts })
}

/// The same, or null.
///
/// # Errors
/// As [`list_in_all`].
pub fn list_in_all_or_null<'de, const MOST: usize, T, D>(
    input: D,
    most_in_all: usize,
    parts: fn(&T) -> usize,
) -> Result<Option<Vec<T>>, D::Error>
where
    T: Deserialize<'de>,
    D: Deserializer<'de>,
{
    input.deserialize_option(OrNull::<MOST, T> { most_in_all, parts })
}

struct OrNull<const MOST: usize, T> {
    most_in_all: usize,
    parts: fn(&T) -> usize,
}

impl<'de, const MOST: usize, T: Deserialize<'de>> Visitor<'de> for OrNull<MOST, T> {
    type Value = Option<Vec<T>>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a list or null")
    }

    fn visit_none<E: Error>(self) -> Result<Self::Value, E> {
        Ok(None)
    }

    fn visit_some<D: Deserializer<'de>>(self, input: D) -> Result<Self::Value, D::Error> {
        list_in_all::<MOST, T, D>(input, self.most_in_all, self.parts).map(Some)
    }
}

struct List<const MOST: usize, T>(Vec<T>);

impl<'de, const MOST: usize, T: Deserialize<'de>> Deserialize<'de> for List<MOST, T> {
    fn deserialize<D: Deserializer<'de>>(input: D) -> Result<Self, D::Error> {
        list::<MOST, T, D>(input).map(Self)
    }
}

struct Row<const MOST: usize, T>(Vec<T>);

impl<'de, const MOST: usize, T: Deserialize<'de> + Clone> Deserialize<'de> for Row<MOST, T> {
    fn deserialize<D: Deserializer<'de>>(input: D) -> Result<Self, D::Error> {
        // A copy is as large as its items: one that is shrunk leaves a hole behind it.
        list::<MOST, T, D>(input).map(|items| Self(items.as_slice().to_vec()))
    }
}

struct Items<const MOST: usize, T> {
    most_in_all: usize,
    parts: fn(&T) -> usize,
}

impl<'de, const MOST: usize, T: Deserialize<'de>> Visitor<'de> for Items<MOST, T> {
    type Value = Vec<T>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "a list of at most {MOST}")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<Vec<T>, A::Error> {
        let (mut items, mut in_all) = (Vec::new(), 0usize);
        while let Some(item) = seq.next_element()? {
            in_all = in_all.saturating_add((self.parts)(&item));
            if items.len() == MOST || in_all > self.most_in_all {
                return Err(Error::custom("more than the limit"));
            }
            items.push(item);
        }
        Ok(items)
    }
}
