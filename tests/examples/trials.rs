//! Prints the errors of the published airlight and of `auto` on the hard scenes as a table in
//! Markdown: `cargo run --release -p fogbank-tests --example trials`.

use fogbank_core::request::Quality;
use fogbank_tests::trials::{Errors, Trial, all};

fn main() {
    println!("| scene | fogshop2007 | auto | near lamps | draft |");
    println!("|---|---|---|---|---|");
    for trial in all() {
        let isotropic = trial.scene["fog"]["phase"].is_null()
            || trial.scene["fog"]["phase"]["kind"] == "isotropic";
        let published = if isotropic { errors(&trial, "fogshop2007") } else { "–".into() };
        let auto = trial.measure("auto", Quality::Full, 600, 200);
        let near = auto.near_lamps.map_or("–".into(), words);
        let draft = words(trial.measure("auto", Quality::Draft, 600, 200).everywhere);
        let (name, title) = (&trial.name, &trial.title);
        println!(
            "| {name}: {title} | {published} | {} | {near} | {draft} |",
            words(auto.everywhere)
        );
    }
}

fn errors(trial: &Trial, airlight: &str) -> String {
    words(trial.measure(airlight, Quality::Full, 600, 200).everywhere)
}

fn words(errors: Errors) -> String {
    errors.map(|error| format!("{:.2}", 100.0 * error)).join(" / ")
}
