//! What turns one value into another, as a patch.

use super::operation::{Operation, Patch};
use super::part::Part;
use crate::json::problem::escaped;
use serde_json::Value;

/// What turns `before` into `after`.
pub fn difference<T: Part>(before: &T, after: &T) -> Patch {
    let mut patch = Vec::new();
    T::differ(before, after, &Place::Root, &mut patch);
    Patch(patch)
}

/// Where a part stands in a document; written out only where it differs.
pub enum Place<'a> {
    /// The whole document.
    Root,
    /// A member of an object.
    Member(&'a Self, &'a str),
    /// An item of a list.
    Item(&'a Self, usize),
}

impl Place<'_> {
    /// A member of what stands here.
    pub fn member<'a>(&'a self, key: &'a str) -> Place<'a> {
        Place::Member(self, key)
    }

    /// An item of what stands here.
    pub fn item(&self, index: usize) -> Place<'_> {
        Place::Item(self, index)
    }

    /// Its JSON pointer.
    pub fn pointer(&self) -> String {
        match self {
            Self::Root => String::new(),
            Self::Member(above, key) => format!("{}/{}", above.pointer(), escaped(key)),
            Self::Item(above, index) => format!("{}/{index}", above.pointer()),
        }
    }
}

/// Appends what turns one plain value into another: objects member by member, lists of objects that are as
/// long as before item by item, all else as a whole.
pub fn members(before: &Value, after: &Value, at: &Place, patch: &mut Vec<Operation>) {
    match (before, after) {
        (Value::Object(before), Value::Object(after)) if kind(before) == kind(after) => {
            for (key, value) in after {
                match before.get(key) {
                    Some(old) => members(old, value, &at.member(key), patch),
                    None => patch.push(Operation::add(&at.member(key), value)),
                }
            }
            let gone = before.keys().filter(|key| !after.contains_key(*key));
            patch.extend(gone.map(|key| Operation::remove(&at.member(key))));
        }
        (Value::Array(before), Value::Array(after))
            if before.len() == after.len() && after.iter().all(Value::is_object) =>
        {
            for (i, (old, value)) in before.iter().zip(after).enumerate() {
                members(old, value, &at.item(i), patch);
            }
        }
        _ if before == after => {}
        _ => patch.push(Operation::replace(at, after)),
    }
}

/// What a variant of a union is; another one has other members.
fn kind(members: &serde_json::Map<String, Value>) -> Option<&Value> {
    members.get("kind")
}
