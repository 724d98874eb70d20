//! Prints the errors of the published airlight and of `auto` on the hard scenes as a table in
//! Markdown: `cargo run --release -p fogbank-tests --example trials`.

use fogbank_tests::trials::{Errors, Trial, Use, all};

fn main() {
    println!(
        "| scene | fogshop2007 | auto | near lamps | seams | 8-bit | near lamps | seams | draft |"
    );
    println!("|---|---|---|---|---|---|---|---|---|");
    for trial in all() {
        let isotropic = trial.scene["fog"]["phase"].is_null()
            || trial.scene["fog"]["phase"]["kind"] == "isotropic";
        let mut cells = vec![if isotropic { published(&trial) } else { "–".into() }];
        for wanted in [Use::Numbers, Use::Screen] {
            let auto = trial.measure("auto", wanted, 600, 200);
            cells.push(words(auto.everywhere));
            cells.push(auto.near_lamps.map_or("–".into(), words));
            cells.push(words(auto.seams));
        }
        cells.push(words(trial.measure("auto", Use::Draft, 600, 200).everywhere));
        println!("| {}: {} | {} |", trial.name, trial.title, cells.join(" | "));
    }
}

fn published(trial: &Trial) -> String {
    words(trial.measure("fogshop2007", Use::Numbers, 600, 200).everywhere)
}

fn words(errors: Errors) -> String {
    errors.map(|error| format!("{:.2}", 100.0 * error)).join(" / ")
}
