//! Families of functions beside the table of their paper: T along the rays of pictures as large as its fog textures.

use super::maps::measure_with;
use super::peak::Machine;
use fogbank_core::presets;
use fogbank_core::request::Options;
use serde_json::{Value, json};

/// Pictures a second: with fog for every pixel of the texture, and, where it is printed, at vertices alone.
type Rates = (f64, Option<f64>);

/// Biri and Michelin 2002, Table 1, by the size of the fog texture, polynomials and a constant; without fog 50. The fog
/// was formed by an AMD Athlon of 1.4 GHz, whose peak is four operations a cycle.
const PAPER: [([u32; 2], [Rates; 2]); 5] = [
    ([512, 512], [(3.5, Some(7.0)), (6.6, Some(11.0))]),
    ([512, 256], [(6.7, Some(9.0)), (11.5, None)]),
    ([256, 256], [(12.5, Some(11.0)), (20.0, Some(23.0))]),
    ([256, 128], [(20.0, Some(12.0)), (30.0, None)]),
    ([128, 128], [(30.0, Some(12.5)), (40.0, Some(33.0))]),
];
const WITHOUT_FOG: f64 = 50.0;
const CARD: f64 = 5.6;

pub fn print(machine: &Machine) {
    println!(
        "\n## Families of functions\n\n\
         Optical depths of `valley-waves`, its two polynomials and a constant in their place, for every pixel of a fog \
         texture's size:\nwhat the pass takes [ms], and the ratio to Biri and Michelin's Table 1, whose pictures \
         take 20 ms without fog (an AMD\nAthlon of {CARD} GFLOP/s). In brackets the same with fog at vertices alone (`per_vertex`), as in theirs.\n\n\
         | pixels | polynomials | ratio | constant | ratio |\n|---|---|---|---|---|"
    );
    let valley = presets::all().into_iter().find(|preset| preset.name == "valley-waves").unwrap();
    let waves = serde_json::to_value(valley.scene).unwrap();
    let mut constant = waves.clone();
    constant["fog"]["terms"] = json!([{ "kind": "functions", "members": [
        { "kind": "cosine", "amplitude": 0.01, "wave_vector": [0, 0, 0] } ] }]);
    for (size, rates) in PAPER {
        let cell = |(json, (rate, at_vertices)): (&Value, Rates)| {
            let corners = Options { per_vertex: true, ..Options::default() };
            let [all, few] =
                [Options::default(), corners].map(|how| measure_with(how, json, size).0);
            let ratio = |ms: f64, rate: f64| {
                let paper = 1e3 / rate - 1e3 / WITHOUT_FOG;
                format!("{:.2}", ms * machine.peak / (paper * CARD))
            };
            let beside = at_vertices.map_or("–".into(), |rate| ratio(few, rate));
            format!("{all:.2} ({few:.2}) | {} ({beside})", ratio(all, rate))
        };
        let [polynomials, even] = [(&waves, rates[0]), (&constant, rates[1])].map(cell);
        println!("| {}×{} | {polynomials} | {even} |", size[0], size[1]);
    }
}
