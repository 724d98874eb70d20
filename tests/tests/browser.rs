//! The page in a browser, driven by the scripts of `web/`.

use fogbank_tests::directory::Directory;
use fogbank_tests::server::{Server, program};
use std::collections::BTreeMap;
use std::ffi::OsStr;
use std::net::TcpListener;
use std::path::Path;
use std::process::Command;

/// Runs a script of `web/` and counts what it says that holds.
fn run(script: &str, arguments: &[&OsStr]) -> usize {
    let web = Path::new(env!("CARGO_MANIFEST_DIR")).join("web");
    let driver = web.join("node_modules/playwright-core");
    assert!(driver.exists(), "{} is missing: run `npm ci` in tests/web", driver.display());
    let mut node = Command::new("node");
    let output = node.arg(script).args(arguments).current_dir(&web).output().expect("node runs");
    let said = String::from_utf8_lossy(&output.stdout);
    let complained = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{said}\n{complained}");
    said.lines().filter(|line| line.starts_with("ok ")).count()
}

#[test]
fn the_page_works_in_a_browser() {
    let server = Server::start();
    let shots = env!("CARGO_TARGET_TMPDIR");
    assert!(run("page.js", &[server.address.as_ref(), shots.as_ref()]) >= 30);
}

#[test]
fn scenes_are_worked_on_in_a_browser() {
    let directory = Directory::new();
    // The script starts the program itself, kills it and starts it again on this address.
    let free = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap();
    let (program, address) = (program(), free.to_string());
    let arguments = [
        program.as_ref(),
        address.as_ref(),
        directory.path().as_ref(),
        env!("CARGO_TARGET_TMPDIR").as_ref(),
    ];
    assert!(run("scenes.js", &arguments) >= 20);
}

#[test]
fn no_module_of_the_page_imports_itself_by_way_of_others() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../web");
    let files = std::fs::read_dir(folder).unwrap().map(|file| file.unwrap().path());
    let scripts = files.filter(|path| path.extension().is_some_and(|end| end == "js"));
    let mut imports: BTreeMap<_, _> = scripts
        .map(|path| {
            let text = std::fs::read_to_string(&path).unwrap();
            let imported = text.lines().filter_map(|line| line.split_once(" from \"./"));
            let imported = imported.filter_map(|(_, rest)| rest.strip_suffix("\";"));
            let name = path.file_name().unwrap().to_string_lossy().into_owned();
            (name, imported.map(str::to_owned).collect::<Vec<_>>())
        })
        .collect();
    assert!(imports["app.js"].len() > 10, "{imports:?}");
    // What imports nothing that is left falls away, until only circles and their importers are left.
    loop {
        let left: Vec<_> = imports.keys().cloned().collect();
        imports.retain(|_, imported| imported.iter().any(|name| left.contains(name)));
        if imports.len() == left.len() {
            break;
        }
    }
    assert!(imports.is_empty(), "{imports:#?}");
}
