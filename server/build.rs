//! Rebuilds the binary when a file of the page comes, changes or goes.

#[allow(clippy::print_stdout, reason = "this is how a build script speaks to cargo")]
fn main() {
    println!("cargo::rerun-if-changed=../web");
}
