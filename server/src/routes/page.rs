//! The page: the files of `web/`, embedded in the binary.

use crate::answer::Fixed;
use crate::app::App;
use axum::http::HeaderMap;
use axum::routing::{MethodRouter, get};
use rust_embed::Embed;

#[derive(Embed)]
#[folder = "../web"]
struct Web;

/// Every file with the path that it is served at; `index.html` also at `/`.
pub fn files() -> Vec<(String, Fixed)> {
    let mut files = Vec::new();
    for name in Web::iter() {
        let Some(file) = Web::get(&name) else { continue };
        let file = Fixed::new(content_type(&name), file.data.into_owned());
        if name == "index.html" {
            files.push(("/".into(), file.clone()));
        }
        files.push((format!("/{name}"), file));
    }
    files
}

/// Answers one file.
pub fn handler(file: Fixed) -> MethodRouter<App> {
    get(move |headers: HeaderMap| async move { file.answer(&headers) })
}

fn content_type(name: &str) -> &'static str {
    match name.rsplit('.').next() {
        Some("html") => "text/html; charset=utf-8",
        Some("js" | "mjs") => "text/javascript; charset=utf-8",
        Some("css") => "text/css; charset=utf-8",
        Some("svg") => "image/svg+xml",
        Some("png") => "image/png",
        Some("txt" | "md") => "text/plain; charset=utf-8",
        Some("json") => "application/json",
        Some("woff2") => "font/woff2",
        _ => "application/octet-stream",
    }
}
