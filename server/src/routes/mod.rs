//! All routes on one screen; one file each.

mod compare;
mod health;
mod limits;
mod models;
mod openapi;
mod optical_depth;
mod page;
mod presets;
pub mod probe;
mod progress;
mod render;
mod scenes;
mod selftest;

use crate::app::App;
use crate::layers;
use crate::live;
use crate::openapi::{Operation, Path, document};
use crate::problem::Problem;
use axum::http::{Method, StatusCode, Uri};
use axum::response::{IntoResponse, Response};
use axum::routing::{MethodRouter, delete, get, patch, post, put};
use axum::{Extension, Router};
use schemars::SchemaGenerator;

/// One path of the API: who answers it, and how it is documented.
struct Route {
    /// Its path.
    path: &'static str,
    /// Who answers.
    handler: MethodRouter<App>,
    /// Its part of the OpenAPI document.
    operation: fn(&mut SchemaGenerator) -> Operation,
}

/// Every path of the API.
fn routes() -> Vec<Route> {
    let route = |path, handler, operation| Route { path, handler, operation };
    vec![
        route("/v1/render", post(render::render), render::operation),
        route("/v1/optical-depth", post(optical_depth::render), optical_depth::operation),
        route("/v1/probe", post(probe::probe), probe::operation),
        route("/v1/compare", post(compare::compare), compare::operation),
        route("/v1/progress/{job}", get(progress::progress), progress::operation),
        route("/v1/scenes", get(scenes::list), scenes::list_operation),
        route("/v1/scenes/{id}", put(scenes::put), scenes::put_operation),
        route("/v1/scenes/{id}", get(scenes::get), scenes::get_operation),
        route("/v1/scenes/{id}", patch(scenes::patch), scenes::patch_operation),
        route("/v1/scenes/{id}", delete(scenes::delete), scenes::delete_operation),
        route("/v1/scenes/{id}/edits", post(scenes::edit), scenes::edit_operation),
        route("/v1/scenes/{id}/history", get(scenes::history), scenes::history_operation),
        route("/v1/scenes/{id}/undo", post(scenes::undo), scenes::undo_operation),
        route("/v1/scenes/{id}/redo", post(scenes::redo), scenes::redo_operation),
        route("/v1/scenes/{id}/frame", get(scenes::frame), scenes::frame_operation),
        route(
            "/v1/scenes/{id}/optical-depth",
            get(scenes::optical_depth),
            scenes::optical_depth_operation,
        ),
        route("/v1/scenes/{id}/probe", post(scenes::probe), scenes::probe_operation),
        route("/v1/scenes/{id}/compare", post(scenes::compare), scenes::compare_operation),
        route("/v1/scenes/{id}/select", post(scenes::select), scenes::select_operation),
        route("/v1/scenes/{id}/live", get(live::live), live::live_operation),
        route("/v1/selftest", post(selftest::selftest), selftest::operation),
        route("/v1/models", get(models::list), models::operation),
        route("/v1/presets", get(presets::list), presets::operation),
        route("/v1/limits", get(limits::list), limits::operation),
        route("/v1/openapi.json", get(openapi::document), openapi::operation),
        route("/healthz", get(health::healthz), health::healthz_operation),
        route("/readyz", get(health::readyz), health::readyz_operation),
    ]
}

/// The whole server: API, page, and the same refusals everywhere.
pub fn router(app: App) -> Router {
    let routes = routes();
    let document = openapi::Document::new(&document(operations(&routes)));
    let pages = page::files().into_iter().map(|(path, file)| (path, page::handler(file)));
    let api = routes.into_iter().map(|route| (route.path.to_owned(), route.handler));
    let router = api
        .chain(pages)
        .fold(Router::new(), |router, (path, handler)| router.route(&path, handler));
    let router = router.layer(Extension(document));
    let router = router.fallback(not_found).method_not_allowed_fallback(not_allowed);
    layers::around(router, &app).with_state(app)
}

fn operations(routes: &[Route]) -> impl Iterator<Item = Path> {
    routes.iter().map(|route| (route.path, route.operation))
}

async fn not_found(uri: Uri) -> Problem {
    Problem::new(StatusCode::NOT_FOUND, format!("there is nothing at {}", uri.path()))
}

/// The router adds the header `Allow`.
async fn not_allowed(method: Method) -> Response {
    if method == Method::OPTIONS {
        return StatusCode::NO_CONTENT.into_response();
    }
    let detail = format!("{method} is not possible here");
    Problem::new(StatusCode::METHOD_NOT_ALLOWED, detail).into_response()
}

#[cfg(test)]
mod tests {
    use super::{operations, routes};
    use crate::openapi;
    use serde_json::{Value, json};
    use std::collections::HashSet;

    fn document() -> Value {
        openapi::document(operations(&routes()))
    }

    fn references(value: &Value, into: &mut Vec<String>) {
        match value {
            Value::Object(members) => {
                into.extend(members.get("$ref").and_then(Value::as_str).map(str::to_owned));
                members.values().for_each(|member| references(member, into));
            }
            Value::Array(items) => items.iter().for_each(|item| references(item, into)),
            _ => {}
        }
    }

    #[test]
    fn every_reference_leads_somewhere() {
        let document = document();
        let mut all = Vec::new();
        references(&document, &mut all);
        assert!(all.len() > 50);
        for reference in all {
            let pointer = reference.strip_prefix('#').unwrap();
            assert!(document.pointer(pointer).is_some(), "{reference}");
        }
    }

    #[test]
    fn every_route_and_type_is_there_and_described() {
        let document = document();
        let mut ids = HashSet::new();
        let paths = document["paths"].as_object().unwrap();
        assert!(routes().iter().all(|route| paths.contains_key(route.path)));
        for path in paths.values() {
            let operations = path.as_object().unwrap();
            for operation in operations.values() {
                assert!(ids.insert(operation["operationId"].as_str().unwrap().to_owned()));
                let mut tags = document["tags"].as_array().unwrap().iter();
                assert!(tags.any(|tag| operation["tags"] == json!([tag["name"]])));
                assert!(operation["summary"].as_str().is_some_and(|text| !text.is_empty()));
                assert!(!operation["responses"]["200"]["content"].as_object().unwrap().is_empty());
            }
        }
        let schemas = document["components"]["schemas"].as_object().unwrap();
        for name in
            ["Scene", "Camera", "Fog", "GaussiansTerm", "PointLight", "Problem", "FieldError"]
        {
            assert!(schemas.contains_key(name), "{name}");
        }
        for (name, schema) in schemas {
            assert!(schema["description"].is_string(), "{name} has no description");
        }
    }

    #[test]
    fn it_is_always_the_same() {
        assert_eq!(document().to_string(), document().to_string());
    }
}
