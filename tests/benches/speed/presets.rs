//! Every preset at its paper's size, beside its paper's figure and beside marching.

use super::clock::{Times, measure};
use super::peak::Machine;
use super::truth::Truth;
use fogbank_core::presets;
use fogbank_core::request::Quality;
use serde_json::{Value, json};

const SIZE: [u32; 2] = [800, 600];
const STEPS: u32 = 64;
/// Passes of which something is to be seen.
const PASSES: [&str; 8] = [
    "prepare",
    "surfaces",
    "light_depth",
    "low_resolution",
    "surface_radiance",
    "airlight",
    "composite",
    "encode",
];

/// Pictures a second that the papers tell (Sun 2005, section 6; Fogshop 2007, table 1), and what their cards could do at
/// most [GFLOP/s]: a GeForce 6800, 12 units of 8 flop a clock at 325 MHz and 5 of vertices, and an 8800 GTX.
const PAPERS: [(&str, f64, f64); 10] = [
    ("street-thin", 20.0, 44.0),
    ("street-thick", 20.0, 44.0),
    ("steaming-vessel", 101.0, 346.0),
    ("terrain-292", 92.0, 346.0),
    ("terrain-sky", 92.0, 346.0),
    ("city-353", 162.0, 346.0),
    ("city-sky", 162.0, 346.0),
    ("vehicle-1223", 31.0, 346.0),
    ("vehicle-sky", 31.0, 346.0),
    ("room-3008", 34.0, 346.0),
];

struct Row {
    name: &'static str,
    json: Value,
    draft: Times,
    full: Times,
}

pub fn print(machine: &Machine, wanted: &dyn Fn(&str) -> bool) {
    let rows = presets::all().into_iter().filter(|preset| wanted(preset.name)).map(|preset| {
        let json = json!(preset.scene);
        let [draft, full] = [Quality::Draft, Quality::Full].map(|how| measure(&json, SIZE, how));
        Row { name: preset.name, json, draft, full }
    });
    let rows: Vec<_> = rows.collect();
    println!(
        "## The presets, at {}×{}\n\n\
         The ratio is (our time × our peak) / (the paper's time × its card's peak): 1 is as much work a picture as the\n\
         paper's. The papers' terrain, city and vehicle were lit by a sky, as ours named after it are; the others are by lamps.\n\n\
         | preset | draft | pictures/s | full | pictures/s | paper's pictures/s | ratio, draft | ratio, full |\n\
         |---|---|---|---|---|---|---|---|",
        SIZE[0], SIZE[1]
    );
    rows.iter().for_each(|row| row.print_times(machine));
    println!("\nPass by pass, drafts and full pictures:\n\n| preset | {} |", PASSES.join(" | "));
    println!("|---|{}", "---|".repeat(PASSES.len()));
    rows.iter().for_each(Row::print_passes);
    println!(
        "\nErrors of the airlight in per cent, median / 95th percentile on 64 rays, and beside them {STEPS} steps of marching\n\
         along the same rays: what they would take for the whole picture, in extinction and shadowing fog that is formed\n\
         exactly at every step, and its errors.\n\n\
         | preset | draft | full | march {STEPS}, ms | march {STEPS} |\n|---|---|---|---|---|"
    );
    rows.iter().for_each(Row::print_errors);
}

impl Row {
    fn print_times(&self, machine: &Machine) {
        let Self { name, draft, full, .. } = self;
        let Some((_, paper, card)) = PAPERS.iter().find(|(of, ..)| of == name) else { return };
        let ratio = |ms: f64| ms * machine.peak / (1e3 / paper * card);
        let second = |ms: f64| 1e3 / ms;
        println!(
            "| {name} | {:.0} | {:.0} | {:.0} | {:.1} | {paper:.0} | {:.1} | {:.1} |",
            draft.whole,
            second(draft.whole),
            full.whole,
            second(full.whole),
            ratio(draft.whole),
            ratio(full.whole)
        );
    }

    fn print_passes(&self) {
        let cell = |pass: &&str| {
            let time = |times: &Times| {
                // With edges it has another name.
                let with_edges = format!("{pass}_and_edges");
                let found = times.passes.get(pass).or(times.passes.get(with_edges.as_str()));
                found.map_or("–".into(), |ms| format!("{ms:.0}"))
            };
            format!("{} / {}", time(&self.draft), time(&self.full))
        };
        println!("| {} | {} |", self.name, PASSES.iter().map(cell).collect::<Vec<_>>().join(" | "));
    }

    fn print_errors(&self) {
        let truth = Truth::new(&self.json, SIZE);
        let [draft, full] = [Quality::Draft, Quality::Full].map(|how| truth.of_pictures(how));
        let marched = match truth.of_marching(STEPS) {
            Some((time, errors)) => format!("{time:.0} | {errors}"),
            None => "– | –".into(),
        };
        println!("| {} | {draft} | {full} | {marched} |", self.name);
    }
}
