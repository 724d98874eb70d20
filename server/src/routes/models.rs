//! `GET /v1/models`: every medium, airlight and surface-lighting model.
//!
//! The names, summaries and schemas come from the scene's own types, and what a model supports is
//! found by asking the check of a scene. Only what no type can know stands in the table here.

use crate::answer::{Fixed, JSON};
use crate::openapi::Operation;
use axum::http::HeaderMap;
use axum::response::Response;
use fogbank_core::airlight::about::{About, Exactness, MeasuredError};
use fogbank_core::media::KINDS;
use fogbank_core::options::{LOSSES, Loss, Options};
use fogbank_core::scene::tagged::Tagged;
use fogbank_core::scene::{self, Airlight, Phase, Scene, SurfaceLighting, Term};
use schemars::generate::SchemaSettings;
use schemars::{JsonSchema, SchemaGenerator};
use serde::Serialize;
use serde_json::{Value, json};
use std::sync::LazyLock;

/// Every model of this server.
#[derive(Serialize, JsonSchema)]
struct Models {
    /// Media, airlight and surface lighting, in this order.
    models: Vec<Model>,
    /// What a render may lose for speed.
    options: Vec<OptionOfRender>,
}

/// What a render may lose for speed, and how much that is.
#[derive(Serialize, JsonSchema)]
struct OptionOfRender {
    /// Its name in `options`.
    name: &'static str,
    /// Where it was published.
    source: &'static str,
    /// What it is.
    summary: String,
    /// By how much pictures are off, as measured.
    measured_error: String,
    /// JSON schema of its value.
    schema: Value,
}

/// A medium, or a way to compute light in it.
#[derive(Serialize, JsonSchema)]
struct Model {
    /// How a scene names it.
    name: String,
    /// Which question it answers.
    kind: Kind,
    /// Where it was published, with the equations.
    source: &'static str,
    /// What it is, in a sentence.
    summary: String,
    /// What it works with.
    supports: Supports,
    /// How far it is from the truth, as measured.
    measured_error: String,
    /// JSON schema of what a scene says to use it.
    schema: Value,
}

/// The question that a model answers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
enum Kind {
    /// Where the fog is: an entry of `fog.terms`.
    Medium,
    /// How much light is scattered into a view ray: `fog.airlight`.
    Airlight,
    /// How much light reaches a surface through the fog: `fog.surface_lighting`.
    SurfaceLighting,
}

/// What a model works with, alone or together.
#[derive(Serialize, JsonSchema)]
struct Supports {
    /// Kinds of fog terms.
    media: Vec<&'static str>,
    /// Kinds of phase functions.
    phase: Vec<&'static str>,
}

/// What no type can know about a model.
#[derive(Clone, Copy)]
struct Origin {
    source: &'static str,
    error: Exactness,
}

impl Origin {
    /// Of a model, by its name in a scene.
    fn of(kind: Kind, name: &str) -> Option<Self> {
        match kind {
            Kind::Medium => {
                let error = Exactness::Words("A closed form: rounding is its only error.");
                let (_, source, _) = KINDS.iter().find(|(own, ..)| *own == name)?;
                Some(Self { source, error })
            }
            Kind::Airlight => {
                let airlight: Airlight = serde_json::from_value(name.into()).ok()?;
                let About { source, error, .. } = airlight.about();
                Some(Self { source, error })
            }
            Kind::SurfaceLighting => {
                let found = SURFACE_LIGHTING.iter().find(|(own, ..)| *own == name)?;
                Some(Self { source: found.1, error: Exactness::Words(found.2) })
            }
        }
    }
}

/// Name, source and error of the surface-lighting models.
const SURFACE_LIGHTING: &[(&str, &str, &str)] = &[
    ("auto", "Chooses for the scene.", "That of the model it chooses."),
    (
        "clear",
        "Light as in clear air, as fog in OpenGL has it (Sun 2005, Fig. 1b; Biri 2002; Giroud 2010).",
        "Leaves out what the fog takes from light on its way to surfaces, and what it scatters onto them.",
    ),
    (
        "attenuated",
        "Beer–Lambert law between lamp and surface.",
        "Leaves out the light that the fog scatters onto surfaces.",
    ),
];

