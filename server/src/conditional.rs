//! What a request expects of what it asks for: revisions as entity tags, and keys of requests that may be repeated.

use crate::answer;
use crate::problem::Problem;
use crate::store::{Condition, Refusal};
use axum::http::{HeaderMap, HeaderValue, StatusCode, header};
use headers::{ETag, HeaderMapExt, IfMatch, IfNoneMatch};

/// The header that names a request, so that a repeated one is not done twice.
pub const KEY: &str = "Idempotency-Key";

/// Characters of such a name.
const KEY_CHARS: usize = 128;

/// The tag of a revision.
pub fn tag(revision: u64) -> ETag {
    // Digits in quotes are always a tag.
    format!("\"{revision}\"").parse().unwrap_or_else(|_| unreachable!("digits"))
}

/// What `If-Match` and `If-None-Match` ask of a scene that is to be changed.
///
/// # Errors
/// 400 where they are not what they should be.
pub fn condition(headers: &HeaderMap) -> Result<Condition, Problem> {
    let mut condition = Condition::default();
    if let Some(matches) = typed::<IfMatch>(headers, header::IF_MATCH)? {
        condition.must_exist = true;
        if !matches.is_any() {
            condition.if_match = Some(revisions(headers));
        }
    }
    if let Some(none) = typed::<IfNoneMatch>(headers, header::IF_NONE_MATCH)? {
        // No tag at all matches something that does not exist, and `*` whatever does.
        condition.must_be_new = none == IfNoneMatch::any();
    }
    Ok(condition)
}

/// Whether the client has what has this tag.
///
/// # Errors
/// 400 where `If-None-Match` is not what it should be.
pub fn is_known(headers: &HeaderMap, tag: &ETag) -> Result<bool, Problem> {
    let none = typed::<IfNoneMatch>(headers, header::IF_NONE_MATCH)?;
    Ok(none.is_some_and(|none| !none.precondition_passes(tag)))
}

fn typed<H: headers::Header>(
    headers: &HeaderMap,
    name: header::HeaderName,
) -> Result<Option<H>, Problem> {
    headers.typed_try_get::<H>().map_err(|_| {
        Problem::new(StatusCode::BAD_REQUEST, format!("{name} is no list of entity tags"))
    })
}

/// The revisions that `If-Match` lists; other tags are of none.
fn revisions(headers: &HeaderMap) -> Vec<u64> {
    let tags = answer::members(headers, header::IF_MATCH);
    tags.filter_map(|tag| tag.strip_prefix('"')?.strip_suffix('"')?.parse().ok()).collect()
}

/// The name that a client gives its request, if any.
///
/// # Errors
/// 400 where it is none.
pub fn key(headers: &HeaderMap) -> Result<Option<String>, Problem> {
    let Some(value) = headers.get(KEY) else { return Ok(None) };
    let name = value.to_str().ok().filter(|name| (1..=KEY_CHARS).contains(&name.len()));
    let detail = format!("{KEY} must be 1 to {KEY_CHARS} characters of ASCII");
    name.map(|name| Some(name.to_owned()))
        .ok_or_else(|| Problem::new(StatusCode::BAD_REQUEST, detail))
}

/// A tag as a header's value.
pub fn value(tag: &ETag) -> HeaderValue {
    let mut headers = HeaderMap::new();
    headers.typed_insert(tag.clone());
    headers.remove(header::ETAG).unwrap_or(HeaderValue::from_static("\"\""))
}

impl From<Refusal> for Problem {
    fn from(refusal: Refusal) -> Self {
        let conflict = |detail: String| Self::new(StatusCode::CONFLICT, detail);
        match refusal {
            Refusal::Missing => Self::new(StatusCode::NOT_FOUND, "there is no such scene"),
            Refusal::Preset => conflict(
                "a preset stays as it is: PUT /v1/scenes/{id}?from={preset} makes a scene of it"
                    .into(),
            ),
            Refusal::Precondition { revision } => {
                let detail = match revision {
                    Some(revision) => format!("the scene is at revision {revision}"),
                    None => "there is no such scene".to_owned(),
                };
                Self::new(StatusCode::PRECONDITION_FAILED, detail)
            }
            Refusal::MovedOn(revision) => {
                conflict(format!("the scene has moved on to revision {revision}"))
            }
            Refusal::Invalid(problems) => Self::invalid(problems),
            Refusal::Nothing(what) => conflict(what.to_owned()),
            Refusal::KeyReused => {
                let detail = format!("another request had this {KEY}");
                Self::new(StatusCode::UNPROCESSABLE_ENTITY, detail)
            }
            Refusal::Full => {
                Self::new(StatusCode::INSUFFICIENT_STORAGE, "there is no room to store it")
            }
            Refusal::TooMany => {
                Self::new(StatusCode::INSUFFICIENT_STORAGE, "there are as many scenes as may be")
            }
            Refusal::Lost => Self::busy("an earlier write was lost, and this one with it"),
            Refusal::Busy => Self::busy("too much waits to be stored"),
            Refusal::Late => Self::new(StatusCode::GATEWAY_TIMEOUT, "the deadline passed"),
            Refusal::Failed(detail) => {
                tracing::error!("store: {detail}");
                Self::broken()
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn headers(name: header::HeaderName, value: &'static str) -> HeaderMap {
        HeaderMap::from_iter([(name, HeaderValue::from_static(value))])
    }

    #[test]
    fn conditions_are_lists_of_revisions() {
        let several = condition(&headers(header::IF_MATCH, "\"3\", \"x\" , \"12\"")).unwrap();
        assert_eq!((several.if_match, several.must_exist), (Some(vec![3, 12]), true));
        let any = condition(&headers(header::IF_MATCH, "*")).unwrap();
        assert_eq!((any.if_match, any.must_exist), (None, true));
        assert!(condition(&headers(header::IF_NONE_MATCH, "*")).unwrap().must_be_new);
        // A weak tag is of no use for a write.
        let weak = condition(&headers(header::IF_MATCH, "W/\"3\"")).unwrap();
        assert_eq!(weak.if_match, Some(vec![]));
        // What is no tag is the tag of nothing.
        assert_eq!(condition(&headers(header::IF_MATCH, "3")).unwrap().if_match, Some(vec![]));
    }

    #[test]
    fn a_tag_is_known_whether_weak_or_strong() {
        assert_eq!(value(&tag(7)), "\"7\"");
        for list in ["\"7\"", "\"6\", W/\"7\"", "*"] {
            assert!(is_known(&headers(header::IF_NONE_MATCH, list), &tag(7)).unwrap(), "{list}");
        }
        assert!(!is_known(&headers(header::IF_NONE_MATCH, "\"6\""), &tag(7)).unwrap());
    }
}
