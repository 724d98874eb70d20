//! The OpenAPI 3.1 document, put together from the table of routes and the types' own schemas.

use crate::answer::JSON;
use crate::problem::{self, Problem};
use crate::scene_id;
use crate::watch;
use axum::http::StatusCode;
use fogbank_core::image::Format;
use fogbank_core::json::TAGS as TAGS_OF_UNIONS;
use fogbank_core::scene::Scene;
use schemars::generate::{SchemaGenerator, SchemaSettings};
use schemars::{JsonSchema, Schema};
use serde_json::{Map, Value, json};

/// Where the document keeps the schemas of types.
const SCHEMAS: &str = "/components/schemas";

/// Makes schemas of types, and remembers those that others refer to.
pub fn generator() -> SchemaGenerator {
    SchemaSettings::draft2020_12()
        .with(|settings| {
            settings.definitions_path = SCHEMAS.into();
            settings.meta_schema = None;
        })
        .into_generator()
}

/// What the operations of a group have to do with each other.
const TAGS: [(&str, &str); 5] = [
    ("pictures", "Images of a scene."),
    ("numbers", "What the models compute, as numbers."),
    ("scenes", "Scenes that live on this server: revisions, edits, history."),
    ("service", "What this server offers and accepts."),
    ("health", "For whoever watches the process."),
];

/// What one method of a path takes and answers.
pub struct Operation {
    method: &'static str,
    /// Stable: generated clients name their functions by it.
    id: &'static str,
    tag: &'static str,
    summary: &'static str,
    /// Bodies that it takes, by media type.
    requests: Vec<(&'static str, Schema)>,
    examples: Map<String, Value>,
    content: Map<String, Value>,
    headers: Map<String, Value>,
    parameters: Vec<Value>,
    refusals: Vec<StatusCode>,
    /// Whether it may answer 201 as well.
    creates: bool,
}

/// What every request may meet before its route is asked.
const ALWAYS: [StatusCode; 5] = [
    StatusCode::BAD_REQUEST,
    StatusCode::URI_TOO_LONG,
    StatusCode::MISDIRECTED_REQUEST,
    StatusCode::REQUEST_HEADER_FIELDS_TOO_LARGE,
    StatusCode::INTERNAL_SERVER_ERROR,
];

/// What every job for the renderer may meet.
const OF_A_JOB: [StatusCode; 3] =
    [StatusCode::FORBIDDEN, StatusCode::SERVICE_UNAVAILABLE, StatusCode::GATEWAY_TIMEOUT];

/// What every body may meet.
const OF_A_BODY: [StatusCode; 4] = [
    StatusCode::REQUEST_TIMEOUT,
    StatusCode::PAYLOAD_TOO_LARGE,
    StatusCode::UNSUPPORTED_MEDIA_TYPE,
    StatusCode::UNPROCESSABLE_ENTITY,
];

impl Operation {
    /// A `GET`, described by one sentence.
    pub fn get(id: &'static str, tag: &'static str, summary: &'static str) -> Self {
        Self {
            method: "get",
            id,
            tag,
            summary,
            requests: Vec::new(),
            examples: Map::new(),
            content: Map::new(),
            headers: Map::new(),
            parameters: Vec::new(),
            refusals: ALWAYS.to_vec(),
            creates: false,
        }
    }

    /// A `POST` whose body does not matter.
    pub fn post(id: &'static str, tag: &'static str, summary: &'static str) -> Self {
        Self::bare_post(id, tag, summary).of_a_job()
    }

    /// A `POST` whose body does not matter, and that is no job for the renderer.
    pub fn bare_post(id: &'static str, tag: &'static str, summary: &'static str) -> Self {
        Self { method: "post", ..Self::get(id, tag, summary) }
    }

    /// A `PUT`.
    pub fn put(id: &'static str, tag: &'static str, summary: &'static str) -> Self {
        Self { method: "put", ..Self::get(id, tag, summary) }
    }

    /// A `PATCH`.
    pub fn patch(id: &'static str, tag: &'static str, summary: &'static str) -> Self {
        Self { method: "patch", ..Self::get(id, tag, summary) }
    }

    /// A `DELETE`.
    pub fn delete(id: &'static str, tag: &'static str, summary: &'static str) -> Self {
        Self { method: "delete", ..Self::get(id, tag, summary) }
    }