/// How far a model is from the truth, in a sentence.
fn in_words(error: Exactness) -> String {
    match error {
        Exactness::Words(words) => words.to_owned(),
        Exactness::Measured(MeasuredError { against, median, p95, max }) => {
            let [median, p95, max] = [median, p95, max].map(percent);
            format!("Relative to {against}: median {median}, p95 {p95}, largest {max}.")
        }
    }
}

/// In percent, two digits of it.
fn percent(share: f64) -> String {
    let percent = 100.0 * share;
    match percent {
        0.0 => "0 %".to_owned(),
        ..0.01 => format!("{percent:.1e} %"),
        ..1.0 => format!("{percent:.2} %"),
        ..10.0 => format!("{percent:.1} %"),
        _ => format!("{percent:.0} %"),
    }
}

static MODELS: LazyLock<Fixed> = LazyLock::new(|| {
    let models = Models { models: all().into_iter().flatten().collect(), options: options() };
    Fixed::new(JSON, serde_json::to_vec(&models).unwrap_or_default())
});

/// All models.
pub async fn list(headers: HeaderMap) -> Response {
    MODELS.answer(&headers)
}

/// Its documentation.
pub fn operation(schemas: &mut SchemaGenerator) -> Operation {
    let summary = "Every medium, airlight and surface-lighting model.";
    Operation::get("list_models", "service", summary).json::<Models>(schemas)
}

/// One entry for each variant of the scene's types; an error names one without an origin.
fn all() -> Vec<Result<Model, String>> {
    let media = variants::<Term>().into_iter().map(|schema| model(Kind::Medium, schema));
    let airlight = variants::<Airlight>().into_iter().map(|schema| model(Kind::Airlight, schema));
    let surface = variants::<SurfaceLighting>().into_iter();
    let surface = surface.map(|schema| model(Kind::SurfaceLighting, schema));
    media.chain(airlight).chain(surface).collect()
}

/// Every option of a render.
fn options() -> Vec<OptionOfRender> {
    let schema = SchemaGenerator::default().into_root_schema_for::<Options>().to_value();
    let option = |Loss { name, source, bound, measured }: &Loss| {
        let schema = schema["properties"][*name].clone();
        let at = |(value, errors): &(f64, [f64; 3])| {
            let [median, p95, max] = errors.map(percent);
            format!("at {value} median {median}, p95 {p95}, largest {max}")
        };
        let all: Vec<_> = measured.iter().map(at).collect();
        let measured = match all.as_slice() {
            [] => String::new(),
            all => format!("Of all light, over the presets: {}.", all.join("; ")),
        };
        OptionOfRender {
            name,
            source,
            summary: schema["description"].as_str().unwrap_or_default().to_owned(),
            measured_error: [*bound, &measured].join(" ").trim().to_owned(),
            schema,
        }
    };
    LOSSES.iter().map(option).collect()
}

/// The self-contained schemas of a union's variants.
fn variants<T: JsonSchema>() -> Vec<Value> {
    let settings =
        SchemaSettings::draft2020_12().with(|settings| settings.inline_subschemas = true);
    let mut schema = settings.into_generator().into_root_schema_for::<T>().to_value();
    let variants = schema.get_mut("oneOf").and_then(Value::as_array_mut);
    variants.map(std::mem::take).unwrap_or_default()
}

fn model(kind: Kind, schema: Value) -> Result<Model, String> {
    let name = match kind {
        Kind::Medium => schema.pointer("/properties/kind/const"),
        Kind::Airlight | Kind::SurfaceLighting => schema.get("const"),
    };
    let name = name.and_then(Value::as_str).unwrap_or_default().to_owned();
    let Some(origin) = Origin::of(kind, &name) else { return Err(name) };
    Ok(Model {
        kind,
        source: origin.source,
        summary: schema["description"].as_str().unwrap_or_default().to_owned(),
        supports: supports(kind, &name),
        measured_error: in_words(origin.error),
        schema,
        name,
    })
}

