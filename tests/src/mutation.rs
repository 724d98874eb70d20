//! Requests with one thing wrong, made from the OpenAPI document: every field, every kind of wrong.

use serde_json::{Map, Value, json};

/// Stands in a value for JSON text that no [`Value`] can hold.
const RAW: &str = "@raw@";

/// A key that no object has; in a pointer it is escaped.
const UNKNOWN: (&str, &str) = ("sm/o~g", "sm~1o~0g");

/// A request, and the place in it that matters.
#[derive(Clone, Debug)]
pub struct Case {
    /// The body, `kind` first in every object.
    pub body: String,
    /// The same with `kind` last.
    pub kind_last: String,
    /// JSON pointer of the place.
    pub pointer: String,
    /// Whether it must be refused at this place; otherwise the place must be accepted.
    pub is_wrong: bool,
}

/// All cases of the request body of `POST path`.
pub fn cases(document: &Value, path: &str) -> Vec<Case> {
    let content = &document["paths"][path]["post"]["requestBody"]["content"];
    let mut walk = Walk { document, cases: Vec::new() };
    walk.visit(&content["application/json"]["schema"], None, "", &|value| value);
    walk.cases
}

/// Writes JSON with the member `kind` first or last.
fn text(value: &Value, kind_first: bool) -> String {
    let member = |(key, value): (&String, &Value)| {
        format!("{}:{}", Value::from(key.as_str()), text(value, kind_first))
    };
    match value {
        Value::Object(members) => {
            let (mut kind, mut rest): (Vec<_>, Vec<_>) =
                members.iter().partition(|(key, _)| key.as_str() == "kind");
            let (first, last) =
                if kind_first { (&mut kind, &mut rest) } else { (&mut rest, &mut kind) };
            first.append(last);
            let members: Vec<_> = first.iter().copied().map(member).collect();
            format!("{{{}}}", members.join(","))
        }
        Value::Array(items) => {
            let items: Vec<_> = items.iter().map(|item| text(item, kind_first)).collect();
            format!("[{}]", items.join(","))
        }
        leaf => leaf.to_string(),
    }
}

/// What asks for a map of a light in place of view rays.
const OF_A_LIGHT: [&str; 2] = ["light", "size"];

struct Walk<'a> {
    document: &'a Value,
    cases: Vec<Case>,
}

/// Puts a value of one field into a whole request.
type Frame<'f> = &'f dyn Fn(Value) -> Value;

impl<'a> Walk<'a> {
    fn case(&mut self, is_wrong: bool, pointer: &str, frame: Frame, raw: &str) {
        let body = frame(json!(RAW));
        let write = |kind_first| text(&body, kind_first).replace(&format!("\"{RAW}\""), raw);
        let (body, kind_last) = (write(true), write(false));
        self.cases.push(Case { body, kind_last, pointer: pointer.into(), is_wrong });
    }

    fn wrong(&mut self, pointer: &str, frame: Frame, raw: &str) {
        self.case(true, pointer, frame, raw);
    }

    fn resolve(&self, schema: &'a Value) -> &'a Value {
        let Some(reference) = schema["$ref"].as_str() else { return schema };
        let pointer = reference.strip_prefix('#').expect("a local reference");
        self.resolve(self.document.pointer(pointer).expect("a definition"))
    }

    /// Visits a field; `at_hand` is a good value of it, if one is known.
    fn visit(&mut self, schema: &'a Value, at_hand: Option<&Value>, pointer: &str, frame: Frame) {
        let (outer, schema) = (schema, self.resolve(schema));
        if let Some(variants) = schema["oneOf"].as_array() {
            self.types(&[type_of_union(variants)], pointer, frame);
            return self.union(variants, pointer, frame);
        }
        if let Some(variants) = schema["anyOf"].as_array() {
            return self.any_of(variants, pointer, frame);
        }
        let types: Vec<_> = match &schema["type"] {
            Value::String(one) => vec![one.as_str()],
            several => {
                several.as_array().expect("a type").iter().filter_map(Value::as_str).collect()
            }
        };
        let at_hand = at_hand.or(outer.get("default")).or(schema.get("default"));
        self.types(&types, pointer, frame);
        if let Some(excluded) = outer.pointer("/not/const") {
            self.wrong(pointer, frame, &excluded.to_string());
        }
        self.typed(types[0], schema, at_hand, pointer, frame);
    }

    /// A value of one of several types.
    fn any_of(&mut self, variants: &'a [Value], pointer: &str, frame: Frame) {
        let variants: Vec<_> = variants.iter().map(|variant| self.resolve(variant)).collect();
        let type_of = |schema: &&'a Value| match schema["oneOf"].as_array() {
            Some(variants) => type_of_union(variants),
            None => schema["type"].as_str().expect("a type"),
        };
        let types: Vec<_> = variants.iter().map(type_of).collect();
        self.types(&types, pointer, frame);
        for (schema, name) in variants.iter().zip(types) {
            match schema["oneOf"].as_array() {
                Some(variants) => self.union(variants, pointer, frame),
                None => self.typed(name, schema, schema.get("default"), pointer, frame),
            }
        }
    }

