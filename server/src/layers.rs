//! What happens to every request and answer, whatever its path.

use crate::app::{App, Phase};
use crate::problem::Problem;
use axum::Router;
use axum::extract::{Request, State};
use axum::http::{HeaderValue, StatusCode, header};
use axum::middleware::{Next, from_fn, from_fn_with_state};
use axum::response::{IntoResponse, Response};
use std::any::Any;
use std::time::Instant;
use tower_http::catch_panic::CatchPanicLayer;

/// Marks a request that came on a connection kept for those who watch the process.
#[derive(Clone, Copy, Debug)]
pub struct Spare;

/// Puts the layers around the routes, the innermost first.
pub fn around(router: Router<App>, app: &App) -> Router<App> {
    router
        .layer(from_fn_with_state(app.clone(), admit))
        .layer(CatchPanicLayer::custom(panicked))
        .layer(from_fn(protect))
        .layer(from_fn(log))
}

/// Lets in what may come in, and answers it before the server is gone.
async fn admit(State(app): State<App>, request: Request, next: Next) -> Result<Response, Problem> {
    app.names.check(request.method(), request.uri(), request.headers())?;
    let is_watch = ["/healthz", "/readyz"].contains(&request.uri().path());
    if request.extensions().get::<Spare>().is_some() && !is_watch {
        return Err(Problem::busy("too many connections at a time"));
    }
    tokio::select! {
        response = next.run(request) => Ok(response),
        () = Phase::Over.begun(app.phase.clone()) => {
            Err(Problem::busy("the server stopped before this was done"))
        }
    }
}

fn panicked(_panic: Box<dyn Any + Send>) -> Response {
    Problem::broken().into_response()
}

/// Browsers are told to take nothing from elsewhere, and to give nothing to other origins.
async fn protect(request: Request, next: Next) -> Response {
    let mut response = next.run(request).await;
    let headers = response.headers_mut();
    let policy = "default-src 'self'; img-src 'self' blob: data:; frame-ancestors 'none'";
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
    // Busy is no fault, and whoever is refused a thousand times must not fill the log.
    let is_busy = response.status() == StatusCode::SERVICE_UNAVAILABLE;
    if response.status().is_server_error() && !is_busy {
        tracing::warn!("{method} {path} {status} {ms:.1} ms");
    } else {
        tracing::info!("{method} {path} {status} {ms:.1} ms");
    }
    response
}
