//! `GET /v1/progress/{job}`: how far a picture or a comparison is that is on its way.

use crate::answer;
use crate::app::App;
use crate::openapi::Operation;
use crate::problem::Problem;
use crate::watch::{HEADER, JobId};
use axum::extract::rejection::PathRejection;
use axum::extract::{Path, State};
use axum::http::StatusCode;
use axum::response::Response;
use fogbank_core::Progress;
use schemars::{JsonSchema, SchemaGenerator};
use serde::Serialize;

/// How far a job is.
#[derive(Serialize, JsonSchema)]
pub struct JobProgress {
    /// Whether its turn has come.
    state: JobState,
    /// Share of its slow work that is done, in [0, 1]; it never falls.
    #[schemars(range(min = 0, max = 1))]
    fraction: f64,
}

/// Whether a job's turn has come.
#[derive(Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
enum JobState {
    /// Others are before it.
    Waiting,
    /// It is being worked on.
    Running,
}

impl From<&Progress> for JobProgress {
    fn from(progress: &Progress) -> Self {
        let state = if progress.has_begun() { JobState::Running } else { JobState::Waiting };
        Self { state, fraction: progress.fraction() }
    }
}

/// Answers while the job waits or runs.
pub async fn progress(
    State(app): State<App>,
    job: Result<Path<String>, PathRejection>,
) -> Result<Response, Problem> {
    // What is not even text is no id either.
    let id = job.ok().and_then(|Path(job)| JobId::read(&job));
    let progress = id.and_then(|id| app.watch.get(&id));
    let detail = format!("no job with this {HEADER} waits or runs");
    let progress = progress.ok_or_else(|| Problem::new(StatusCode::NOT_FOUND, detail))?;
    Ok(answer::json(&JobProgress::from(&*progress)))
}

/// Its documentation.
pub fn operation(schemas: &mut SchemaGenerator) -> Operation {
    let job = "The header `Fog-Job` of the request that is on its way.";
    let summary = "How far a picture or a comparison is; nothing is kept when it has ended.";
    Operation::get("progress", "pictures", summary)
        .parameter("path", "job", job)
        .json::<JobProgress>(schemas)
        .refuses(&[StatusCode::NOT_FOUND])
}
