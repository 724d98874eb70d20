//! `POST /v1/optical-depth`: the optical depth of every view ray.

use crate::accept;
use crate::app::App;
use crate::budget::Client;
use crate::openapi::Operation;
use crate::picture::{self, Encoded};
use crate::problem::Problem;
use crate::watch::JobId;
use axum::extract::{Request, State};
use axum::http::HeaderName;
use axum::response::Response;
use fogbank_core::image::{EncodeError, Format, encode_png16};
use fogbank_core::request::{DepthsOf, OpticalDepthRequest, View};
use fogbank_core::scene::CheckedScene;
use fogbank_core::{Frame, Progress, Renderer, light_map};
use schemars::SchemaGenerator;
use serde_json::json;

/// Formats of such a map, the usual one first.
pub const FORMATS: [Format; 3] = [Format::Npy, Format::Exr, Format::Png];

/// The header that says which optical depth the white of a 16-bit PNG stands for.
pub const SCALE: &str = "Fog-Optical-Depth-Scale";

/// What it says.
pub const SCALE_IS: &str =
    "Only with image/png: the optical depth of white; a pixel p means p / 65535 of it.";

/// Renders the map in the format that `Accept` asks for.
pub async fn render(
    State(app): State<App>,
    client: Client,
    request: Request,
) -> Result<Response, Problem> {
    let format = accept::choose(request.headers(), &FORMATS, Format::content_type)?;
    let job = JobId::of(request.headers())?;
    let (scene, of) = app.intake.read(request, OpticalDepthRequest::check).await?;
    let (light, size) = match of {
        DepthsOf::View(view) => {
            let encode = move |frame: &Frame| encode_map(frame, &view, format);
            return picture::answer(&app, client, job, scene, view, format, encode).await;
        }
        DepthsOf::Light(light, size) => (light, size),
    };
    let pictures = light_map::pictures(&scene.lights[light]);
    let view = View { height: size * pictures, ..light_map::view(size) };
    let encode = move |frame: &Frame| encode_map(frame, &view, format);
    let render = move |renderer: &Renderer, scene: &CheckedScene, progress: &Progress| {
        light_map::render(renderer, scene, light, size, progress)
    };
    picture::answer_by(&app, client, job, scene, view, format, (render, encode)).await
}

/// Encodes it; a PNG has 16 bits a pixel and a scale.
pub fn encode_map(frame: &Frame, view: &View, format: Format) -> Result<Encoded, EncodeError> {
    if format != Format::Png {
        return Encoded::of(frame, view, format);
    }
    let (bytes, scale) = encode_png16(frame)?;
    let name = HeaderName::from_static("fog-optical-depth-scale");
    let extra = Some((name, scale.to_string()));
    let content_type = format.content_type();
    Ok(Encoded { bytes, backend: frame.backend, content_type, extra })
}

/// Its documentation.
pub fn operation(schemas: &mut SchemaGenerator) -> Operation {
    let summary = "The optical depth of every view ray, or from a light to what it first meets in all directions: \
        float32, or a 16-bit PNG with a scale; a number a pixel, or three where an extinction has a colour.";
    let blob = json!({ "kind": "gaussians", "blobs": [{ "center": [0, 1, 0], "radius": 2 }] });
    let example = json!({ "scene": { "fog": { "terms": [blob] } }, "width": 64, "height": 48 });
    let lit = json!({ "scene": { "lights": [{ "kind": "point", "id": "lamp" }], "fog": { "terms": [blob] } },
        "light": "lamp", "size": 32 });
    Operation::post("optical_depth", "pictures", summary)
        .takes::<OpticalDepthRequest>(schemas)
        .example("blob", "One blob of fog.", example)
        .example("light", "The same around a lamp: the six faces of a cube.", lit)
        .picture(&FORMATS)
        .header(SCALE, SCALE_IS)
}
