//! All routes on one screen, and what they share.

use crate::answer::Answers;
use crate::cli::ServeArgs;
use crate::extract::Intake;
use crate::layers;
use crate::openapi::Operation;
use crate::origin::Names;
use crate::problem::Problem;
use crate::queue::Queue;
use crate::routes::{
    compare, health, limits, models, openapi, optical_depth, page, presets, probe, progress,
    render, selftest,
};
use crate::watch::Watch;
use axum::Router;
use axum::http::{Method, StatusCode, Uri};
use axum::response::{IntoResponse, Response};
use axum::routing::{MethodRouter, get, post};
use fogbank_core::Renderer;
use schemars::SchemaGenerator;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};
use tokio::sync::watch;

/// One path of the API: who answers it, and how it is documented.
pub struct Route {
    /// Its path.
    pub path: &'static str,
    /// Who answers.
    pub handler: MethodRouter<App>,
    /// Its part of the OpenAPI document.
    pub operation: fn(&mut SchemaGenerator) -> Operation,
}

/// Every path of the API.
pub fn routes() -> Vec<Route> {
    let route = |path, handler, operation| Route { path, handler, operation };
    vec![
        route("/v1/render", post(render::render), render::operation),
        route("/v1/optical-depth", post(optical_depth::render), optical_depth::operation),
        route("/v1/probe", post(probe::probe), probe::operation),
        route("/v1/compare", post(compare::compare), compare::operation),
        route("/v1/progress/{job}", get(progress::progress), progress::operation),
        route("/v1/selftest", post(selftest::selftest), selftest::operation),
        route("/v1/models", get(models::list), models::operation),
        route("/v1/presets", get(presets::list), presets::operation),
        route("/v1/limits", get(limits::list), limits::operation),
        route("/v1/openapi.json", get(openapi::document), openapi::operation),
        route("/healthz", get(health::healthz), health::healthz_operation),
        route("/readyz", get(health::readyz), health::readyz_operation),
    ]
}

/// Where the server is in its life.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd)]
pub enum Phase {
    /// It takes requests.
    Serving,
    /// It takes no new ones, and ends those that it has.
    Draining,
    /// What is not answered now never will be.
    Over,
}

impl Phase {
    /// Waits until this phase has begun.
    pub async fn begun(self, mut told: watch::Receiver<Self>) {
        // Also when the sender is gone: then nobody else will say so.
        let _ = told.wait_for(|now| *now >= self).await;
    }
}

/// What all requests share.
#[derive(Clone)]
pub struct App {
    /// The renderer.
    pub queue: Arc<Queue<Renderer>>,
    /// Jobs that clients may ask about.
    pub watch: Watch,
    /// Reads bodies.
    pub intake: Intake,
    /// What answers may take.
    pub answers: Answers,
    /// By which names clients may call it.
    pub names: Arc<Names>,
    /// Where it is in its life.
    pub phase: watch::Receiver<Phase>,
    /// Whether the CPU had to take over from a GPU.
    pub has_fallen_back: Arc<AtomicBool>,
    /// What the command line chose.
    pub options: Arc<ServeArgs>,
}

impl App {
    /// Starts the renderer; `phase` will tell when to stop.
    ///
    /// # Errors
    /// When there is no such backend, or the system gives it no thread.
    pub fn start(options: ServeArgs, phase: watch::Receiver<Phase>) -> std::io::Result<Self> {
        let renderer = Renderer::open(options.backend.into()).map_err(std::io::Error::other)?;
        renderer.warm_up();
        let parsers = std::thread::available_parallelism().map_or(1, usize::from);
        Ok(Self {
            has_fallen_back: renderer.fallback(),
            queue: Arc::new(Queue::start(options.queue, renderer)?),
            watch: Watch::default(),
            intake: Intake::new(parsers),
            answers: Answers::new(),
            names: Arc::new(Names::new(&options.listen, &options.allow_host)),
            phase,
            options: Arc::new(options),
        })
    }

    /// When a request, accepted now, must be answered; the reference has more time than the others.
    pub fn deadline(&self, is_reference: bool) -> Instant {
        let seconds =
            if is_reference { self.options.reference_deadline_s } else { self.options.deadline_s };
        Instant::now() + Duration::from_secs_f64(seconds)
    }

    /// The whole server: API, page, and the same refusals everywhere.
    pub fn router(self) -> Router {
        let pages = page::files().into_iter().map(|(path, file)| (path, page::handler(file)));
        let api = routes().into_iter().map(|route| (route.path.to_owned(), route.handler));
        let router = api
            .chain(pages)
            .fold(Router::new(), |router, (path, handler)| router.route(&path, handler));
        let router = router.fallback(not_found).method_not_allowed_fallback(not_allowed);
        layers::around(router, &self).with_state(self)
    }
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
