//! Where a part of a document stands.

use crate::json::problem::escaped;

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