    /// Is a job for the renderer.
    pub fn of_a_job(self) -> Self {
        self.refuses(&OF_A_JOB)
    }

    /// Is about the scene that the path names.
    pub fn of_scene(self) -> Self {
        let id = json!({ "in": "path", "name": "id", "required": true, "description": "The scene's id.",
            "schema": { "type": "string", "pattern": scene_id::PATTERN } });
        self.with_parameter(id).refuses(&[StatusCode::NOT_FOUND])
    }

    /// May answer 201, where something is new.
    pub fn creates(self) -> Self {
        Self { creates: true, ..self }
    }

    /// Takes a type as a JSON body.
    pub fn takes<T: JsonSchema>(self, schemas: &mut SchemaGenerator) -> Self {
        self.takes_as::<T>(JSON, schemas)
    }

    /// The same as another media type.
    pub fn takes_as<T: JsonSchema>(
        mut self,
        media_type: &'static str,
        schemas: &mut SchemaGenerator,
    ) -> Self {
        self.requests.push((media_type, schemas.subschema_for::<T>()));
        self.refuses(&OF_A_BODY)
    }

    /// Takes the members of a type as parts of the address's query.
    pub fn query<T: JsonSchema>(mut self, schemas: &mut SchemaGenerator) -> Self {
        let schema = schemas.root_schema_for::<T>();
        for (name, member) in
            schema.get("properties").and_then(Value::as_object).into_iter().flatten()
        {
            let mut schema = member.clone();
            let description =
                schema.as_object_mut().and_then(|schema| schema.remove("description"));
            self.parameters.push(json!({ "in": "query", "name": name, "description": description,
                "schema": schema }));
        }
        self.refuses(&[StatusCode::UNPROCESSABLE_ENTITY])
    }

    /// A body that is answered with 200.
    pub fn example(mut self, name: &str, summary: &str, body: Value) -> Self {
        let example = json!({ "summary": summary, "value": body });
        self.examples.insert(name.into(), example);
        self
    }

    /// Answers a type as JSON.
    pub fn json<T: JsonSchema>(self, schemas: &mut SchemaGenerator) -> Self {
        let schema = schemas.subschema_for::<T>();
        self.content(JSON, json!({ "schema": schema }))
    }

    /// Answers this, for one: if there are examples of bodies, to the first of them.
    pub fn answers(mut self, example: Value) -> Self {
        self.content[JSON]["example"] = example;
        self
    }

    /// Answers something else.
    pub fn content(mut self, media_type: &str, description: Value) -> Self {
        self.content.insert(media_type.into(), description);
        self
    }

    /// Answers a picture in one of `formats`, by `Accept`.
    pub fn picture(self, formats: &[Format]) -> Self {
        let job = "An id of the client's choice: `/v1/progress/{job}` tells how far the job is.";
        let operation = self
            .refuses(&[StatusCode::NOT_ACCEPTABLE, StatusCode::CONFLICT])
            .parameter("header", watch::HEADER, job)
            .header("ETag", "The same bytes have the same tag.")
            .header("Fog-Backend", "Where the picture was made.")
            .header("Fog-Quality", "`draft` or `full`.")
            .header("Fog-Far-Cut", "The transmittance below which rays ended, if the request set one.")
            .header("Server-Timing", "Milliseconds in the queue, in each pass and encoding; `desc=reused` where what a pass made before was kept.");
        // Without this schema, generated clients drop the bytes.
        let bytes = json!({ "schema": { "type": "string", "format": "binary" } });
        formats.iter().fold(operation, |operation, format| {
            operation.content(format.content_type(), bytes.clone())
        })
    }

    /// Takes a parameter in the request's `path` or `header`.
    pub fn parameter(self, place: &str, name: &str, description: &str) -> Self {
        let schema = json!({ "type": "string", "pattern": watch::ID_PATTERN });
        let is_required = place == "path";
        self.with_parameter(json!({ "in": place, "name": name, "required": is_required,
            "description": description, "schema": schema }))
    }

    /// Takes any text in a header.
    pub fn header_parameter(self, name: &str, description: &str) -> Self {
        let schema = json!({ "type": "string" });
        self.with_parameter(json!({ "in": "header", "name": name, "description": description,
            "schema": schema }))
    }