    /// What a value of a type may be.
    fn typed(
        &mut self,
        name: &str,
        schema: &'a Value,
        at_hand: Option<&Value>,
        pointer: &str,
        frame: Frame,
    ) {
        match name {
            "number" | "integer" => self.number(schema, name == "integer", pointer, frame),
            "string" => self.string(schema, pointer, frame),
            "array" => self.array(schema, at_hand, pointer, frame),
            "object" => self.object(schema, pointer, frame),
            _ => {}
        }
    }

    /// One value of each type of JSON: those that are not among `types` are refused.
    fn types(&mut self, types: &[&str], pointer: &str, frame: Frame) {
        let samples = [
            ("null", "null"),
            ("boolean", "true"),
            ("number", "0.5"),
            ("string", "\"fog\""),
            ("array", "[]"),
            ("object", "{}"),
        ];
        for (name, raw) in samples {
            if name == "null" && types.contains(&name) {
                self.case(false, pointer, frame, raw);
            } else if !types.contains(&name) {
                self.wrong(pointer, frame, raw);
            }
        }
    }

    fn number(&mut self, schema: &Value, is_integer: bool, pointer: &str, frame: Frame) {
        for raw in ["1e39", "-1e39", "1e400", "-1e400"] {
            self.wrong(pointer, frame, raw);
        }
        for (key, sign) in [("minimum", -1.0), ("maximum", 1.0)] {
            let bound = schema[key].as_f64().unwrap_or_else(|| panic!("{pointer} has no {key}"));
            self.case(false, pointer, frame, &bound.to_string());
            // A whole number is one however it is written.
            self.case(false, pointer, frame, &format!("{bound:e}"));
            let step = match bound {
                _ if is_integer => 1.0,
                0.0 => 1e-12,
                _ => 1e-12 * bound.abs(),
            };
            self.wrong(pointer, frame, &(bound + sign * step).to_string());
            self.case(false, pointer, frame, &(bound - sign * step).to_string());
        }
    }

    fn string(&mut self, schema: &Value, pointer: &str, frame: Frame) {
        let of_length = |length: usize| format!("\"{}\"", "雾".repeat(length));
        let Some(longest) = schema["maxLength"].as_u64() else {
            // Only a text that means nothing may have any length.
            assert!(pointer.ends_with("/$schema"), "{pointer} has no maxLength");
            return self.case(false, pointer, frame, &of_length(1000));
        };
        let longest = longest as usize;
        if pointer.ends_with("/radiance/file") {
            // Only the command line reads files.
            return self.wrong(pointer, frame, &of_length(longest));
        }
        self.wrong(pointer, frame, &of_length(longest + 1));
        self.case(false, pointer, frame, &of_length(longest));
        assert_eq!(schema["minLength"], 1, "{pointer}");
        self.wrong(pointer, frame, "\"\"");
    }

    fn array(&mut self, schema: &'a Value, at_hand: Option<&Value>, pointer: &str, frame: Frame) {
        let exact =
            schema["minItems"].as_u64().filter(|_| schema["minItems"] == schema["maxItems"]);
        let item = &schema["items"];
        let mut items = at_hand.and_then(Value::as_array).cloned().unwrap_or_default();
        if let Some(length) = exact {
            let length = length as usize;
            if items.len() != length {
                // The last one is 1: a direction must have a length.
                items = (0..length).map(|k| json!(u8::from(k + 1 == length))).collect();
            }
            for length in [0, length - 1, length + 1] {
                self.wrong(pointer, frame, &json!(vec![1; length]).to_string());
            }
        } else {
            self.lengths(schema, &items, pointer, frame);
            if items.is_empty() {
                items.push(self.sample(item));
            }
        }
        for k in 0..if exact.is_some() { items.len() } else { 1 } {
            let inner = |value: Value| {
                let mut items = items.clone();
                items[k] = value;
                frame(items.into())
            };
            self.visit(item, Some(&items[k]), &format!("{pointer}/{k}"), &inner);
        }
    }

