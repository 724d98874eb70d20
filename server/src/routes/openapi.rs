//! `GET /v1/openapi.json`: this API, for programs.

use crate::answer::{Fixed, JSON};
use crate::openapi::{self, Operation};
use axum::http::HeaderMap;
use axum::response::Response;
use schemars::SchemaGenerator;
use serde_json::json;
use std::sync::LazyLock;

static DOCUMENT: LazyLock<Fixed> = LazyLock::new(|| {
    Fixed::new(JSON, serde_json::to_vec_pretty(&openapi::document()).unwrap_or_default())
});

/// The OpenAPI 3.1 document.
pub async fn document(headers: HeaderMap) -> Response {
    DOCUMENT.answer(&headers)
}

/// Its documentation.
pub fn operation(_schemas: &mut SchemaGenerator) -> Operation {
    let operation = Operation::get("get_openapi", "service", "This document.");
    operation.content(JSON, json!({ "schema": { "type": "object" } }))
}
