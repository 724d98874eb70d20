//! Prints the errors of the published airlight and of `auto` on the hard scenes as a table in
//! Markdown: `cargo run --release -p fogbank-tests --example trials`, and behind `--` a part of a scene's name.

use fogbank_core::scene::{Airlight, Scene, read};
use fogbank_tests::trials::{Errors, Trial, Use, all};

fn main() {
    println!(
        "| scene | fogshop2007 | auto | near lamps | seams | 8-bit | near lamps | seams | draft |"
    );
    println!("|---|---|---|---|---|---|---|---|---|");
    let named = std::env::args().nth(1).unwrap_or_default();
    for trial in all().into_iter().filter(|trial| trial.name.contains(&named)) {
        let mut cells = vec![if is_taken(&trial) { published(&trial) } else { "–".into() }];
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

/// Whether the published method takes the scene.
fn is_taken(trial: &Trial) -> bool {
    let Ok(scene) = read::<Scene>(trial.scene.to_string().as_bytes()) else { return false };
    scene.fog.refusal(Airlight::Fogshop2007).is_none()
}

fn published(trial: &Trial) -> String {
    words(trial.measure("fogshop2007", Use::Numbers, 600, 200).everywhere)
}

fn words(errors: Errors) -> String {
    errors.map(|error| format!("{:.2}", 100.0 * error)).join(" / ")
}
