//! What turns one plain value into another.

use super::operation::Operation;
use super::place::Place;
use serde_json::Value;

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
