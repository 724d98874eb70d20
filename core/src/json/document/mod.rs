//! A typed value as a JSON document that is patched without being written out.
//!
//! A patch of a few bytes must not cost what a document of megabytes costs. So a document is a tree
//! ([`Node`]) whose parts stay the typed values that they are until a pointer leads into one of them;
//! only that part is opened, one level deep ([`Part`]). When the patch is through, the tree is closed:
//! what was never opened comes back as it was, shared with the value before, and what was opened or
//! added is read as any text of a client's is.
//!
//! What changed between two values is found the same way ([`Part::differ`]): parts that are shared are
//! equal without a look. It is always the least that a client with the old document needs, however the
//! new one came about: defaults that were filled in are part of it.

mod difference;
mod list;
mod node;
mod operation;
mod part;
mod place;
mod plain;
#[cfg(test)]
mod tests;

pub use difference::difference;
pub use node::{Node, value};
pub use operation::{Operation, Patch};
pub use part::{Part, closed, read_part};
pub(crate) use part::{parts, union_parts};
pub use place::Place;
pub use plain::members;
