//! The tree of a document: plain JSON, and typed parts that nothing has led into yet.

use serde::Serialize;
use serde_json::{Map, Value};
use std::any::Any;
use std::collections::BTreeMap;
use std::sync::Arc;

/// A value of a document.
#[derive(Clone)]
pub enum Node {
    /// JSON.
    Plain(Value),
    /// An object, some members of which may be typed parts.
    Object(BTreeMap<String, Node>),
    /// A list, likewise.
    List(Vec<Node>),
    /// A typed part.
    Kept(Arc<dyn Kept>),
}

/// A typed part, whatever its type.
pub trait Kept: Send + Sync {
    /// One level of it.
    fn open(&self) -> Node;
    /// All of it.
    fn value(&self) -> Value;
    /// How many values stand in it, near enough.
    fn values(&self) -> usize;
    /// For whoever knows the type.
    fn as_any(&self) -> &dyn Any;
}

impl Node {
    /// A value written out.
    pub fn plain(value: &impl Serialize) -> Self {
        Self::Plain(self::value(value))
    }

    /// The typed part that this is, if nothing led into it.
    pub fn typed<T: Clone + 'static>(&self) -> Option<T> {
        let Self::Kept(part) = self else { return None };
        part.as_any().downcast_ref::<T>().cloned()
    }

    /// Its members, if it is an object.
    pub fn members(&mut self) -> Option<&mut BTreeMap<String, Self>> {
        self.open();
        match self {
            Self::Object(members) => Some(members),
            _ => None,
        }
    }

    /// Its items, if it is a list.
    pub fn items(&mut self) -> Option<&mut Vec<Self>> {
        self.open();
        match self {
            Self::List(items) => Some(items),
            _ => None,
        }
    }

    fn open(&mut self) {
        if let Self::Kept(part) = self {
            *self = part.open();
        }
        let Self::Plain(value) = self else { return };
        *self = match std::mem::take(value) {
            Value::Object(members) => {
                Self::Object(members.into_iter().map(|(key, value)| (key, value.into())).collect())
            }
            Value::Array(items) => Self::List(items.into_iter().map(Self::from).collect()),
            scalar => Self::Plain(scalar),
        };
    }

    /// The value that a token of a pointer leads to, if there is one.
    pub fn child(&mut self, token: &str) -> Option<&mut Self> {
        self.open();
        match self {
            Self::Object(members) => members.get_mut(token),
            Self::List(items) => items.get_mut(index(token)?),
            _ => None,
        }
    }

    /// Sets a member, or adds an item before the one that `token` names; `-` is behind the last. Says
    /// whether there is such a place.
    pub fn add(&mut self, token: &str, value: Self) -> bool {
        self.open();
        match self {
            Self::Object(members) => {
                members.insert(token.to_owned(), value);
                true
            }
            Self::List(items) => {
                let at = if token == "-" { Some(items.len()) } else { index(token) };
                let at = at.filter(|at| *at <= items.len());
                at.map(|at| items.insert(at, value)).is_some()
            }
            _ => false,
        }
    }

    /// Takes a member or an item out.
    pub fn remove(&mut self, token: &str) -> Option<Self> {
        self.open();
        match self {
            Self::Object(members) => members.remove(token),
            Self::List(items) => {
                let at = index(token).filter(|at| *at < items.len())?;
                Some(items.remove(at))
            }
            _ => None,
        }
    }

    /// Changes it as a merge patch says (RFC 7396).
    pub fn merge(&mut self, patch: Value) {
        let Value::Object(changes) = patch else {
            *self = Self::Plain(patch);
            return;
        };
        if self.members().is_none() {
            *self = Self::Object(BTreeMap::new());
        }
        let Self::Object(members) = self else { return };
        for (key, change) in changes {
            if change.is_null() {
                members.remove(&key);
            } else {
                members.entry(key).or_insert(Self::Plain(Value::Null)).merge(change);
            }
        }
    }

    /// All of it, written out.
    pub fn into_value(self) -> Value {
        match self {
            Self::Plain(value) => value,
            Self::Object(members) => {
                let members = members.into_iter().map(|(key, node)| (key, node.into_value()));
                Value::Object(members.collect::<Map<_, _>>())
            }
            Self::List(items) => Value::Array(items.into_iter().map(Self::into_value).collect()),
            Self::Kept(part) => part.value(),
        }
    }

    /// How many values stand in it, and how deep; a typed part counts as one level.
    pub fn weight(&self) -> Weight {
        match self {
            Self::Plain(value) => weight(value),
            Self::Object(members) => Weight::around(members.values().map(Self::weight)),
            Self::List(items) => Weight::around(items.iter().map(Self::weight)),
            Self::Kept(part) => Weight { values: part.values(), depth: 1 },
        }
    }
}

impl From<Value> for Node {
    fn from(value: Value) -> Self {
        Self::Plain(value)
    }
}

/// A value written out.
pub fn value(part: &impl Serialize) -> Value {
    serde_json::to_value(part).unwrap_or_default()
}

/// The size of a document.
#[derive(Clone, Copy)]
pub struct Weight {
    /// Values that stand in it, itself included.
    pub values: usize,
    /// Levels.
    pub depth: usize,
}

impl Weight {
    fn around(parts: impl Iterator<Item = Self>) -> Self {
        let sum = |sum: Self, part: Self| Self {
            values: sum.values + part.values,
            depth: sum.depth.max(part.depth + 1),
        };
        parts.fold(Self { values: 1, depth: 1 }, sum)
    }
}

/// The weight of plain JSON.
pub fn weight(value: &Value) -> Weight {
    match value {
        Value::Object(members) => Weight::around(members.values().map(weight)),
        Value::Array(items) => Weight::around(items.iter().map(weight)),
        // A long text takes as much as many numbers.
        Value::String(text) => Weight { values: 1 + text.len() / 32, depth: 1 },
        _ => Weight { values: 1, depth: 1 },
    }
}

/// The place in a list that a token names (RFC 6901): digits without a leading zero.
fn index(token: &str) -> Option<usize> {
    let is_index = token.bytes().all(|byte| byte.is_ascii_digit())
        && (token == "0" || !token.starts_with('0'));
    if is_index { token.parse().ok() } else { None }
}
