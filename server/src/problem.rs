//! The one shape of every refusal: RFC 9457 problem details.

use crate::queue::Refusal;
use axum::http::{HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use fogbank_core::image::EncodeError;
use fogbank_core::scene::{self, ReadError};
use schemars::JsonSchema;
use serde::Serialize;

/// Its media type.
pub const CONTENT_TYPE: &str = "application/problem+json";

/// Why a request was refused (RFC 9457).
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct Problem {
    /// `about:blank`: the status says what kind of problem it is.
    #[serde(rename = "type")]
    kind: &'static str,
    /// The words of the status.
    title: &'static str,
    /// The HTTP status.
    status: u16,
    /// What is wrong with this request.
    detail: String,
    /// What is wrong in the request's body, if it is that: at most 32 entries, and a last one of the
    /// code `more` where there are more.
    errors: Vec<scene::Problem>,
    #[serde(skip)]
    retry_after_s: Option<u32>,
}

impl Problem {
    /// A refusal in a few words.
    pub fn new(status: StatusCode, detail: impl Into<String>) -> Self {
        Self {
            kind: "about:blank",
            title: status.canonical_reason().unwrap_or("Unknown status"),
            status: status.as_u16(),
            detail: detail.into(),
            errors: Vec::new(),
            retry_after_s: None,
        }
    }

    /// The body is JSON, but not a valid request.
    pub fn invalid(errors: Vec<scene::Problem>) -> Self {
        let detail = match errors.first() {
            Some(first) if first.pointer.is_empty() => first.detail.clone(),
            Some(first) => format!("{}: {}", first.pointer, first.detail),
            None => "the request is not valid".to_owned(),
        };
        Self { errors, ..Self::new(StatusCode::UNPROCESSABLE_ENTITY, detail) }
    }

    /// The server has too much to do right now.
    pub fn busy(detail: &str) -> Self {
        let retry_after_s = Some(1);
        Self { retry_after_s, ..Self::new(StatusCode::SERVICE_UNAVAILABLE, detail) }
    }

    /// Something broke that is not the client's fault.
    pub fn broken() -> Self {
        Self::new(StatusCode::INTERNAL_SERVER_ERROR, "the server failed; its log says why")
    }

    /// Its JSON.
    pub fn json(&self) -> Vec<u8> {
        serde_json::to_vec(self).unwrap_or_default()
    }

    /// The HTTP status.
    pub fn status(&self) -> StatusCode {
        StatusCode::from_u16(self.status).unwrap_or(StatusCode::INTERNAL_SERVER_ERROR)
    }
}

impl IntoResponse for Problem {
    fn into_response(self) -> Response {
        let content_type = HeaderValue::from_static(CONTENT_TYPE);
        let headers = [(header::CONTENT_TYPE, content_type)];
        let mut response = (self.status(), headers, self.json()).into_response();
        if let Some(seconds) = self.retry_after_s {
            response.headers_mut().insert(header::RETRY_AFTER, HeaderValue::from(seconds));
        }
        response
    }
}

impl From<ReadError> for Problem {
    fn from(error: ReadError) -> Self {
        match error {
            ReadError::NotJson(_) => Self::new(StatusCode::BAD_REQUEST, error.to_string()),
            ReadError::Invalid(problems) => Self::invalid(problems),
        }
    }
}

impl From<Refusal> for Problem {
    fn from(refusal: Refusal) -> Self {
        match refusal {
            Refusal::Busy => Self::busy("the queue is full"),
            Refusal::Late => Self::new(StatusCode::GATEWAY_TIMEOUT, "the deadline passed"),
            Refusal::Broken => Self::broken(),
        }
    }
}

impl From<EncodeError> for Problem {
    fn from(error: EncodeError) -> Self {
        tracing::error!("{error}");
        Self::new(StatusCode::INTERNAL_SERVER_ERROR, error.to_string())
    }
}

impl From<tokio::task::JoinError> for Problem {
    fn from(error: tokio::task::JoinError) -> Self {
        tracing::error!("{error}");
        Self::broken()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::{Value, json};

    fn body(problem: &Problem) -> Value {
        serde_json::from_slice(&problem.json()).unwrap()
    }

    #[test]
    fn a_problem_has_every_member_of_the_rfc() {
        let problem = Problem::new(StatusCode::NOT_FOUND, "no such page");
        let expected = json!({
            "type": "about:blank", "title": "Not Found", "status": 404,
            "detail": "no such page", "errors": [],
        });
        assert_eq!(body(&problem), expected);
        let response = problem.into_response();
        assert_eq!(response.status(), 404);
        assert_eq!(response.headers()[header::CONTENT_TYPE], CONTENT_TYPE);
    }

    #[test]
    fn bad_input_names_its_places() {
        let wrong = |pointer: &str| scene::Problem {
            pointer: pointer.into(),
            code: scene::Code::OutOfRange,
            detail: "x".into(),
        };
        let problem = Problem::invalid(vec![wrong("/scene/far_m"), wrong("/width")]);
        assert_eq!(problem.status(), 422);
        assert_eq!(body(&problem)["detail"], "/scene/far_m: x");
        let expected = json!({"pointer": "/width", "code": "out_of_range", "detail": "x"});
        assert_eq!(body(&problem)["errors"][1], expected);
    }

    #[test]
    fn what_is_not_json_is_a_400_and_what_is_wrong_json_a_422() {
        let not_json = scene::read::<scene::Scene>(b"{").unwrap_err();
        assert_eq!(Problem::from(not_json).status(), 400);
        let wrong = scene::read::<scene::Scene>(b"{\"nothing\": 1}").unwrap_err();
        assert_eq!(Problem::from(wrong).status(), 422);
    }

    #[test]
    fn busy_says_when_to_come_again() {
        let response = Problem::from(Refusal::Busy).into_response();
        assert_eq!(response.status(), 503);
        assert_eq!(response.headers()[header::RETRY_AFTER], "1");
    }
}
