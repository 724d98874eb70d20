//! What a client's JSON is read with, whatever it says: strict types, ranges, and every problem with
//! its pointer.

pub mod bounded;
mod diagnose;
pub mod document;
mod form;
pub mod limits;
mod problem;
mod strict;
pub mod tagged;
mod values;

pub use form::TAGS;
pub use problem::{Checker, Code, Problem};
pub use values::{Albedo, Rgb, Spectrum, Vec3};

use schemars::JsonSchema;
use serde::de::DeserializeOwned;

/// Reads JSON into any documented type.
///
/// Nothing is noted on the way: only a text that cannot be read is walked a second time, to tell
/// everything that is wrong with it.
///
/// # Errors
/// That it is no JSON, or what is wrong with it, each with its JSON pointer.
pub fn read<T: DeserializeOwned + JsonSchema>(json: &[u8]) -> Result<T, ReadError> {
    let text = std::str::from_utf8(json).map_err(|error| {
        ReadError::NotJson(format!("no UTF-8 after {} bytes", error.valid_up_to()))
    })?;
    parse(text).map_err(|error| diagnose::errors::<T>(text, &error))
}

fn parse<T: DeserializeOwned>(text: &str) -> Result<T, serde_json::Error> {
    let mut input = serde_json::Deserializer::from_str(text);
    let value = T::deserialize(strict::Strict(&mut input))?;
    input.end().map(|()| value)
}

/// Why some JSON is not what it should be.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ReadError {
    /// It is not JSON at all.
    #[error("not JSON: {0}")]
    NotJson(String),
    /// It is JSON, but not of the documented form.
    #[error("{} problems", .0.len())]
    Invalid(Vec<Problem>),
}
