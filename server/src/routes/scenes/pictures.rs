//! Pictures and numbers of a scene that the server has: what the stateless routes answer, but nobody sends the scene.

use super::head;
use crate::accept;
use crate::answer;
use crate::app::App;
use crate::budget::Client;
use crate::conditional;
use crate::openapi::Operation;
use crate::picture::{self, Encoded};
use crate::problem::Problem;
use crate::query::query;
use crate::routes::{compare as errors, optical_depth as maps, probe as rays};
use crate::scene_id::SceneId;
use crate::store::record::Head;
use crate::watch::JobId;
use axum::extract::{Request, State};
use axum::http::{HeaderMap, HeaderValue, StatusCode, Uri, header};
use axum::response::{IntoResponse, Response};
use fogbank_core::Frame;
use fogbank_core::compare::EstimatorsRequest;
use fogbank_core::edit::{SelectRequest, Selected};
use fogbank_core::image::{EncodeError, Format};
use fogbank_core::request::{Eye, FrameRequest, Layer, Quality, RaysRequest, Tonemap, View};
use fogbank_core::scene::Problem as Wrong;
use headers::ETag;
use schemars::SchemaGenerator;
use serde_json::json;

/// A picture of a stored scene, in the format that `Accept` asks for.
pub async fn frame(
    State(app): State<App>,
    SceneId(id): SceneId,
    client: Client,
    uri: Uri,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let format = accept::choose(&headers, &Format::ALL, Format::content_type)?;
    let (view, eye) = query(&uri, FrameRequest::check)?;
    let view = view.for_format(format);
    let encode = move |frame: &Frame| Encoded::of(frame, &view, format);
    let head = head(&app, &id).await?;
    answer_picture(&app, client, (&uri, &headers), &head, (view, eye, format), encode).await
}

/// Its documentation.
pub fn frame_operation(schemas: &mut SchemaGenerator) -> Operation {
    let summary = "A picture of a stored scene, or another layer of its frame.";
    Operation::get("scene_frame", "scenes", summary)
        .of_scene()
        .query::<FrameRequest>(schemas)
        .picture(&Format::ALL)
        .header_parameter(
            "If-None-Match",
            "Tags that the client has: 304 if the picture has one of them.",
        )
        .of_a_job()
}

/// The optical depth of every view ray of a stored scene.
pub async fn optical_depth(
    State(app): State<App>,
    SceneId(id): SceneId,
    client: Client,
    uri: Uri,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let format = accept::choose(&headers, &maps::FORMATS, Format::content_type)?;
    let (view, eye) = query(&uri, check_map)?;
    let encode = move |frame: &Frame| maps::encode_map(frame, &view, format);
    let head = head(&app, &id).await?;
    answer_picture(&app, client, (&uri, &headers), &head, (view, eye, format), encode).await
}

/// What a map of optical depths is, whatever else is asked for.
fn check_map(request: FrameRequest) -> Result<(View, Eye), Vec<Wrong>> {
    let (layer, samples) = (Layer::OpticalDepth, Some(1));
    let (quality, tonemap) = (Quality::Full, Tonemap::None);
    FrameRequest { layer, samples, quality, tonemap, exposure_ev: 0.0, ..request }.check()
}

/// Its documentation.
pub fn optical_depth_operation(schemas: &mut SchemaGenerator) -> Operation {
    let summary = "The optical depth of every view ray of a stored scene: float32, or a 16-bit PNG with a scale.";
    Operation::get("scene_optical_depth", "scenes", summary)
        .of_scene()
        .query::<FrameRequest>(schemas)
        .picture(&maps::FORMATS)
        .header(maps::SCALE, maps::SCALE_IS)
        .of_a_job()
}

/// The tag of a picture that is not made yet: all that its bytes depend on.
fn picture_tag(app: &App, head: &Head, uri: &Uri, format: Format) -> ETag {
    let version = env!("CARGO_PKG_VERSION");
    let backend = app.renderer.backend();
    let all = format!("{version} {backend} {uri} {} {}", head.revision, format.content_type());
    let tag = answer::etag(all.as_bytes());
    tag.parse().unwrap_or_else(|_| conditional::tag(head.revision))
}

