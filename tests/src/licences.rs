//! The crates whose code is in the program, with their licences, as cargo knows them.

use std::process::Command;

const HEAD: &str = "# Third-party software

Fogbank's program contains the crates below, as built for x86-64 Linux; other systems add the crates
that talk to them. Each is used under a licence named here, whose text its source holds. The page in
`web/` contains fast-json-patch (MIT), in `web/vendor/fast-json-patch` with its licence and hashes.

Written by `cargo run -p fogbank-tests --example third_party`; a test compares.

| crate | version | licence | source |
|---|---|---|---|
";

/// The text of `THIRD-PARTY.md`.
pub fn third_party() -> String {
    let mut cargo = Command::new(std::env::var_os("CARGO").unwrap_or("cargo".into()));
    cargo.args(["tree", "--locked", "--package", "fogbank-server", "--prefix", "none"]);
    // What runs while building, procedural macros too, is in no program.
    cargo.args(["--edges", "normal,no-proc-macro", "--target", "x86_64-unknown-linux-gnu"]);
    cargo.args(["--format", "{p}\t{l}\t{r}"]).current_dir(env!("CARGO_MANIFEST_DIR"));
    let output = cargo.output().expect("cargo runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let tree = String::from_utf8(output.stdout).expect("text from cargo");
    let mut rows: Vec<_> = tree.lines().filter_map(row).collect();
    rows.sort();
    rows.dedup();
    format!("{HEAD}{}", rows.concat())
}

/// `name v1.2.3`, licence, repository; what lies in the workspace is ours.
fn row(line: &str) -> Option<String> {
    let [package, licence, source] = line.split('\t').collect::<Vec<_>>().try_into().ok()?;
    // A crate that was listed already is marked, as is one from elsewhere than the registry.
    let mut words = package.split(' ');
    let (name, version) = (words.next()?, words.next()?.trim_start_matches('v'));
    if name.starts_with("fogbank-") {
        return None;
    }
    let source = match source.trim_end_matches(" (*)") {
        // Some do not say where they come from: the registry does.
        "" => format!("https://crates.io/crates/{name}"),
        told => told.to_owned(),
    };
    Some(format!("| {name} | {version} | {licence} | {source} |\n"))
}
