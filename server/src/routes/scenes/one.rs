//! `/v1/scenes/{id}`: a whole scene that comes, is read, is patched and goes.

use super::{Revised, a_write, head, revised, terms, write};
use crate::answer;
use crate::app::App;
use crate::budget::Client;
use crate::conditional::{self, tag};
use crate::extract::{Digested, digest_of};
use crate::openapi::Operation;
use crate::problem::Problem;
use crate::query::texts;
use crate::scene_id::SceneId;
use crate::store::record::{Head, Kind};
use crate::store::{Key, Made, Refusal};
use axum::extract::{Request, State};
use axum::http::{HeaderMap, HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use fogbank_core::edit::in_scene;
use fogbank_core::json::document::{Node, Patch, closed};
use fogbank_core::scene::{CheckedScene, Checker, Problem as Wrong, Scene};
use schemars::{JsonSchema, SchemaGenerator};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

/// A scene in an answer may be so many times as large as the largest body: defaults are filled in.
const SCENE_BYTES: usize = 2 * crate::extract::BODY_BYTES;

const MERGE_PATCH: &str = "application/merge-patch+json";
const JSON_PATCH: &str = "application/json-patch+json";

/// A scene that lives on the server.
#[derive(Serialize, JsonSchema)]
struct StoredScene<'a> {
    /// Its id.
    id: &'a str,
    /// The revision that it is at.
    revision: u64,
    /// The scene, in which every surface, light and term has an id.
    scene: &'a Scene,
}

/// Where a scene comes from.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Source {
    /// A stored scene or a preset that is copied: then there is no body.
    #[serde(default)]
    from: Option<String>,
}

/// Stores a scene, new or in the place of the one of that id: the one in the body, or a copy of another.
pub async fn put(
    State(app): State<App>,
    SceneId(id): SceneId,
    request: Request,
) -> Result<Response, Problem> {
    let headers = request.headers().clone();
    let Source { from } = texts(request.uri(), Ok::<Source, Vec<Wrong>>)?;
    let from = from.map(SceneId::read).transpose()?;
    let body: Digested<CheckedScene> = match from {
        Some(SceneId(from)) => {
            let digest = digest_of(&request, &[]);
            Digested { value: head(&app, &from).await?.scene.clone(), digest }
        }
        None => {
            let named = |mut scene: Scene| {
                scene.name_all();
                scene.check()
            };
            app.intake.digest(request, named).await?
        }
    };
    let (condition, key) = terms(&headers, &body)?;
    let name = id.clone();
    let written = write(&app, move |store| {
        store.write(&name, &condition, key, |_, _| Ok(Made::whole(body.value, Kind::Put)))
    });
    Ok(revised(id, written.await?, false))
}

/// Its documentation.
pub fn put_operation(schemas: &mut SchemaGenerator) -> Operation {
    let summary = "Stores a scene, new or in the place of the one of that id. With `If-None-Match: *` it must be new. \
        With `?from=` it is a copy of another scene, or of a preset.";
    let example = json!({ "lights": [{ "id": "lamp", "kind": "point", "position": [0, 2.2, 1] }] });
    a_write(Operation::put("put_scene", "scenes", summary).takes::<Scene>(schemas))
        .query::<Source>(schemas)
        .header_parameter("If-None-Match", "`*`: there must be no such scene yet.")
        .example("lamp", "A lamp.", example)
        .json::<Revised>(schemas)
        .creates()
}

/// Answers a scene.
pub async fn get(
    State(app): State<App>,
    SceneId(id): SceneId,
    client: Client,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let head = head(&app, &id).await?;
    let tag = tag(head.revision);
    let etag = [
        (header::ETAG, conditional::value(&tag)),
        (header::CACHE_CONTROL, HeaderValue::from_static("no-cache")),
    ];
    if conditional::is_known(&headers, &tag)? {
        return Ok((StatusCode::NOT_MODIFIED, etag).into_response());
    }
    let room = app.answers.reserve(client, SCENE_BYTES)?;
    let encode = move || {
        let stored = StoredScene { id: &id, revision: head.revision, scene: &head.scene };
        answer::large_json(&stored, &headers, room)
    };
    Ok((etag, tokio::task::spawn_blocking(encode).await?).into_response())
}

