//! What is wrong with a document, and where.

use super::limits::{self, Range};
use super::values::{Spectrum, Vec3};
use schemars::JsonSchema;
use serde::Serialize;
use std::fmt::Display;

/// One thing that is wrong with a request's body, and where.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, JsonSchema)]
#[schemars(rename = "FieldError")]
pub struct Problem {
    /// JSON pointer (RFC 6901) of the offending place. A name longer than 64 characters is cut, and
    /// then ends in `…`.
    pub pointer: String,
    /// What kind of wrong it is.
    pub code: Code,
    /// What is wrong with it, for people.
    pub detail: String,
}

/// The kinds of wrong. The words of a `detail` may change, these do not.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Code {
    /// The object has no such member.
    UnknownKey,
    /// The member stands twice in its object.
    DuplicateKey,
    /// The object lacks a member that it must have.
    Missing,
    /// Another type of value is needed here.
    WrongType,
    /// The string is none of the words that are known here, such as a `kind`.
    UnknownWord,
    /// The number is outside its range.
    OutOfRange,
    /// The list or string is too short or too long.
    WrongLength,
    /// There are more of these than `/v1/limits` allows.
    TooMany,
    /// Another item of the list has this `id`.
    DuplicateId,
    /// The value does not go together with others.
    Conflict,
    /// The document is not of the described form, in a way that has no code of its own.
    Invalid,
    /// The last entry of a long list: how many more there are.
    More,
}

/// Collects problems while a document is walked.
///
/// Paths are only written out when something is wrong. At most [`Checker::MOST`] problems are
/// kept, the others counted: a mesh of a million bad corners needs no answer of a million lines.
#[derive(Debug, Default)]
pub struct Checker {
    base: &'static str,
    problems: Vec<Problem>,
    count: usize,
}

impl Checker {
    /// How many problems one answer lists.
    pub const MOST: usize = 32;

    /// Notes a problem at `pointer`.
    pub fn refuse(
        &mut self,
        code: Code,
        pointer: impl FnOnce() -> String,
        detail: impl Into<String>,
    ) {
        if self.count < Self::MOST {
            let pointer = self.base.to_owned() + &pointer();
            self.problems.push(Problem { pointer, code, detail: detail.into() });
        }
        self.count += 1;
    }

    /// `value` must lie in `range`.
    pub fn number(&mut self, value: f64, range: Range, pointer: impl FnOnce() -> String) {
        if !range.contains(value) {
            // In full, 1e300 has 301 digits; and a whole number needs no ".0".
            let text = format!("{value:?}");
            let text = text.strip_suffix(".0").unwrap_or(&text);
            self.refuse(Code::OutOfRange, pointer, outside(&text, range));
        }
    }

    /// All components must lie in `range`.
    pub fn triple(&mut self, value: [f64; 3], range: Range, pointer: impl Fn() -> String) {
        for (i, component) in value.into_iter().enumerate() {
            self.number(component, range, || format!("{}/{i}", pointer()));
        }
    }

    /// Its value in every channel must lie in `range`.
    pub fn spectrum(&mut self, value: Spectrum, range: Range, pointer: impl Fn() -> String) {
        match value {
            Spectrum::Grey(value) => self.number(value, range, pointer),
            Spectrum::Rgb(values) => self.triple(values, range, pointer),
        }
    }

    /// There may be at most `most` of them.
    pub fn count(
        &mut self,
        count: usize,
        most: usize,
        what: &str,
        pointer: impl FnOnce() -> String,
    ) {
        if count > most {
            let detail = format!("{count} {what} are more than the limit of {most}");
            self.refuse(Code::TooMany, pointer, detail);
        }
    }

    /// A direction must have a length.
    pub fn direction(&mut self, value: Vec3, pointer: impl Fn() -> String) {
        self.triple(value.0, limits::COORDINATE, &pointer);
        if value.vector().length_squared() < f64::MIN_POSITIVE {
            self.refuse(Code::OutOfRange, pointer, "a direction must not be zero");
        }
    }

    /// Checks a part of the document: its pointers begin at `base`.
    pub fn within(&mut self, base: &'static str, check: impl FnOnce(&mut Self)) {
        let outer = std::mem::replace(&mut self.base, base);
        check(self);
        self.base = outer;
    }

    /// How many problems there are so far.
    pub fn found(&self) -> usize {
        self.count
    }

    /// Whether nothing was refused so far.
    pub fn is_clean(&self) -> bool {
        self.count == 0
    }

    /// The value when nothing was refused.
    ///
    /// # Errors
    /// What was refused; if that is more than [`Self::MOST`], the last entry says how many more.
    pub fn finish<T>(mut self, value: T) -> Result<T, Vec<Problem>> {
        let more = self.count - self.problems.len();
        if more > 0 {
            let detail = format!("{more} more problems are not listed");
            self.problems.push(Problem { pointer: String::new(), code: Code::More, detail });
        }
        if self.problems.is_empty() { Ok(value) } else { Err(self.problems) }
    }
}

/// The words for a number outside its range.
pub fn outside(value: &dyn Display, range: Range) -> String {
    format!("{value} is not between {} and {}", range.min, range.max)
}

/// A text of the client's as it may stand in an answer: its first 64 characters.
pub fn shown(text: &str) -> String {
    const MOST: usize = 64;
    match text.char_indices().nth(MOST) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text.to_owned(),
    }
}

/// A member's name as a token of a JSON pointer.
pub fn token(key: &str) -> String {
    escaped(&shown(key))
}

/// A whole name as a token of a JSON pointer.
pub fn escaped(key: &str) -> String {
    key.replace('~', "~0").replace('/', "~1")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_listed_is_counted() {
        let mut check = Checker::default();
        for i in 0..Checker::MOST + 5 {
            check.refuse(Code::Conflict, || format!("/{i}"), "no");
        }
        let problems = check.finish(()).unwrap_err();
        assert_eq!(problems.len(), Checker::MOST + 1);
        let last = problems.last().unwrap();
        assert_eq!((last.pointer.as_str(), last.code), ("", Code::More));
        assert_eq!(last.detail, "5 more problems are not listed");
    }

    #[test]
    fn pointers_of_a_part_begin_where_it_stands() {
        let mut check = Checker::default();
        check.within("/scene", |check| check.number(2.0, limits::FRACTION, || "/a".into()));
        check.number(1e300, limits::FRACTION, || "/b".into());
        let problems = check.finish(()).unwrap_err();
        assert_eq!(problems[0].pointer, "/scene/a");
        assert_eq!((problems[1].pointer.as_str(), problems[1].code), ("/b", Code::OutOfRange));
        assert_eq!(problems[1].detail, "1e300 is not between 0 and 1");
    }

    #[test]
    fn long_names_are_cut_and_slashes_escaped() {
        assert_eq!(token("a/b~c"), "a~1b~0c");
        assert_eq!(token(&"雾".repeat(65)), "雾".repeat(64) + "…");
        assert_eq!(shown(&"x".repeat(64)), "x".repeat(64));
    }
}
