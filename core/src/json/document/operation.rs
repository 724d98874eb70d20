//! A patch, operation by operation (RFC 6902).

use super::node::{Node, value, weight};
use super::place::Place;
use crate::json::limits::COUNTS;
use crate::json::tagged::tagged;
use crate::json::{Checker, Code, Problem};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::Value;

tagged!(
    by "op"
    /// One change of a document (RFC 6902).
    Operation {
        /// Sets a member, or inserts an item before the one that `path` names; `-` stands behind the last.
        Add = "add",
        /// Takes out what is there.
        Remove = "remove",
        /// Puts another value in the place of what is there.
        Replace = "replace",
        /// Takes a value out and adds it elsewhere.
        Move = "move",
        /// Adds a copy of a value elsewhere.
        Copy = "copy",
        /// Goes on only where this value stands there.
        Test = "test",
    }
);

macro_rules! operation {
    ($(#[$doc:meta])* $Name:ident { $($(#[$member_doc:meta])* $member:ident: $type:ty),* }) => {
        $(#[$doc])*
        #[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
        pub struct $Name {
            /// Where (a JSON pointer, RFC 6901).
            pub path: String,
            $($(#[$member_doc])* pub $member: $type,)*
        }
    };
}

operation!(
    /// Sets a member, or inserts an item.
    Add {
        /// The value.
        value: Value
    }
);
operation!(
    /// Takes out what is there.
    Remove {}
);
operation!(
    /// Puts another value in the place of what is there.
    Replace {
        /// The value.
        value: Value
    }
);
operation!(
    /// Takes a value out and adds it at `path`.
    Move {
        /// From where (a JSON pointer).
        from: String
    }
);
operation!(
    /// Adds a copy of a value at `path`.
    Copy {
        /// Of what (a JSON pointer).
        from: String
    }
);
operation!(
    /// Goes on only where this value stands there.
    Test {
        /// The value.
        value: Value
    }
);

/// Changes of a document, one after the other (RFC 6902): all of them, or none.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(transparent)]
pub struct Patch(
    // What this program wrote itself may be longer: a client's is counted by `check`.
    #[schemars(length(max = COUNTS.operations))] pub Vec<Operation>,
);

/// Levels that a document may have while it is patched: more than any scene, and few enough for every
/// recursion over one.
const DEEPEST: usize = 128;

/// Values that the operations of one patch may copy and compare: a few times what a request may hold, so that
/// copies of copies end.
const MOST_VALUES: usize = 4_000_000;

impl Operation {
    /// Puts a value in the place of another.
    pub fn replace(at: &Place, part: &impl Serialize) -> Self {
        Self::Replace(Replace { path: at.pointer(), value: value(part) })
    }

    /// Sets a member or inserts an item.
    pub fn add(at: &Place, part: &impl Serialize) -> Self {
        Self::Add(Add { path: at.pointer(), value: value(part) })
    }

    /// Takes out what is there.
    pub fn remove(at: &Place) -> Self {
        Self::Remove(Remove { path: at.pointer() })
    }
}

impl Patch {
    /// Counts the operations of a client's patch.
    pub fn check(&self, check: &mut Checker, at: impl FnOnce() -> String) {
        check.count(self.0.len(), COUNTS.operations, "operations", at);
    }

    /// Changes a document.
    ///
    /// # Errors
    /// The operation that could not be done, with a pointer into this patch; the document is worth
    /// nothing then.
    pub fn apply(self, document: &mut Node) -> Result<(), Problem> {
        let mut left = MOST_VALUES;
        for (i, operation) in self.0.into_iter().enumerate() {
            operation.apply(document, &mut left).map_err(|Fault { member, code, detail }| {
                Problem { pointer: format!("/{i}/{member}"), code, detail }
            })?;
        }
        Ok(())
    }
}

/// Why an operation cannot be done, and the member of it that says so.
struct Fault {
    member: &'static str,
    code: Code,
    detail: String,
}

impl Fault {
    fn nothing(member: &'static str) -> Self {
        Self { member, code: Code::Conflict, detail: "there is nothing at this pointer".into() }
    }
}

impl Operation {
    fn apply(self, document: &mut Node, left: &mut usize) -> Result<(), Fault> {
        match self {
            Self::Add(Add { path, value }) => add(document, &path, value.into()),
            Self::Remove(Remove { path }) => take(document, &path, "path").map(drop),
            Self::Replace(Replace { path, value }) => {
                let tokens = tokens(&path, "path")?;
                is_not_too_deep(&tokens, weight(&value).depth)?;
                *find(document, &tokens, "path")? = value.into();
                Ok(())
            }
            Self::Move(Move { path, from }) => {
                if path.strip_prefix(&from).is_some_and(|rest| rest.starts_with('/')) {
                    let detail = "a value cannot move into itself".into();
                    return Err(Fault { member: "path", code: Code::Conflict, detail });
                }
                let value = take(document, &from, "from")?;
                add(document, &path, value)
            }
            Self::Copy(Copy { path, from }) => {
                let value = find(document, &tokens(&from, "from")?, "from")?;
                spend(left, value.weight().values)?;
                let value = value.clone();
                add(document, &path, value)
            }
            Self::Test(Test { path, value }) => {
                let there = find(document, &tokens(&path, "path")?, "path")?;
                // Before it is written out.
                spend(left, there.weight().values)?;
                let there = there.clone().into_value();
                if is_same(&there, &value) {
                    return Ok(());
                }
                let detail = "another value stands there".into();
                Err(Fault { member: "value", code: Code::Conflict, detail })
            }
        }
    }
}

fn add(document: &mut Node, path: &str, value: Node) -> Result<(), Fault> {
    let tokens = tokens(path, "path")?;
    is_not_too_deep(&tokens, value.weight().depth)?;
    let Some((last, above)) = tokens.split_last() else {
        *document = value;
        return Ok(());
    };
    let there = find(document, above, "path")?.add(last, value);
    if there { Ok(()) } else { Err(Fault::nothing("path")) }
}

fn take(document: &mut Node, path: &str, member: &'static str) -> Result<Node, Fault> {
    let tokens = tokens(path, member)?;
    let Some((last, above)) = tokens.split_last() else {
        return Ok(std::mem::replace(document, Node::Plain(Value::Null)));
    };
    find(document, above, member)?.remove(last).ok_or_else(|| Fault::nothing(member))
}

fn find<'a>(
    document: &'a mut Node,
    tokens: &[String],
    member: &'static str,
) -> Result<&'a mut Node, Fault> {
    let mut steps = tokens.iter();
    steps.try_fold(document, |node, token| node.child(token)).ok_or_else(|| Fault::nothing(member))
}

/// The tokens of a pointer (RFC 6901).
fn tokens(pointer: &str, member: &'static str) -> Result<Vec<String>, Fault> {
    let fault = |detail: &str| Fault { member, code: Code::Invalid, detail: detail.into() };
    if pointer.is_empty() {
        return Ok(Vec::new());
    }
    let rest = pointer.strip_prefix('/').ok_or_else(|| fault("a pointer begins with `/`"))?;
    let tokens = rest.split('/').map(|token| {
        let plain = token.replace("~1", "").replace("~0", "");
        if plain.contains('~') {
            return Err(fault("in a pointer, `~` stands before 0 or 1 alone"));
        }
        Ok(token.replace("~1", "/").replace("~0", "~"))
    });
    tokens.take(DEEPEST + 1).collect()
}

fn is_not_too_deep(tokens: &[String], depth: usize) -> Result<(), Fault> {
    if tokens.len() + depth <= DEEPEST {
        return Ok(());
    }
    let detail = format!("a document has at most {DEEPEST} levels");
    Err(Fault { member: "path", code: Code::TooMany, detail })
}

fn spend(left: &mut usize, values: usize) -> Result<(), Fault> {
    *left = left.checked_sub(values).ok_or_else(|| {
        let detail = format!("a patch copies and compares at most {MOST_VALUES} values");
        Fault { member: "path", code: Code::TooMany, detail }
    })?;
    Ok(())
}

/// Whether two values are equal; numbers by what they are worth (RFC 6902, 4.6).
fn is_same(a: &Value, b: &Value) -> bool {
    match (a, b) {
        (Value::Number(a), Value::Number(b)) => a == b || a.as_f64() == b.as_f64(),
        (Value::Array(a), Value::Array(b)) => {
            a.len() == b.len() && a.iter().zip(b).all(|(a, b)| is_same(a, b))
        }
        (Value::Object(a), Value::Object(b)) => {
            let same = |(key, a): (&String, &Value)| b.get(key).is_some_and(|b| is_same(a, b));
            a.len() == b.len() && a.iter().all(same)
        }
        _ => a == b,
    }
}
