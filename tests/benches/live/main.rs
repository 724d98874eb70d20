//! How a live preview feels: from a view or an edit to its frame, over the socket on loopback, beside the requests that
//! send the whole scene; and how many edits and frames a server takes at a time.
//!
//! Prints docs/live.md: `FOGBANK_BIN=$PWD/target/release/fogbank cargo bench -p fogbank-tests --bench live > docs/live.md`;
//! add `-- 'city|room'` to measure some presets alone, `-- crowd` for many clients alone.

#![allow(missing_docs, clippy::print_stdout, reason = "a benchmark")]

mod crowd;
mod hand;

fn main() {
    let only = std::env::args().skip(1).find(|word| !word.starts_with('-'));
    let wanted = |name: &str| {
        only.as_ref().is_none_or(|only| only.split('|').any(|part| name.contains(part)))
    };
    println!(
        "# How a live preview feels\n\n\
         Printed by one run of `cargo bench -p fogbank-tests --bench live`, over loopback, on {} cores and no GPU. Other programs\n\
         ran on the machine, so a time may be a fifth off.\n",
        std::thread::available_parallelism().map_or(1, usize::from)
    );
    hand::print(&wanted);
    if wanted("crowd") {
        crowd::print();
    }
}

/// A share of the way through some sorted times.
fn quantile(times: &mut [f64], share: f64) -> f64 {
    times.sort_by(f64::total_cmp);
    let last = times.len().saturating_sub(1);
    times.get((share * last as f64).round() as usize).copied().unwrap_or(f64::NAN)
}
