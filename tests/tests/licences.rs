//! Whose work the program contains is said beside it.

use fogbank_tests::licences::third_party;

/// `cargo run -p fogbank-tests --example third_party` writes the list anew.
#[test]
fn third_party_software_is_listed() {
    let kept = include_str!("../../THIRD-PARTY.md");
    let now = third_party();
    assert!(kept == now, "THIRD-PARTY.md is stale: write it anew by the example `third_party`");
    assert!(now.lines().filter(|line| line.starts_with("| ")).count() > 100);
    assert!(!now.contains("|  |"), "a crate without a licence or a source: {now}");
}

/// What the page has of others is what they published.
#[test]
fn vendored_files_are_as_they_came() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../web/vendor/fast-json-patch");
    let mut check = std::process::Command::new("sha256sum");
    let output = check.args(["--check", "SHA256SUMS"]).current_dir(folder).output().unwrap();
    let said = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{said}");
    assert_eq!(said.lines().filter(|line| line.ends_with(": OK")).count(), 4, "{said}");
}

/// The workspace's own licence is `MIT OR Apache-2.0`.
#[test]
fn both_licences_are_there() {
    assert!(include_str!("../../LICENSE-MIT").contains("the Fogbank authors"));
    assert!(include_str!("../../LICENSE-APACHE").contains("Version 2.0, January 2004"));
}
