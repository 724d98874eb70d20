//! What stands behind the `?` of an address, read as any document: with its ranges, and problems with pointers.

use crate::problem::Problem;
use axum::http::Uri;
use fogbank_core::scene;
use schemars::JsonSchema;
use serde::de::DeserializeOwned;
use serde_json::{Map, Value};

/// The checked request that an address holds. What looks like JSON is that, all else is text.
///
/// # Errors
/// 422 with what is wrong.
pub fn query<T: DeserializeOwned + JsonSchema, C>(
    uri: &Uri,
    check: fn(T) -> Result<C, Vec<scene::Problem>>,
) -> Result<C, Problem> {
    read(uri, check, |text| match serde_json::from_str::<Value>(&text) {
        Ok(value @ (Value::Number(_) | Value::Bool(_) | Value::Object(_))) => value,
        _ => Value::String(text),
    })
}

/// The same where everything is text, also what looks like a number.
///
/// # Errors
/// 422 with what is wrong.
pub fn texts<T: DeserializeOwned + JsonSchema, C>(
    uri: &Uri,
    check: fn(T) -> Result<C, Vec<scene::Problem>>,
) -> Result<C, Problem> {
    read(uri, check, Value::String)
}

fn read<T: DeserializeOwned + JsonSchema, C>(
    uri: &Uri,
    check: fn(T) -> Result<C, Vec<scene::Problem>>,
    value: impl Fn(String) -> Value,
) -> Result<C, Problem> {
    let pairs: Vec<(String, String)> =
        serde_urlencoded::from_str(uri.query().unwrap_or_default()).unwrap_or_default();
    let members: Map<_, _> = pairs.into_iter().map(|(key, text)| (key, value(text))).collect();
    let text = serde_json::to_vec(&members).unwrap_or_default();
    check(scene::read::<T>(&text)?).map_err(Problem::invalid)
}
