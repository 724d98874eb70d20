//! `POST /v1/compare`: how far one airlight estimator is from another, in numbers or as an image.

use crate::accept;
use crate::answer::JSON;
use crate::app::App;
use crate::budget::Client;
use crate::estimate::picture_bytes;
use crate::openapi::Operation;
use crate::picture::{self, Encoded};
use crate::problem::Problem;
use crate::queue::{Lane, Order};
use crate::watch::JobId;
use axum::extract::{Request, State};
use axum::http::{HeaderMap, HeaderName};
use axum::response::Response;
use fogbank_core::compare::{self, CompareRequest, Compared, Comparison, Pair};
use fogbank_core::image::{EncodeError, Format, encode_errors};
use fogbank_core::request::Quality;
use fogbank_core::scene::CheckedScene;
use fogbank_core::{Interrupted, Progress, Renderer};
use schemars::SchemaGenerator;
use serde_json::json;

/// The numbers as JSON, or an image of the errors.
#[derive(Clone, Copy)]
enum Form {
    Numbers,
    Image(Format),
}

const FORMS: [Form; 6] = [
    Form::Numbers,
    Form::Image(Format::Png),
    Form::Image(Format::Jpeg),
    Form::Image(Format::WebP),
    Form::Image(Format::Exr),
    Form::Image(Format::Npy),
];

/// The header of an image that holds the numbers.
const NUMBERS: &str = "Fog-Comparison";

impl Form {
    fn content_type(self) -> &'static str {
        match self {
            Self::Numbers => JSON,
            Self::Image(format) => format.content_type(),
        }
    }
}

/// Compares two estimators on the layer `airlight`.
pub async fn compare(
    State(app): State<App>,
    client: Client,
    request: Request,
) -> Result<Response, Problem> {
    let headers = request.headers().clone();
    let compared = app.intake.read(request, CompareRequest::check).await?;
    answer(&app, client, &headers, compared).await
}

/// Compares a checked pair.
///
/// # Errors
/// 406, and those of [`picture::answer_job`].
pub async fn answer(
    app: &App,
    client: Client,
    headers: &HeaderMap,
    (scene, pair): (CheckedScene, Pair),
) -> Result<Response, Problem> {
    let form = accept::choose(headers, &FORMS, Form::content_type)?;
    let job = JobId::of(headers)?;
    let (width, height) = pair.size();
    let most_bytes = match form {
        Form::Numbers => 0,
        Form::Image(format) => picture_bytes(width, height, 1, format),
    };
    let room = app.answers.reserve(client, most_bytes)?;
    let order = Order::new(Lane::Long, client, app.deadline(pair.is_slow()));
    let work = move |renderer: &Renderer, progress: &Progress| {
        let mut compared = compare::run(renderer, &scene, &pair, progress)?;
        let timings = std::mem::take(&mut compared.timings);
        Ok::<_, Interrupted>((compared, timings))
    };
    let encode = move |compared: &Compared| encode(compared, form);
    picture::answer_job(app, order, room, job, Quality::Full, work, encode).await
}

fn encode(compared: &Compared, form: Form) -> Result<Encoded, EncodeError> {
    let numbers = serde_json::to_string(&compared.comparison).unwrap_or_default();
    let content_type = form.content_type();
    let Form::Image(format) = form else {
        let (bytes, backend) = (numbers.into_bytes(), compared.backend);
        return Ok(Encoded { bytes, backend, content_type, extra: None });
    };
    let bytes = encode_errors(&compared.errors, format)?;
    let name = HeaderName::from_static("fog-comparison");
    let extra = Some((name, numbers));
    Ok(Encoded { bytes, backend: compared.backend, content_type, extra })
}

/// Its documentation.
pub fn operation(schemas: &mut SchemaGenerator) -> Operation {
    let summary = "How far one airlight estimator is from another: numbers, or an image of the \
        relative errors, float32 or colour-mapped by their logarithm from 0.0001 (darkest) to 1 \
        (brightest).";
    let scene = json!({
        "lights": [{ "kind": "point", "position": [0, 2, 0] }],
        "fog": { "terms": [{ "kind": "homogeneous", "extinction": 0.1 }] },
    });
    let march = json!({ "airlight": "march", "steps": 16 });
    let example = json!({ "scene": scene, "width": 16, "height": 12, "a": march });
    let operation = Operation::post("compare", "numbers", summary)
        .takes::<CompareRequest>(schemas)
        .example("march", "16 steps against the integral itself.", example);
    answers(operation, schemas)
}

/// What every comparison answers.
pub fn answers(operation: Operation, schemas: &mut SchemaGenerator) -> Operation {
    operation
        .json::<Comparison>(schemas)
        .picture(&[Format::Png, Format::Jpeg, Format::WebP, Format::Exr, Format::Npy])
        .header(NUMBERS, "Only with an image: the numbers, as the JSON would say them.")
}