/// Its documentation.
pub fn get_operation(schemas: &mut SchemaGenerator) -> Operation {
    Operation::get("get_scene", "scenes", "A scene that lives on this server.")
        .of_scene()
        .header_parameter(
            "If-None-Match",
            "Revisions that the client has: 304 if it is one of them.",
        )
        .header("ETag", "The revision.")
        .json::<StoredScene<'_>>(schemas)
        .refuses(&[StatusCode::SERVICE_UNAVAILABLE])
}

/// Changes a scene by a merge patch or a JSON patch.
pub async fn patch(
    State(app): State<App>,
    SceneId(id): SceneId,
    request: Request,
) -> Result<Response, Problem> {
    let headers = request.headers().clone();
    let content_type = headers.get(header::CONTENT_TYPE).and_then(|value| value.to_str().ok());
    let name = content_type.unwrap_or_default().split(';').next().unwrap_or_default().trim();
    if name.eq_ignore_ascii_case(JSON_PATCH) {
        let body = app.intake.digest(request, counted).await?;
        return patch_with(app, id, headers, body, |patch, document| {
            patch.apply(document).map_err(|problem| Refusal::Invalid(vec![problem]))
        })
        .await;
    }
    if name.eq_ignore_ascii_case(MERGE_PATCH) {
        let body = app.intake.digest(request, Ok::<Value, Vec<Wrong>>).await?;
        return patch_with(app, id, headers, body, |patch, document| {
            document.merge(patch);
            Ok(())
        })
        .await;
    }
    let detail = format!("the body must be {MERGE_PATCH} or {JSON_PATCH}");
    let problem = Problem::new(StatusCode::UNSUPPORTED_MEDIA_TYPE, detail);
    let accepted =
        HeaderValue::from_static("application/merge-patch+json, application/json-patch+json");
    Ok(([("accept-patch", accepted)], problem).into_response())
}

fn counted(patch: Patch) -> Result<Patch, Vec<Wrong>> {
    let mut check = Checker::default();
    patch.check(&mut check, String::new);
    check.finish(patch)
}

async fn patch_with<T: Send + 'static>(
    app: App,
    id: String,
    headers: HeaderMap,
    body: Digested<T>,
    apply: impl FnOnce(T, &mut Node) -> Result<(), Refusal> + Send + 'static,
) -> Result<Response, Problem> {
    let (condition, key) = terms(&headers, &body)?;
    let name = id.clone();
    let written = write(&app, move |store| {
        store.write(&name, &condition, key, |head, _| {
            let head = head.ok_or(Refusal::Missing)?;
            let scene = patched(head, |document| apply(body.value, document))?;
            Ok(Made::whole(scene, Kind::Patch))
        })
    });
    Ok(revised(id, written.await?, true))
}

fn patched(
    head: &Head,
    apply: impl FnOnce(&mut Node) -> Result<(), Refusal>,
) -> Result<CheckedScene, Refusal> {
    let mut document = Node::kept(&*head.scene);
    apply(&mut document)?;
    let invalid = |problems| Refusal::Invalid(in_scene(problems));
    let mut scene: Scene = closed(document).map_err(invalid)?;
    scene.name_all();
    scene.check_after(&head.scene).map_err(invalid)
}

/// Its documentation.
pub fn patch_operation(schemas: &mut SchemaGenerator) -> Operation {
    let summary = "Changes a scene by a merge patch (RFC 7396) or a JSON patch (RFC 6902). Where the scene would not \
        be valid, pointers of the problem begin with `/scene`.";
    a_write(Operation::patch("patch_scene", "scenes", summary))
        .takes_as::<Value>(MERGE_PATCH, schemas)
        .takes_as::<Patch>(JSON_PATCH, schemas)
        .json::<Revised>(schemas)
}

/// Takes a scene away.
pub async fn delete(
    State(app): State<App>,
    SceneId(id): SceneId,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let condition = conditional::condition(&headers)?;
    // Nothing that is written with a body has this number but by chance.
    let key = conditional::key(&headers)?.map(|name| Key { name, digest: u64::MAX });
    let name = id.clone();
    let written = write(&app, move |store| store.delete(&name, &condition, key)).await?;
    Ok(answer::json(&Revised { id, revision: written.revision, patch: None }))
}

/// Its documentation.
pub fn delete_operation(schemas: &mut SchemaGenerator) -> Operation {
    let summary = "Takes a scene away, with its history; answers the revision that it was at. A scene that comes \
        under its id later has larger ones.";
    a_write(Operation::delete("delete_scene", "scenes", summary)).json::<Revised>(schemas)
}
