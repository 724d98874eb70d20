//! Everything that is wrong with a text that could not be read.
//!
//! The text is walked beside the schema of the type that was asked for. Values are slices of the text:
//! nothing is built, whatever is in it.

use super::form::{Form, List, Member, Union};
use super::problem::{Checker, Code, outside, shown, token};
use super::{Problem, ReadError};
use schemars::{JsonSchema, schema_for};
use serde::de::{Deserializer, MapAccess, SeqAccess, Visitor};
use serde_json::value::RawValue;
use std::borrow::Cow;
use std::fmt;

/// Why `text` is no `T`; `first` is what stopped its reading.
pub fn errors<T: JsonSchema>(text: &str, first: &serde_json::Error) -> ReadError {
    let raw: &RawValue = match serde_json::from_str(text) {
        Ok(raw) => raw,
        Err(error) => return ReadError::NotJson(error.to_string()),
    };
    let mut walk = Walk::default();
    walk.value(&Form::of(schema_for!(T).as_value()), raw.get(), &Place::Root);
    let otherwise = || {
        let detail = shown(&first.to_string());
        vec![Problem { pointer: String::new(), code: Code::Invalid, detail }]
    };
    ReadError::Invalid(walk.check.finish(()).err().unwrap_or_else(otherwise))
}

/// Where a value stands; written out only when something is wrong with it.
enum Place<'a> {
    Root,
    Key(&'a Self, &'a str),
    Index(&'a Self, usize),
}

impl Place<'_> {
    fn pointer(&self) -> String {
        match self {
            Self::Root => String::new(),
            Self::Key(above, key) => format!("{}/{}", above.pointer(), token(key)),
            Self::Index(above, index) => format!("{}/{index}", above.pointer()),
        }
    }
}

#[derive(Default)]
struct Walk {
    check: Checker,
}

impl Walk {
    /// Words are only found for what is listed: a text may be wrong in millions of places.
    fn refuse(&mut self, code: Code, at: &Place, detail: impl FnOnce() -> String) {
        let is_listed = self.check.found() < Checker::MOST;
        let detail = if is_listed { detail() } else { String::new() };
        self.check.refuse(code, || at.pointer(), detail);
    }

    fn value(&mut self, form: &Form, raw: &str, at: &Place) {
        match (form, raw.as_bytes()[0]) {
            (Form::Any, _) | (Form::Nullable(_), b'n') | (Form::Boolean, b't' | b'f') => {}
            (Form::Nullable(form), _) => self.value(form, raw, at),
            (Form::Number { range, is_whole }, b'-' | b'0'..=b'9') => {
                let value: f64 = raw.parse().unwrap_or(f64::NAN);
                if *is_whole && value.is_finite() && value.fract() != 0.0 {
                    let detail = || format!("expected an integer, found {}", shown(raw));
                    self.refuse(Code::WrongType, at, detail);
                } else if !range.contains(value) {
                    self.refuse(Code::OutOfRange, at, || outside(&shown(raw), *range));
                }
            }
            (Form::Text { least, most }, b'"') => self.text(*least, *most, raw, at),
            (Form::Words(words), b'"') => self.word(words, raw, at),
            (Form::List(list), b'[') => self.list(list, raw, at),
            (Form::Object(known), b'{') => self.members(known, raw, at),
            (Form::Union(union), b'{') => self.union(union, raw, at),
            (Form::Choice(forms), first) if forms.iter().any(|form| name(form) == found(first)) => {
                forms.iter().filter(|form| name(form) == found(first)).for_each(|form| {
                    self.value(form, raw, at);
                });
            }
            (_, first) => {
                let detail = || format!("expected {}, found {}", names(form), found(first));
                self.refuse(Code::WrongType, at, detail);
            }
        }
    }

    fn text(&mut self, least: usize, most: usize, raw: &str, at: &Place) {
        let Some(text) = unescaped(raw) else {
            return self.refuse(Code::WrongType, at, || "its escapes are no Unicode text".into());
        };
        let length = text.chars().count();
        if length < least || length > most {
            let detail = || format!("{length} characters are not between {least} and {most}");
            self.refuse(Code::WrongLength, at, detail);
        }
    }

    fn word(&mut self, words: &[String], raw: &str, at: &Place) {
        let text = unescaped(raw);
        if !words.iter().any(|word| Some(word.as_str()) == text.as_deref()) {
            self.unknown_word(words, raw, at);
        }
    }

    fn unknown_word(&mut self, words: &[String], raw: &str, at: &Place) {
        let detail = || format!("unknown {}, expected one of {}", shown(raw), words.join(", "));
        self.refuse(Code::UnknownWord, at, detail);
    }

    fn list(&mut self, list: &List, raw: &str, at: &Place) {
        let mut count = 0;
        each_item(raw, |item| {
            if count < list.most {
                self.value(&list.item, item, &Place::Index(at, count));
            }
            count += 1;
        });
        let in_all = list.seen_in_all.get().saturating_add(count);
        list.seen_in_all.set(in_all);
        let is_fixed = list.least == list.most;
        if count < list.least || (count > list.most && is_fixed) {
            let least = if is_fixed { "" } else { "at least " };
            let detail = || format!("expected {least}{} items, found {count}", list.least);
            self.refuse(Code::WrongLength, at, detail);
        } else if count > list.most {
            self.check.count(count, list.most, "items", || at.pointer());
        } else {
            self.check.count(in_all, list.most_in_all, "items in all", || at.pointer());
        }
    }

