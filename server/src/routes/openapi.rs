//! `GET /v1/openapi.json`: this API, for programs.

use crate::answer::{Fixed, JSON};
use crate::openapi::Operation;
use axum::Extension;
use axum::http::HeaderMap;
use axum::response::Response;
use schemars::SchemaGenerator;
use serde_json::{Value, json};

/// The OpenAPI 3.1 document of all routes, ready to be sent.
#[derive(Clone)]
pub struct Document(Fixed);

impl Document {
    /// From its JSON.
    pub fn new(json: &Value) -> Self {
        Self(Fixed::new(JSON, serde_json::to_vec_pretty(json).unwrap_or_default()))
    }
}

/// Sends it.
pub async fn document(Extension(document): Extension<Document>, headers: HeaderMap) -> Response {
    document.0.answer(&headers)
}

/// Its documentation.
pub fn operation(_schemas: &mut SchemaGenerator) -> Operation {
    let operation = Operation::get("get_openapi", "service", "This document.");
    operation.content(JSON, json!({ "schema": { "type": "object" } }))
}
