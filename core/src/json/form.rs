//! What a JSON schema asks of a value, in the few words that the schemas of this program use.

use super::limits::Range;
use serde_json::Value;
use std::cell::Cell;

/// How many items all lists of one kind in a document may have together (this program's own word).
const IN_ALL: &str = "x-items-in-all";

/// Members that tell the variants of a union apart.
pub const TAGS: [&str; 3] = ["kind", "op", "type"];

/// References and lists deeper than this are taken as they are; the scene has a dozen levels.
const DEEPEST: usize = 64;

/// The form that a value must have.
#[derive(Debug)]
pub enum Form {
    /// Whatever the schema says, no word of it is known here.
    Any,
    /// The form, or null.
    Nullable(Box<Self>),
    /// `true` or `false`.
    Boolean,
    /// A number, perhaps without a fraction.
    Number { range: Range, is_whole: bool },
    /// A string of so many characters.
    Text { least: usize, most: usize },
    /// One of these strings.
    Words(Vec<String>),
    /// A list.
    List(List),
    /// An object.
    Object(Vec<Member>),
    /// An object of which one member says which of these it is.
    Union(Union),
    /// One of these, told apart by the type of JSON.
    Choice(Vec<Self>),
}

/// The form of an object that is one of several.
#[derive(Debug)]
pub struct Union {
    /// The member that tells.
    pub tag: &'static str,
    /// What it says, and the members then.
    pub kinds: Vec<(String, Vec<Member>)>,
}

/// The form of a list.
#[derive(Debug)]
pub struct List {
    /// That of every item.
    pub item: Box<Form>,
    /// How many there may be.
    pub least: usize,
    /// See `least`.
    pub most: usize,
    /// How many there may be in all lists of this form.
    pub most_in_all: usize,
    /// How many were seen in all of them.
    pub seen_in_all: Cell<usize>,
}

/// A member of an object.
#[derive(Debug)]
pub struct Member {
    /// Its key.
    pub key: String,
    /// What its value must be.
    pub form: Form,
    /// Whether it must be there.
    pub is_required: bool,
}

impl Form {
    /// Reads a schema whose references are local.
    pub fn of(schema: &Value) -> Self {
        Reader { root: schema }.form(schema, 0)
    }
}

struct Reader<'a> {
    root: &'a Value,
}

impl<'a> Reader<'a> {
    fn form(&self, schema: &'a Value, depth: usize) -> Form {
        if depth == DEEPEST {
            return Form::Any;
        }
        if let Some(reference) = schema["$ref"].as_str() {
            let target = self.root.pointer(reference.trim_start_matches('#'));
            return target.map_or(Form::Any, |target| self.form(target, depth + 1));
        }
        for word in ["oneOf", "anyOf"] {
            if let Some(variants) = schema[word].as_array() {
                return self.one_of(variants, depth + 1);
            }
        }
        match &schema["type"] {
            Value::String(name) => self.typed(name, schema, depth + 1),
            // The only lists of types are those of a type and null.
            Value::Array(names) => {
                let name = names.iter().filter_map(Value::as_str).find(|name| *name != "null");
                nullable(self.typed(name.unwrap_or_default(), schema, depth + 1))
            }
            _ => Form::Any,
        }
    }

    fn typed(&self, name: &str, schema: &'a Value, depth: usize) -> Form {
        match name {
            "boolean" => Form::Boolean,
            "integer" => Form::Number { range: range(schema), is_whole: true },
            "number" => Form::Number { range: range(schema), is_whole: false },
            "string" => self.string(schema),
            "array" => Form::List(List {
                item: Box::new(self.form(&schema["items"], depth)),
                least: size(schema, "minItems", 0),
                most: size(schema, "maxItems", usize::MAX),
                most_in_all: size(schema, IN_ALL, usize::MAX),
                seen_in_all: Cell::new(0),
            }),
            "object" => Form::Object(self.members(schema, depth)),
            _ => Form::Any,
        }
    }

    fn string(&self, schema: &Value) -> Form {
        if let Some(words) = schema["enum"].as_array() {
            return Form::Words(words.iter().filter_map(word).collect());
        }
        match word(&schema["const"]) {
            Some(word) => Form::Words(vec![word]),
            None => Form::Text {
                least: size(schema, "minLength", 0),
                most: size(schema, "maxLength", usize::MAX),
            },
        }
    }

    fn members(&self, schema: &'a Value, depth: usize) -> Vec<Member> {
        let required = schema["required"].as_array().map(Vec::as_slice).unwrap_or_default();
        let properties = schema["properties"].as_object().into_iter().flatten();
        let member = |(key, property): (&String, &'a Value)| Member {
            key: key.clone(),
            form: self.form(property, depth),
            is_required: required.iter().any(|name| name == key),
        };
        properties.map(member).collect()
    }

    /// A list of words, a union told apart by a member, or something and null.
    fn one_of(&self, variants: &'a [Value], depth: usize) -> Form {
        let is_null = |variant: &&Value| variant["type"] == "null";
        let rest: Vec<_> = variants.iter().filter(|variant| !is_null(variant)).collect();
        let form = self.choice(&rest, depth);
        if rest.len() < variants.len() { nullable(form) } else { form }
    }

    fn choice(&self, variants: &[&'a Value], depth: usize) -> Form {
        for tag in TAGS {
            let kind = |variant: &&'a Value| {
                let kind = word(&variant["properties"][tag]["const"])?;
                Some((kind, self.members(variant, depth)))
            };
            if let Some(kinds) = variants.iter().map(kind).collect() {
                return Form::Union(Union { tag, kinds });
            }
        }
        let words = |variant: &&'a Value| match self.string(variant) {
            Form::Words(words) => Some(words),
            _ => None,
        };
        if let Some(words) = variants.iter().map(words).collect::<Option<Vec<_>>>() {
            return Form::Words(words.concat());
        }
        match variants {
            [one] => self.form(one, depth),
            several => {
                Form::Choice(several.iter().map(|variant| self.form(variant, depth)).collect())
            }
        }
    }
}

fn nullable(form: Form) -> Form {
    Form::Nullable(Box::new(form))
}

fn word(value: &Value) -> Option<String> {
    value.as_str().map(str::to_owned)
}

fn size(schema: &Value, key: &str, otherwise: usize) -> usize {
    let size = schema[key].as_u64().and_then(|size| usize::try_from(size).ok());
    size.unwrap_or(otherwise)
}

/// What the schema says; without a word, the numbers that there are.
fn range(schema: &Value) -> Range {
    let most = if schema["format"] == "uint32" { f64::from(u32::MAX) } else { f64::MAX };
    let bound = |key: &str, otherwise: f64| schema[key].as_f64().unwrap_or(otherwise);
    Range { min: bound("minimum", f64::MIN), max: bound("maximum", most) }
}
