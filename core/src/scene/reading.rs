//! What is wrong with a scene that cannot be read.

use super::Scene;
use crate::json::{Checker, Code, Problem, ReadError, read};

fn problems(text: &str) -> Vec<Problem> {
    match read::<Scene>(text.as_bytes()).unwrap_err() {
        ReadError::Invalid(problems) => problems,
        ReadError::NotJson(why) => panic!("{why}"),
    }
}

fn found_in(text: &str) -> Vec<(String, Code)> {
    problems(text).into_iter().map(|problem| (problem.pointer, problem.code)).collect()
}

#[test]
fn every_kind_of_wrong_is_found_at_once() {
    let text = r#"{"far_m": 1e400, "time_s": "now", "glow": 1, "glow": 2,
        "camera": {"up": [0, 1], "target": [0, 0, 0, 0]},
        "lights": [{"id": "\ud800", "kind": "point"}, {"kind": "laser"}, {"kind": 3}, {}, []],
        "fog": {"airlight": "best", "terms": [{"blobs": [{"radius": -1}], "kind": "gaussians"}]},
        "surfaces": [{"shape": {"indices": [[0, 0.5, 1]], "kind": "mesh"}, "enabled": null},
                     {"enabled": true, "enabled": true}]}"#;
    let expected = [
        ("/far_m", Code::OutOfRange),
        ("/time_s", Code::WrongType),
        ("/glow", Code::UnknownKey),
        ("/glow", Code::UnknownKey),
        ("/camera/up", Code::WrongLength),
        ("/camera/target", Code::WrongLength),
        ("/lights/0/id", Code::WrongType),
        ("/lights/1/kind", Code::UnknownWord),
        ("/lights/2/kind", Code::WrongType),
        ("/lights/3", Code::Missing),
        ("/lights/4", Code::WrongType),
        ("/fog/airlight", Code::UnknownWord),
        ("/fog/terms/0/blobs/0/radius", Code::OutOfRange),
        ("/surfaces/0/shape/indices/0/1", Code::WrongType),
        ("/surfaces/0/enabled", Code::WrongType),
        ("/surfaces/1/enabled", Code::DuplicateKey),
    ];
    assert_eq!(found_in(text), expected.map(|(pointer, code)| (pointer.to_owned(), code)));
}

#[test]
fn what_all_lists_hold_together_is_counted_where_it_is_too_much() {
    let term = |blobs: usize| {
        format!(r#"{{"kind":"gaussians","blobs":[{}{{}}]}}"#, "{},".repeat(blobs - 1))
    };
    let text = format!(r#"{{"fog":{{"terms":[{},{}]}}}}"#, term(1), term(200_000));
    assert_eq!(found_in(&text), [("/fog/terms/1/blobs".to_owned(), Code::TooMany)]);
}

#[test]
fn an_answer_stays_small_whatever_is_refused() {
    let key = "雾/~".repeat(1_000_000);
    let many = format!(r#"{{"{key}": 1}}, "#).repeat(3);
    let word = format!(r#"{{"kind": "{key}"}}, "#);
    let text = format!(r#"{{"surfaces": [{many}{{}}], "lights": [{word}{}3]}}"#, "0,".repeat(99));
    let problems = problems(&text);
    assert_eq!(problems.len(), Checker::MOST + 1);
    assert_eq!(problems.last().unwrap().detail, "36 more problems are not listed");
    let bytes: usize = problems.iter().map(|p| p.pointer.len() + p.detail.len()).sum();
    assert!(bytes < 8 << 10, "{bytes}");
}

#[test]
fn what_is_no_json_says_where_it_stops() {
    for (text, words) in [
        (
            "{\"fog\":\n {\"terms\": [{\"blobs\": [1,], \"kind\": \"gaussians\"}]}}",
            "line 2 column 26",
        ),
        ("{} {}", "trailing characters at line 1 column 4"),
        (r#"{"a": "b}"#, "EOF"),
    ] {
        let error = read::<Scene>(text.as_bytes()).unwrap_err();
        assert!(matches!(&error, ReadError::NotJson(why) if why.contains(words)), "{error}");
    }
    let error = read::<Scene>(b"{\"\xff\": 1}").unwrap_err();
    assert_eq!(error, ReadError::NotJson("no UTF-8 after 2 bytes".into()));
}
