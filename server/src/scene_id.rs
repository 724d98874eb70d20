//! What a stored scene is called.

use crate::app::App;
use crate::problem::Problem;
use axum::extract::{FromRequestParts, Path};
use axum::http::StatusCode;
use axum::http::request::Parts;

/// What an id looks like.
pub const PATTERN: &str = "^[a-z0-9-]{1,64}$";

/// Characters of a scene's id.
const ID_CHARS: usize = 64;

/// What a scene is called: the part of the path.
#[derive(Clone, Debug)]
pub struct SceneId(pub String);

impl FromRequestParts<App> for SceneId {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, app: &App) -> Result<Self, Problem> {
        let Path(id) = Path::<String>::from_request_parts(parts, app).await.map_err(|_| no_id())?;
        Self::read(id)
    }
}

impl SceneId {
    /// The id that a text is.
    ///
    /// # Errors
    /// 404 where it is none.
    pub fn read(id: String) -> Result<Self, Problem> {
        let is_plain = |c: u8| c.is_ascii_lowercase() || c.is_ascii_digit() || c == b'-';
        let is_id = (1..=ID_CHARS).contains(&id.len()) && id.bytes().all(is_plain);
        if is_id { Ok(Self(id)) } else { Err(no_id()) }
    }
}

fn no_id() -> Problem {
    let detail = format!("a scene's id is 1 to {ID_CHARS} of a–z, 0–9 and -");
    Problem::new(StatusCode::NOT_FOUND, detail)
}