    fn members(&mut self, known: &[Member], raw: &str, at: &Place) {
        let mut seen = vec![false; known.len()];
        each_member(raw, |key, value| {
            let at = Place::Key(at, key);
            let Some(i) = known.iter().position(|member| member.key == key) else {
                return self.refuse(Code::UnknownKey, &at, || {
                    let keys: Vec<_> = known.iter().map(|member| member.key.as_str()).collect();
                    format!("unknown key, expected one of {}", keys.join(", "))
                });
            };
            if std::mem::replace(&mut seen[i], true) {
                let detail = || "this key stands here twice".into();
                return self.refuse(Code::DuplicateKey, &at, detail);
            }
            self.value(&known[i].form, value, &at);
        });
        for (member, seen) in known.iter().zip(seen) {
            if member.is_required && !seen {
                self.refuse(Code::Missing, at, || format!("`{}` is missing", member.key));
            }
        }
    }

    fn union(&mut self, Union { tag, kinds }: &Union, raw: &str, at: &Place) {
        let mut kind = None;
        each_member(raw, |key, value| {
            if key == *tag {
                kind.get_or_insert(value);
            }
        });
        let words = || -> Vec<_> { kinds.iter().map(|(name, _)| name.clone()).collect() };
        let Some(kind) = kind else {
            return self.refuse(Code::Missing, at, || {
                format!("`{tag}` is missing, expected one of {}", words().join(", "))
            });
        };
        let at_kind = Place::Key(at, tag);
        if !kind.starts_with('"') {
            let detail = || format!("expected a string, found {}", found(kind.as_bytes()[0]));
            return self.refuse(Code::WrongType, &at_kind, detail);
        }
        let word = unescaped(kind);
        match kinds.iter().find(|(name, _)| Some(name.as_str()) == word.as_deref()) {
            Some((_, members)) => self.members(members, raw, at),
            None => self.unknown_word(&words(), kind, &at_kind),
        }
    }
}

/// What a form asks for.
fn names(form: &Form) -> String {
    match form {
        Form::Nullable(form) => names(form),
        Form::Choice(forms) => forms.iter().map(names).collect::<Vec<_>>().join(" or "),
        _ => name(form).to_owned(),
    }
}

/// The same of a form that is no choice.
fn name(form: &Form) -> &'static str {
    match form {
        Form::Any | Form::Choice(_) => "a value",
        Form::Nullable(form) => name(form),
        Form::Boolean => "a boolean",
        Form::Number { is_whole: true, .. } => "an integer",
        Form::Number { .. } => "a number",
        Form::Text { .. } | Form::Words(_) => "a string",
        Form::List(_) => "a list",
        Form::Object(_) | Form::Union(_) => "an object",
    }
}

/// What a value is, by its first character.
fn found(first: u8) -> &'static str {
    match first {
        b'n' => "null",
        b't' | b'f' => "a boolean",
        b'"' => "a string",
        b'[' => "a list",
        b'{' => "an object",
        _ => "a number",
    }
}

/// The text of a string with its quotes; none where its escapes are no characters.
fn unescaped(raw: &str) -> Option<Cow<'_, str>> {
    if raw.contains('\\') {
        return serde_json::from_str(raw).ok().map(Cow::Owned);
    }
    raw.get(1..raw.len() - 1).map(Cow::Borrowed)
}

/// Visits the items of a list. Its text was found to be JSON: nothing in it can fail.
fn each_item<'t>(raw: &'t str, visit: impl FnMut(&'t str)) {
    let _ = serde_json::Deserializer::from_str(raw).deserialize_seq(Items(visit));
}

/// Visits the members of an object, as [`each_item`].
fn each_member<'t>(raw: &'t str, visit: impl FnMut(&str, &'t str)) {
    let _ = serde_json::Deserializer::from_str(raw).deserialize_map(Members(visit));
}

struct Items<F>(F);

impl<'t, F: FnMut(&'t str)> Visitor<'t> for Items<F> {
    type Value = ();

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a list")
    }

    fn visit_seq<A: SeqAccess<'t>>(mut self, mut items: A) -> Result<(), A::Error> {
        while let Some(item) = items.next_element::<&RawValue>()? {
            (self.0)(item.get());
        }
        Ok(())
    }
}

struct Members<F>(F);

impl<'t, F: FnMut(&str, &'t str)> Visitor<'t> for Members<F> {
    type Value = ();

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("an object")
    }

    fn visit_map<A: MapAccess<'t>>(mut self, mut members: A) -> Result<(), A::Error> {
        while let Some((key, value)) = members.next_entry::<&RawValue, &RawValue>()? {
            // A key whose escapes are no characters is none that is known.
            let key = unescaped(key.get()).unwrap_or(Cow::Borrowed(key.get()));
            (self.0)(&key, value.get());
        }
        Ok(())
    }
}
