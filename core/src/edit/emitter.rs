//! Emitters that come, change and go.

use super::term::{Name, emitter};
use super::{Desk, Refused, Tool};
use crate::json::document::{Node, closed};
use crate::json::{Checker, Problem};
use crate::media::Term;
use crate::media::emitter::Emitter;
use crate::scene::{CheckedScene, Scene};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

/// Adds an emitter behind all other terms.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EmitterAdd {
    /// The emitter: a term of the fog, whose `kind` may be left out.
    #[serde(deserialize_with = "with_or_without_kind")]
    pub emitter: Emitter,
}

/// Changes an emitter.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EmitterUpdate {
    /// Its id, or its place among the terms.
    pub term: Name,
    /// The members that change (a merge patch, RFC 7396).
    pub changes: Map<String, Value>,
}

/// Takes an emitter away.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EmitterRemove {
    /// Its id, or its place among the terms.
    pub term: Name,
}

/// Reads an emitter as it stands among the terms, or as what it is.
fn with_or_without_kind<'de, D: serde::Deserializer<'de>>(input: D) -> Result<Emitter, D::Error> {
    let mut members = Map::<String, Value>::deserialize(input)?;
    if members.get("kind").and_then(Value::as_str) == Some("emitter") {
        members.remove("kind");
    }
    Emitter::deserialize(Value::Object(members)).map_err(serde::de::Error::custom)
}

impl Tool for EmitterAdd {
    fn check(&self, _check: &mut Checker, _at: &dyn Fn(&str) -> String) {}

    fn apply(&self, scene: &CheckedScene, _desk: &mut Desk) -> Result<Scene, Refused> {
        let mut after = (**scene).clone();
        after.fog.terms.push(Term::Emitter(self.emitter.clone()));
        Ok(after)
    }
}

impl Tool for EmitterUpdate {
    fn check(&self, _check: &mut Checker, _at: &dyn Fn(&str) -> String) {}

    fn apply(&self, scene: &CheckedScene, _desk: &mut Desk) -> Result<Scene, Refused> {
        let mut after = (**scene).clone();
        let (_, emitter) = emitter(&mut after, &self.term)?;
        let mut node = Node::kept(emitter);
        node.merge(Value::Object(self.changes.clone()));
        *emitter = closed(node).map_err(|mut problems: Vec<Problem>| {
            let Problem { pointer, code, detail } = problems.swap_remove(0);
            Refused::Member { member: format!("changes{pointer}"), code, detail }
        })?;
        Ok(after)
    }
}

impl Tool for EmitterRemove {
    fn check(&self, _check: &mut Checker, _at: &dyn Fn(&str) -> String) {}

    fn apply(&self, scene: &CheckedScene, _desk: &mut Desk) -> Result<Scene, Refused> {
        let mut after = (**scene).clone();
        let (place, _) = emitter(&mut after, &self.term)?;
        after.fog.terms.remove(place);
        Ok(after)
    }
}
