//! What happens to every request and answer, whatever its path.

use crate::answer::JSON;
use crate::problem::Problem;
use axum::Router;
use axum::extract::Request;
use axum::http::{HeaderValue, header};
use axum::middleware::{Next, from_fn};
use axum::response::{IntoResponse, Response};
use std::any::Any;
use std::time::Instant;
use tower_http::CompressionLevel;
use tower_http::catch_panic::CatchPanicLayer;
use tower_http::compression::CompressionLayer;

/// Puts the layers around the routes, the innermost first.
pub fn around<S: Clone + Send + Sync + 'static>(router: Router<S>) -> Router<S> {
    let compression = CompressionLayer::new().quality(CompressionLevel::Fastest).compress_when(
        |_: axum::http::StatusCode, _, headers: &axum::http::HeaderMap, _: &_| {
            headers.get(header::CONTENT_TYPE).is_some_and(|value| value == JSON)
        },
    );
    router
        .layer(CatchPanicLayer::custom(panicked))
        .layer(compression)
        .layer(from_fn(protect))
        .layer(from_fn(log))
}

fn panicked(_panic: Box<dyn Any + Send>) -> Response {
    Problem::broken().into_response()
}

/// Browsers are told to take nothing from elsewhere, and to give nothing to other origins.
async fn protect(request: Request, next: Next) -> Response {
    let mut response = next.run(request).await;
    let headers = response.headers_mut();
    let policy = "default-src 'self'; img-src 'self' blob: data:";
    headers.insert(header::CONTENT_SECURITY_POLICY, HeaderValue::from_static(policy));
    headers.insert(header::X_CONTENT_TYPE_OPTIONS, HeaderValue::from_static("nosniff"));
    let own = HeaderValue::from_static("same-origin");
    headers.insert("cross-origin-resource-policy", own);
    response
}

async fn log(request: Request, next: Next) -> Response {
    let (method, uri, began) = (request.method().clone(), request.uri().clone(), Instant::now());
    let response = next.run(request).await;
    let (status, path) = (response.status().as_u16(), uri.path());
    let ms = began.elapsed().as_secs_f64() * 1e3;
    if response.status().is_server_error() {
        tracing::warn!("{method} {path} {status} {ms:.1} ms");
    } else {
        tracing::info!("{method} {path} {status} {ms:.1} ms");
    }
    response
}
