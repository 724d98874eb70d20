//! Types that stay typed in a document until a pointer leads into them.

use super::node::{Kept, Node, value};
use super::operation::Operation;
use super::place::Place;
use super::plain::members;
use crate::json::{Checker, Code, Problem, ReadError, read};
use schemars::JsonSchema;
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::Value;
use std::any::Any;
use std::sync::Arc;

/// A type of documents, or of parts of them. By itself it opens as a whole.
pub trait Part:
    Clone + PartialEq + Serialize + DeserializeOwned + JsonSchema + Send + Sync + 'static
{
    /// One level of it, with its parts as they are.
    fn open(&self) -> Node {
        Node::plain(self)
    }

    /// The value that a document holds, if nothing in it is refused: itself, where nothing led into it.
    fn close(node: Node, at: &Place, check: &mut Checker) -> Option<Self> {
        node.typed().or_else(|| Self::close_opened(node, at, check))
    }

    /// The same of what was opened.
    fn close_opened(node: Node, at: &Place, check: &mut Checker) -> Option<Self> {
        read_part(node, at, check)
    }

    /// How many values stand in it, near enough.
    fn values(&self) -> usize {
        16
    }

    /// Appends what turns `before` into `after`.
    fn differ(before: &Self, after: &Self, at: &Place, patch: &mut Vec<Operation>) {
        if before != after {
            members(&value(before), &value(after), at, patch);
        }
    }
}

impl Part for f64 {}

impl<T: Part> Kept for T {
    fn open(&self) -> Node {
        Part::open(self)
    }

    fn value(&self) -> Value {
        value(self)
    }

    fn values(&self) -> usize {
        Part::values(self)
    }

    fn as_any(&self) -> &dyn Any {
        self
    }
}

impl Node {
    /// A typed part.
    pub fn kept<T: Part>(part: &T) -> Self {
        Self::Kept(Arc::new(part.clone()))
    }
}

/// The value that a whole document holds.
///
/// # Errors
/// Why it holds none, with pointers into it.
pub fn closed<T: Part>(document: Node) -> Result<T, Vec<Problem>> {
    let mut check = Checker::default();
    let value = T::close(document, &Place::Root, &mut check);
    check.finish(())?;
    // What holds none says why.
    value.ok_or_else(Vec::new)
}

/// Reads a part from its text, as any document is read.
pub fn read_part<T: Part>(node: Node, at: &Place, check: &mut Checker) -> Option<T> {
    let text = serde_json::to_vec(&node.into_value()).unwrap_or_default();
    match read(&text) {
        Ok(part) => Some(part),
        Err(ReadError::Invalid(problems)) => {
            for problem in problems {
                check.refuse(problem.code, || at.pointer() + &problem.pointer, problem.detail);
            }
            None
        }
        Err(ReadError::NotJson(detail)) => {
            check.refuse(Code::Invalid, || at.pointer(), detail);
            None
        }
    }
}

/// Names the large parts of a struct that has a default: the rest of it is small, and opens as a whole.
macro_rules! parts {
    ($Type:ident { $($part:ident),* }) => {
        impl $crate::json::document::Part for $Type {
            fn open(&self) -> $crate::json::document::Node {
                use $crate::json::document::Node;
                let mut node = Node::plain(&self.without_parts());
                $(node.add(stringify!($part), Node::kept(&self.$part));)*
                node
            }

            fn close_opened(
                mut node: $crate::json::document::Node,
                at: &$crate::json::document::Place,
                check: &mut $crate::json::Checker,
            ) -> Option<Self> {
                use $crate::json::document::{Part, read_part};
                let Some(members) = node.members() else { return read_part(node, at, check) };
                $(let $part = members.remove(stringify!($part))
                    .map(|part| Part::close(part, &at.member(stringify!($part)), check));)*
                let whole: Option<Self> = read_part(node, at, check);
                let mut whole = whole?;
                $(if let Some(part) = $part {
                    whole.$part = part?;
                })*
                Some(whole)
            }

            fn values(&self) -> usize {
                16 $(+ $crate::json::document::Part::values(&self.$part))*
            }

            fn differ(
                before: &Self,
                after: &Self,
                at: &$crate::json::document::Place,
                patch: &mut Vec<$crate::json::document::Operation>,
            ) {
                use $crate::json::document::{Part, members, value};
                let (rest, others) = (before.without_parts(), after.without_parts());
                if rest != others {
                    members(&value(&rest), &value(&others), at, patch);
                }
                $(Part::differ(&before.$part, &after.$part, &at.member(stringify!($part)), patch);)*
            }
        }

        impl $Type {
            /// The rest: its parts are those of the default.
            fn without_parts(&self) -> Self {
                Self { $($part: Self::default().$part,)* ..self.clone() }
            }
        }
    };
}
pub(crate) use parts;

/// Lets a union told apart by `kind` open as the variant that it is.
macro_rules! union_parts {
    ($Name:ident { $($Variant:ident = $kind:literal),+ $(,)? }) => {
        impl $crate::json::document::Part for $Name {
            fn open(&self) -> $crate::json::document::Node {
                use $crate::json::document::{Node, Part};
                let (mut node, kind) = match self {
                    $(Self::$Variant(variant) => (Part::open(variant), $kind)),+
                };
                node.add("kind", Node::plain(&kind));
                node
            }

            fn close_opened(
                mut node: $crate::json::document::Node,
                at: &$crate::json::document::Place,
                check: &mut $crate::json::Checker,
            ) -> Option<Self> {
                use $crate::json::document::{Part, read_part};
                let kind = node.child("kind").map(|kind| kind.clone().into_value());
                match kind.as_ref().and_then(serde_json::Value::as_str) {
                    $(Some($kind) => {
                        node.remove("kind");
                        Part::close(node, at, check).map(Self::$Variant)
                    })+
                    _ => read_part(node, at, check),
                }
            }

            fn values(&self) -> usize {
                match self {
                    $(Self::$Variant(variant) => $crate::json::document::Part::values(variant)),+
                }
            }

            fn differ(
                before: &Self,
                after: &Self,
                at: &$crate::json::document::Place,
                patch: &mut Vec<$crate::json::document::Operation>,
            ) {
                use $crate::json::document::{Operation, Part};
                match (before, after) {
                    $((Self::$Variant(before), Self::$Variant(after)) => {
                        Part::differ(before, after, at, patch);
                    })+
                    _ => patch.push(Operation::replace(at, after)),
                }
            }
        }
    };
}
pub(crate) use union_parts;
