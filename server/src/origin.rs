//! Which page of which site a browser sends for: other sites' pages must not use this server.
//!
//! A page whose own name was made to lead here (DNS rebinding) betrays itself by the header `Host`;
//! a page of another site by `Sec-Fetch-Site` or `Origin`. Programs send neither of the latter.

use crate::problem::Problem;
use axum::http::uri::Authority;
use axum::http::{HeaderMap, HeaderName, Method, StatusCode, Uri, header};
use std::net::IpAddr;

/// The names by which this server may be called, besides addresses: those cannot be rebound.
#[derive(Clone, Debug)]
pub struct Names {
    /// Where it listens.
    own: String,
    /// What it is told to be called, perhaps by a proxy on another port.
    allowed: Vec<String>,
}

impl Names {
    /// `localhost`, what the server listens on and what it is told to be called.
    pub fn new(listen: &str, allowed: &[String]) -> Self {
        let own = listen.rsplit_once(':').map_or(listen, |(name, _)| name);
        Self { own: normal(own), allowed: allowed.iter().map(|name| normal(name)).collect() }
    }

    /// Refuses what a page of another site made a browser send.
    ///
    /// # Errors
    /// 421 under a name that is not the server's own, 403 from a page of another site.
    pub fn check(&self, method: &Method, uri: &Uri, headers: &HeaderMap) -> Result<(), Problem> {
        let target = uri.authority().map(|authority| Ok(authority.clone()));
        let hosts =
            headers.get_all(header::HOST).iter().map(|value| text(value.as_bytes()).parse());
        for host in target.into_iter().chain(hosts) {
            if !host.is_ok_and(|host: Authority| self.has(host.host())) {
                return Err(misdirected());
            }
        }
        // What is only read is kept from other sites' pages by the browser.
        if method.is_safe() { Ok(()) } else { self.check_origin(headers) }
    }

    /// Refuses what a page of another site asks for, be it only to read: a socket is not kept from it by the browser.
    ///
    /// # Errors
    /// 403 from a page of another site.
    pub fn check_origin(&self, headers: &HeaderMap) -> Result<(), Problem> {
        let is_foreign = match headers.get(HeaderName::from_static("sec-fetch-site")) {
            Some(site) => site != "same-origin" && site != "none",
            None => {
                headers.get(header::ORIGIN).is_some_and(|o| !self.is_own(o.as_bytes(), headers))
            }
        };
        if is_foreign {
            let detail = "a page of another site must not use this server";
            return Err(Problem::new(StatusCode::FORBIDDEN, detail));
        }
        Ok(())
    }

    /// Whether an origin is this server: as the browser called it, or by a name of its own.
    fn is_own(&self, origin: &[u8], headers: &HeaderMap) -> bool {
        let Ok(origin) = text(origin).parse::<Uri>() else { return false };
        let Some(authority) = origin.authority() else { return false };
        let host = headers.get(header::HOST);
        let is_same = host.is_some_and(|host| authority.as_str().as_bytes() == host.as_bytes());
        is_same || self.allowed.contains(&normal(authority.host()))
    }

    fn has(&self, host: &str) -> bool {
        let host = normal(host);
        let is_local = host == "localhost" || host.ends_with(".localhost");
        is_local || is_address(&host) || host == self.own || self.allowed.contains(&host)
    }
}

fn is_address(host: &str) -> bool {
    host.trim_start_matches('[').trim_end_matches(']').parse::<IpAddr>().is_ok()
}

fn normal(name: &str) -> String {
    name.trim_end_matches('.').to_ascii_lowercase()
}

fn text(bytes: &[u8]) -> &str {
    std::str::from_utf8(bytes).unwrap_or_default()
}

fn misdirected() -> Problem {
    let detail = "this server is not called so: start it with `--allow-host NAME` if it should be";
    Problem::new(StatusCode::MISDIRECTED_REQUEST, detail)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn status(method: Method, headers: &[(&'static str, &'static str)]) -> u16 {
        let names = Names::new("studio.example:8080", &["Fog.Example".to_owned()]);
        let pairs = headers.iter().map(|(name, value)| {
            (HeaderName::from_static(name), value.parse::<axum::http::HeaderValue>().unwrap())
        });
        let checked = names.check(&method, &Uri::from_static("/"), &pairs.collect());
        checked.map_or_else(|problem| problem.status().as_u16(), |()| 200)
    }

    #[test]
    fn it_answers_to_addresses_and_to_its_own_names() {
        for host in [
            "localhost",
            "LOCALHOST:8080",
            "fog.localhost:1",
            "localhost.",
            "127.0.0.1:8080",
            "[::1]:8080",
            "192.168.0.7",
            "studio.example",
            "fog.example:443",
        ] {
            assert_eq!(status(Method::GET, &[("host", host)]), 200, "{host}");
        }
        for host in ["evil.example", "127.0.0.1.evil.example", "notlocalhost", "", "a b", "::1x"] {
            assert_eq!(status(Method::GET, &[("host", host)]), 421, "{host}");
        }
        assert_eq!(status(Method::GET, &[]), 200);
        let names = Names::new("127.0.0.1:0", &[]);
        let uri = Uri::from_static("http://evil.example/");
        assert!(names.check(&Method::GET, &uri, &HeaderMap::new()).is_err());
    }

    #[test]
    fn a_page_of_another_site_may_not_post() {
        let own = ("host", "127.0.0.1:8080");
        let post = |header| status(Method::POST, &[own, header]);
        for site in ["cross-site", "same-site", "anything"] {
            assert_eq!(post(("sec-fetch-site", site)), 403, "{site}");
            assert_eq!(status(Method::GET, &[own, ("sec-fetch-site", site)]), 200, "{site}");
        }
        for site in ["same-origin", "none"] {
            assert_eq!(post(("sec-fetch-site", site)), 200, "{site}");
        }
        for origin in ["null", "http://evil.example", "http://127.0.0.1:3000", "http://localhost:1"]
        {
            assert_eq!(post(("origin", origin)), 403, "{origin}");
        }
        for origin in ["http://127.0.0.1:8080", "https://fog.example"] {
            assert_eq!(post(("origin", origin)), 200, "{origin}");
        }
        assert_eq!(status(Method::POST, &[own]), 200);
    }
}