/// Asks the check of a scene which media and phase functions go with this model.
fn supports(kind: Kind, name: &str) -> Supports {
    let accepts = |medium: &str, phase: &str| {
        let mut fog = json!({ "terms": [term(medium)], "phase": { "kind": phase } });
        match kind {
            Kind::Medium => {}
            Kind::Airlight => fog["airlight"] = name.into(),
            Kind::SurfaceLighting => fog["surface_lighting"] = name.into(),
        }
        let scene = json!({ "fog": fog }).to_string();
        scene::read::<Scene>(scene.as_bytes()).is_ok_and(|scene| scene.check().is_ok())
    };
    let (media, phases) = (Term::KINDS.iter().copied(), Phase::KINDS.iter().copied());
    let media: Vec<_> = match kind {
        Kind::Medium => media.filter(|medium| *medium == name).collect(),
        _ => media.filter(|medium| phases.clone().any(|phase| accepts(medium, phase))).collect(),
    };
    let phase = phases.filter(|phase| media.iter().any(|medium| accepts(medium, phase))).collect();
    Supports { media, phase }
}

/// The plainest term of a kind that is there at all.
fn term(kind: &str) -> Value {
    let trial = KINDS.iter().find(|(name, ..)| *name == kind).map_or("[]", |(.., trial)| trial);
    let terms = serde_json::from_str::<Value>(trial).unwrap_or_default();
    terms.get(0).cloned().unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn find(kind: Kind, name: &str) -> Model {
        let mut all = all().into_iter().flatten();
        all.find(|model| model.kind == kind && model.name == name).unwrap()
    }

    #[test]
    fn every_model_of_a_scene_has_an_origin_and_every_origin_a_model() {
        let all: Vec<_> = all().into_iter().map(Result::unwrap).collect();
        let count = |kind| all.iter().filter(|model| model.kind == kind).count();
        assert_eq!(count(Kind::Medium), Term::KINDS.len());
        assert_eq!(count(Kind::Airlight), Airlight::ALL.len());
        assert_eq!(count(Kind::SurfaceLighting), SURFACE_LIGHTING.len());
        assert!(all.iter().all(|model| !model.summary.is_empty()));
    }

    #[test]
    fn what_a_model_supports_is_what_the_check_accepts() {
        assert_eq!(find(Kind::Airlight, "reference").supports.media, Term::KINDS);
        assert_eq!(find(Kind::Airlight, "reference").supports.phase, Phase::KINDS);
        assert_eq!(find(Kind::Airlight, "sun2005").supports.media, ["homogeneous"]);
        assert_eq!(find(Kind::Airlight, "sun2005").supports.phase, ["isotropic"]);
        assert_eq!(find(Kind::Medium, "gaussians").supports.phase, Phase::KINDS);
    }

    #[test]
    fn errors_are_said_in_percent() {
        let said = [0.0, 3.2e-7, 0.0016, 0.041, 1.56].map(percent);
        assert_eq!(said, ["0 %", "3.2e-5 %", "0.16 %", "4.1 %", "156 %"]);
        let auto = find(Kind::Airlight, "auto").measured_error;
        let all = ["median", "p95", "largest", " %"];
        assert!(all.iter().all(|word| auto.contains(word)), "{auto}");
    }

    #[test]
    fn every_option_of_a_render_is_stated() {
        let schema = SchemaGenerator::default().into_root_schema_for::<Options>().to_value();
        let stated: Vec<_> = options().into_iter().map(|option| option.name).collect();
        let properties = schema["properties"].as_object().unwrap();
        assert_eq!(stated.len(), properties.len());
        assert!(stated.iter().all(|name| properties.contains_key(*name)));
        for option in options() {
            assert!(
                !option.summary.is_empty() && !option.measured_error.is_empty(),
                "{}",
                option.name
            );
        }
    }

    #[test]
    fn a_schema_stands_for_itself() {
        for model in all().into_iter().flatten() {
            assert!(!model.schema.to_string().contains("$ref"), "{}", model.name);
        }
    }
}
