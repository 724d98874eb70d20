//! How fast pictures are, and how right: the presets beside their papers' figures and beside marching, and how time
//! grows with pixels, blobs and lamps. All in one run, for machines are shared and noisy: ratios mean more than times.
//!
//! Prints docs/speed.md: `cargo bench -p fogbank-tests --bench speed > docs/speed.md`; add `-- 'city|room'`
//! to measure some presets alone.

#![allow(missing_docs, clippy::print_stdout, clippy::unwrap_used, reason = "a benchmark")]

mod clock;
mod families;
mod growth;
mod lights;
mod maps;
mod peak;
mod presets;
mod pruning;
mod truth;

fn main() {
    let only = std::env::args().skip(1).find(|word| !word.starts_with('-'));
    let wanted = |name: &str| {
        only.as_ref().is_none_or(|only| only.split('|').any(|part| name.contains(part)))
    };
    let machine = peak::Machine::measure();
    println!(
        "# How fast pictures are\n\n\
         Printed by one run of `cargo bench -p fogbank-tests --bench speed` on {machine}.\n\
         Times are of whole 8-bit pictures by `auto` (of the street by its own `sun2005`), from a scene that is known to\n\
         the file (JPEG of a draft, PNG at rest), while the camera moves: first hits and airlight are formed anew, light\n\
         tables are kept. Each is the median of several, in milliseconds. Other programs ran on the machine, so a time\n\
         may be a fifth off.\n"
    );
    presets::print(&machine, &wanted);
    if only.as_deref() == Some("maps") {
        maps::print(&machine);
        families::print(&machine);
        pruning::print();
    }
    if only.as_deref() == Some("lights") {
        lights::print();
    }
    if only.is_none() {
        growth::print();
        lights::print();
        maps::print(&machine);
        families::print(&machine);
        pruning::print();
    }
}
