//! The page in a browser, driven by `web/page.js`.

use fogbank_tests::server::Server;
use std::path::Path;
use std::process::Command;

#[test]
fn the_page_works_in_a_browser() {
    let web = Path::new(env!("CARGO_MANIFEST_DIR")).join("web");
    let driver = web.join("node_modules/playwright-core");
    assert!(driver.exists(), "{} is missing: run `npm ci` in tests/web", driver.display());
    let server = Server::start();
    let output = Command::new("node")
        .arg("page.js")
        .arg(&server.address)
        .arg(env!("CARGO_TARGET_TMPDIR"))
        .current_dir(&web)
        .output()
        .expect("node runs");
    let said = String::from_utf8_lossy(&output.stdout);
    let complained = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{said}\n{complained}");
    assert!(said.lines().filter(|line| line.starts_with("ok ")).count() >= 12, "{said}");
}