    fn with_parameter(mut self, parameter: Value) -> Self {
        self.parameters.push(parameter);
        self
    }

    /// The answer carries this header.
    pub fn header(mut self, name: &str, description: &str) -> Self {
        let header = json!({ "description": description, "schema": { "type": "string" } });
        self.headers.insert(name.into(), header);
        self
    }

    /// May also be refused with these.
    pub fn refuses(mut self, statuses: &[StatusCode]) -> Self {
        self.refusals.extend_from_slice(statuses);
        self
    }

    fn document(self) -> Value {
        let mut operation = json!({
            "operationId": self.id,
            "tags": [self.tag],
            "summary": self.summary,
        });
        if !self.requests.is_empty() {
            let mut bodies = Map::new();
            for (media_type, schema) in self.requests {
                let mut content = json!({ "schema": schema });
                if !self.examples.is_empty() {
                    content["examples"] = self.examples.clone().into();
                }
                bodies.insert(media_type.into(), content);
            }
            operation["requestBody"] = json!({ "required": true, "content": bodies });
        }
        let mut success = json!({ "description": "Success", "content": self.content });
        if !self.headers.is_empty() {
            success["headers"] = self.headers.into();
        }
        let mut responses = Map::new();
        if self.creates {
            let mut created = success.clone();
            created["description"] = "It is new".into();
            responses.insert("201".into(), created);
        }
        responses.insert("200".into(), success);
        for status in self.refusals {
            let reference = json!({ "$ref": format!("#/components/responses/{}", name(status)) });
            responses.insert(status.as_str().into(), reference);
        }
        operation["responses"] = responses.into();
        if !self.parameters.is_empty() {
            operation["parameters"] = self.parameters.into();
        }
        json!({ self.method: operation })
    }
}

/// One path: where it is, and what it takes and answers.
pub type Path = (&'static str, fn(&mut SchemaGenerator) -> Operation);

/// The whole document of some paths.
pub fn document(all: impl Iterator<Item = Path>) -> Value {
    let mut schemas = generator();
    schemas.subschema_for::<Scene>();
    let mut paths = Map::new();
    for (path, operation) in all {
        let operation = operation(&mut schemas).document();
        match (paths.get_mut(path), operation) {
            (Some(Value::Object(others)), Value::Object(own)) => others.extend(own),
            (_, operation) => {
                paths.insert(path.into(), operation);
            }
        }
    }
    let responses = refusals(&mut schemas);
    let mut definitions = schemas.take_definitions(true);
    name_variants(&mut definitions);
    json!({
        "openapi": "3.1.0",
        "jsonSchemaDialect": "https://json-schema.org/draft/2020-12/schema",
        "info": {
            "title": "Fogbank",
            "version": env!("CARGO_PKG_VERSION"),
            "description": "Previews of fog by published closed forms. Lengths are metres, angles \
                degrees, colours linear Rec. 709; the world is right-handed, +Y up.\n\nEvery refusal \
                is an RFC 9457 problem of the type `about:blank`: its status says what kind it is, \
                and where a body is not valid, each of its `errors` has a `code`, which is stable. \
                In schemas, `x-items-in-all` bounds what all lists of that name in a scene hold \
                together.",
            "license": { "name": env!("CARGO_PKG_LICENSE"), "identifier": env!("CARGO_PKG_LICENSE") },
        },
        "servers": [{ "url": "/" }],
        "tags": TAGS.map(|(name, description)| json!({ "name": name, "description": description })),
        "paths": paths,
        "components": { "schemas": definitions, "responses": responses },
    })
}

/// Every refusal that a route may answer, by name.
fn refusals(schemas: &mut SchemaGenerator) -> Map<String, Value> {
    let schema = schemas.subschema_for::<Problem>();
    let all = [
        (StatusCode::BAD_REQUEST, "The body is not JSON, or the request not HTTP."),
        (StatusCode::FORBIDDEN, "A page of another site must not use this server."),
        (StatusCode::NOT_ACCEPTABLE, "`Accept` takes no format that is offered."),
        (StatusCode::NOT_FOUND, "There is nothing of that name."),
        (
            StatusCode::CONFLICT,
            "Another job that waits or runs has this `Fog-Job`, the scene has moved on, or there is \
            nothing to undo.",
        ),
        (
            StatusCode::PRECONDITION_FAILED,
            "The scene is not at a revision that the request expects.",
        ),
        (StatusCode::INSUFFICIENT_STORAGE, "There is no room to store it."),
        (StatusCode::REQUEST_TIMEOUT, "The body came too slowly."),
        (StatusCode::PAYLOAD_TOO_LARGE, "The body is larger than `/v1/limits` allows."),
        (StatusCode::URI_TOO_LONG, "The address is too long."),
        (StatusCode::UNSUPPORTED_MEDIA_TYPE, "The body is not declared as JSON."),
        (StatusCode::MISDIRECTED_REQUEST, "`Host` names another server."),
        (StatusCode::UNPROCESSABLE_ENTITY, "The body is JSON, but no valid request."),
        (StatusCode::REQUEST_HEADER_FIELDS_TOO_LARGE, "The headers are too large."),
        (StatusCode::INTERNAL_SERVER_ERROR, "The server failed."),
        (StatusCode::SERVICE_UNAVAILABLE, "Busy: come again after `Retry-After` seconds."),
        (StatusCode::GATEWAY_TIMEOUT, "The deadline passed."),
    ];
    let describe = |(status, description): (StatusCode, &str)| {
        let mut content = json!({ "schema": schema });
        if status == StatusCode::UNPROCESSABLE_ENTITY {
            content["example"] = invalid_example();
        }
        let content = json!({ problem::CONTENT_TYPE: content });
        let mut response = json!({ "description": description, "content": content });
        if status == StatusCode::SERVICE_UNAVAILABLE {
            let seconds = json!({ "description": "Seconds.", "schema": { "type": "integer" } });
            response["headers"] = json!({ "Retry-After": seconds });
        }
        (name(status), response)
    };
    all.into_iter().map(describe).collect()
}

/// What is answered to `{"scene": {"far_m": "far"}, "width": 0}` for a picture.
fn invalid_example() -> Value {
    let error = |pointer: &str, code: &str, detail: &str| json!({ "pointer": pointer, "code": code, "detail": detail });
    json!({
        "type": "about:blank",
        "title": "Unprocessable Entity",
        "status": 422,
        "detail": "/scene/far_m: expected a number, found a string",
        "errors": [
            error("/scene/far_m", "wrong_type", "expected a number, found a string"),
            error("/width", "out_of_range", "0 is not between 1 and 8192"),
            error("", "missing", "`height` is missing"),
        ],
    })
}

/// `UnprocessableEntity`.
fn name(status: StatusCode) -> String {
    status.canonical_reason().unwrap_or_default().split(' ').collect()
}

/// Gives every variant of a tagged union a name of its own, `PlaneShape` or `PointLight`, and says
/// which member tells them apart: generated clients have named types then.
fn name_variants(definitions: &mut Map<String, Value>) {
    let mut named = Map::new();
    for (union, schema) in definitions.iter_mut() {
        let Some(variants) = schema.get_mut("oneOf").and_then(Value::as_array_mut) else {
            continue;
        };
        let mut mapping = Map::new();
        let mut discriminator = "kind";
        for variant in variants {
            let word = |tag| variant.pointer(&format!("/properties/{tag}/const"));
            let found = TAGS_OF_UNIONS.iter().find_map(|tag| Some((*tag, word(tag)?.as_str()?)));
            let Some((tag, kind)) = found else { continue };
            discriminator = tag;
            let (kind, name) = (kind.to_owned(), format!("{}{union}", pascal_case(kind)));
            let reference = format!("#{SCHEMAS}/{name}");
            mapping.insert(kind, reference.clone().into());
            named.insert(name, std::mem::replace(variant, json!({ "$ref": reference })));
        }
        if !mapping.is_empty() {
            schema["discriminator"] = json!({ "propertyName": discriminator, "mapping": mapping });
        }
    }
    definitions.append(&mut named);
}

fn pascal_case(snake_case: &str) -> String {
    let capitalise = |word: &str| {
        let mut letters = word.chars();
        letters.next().map(|first| first.to_ascii_uppercase().to_string() + letters.as_str())
    };
    snake_case.split('_').filter_map(capitalise).collect()
}
