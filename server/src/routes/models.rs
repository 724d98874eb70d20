//! `GET /v1/models`: every medium, airlight and surface-lighting model.
//!
//! The names, summaries and schemas come from the scene's own types, and what a model supports is
//! found by asking the check of a scene. Only what no type can know stands in the table here.

use crate::answer::{Fixed, JSON};
use crate::openapi::Operation;
use axum::http::HeaderMap;
use axum::response::Response;
use fogbank_core::airlight::errors;
use fogbank_core::media::KINDS;
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
    kind: Kind,
    name: &'static str,
    source: &'static str,
    measured_error: Measured,
}

/// How far a model is from the truth.
#[derive(Clone, Copy)]
enum Measured {
    /// In words.
    Words(&'static str),
    /// As [`errors::MEASURED`] says of this estimator.
    Table(Airlight),
}

impl Measured {
    fn text(self) -> String {
        let airlight = match self {
            Self::Words(words) => return words.to_owned(),
            Self::Table(airlight) => airlight,
        };
        let error = errors::measured(airlight).copied().unwrap_or_default();
        let [median, p95, max] = [error.median, error.p95, error.max].map(percent);
        format!("Relative to {}: median {median}, p95 {p95}, largest {max}.", error.against)
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

const ORIGINS: &[Origin] = &[
    Origin {
        kind: Kind::Airlight,
        name: "auto",
        source: "Sun 2005 in isotropic homogeneous fog; else one Gauss rule per ray in a variable that \
            is smooth near lights and where fog lies, with exact β and T.",
        measured_error: Measured::Table(Airlight::Auto),
    },
    Origin {
        kind: Kind::Airlight,
        name: "none",
        source: "Only the veil: ambient · (1 − transmittance) (Biri 2002).",
        measured_error: Measured::Words(
            "Leaves out all light of the lamps that the fog scatters to the eye.",
        ),
    },
    Origin {
        kind: Kind::Airlight,
        name: "sun2005",
        source: "Sun, Ramamoorthi, Narasimhan, Nayar: A Practical Analytic Single Scattering Model \
            for Real Time Rendering (SIGGRAPH 2005): airlight of a point light by the function F.",
        measured_error: Measured::Table(Airlight::Sun2005),
    },
    Origin {
        kind: Kind::Airlight,
        name: "fogshop2007",
        source: "Zhou, Hou, Gong, Snyder, Guo, Shum: Fogshop (Pacific Graphics 2007): analytic \
            approximation of single scattering in a sum of Gaussians.",
        measured_error: Measured::Table(Airlight::Fogshop2007),
    },
    Origin {
        kind: Kind::Airlight,
        name: "reference",
        source: "The single-scattering integral itself, by adaptive quadrature in f64.",
        measured_error: Measured::Table(Airlight::Reference),
    },
    Origin {
        kind: Kind::SurfaceLighting,
        name: "auto",
        source: "Chooses for the scene.",
        measured_error: Measured::Words("That of the model it chooses."),
    },
    Origin {
        kind: Kind::SurfaceLighting,
        name: "attenuated",
        source: "Beer–Lambert law between lamp and surface.",
        measured_error: Measured::Words(
            "Leaves out the light that the fog scatters onto surfaces.",
        ),
    },
];

static MODELS: LazyLock<Fixed> = LazyLock::new(|| {
    let models = Models { models: all().into_iter().flatten().collect() };
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
    let mut origins = origins();
    let origin = origins.find(|origin| origin.kind == kind && origin.name == name);
    let Some(origin) = origin else { return Err(name) };
    Ok(Model {
        kind,
        source: origin.source,
        summary: schema["description"].as_str().unwrap_or_default().to_owned(),
        supports: supports(kind, &name),
        measured_error: origin.measured_error.text(),
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

/// Where every model comes from: the media as their list says, then the others.
fn origins() -> impl Iterator<Item = Origin> {
    let medium = |(name, source, _): &(&'static str, &'static str, &str)| Origin {
        kind: Kind::Medium,
        name,
        source,
        measured_error: Measured::Words("A closed form: rounding is its only error."),
    };
    KINDS.iter().map(medium).chain(ORIGINS.iter().copied())
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
        assert_eq!(all.len(), origins().count());
        let media: Vec<_> = all.iter().filter(|model| model.kind == Kind::Medium).collect();
        assert_eq!(media.len(), Term::KINDS.len());
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
    fn a_schema_stands_for_itself() {
        for model in all().into_iter().flatten() {
            assert!(!model.schema.to_string().contains("$ref"), "{}", model.name);
        }
    }
}
