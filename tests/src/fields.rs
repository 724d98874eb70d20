//! The fields of a scene, taken from its JSON schema, and where a scene holds them.

#![allow(clippy::expect_used, clippy::panic, reason = "a schema of an unknown form must not pass")]

use fogbank_core::scene::Scene;
use schemars::schema_for;
use serde_json::{Value, json};
use std::sync::LazyLock;

static SCHEMA: LazyLock<Value> = LazyLock::new(|| schema_for!(Scene).to_value());

/// Something in a scene that may differ.
#[derive(Clone, Debug, PartialEq)]
pub struct Field {
    /// A JSON pointer with `*` for any item of a list, and the kind of an object in brackets behind
    /// its token: `/surfaces/*/shape(sphere)/radius`.
    pub path: String,
    /// How its value may differ.
    pub change: Change,
}

/// What a field may hold.
#[derive(Clone, Debug, PartialEq)]
pub enum Change {
    /// Any number.
    Number,
    /// True or false.
    Flag,
    /// Any text.
    Text,
    /// This one of several words.
    Word(String),
    /// An object of this one of several kinds.
    Kind(String),
}

impl Field {
    /// The path, and the word or kind behind `=`.
    pub fn name(&self) -> String {
        match &self.change {
            Change::Word(word) | Change::Kind(word) => format!("{}={word}", self.path),
            _ => self.path.clone(),
        }
    }

    /// JSON pointers of all places of a scene that hold this field.
    pub fn places(&self, scene: &Value) -> Vec<String> {
        let mut places = vec![(String::new(), scene)];
        for token in self.path.split('/').skip(1) {
            let (member, kind) = match token.strip_suffix(')').and_then(|t| t.split_once('(')) {
                Some((member, kind)) => (member, Some(kind)),
                None => (token, None),
            };
            let below = |(pointer, value)| {
                let named = move |(key, value)| (format!("{pointer}/{key}"), value);
                members(value, member).into_iter().map(named)
            };
            places = places.into_iter().flat_map(below).collect();
            places.retain(|(_, value)| kind.is_none_or(|kind| value["kind"] == kind));
        }
        places.into_iter().map(|(pointer, _)| pointer).collect()
    }

    /// Values that differ from the one at hand; not each of them need be valid.
    pub fn others(&self, value: &Value) -> Vec<Value> {
        match &self.change {
            // The same quantity may also be a row of numbers.
            Change::Number if !value.is_number() => vec![],
            Change::Number if value.is_u64() => {
                let whole = value.as_u64().expect("a whole number");
                vec![json!(whole + 1), json!(whole.wrapping_sub(1))]
            }
            Change::Number => {
                let number = value.as_f64().expect("a number");
                vec![json!(1.3 * number + 0.1), json!(0.7 * number - 0.1), json!(0.7 * number)]
            }
            Change::Flag => vec![json!(!value.as_bool().expect("true or false"))],
            Change::Text => vec![json!("another")],
            Change::Word(word) if value == word => vec![],
            Change::Word(word) => vec![json!(word)],
            Change::Kind(kind) if value["kind"] == *kind => vec![],
            Change::Kind(kind) => vec![json!({ "kind": kind })],
        }
    }
}

fn members<'v>(value: &'v Value, member: &str) -> Vec<(String, &'v Value)> {
    match value {
        Value::Array(items) if member == "*" => {
            items.iter().enumerate().map(|(i, item)| (i.to_string(), item)).collect()
        }
        Value::Array(items) => {
            let place = member.parse::<usize>().expect("a place");
            items.get(place).map(|item| (member.to_owned(), item)).into_iter().collect()
        }
        _ => value.get(member).map(|value| (member.to_owned(), value)).into_iter().collect(),
    }
}

/// All fields of a scene.
pub fn all() -> Vec<Field> {
    let mut fields = Vec::new();
    visit(&SCHEMA, "", &mut fields);
    fields
}

/// The kinds or words of a union, by its name in the schema; none if there is no such union.
pub fn variants(union: &str) -> Vec<String> {
    let variants = SCHEMA["$defs"][union]["oneOf"].as_array().into_iter().flatten();
    variants.map(variant).collect()
}

/// The word or kind of a union's variant.
fn variant(schema: &Value) -> String {
    let name = schema["const"].as_str().or(schema["properties"]["kind"]["const"].as_str());
    name.unwrap_or_else(|| panic!("{schema} has no name")).to_owned()
}

fn visit(schema: &Value, path: &str, fields: &mut Vec<Field>) {
    if let Some(reference) = schema["$ref"].as_str() {
        let pointer = reference.strip_prefix('#').expect("a local reference");
        return visit(SCHEMA.pointer(pointer).expect("a definition"), path, fields);
    }
    if let Some(variants) = schema["oneOf"].as_array() {
        return visit_union(variants, path, fields);
    }
    if let Some(variants) = schema["anyOf"].as_array() {
        let named = variants.iter().filter(|variant| variant["type"] != "null");
        return named.for_each(|variant| visit(variant, path, fields));
    }
    let mut leaf = |change| fields.push(Field { path: path.to_owned(), change });
    match type_of(schema) {
        "number" | "integer" => leaf(Change::Number),
        "boolean" => leaf(Change::Flag),
        "string" => leaf(Change::Text),
        "array" => visit_array(schema, path, fields),
        "object" => visit_object(schema, path, fields),
        other => panic!("{path}: {other}"),
    }
}

/// The type, or the one beside null.
fn type_of(schema: &Value) -> &str {
    let types = &schema["type"];
    let several = types.as_array().into_iter().flatten().filter_map(Value::as_str);
    let mut types = types.as_str().into_iter().chain(several).filter(|name| *name != "null");
    types.next().unwrap_or_else(|| panic!("{schema} has no type"))
}

/// One variant alone is no choice.
fn visit_union(variants: &[Value], path: &str, fields: &mut Vec<Field>) {
    for schema in variants {
        let name = variant(schema);
        let is_word = schema["const"].is_string();
        if variants.len() > 1 {
            let name = name.clone();
            let change = if is_word { Change::Word(name) } else { Change::Kind(name) };
            fields.push(Field { path: path.to_owned(), change });
        }
        if !is_word {
            visit_object(schema, &format!("{path}({name})"), fields);
        }
    }
}

fn visit_array(schema: &Value, path: &str, fields: &mut Vec<Field>) {
    let items = &schema["items"];
    match (schema["minItems"].as_u64(), schema["maxItems"].as_u64()) {
        (Some(least), Some(most)) if least == most => {
            (0..least).for_each(|place| visit(items, &format!("{path}/{place}"), fields));
        }
        _ => visit(items, &format!("{path}/*"), fields),
    }
}

fn visit_object(schema: &Value, path: &str, fields: &mut Vec<Field>) {
    assert_eq!(schema["additionalProperties"], false, "{path} holds members without a name");
    for (key, property) in schema["properties"].as_object().into_iter().flatten() {
        // Of a union: what tells its variants apart.
        if key != "kind" {
            visit(property, &format!("{path}/{key}"), fields);
        }
    }
}