async fn answer_picture(
    app: &App,
    client: Client,
    (uri, headers): (&Uri, &HeaderMap),
    head: &Head,
    (view, eye, format): (View, Eye, Format),
    encode: impl FnOnce(&Frame) -> Result<Encoded, EncodeError> + Send + 'static,
) -> Result<Response, Problem> {
    let job = JobId::of(headers)?;
    let tag = picture_tag(app, head, uri, format);
    let fixed = [
        (header::ETAG, conditional::value(&tag)),
        (header::CACHE_CONTROL, HeaderValue::from_static("no-cache")),
        (header::VARY, HeaderValue::from_static("accept")),
    ];
    let revision = [("fog-revision", HeaderValue::from(head.revision))];
    if conditional::is_known(headers, &tag)? {
        return Ok((StatusCode::NOT_MODIFIED, fixed, revision).into_response());
    }
    let scene = eye.on(&head.scene).map_err(Problem::invalid)?;
    let response = picture::answer(app, client, job, scene, view, format, encode).await?;
    // This tag in the place of one of the bytes.
    let mut response = (revision, response).into_response();
    for (name, value) in fixed {
        response.headers_mut().insert(name, value);
    }
    Ok(response)
}

/// The numbers along rays in a stored scene.
pub async fn probe(
    State(app): State<App>,
    SceneId(id): SceneId,
    client: Client,
    request: Request,
) -> Result<Response, Problem> {
    let headers = request.headers().clone();
    let request = app.intake.read(request, Ok::<RaysRequest, Vec<Wrong>>).await?;
    let head = head(&app, &id).await?;
    let (scene, found) = request.check(&head.scene).map_err(Problem::invalid)?;
    rays::answer(&app, client, headers, scene, found).await
}

/// Its documentation.
pub fn probe_operation(schemas: &mut SchemaGenerator) -> Operation {
    let summary =
        "Optical depth, transmittance, airlight and radiance along rays of a stored scene, in f64.";
    let ray = json!({ "origin": [0, 1, 8], "direction": [0, 0, -1] });
    Operation::post("scene_probe", "scenes", summary)
        .of_scene()
        .takes::<RaysRequest>(schemas)
        .example("ray", "One ray.", json!({ "rays": [ray] }))
        .json::<rays::ProbeAnswer>(schemas)
}

/// How far one airlight estimator is from another on a stored scene.
pub async fn compare(
    State(app): State<App>,
    SceneId(id): SceneId,
    client: Client,
    request: Request,
) -> Result<Response, Problem> {
    let headers = request.headers().clone();
    let request = app.intake.read(request, Ok::<EstimatorsRequest, Vec<Wrong>>).await?;
    let head = head(&app, &id).await?;
    let compared = request.check(&head.scene).map_err(Problem::invalid)?;
    errors::answer(&app, client, &headers, compared).await
}

/// Its documentation.
pub fn compare_operation(schemas: &mut SchemaGenerator) -> Operation {
    let summary = "How far one airlight estimator is from another on a stored scene.";
    let small = json!({ "width": 16, "height": 12 });
    let operation = Operation::post("scene_compare", "scenes", summary).of_scene();
    let operation = operation.takes::<EstimatorsRequest>(schemas);
    errors::answers(
        operation.example("small", "`auto` against the integral itself.", small),
        schemas,
    )
}

/// What lies in a rectangle of a picture of a stored scene.
pub async fn select(
    State(app): State<App>,
    SceneId(id): SceneId,
    request: Request,
) -> Result<Response, Problem> {
    let request = app.intake.read(request, SelectRequest::check).await?;
    let head = head(&app, &id).await?;
    let revision = [("fog-revision", HeaderValue::from(head.revision))];
    let select = move || answer::json(&request.select(&head.scene));
    Ok((revision, tokio::task::spawn_blocking(select).await?).into_response())
}

/// Its documentation.
pub fn select_operation(schemas: &mut SchemaGenerator) -> Operation {
    let summary = "Blobs, lights and emitters that lie in a rectangle of a picture, hidden or not.";
    let all = json!({ "rectangle": [0, 0, 1, 1] });
    Operation::post("scene_select", "scenes", summary)
        .of_scene()
        .takes::<SelectRequest>(schemas)
        .example("all", "All that is seen.", all)
        .json::<Selected>(schemas)
}