    /// One item too few, and one too many where that is not megabytes of text.
    fn lengths(&mut self, schema: &'a Value, items: &[Value], pointer: &str, frame: Frame) {
        let longest = schema["maxItems"].as_u64();
        let longest = longest.unwrap_or_else(|| panic!("{pointer} has no maxItems")) as usize;
        let item = items.first().cloned().unwrap_or_else(|| self.sample(&schema["items"]));
        let mut of_length = |length: usize| {
            self.wrong(pointer, frame, &json!(vec![&item; length]).to_string());
        };
        if let Some(shorter) = schema["minItems"].as_u64().and_then(|least| least.checked_sub(1)) {
            of_length(shorter as usize);
        }
        if longest <= 1000 {
            of_length(longest + 1);
        }
    }

    fn object(&mut self, schema: &'a Value, pointer: &str, frame: Frame) {
        let sample = self.sample(schema);
        let mut members = sample.as_object().expect("an object").clone();
        let properties = schema["properties"].as_object();
        // A map of optical depths is of view rays or of a light; that of a light has tests of its own.
        let is_map =
            properties.is_some_and(|all| OF_A_LIGHT.iter().all(|key| all.contains_key(*key)));
        if is_map {
            members.extend(["width", "height"].map(|key| (key.to_owned(), json!(8))));
        }
        let with = |key: &str, value: Value| {
            let mut members = members.clone();
            members.insert(key.into(), value);
            frame(members.into())
        };
        self.wrong(&format!("{pointer}/{}", UNKNOWN.1), &|value| with(UNKNOWN.0, value), "1");
        for key in schema["required"].as_array().into_iter().flatten().filter_map(Value::as_str) {
            let mut members = members.clone();
            members.remove(key);
            self.wrong(pointer, &|_| frame(members.clone().into()), "");
        }
        for (key, property) in properties.into_iter().flatten() {
            if key != "kind" && !(is_map && OF_A_LIGHT.contains(&key.as_str())) {
                let at_hand = known(key);
                let pointer = format!("{pointer}/{key}");
                self.visit(property, at_hand.as_ref(), &pointer, &|value| with(key, value));
            }
        }
    }

    fn union(&mut self, variants: &'a [Value], pointer: &str, frame: Frame) {
        if type_of_union(variants) == "string" {
            self.wrong(pointer, frame, "\"fog\"");
            for variant in variants {
                self.case(false, pointer, frame, &variant["const"].to_string());
            }
            return;
        }
        self.wrong(pointer, frame, "{}");
        let kind = |value| frame(json!({ "kind": value }));
        self.types(&["string"], &format!("{pointer}/kind"), &kind);
        self.wrong(&format!("{pointer}/kind"), &kind, "\"fog\"");
        for variant in variants {
            self.object(self.resolve(variant), pointer, frame);
        }
    }

    /// A good value that is as small as it can be.
    fn sample(&self, schema: &'a Value) -> Value {
        let (outer, schema) = (schema, self.resolve(schema));
        let default = outer.get("default").or(schema.get("default")).or(schema.get("const"));
        if let Some(default) = default {
            return default.clone();
        }
        if let Some(variants) = schema["oneOf"].as_array().or(schema["anyOf"].as_array()) {
            return self.sample(&variants[0]);
        }
        match schema["type"].as_str() {
            Some("array") => {
                let length = schema["minItems"].as_u64().unwrap_or(0);
                (0..length).map(|k| json!(u8::from(k + 1 == length))).collect()
            }
            Some("object") => {
                let required = schema["required"].as_array().into_iter().flatten();
                let member = |key: &str| (key.to_owned(), self.sample(&schema["properties"][key]));
                let mut members: Map<_, _> =
                    required.filter_map(Value::as_str).map(member).collect();
                if members.get("kind") == Some(&json!("mesh")) {
                    members.insert("positions".into(), known("positions").expect("known"));
                }
                members.into()
            }
            Some("number" | "integer") => json!(schema["minimum"].as_u64().unwrap_or(0)),
            _ => panic!("no sample of {schema}"),
        }
    }
}

/// What its variants are.
fn type_of_union(variants: &[Value]) -> &'static str {
    if variants.iter().all(|variant| variant["const"].is_string()) { "string" } else { "object" }
}

/// Lists that must fit together.
fn known(key: &str) -> Option<Value> {
    match key {
        "positions" => Some(json!([[0, 0, 0], [1, 0, 0], [0, 1, 0]])),
        "indices" => Some(json!([[0, 1, 2]])),
        "normals" => Some(json!([[0, 0, 1], [0, 0, 1], [0, 0, 1]])),
        _ => None,
    }
}
