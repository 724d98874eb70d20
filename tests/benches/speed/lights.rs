//! Each kind of light with shadows and without, on a few presets, and marching beside it; a sky, which has none.

use super::clock::measure;
use fogbank_core::airlight::Method;
use fogbank_core::presets;
use fogbank_core::request::{Layer, Quality, View};
use fogbank_core::{Frame, Progress, Renderer};
use fogbank_tests::scenes::{scene, view};
use fogbank_tests::trials::{DARK, luminance_at, quantiles, signed_errors};
use serde_json::{Value, json};
use std::time::Instant;

const SIZE: [u32; 2] = [800, 600];
/// The size at which all pixels are compared.
const SMALL: [u32; 2] = [40, 30];
/// The same under a sky, of which the integral takes about a second a ray.
const SMALLER: [u32; 2] = [8, 6];
const STEPS: u32 = 64;
const PRESETS: [&str; 3] = ["street-thick", "steaming-vessel", "city-353"];

pub fn print() {
    println!(
        "\n## Kinds of light, at {}×{}\n\n\
         The lamps of a preset as they are, as spots that look where the camera does (20 to 35 degrees), and one sun or a sky in\n\
         their place, by `auto`, with shadows and without. Errors of the airlight in per cent, median / 95th percentile of all pixels of\n\
         a picture of {}×{} ({}×{} under a sky), and beside them {STEPS} steps of marching from exact extinction, shadowing fog and shadows: what they\n\
         take for the whole picture, and their errors.\n\n\
         | preset | lights | shadows | draft, ms | full, ms | shadows' pass, ms | draft | full | march {STEPS}, ms | march {STEPS} |\n\
         |---|---|---|---|---|---|---|---|---|---|",
        SIZE[0], SIZE[1], SMALL[0], SMALL[1], SMALLER[0], SMALLER[1]
    );
    let wanted = |name: &&str| presets::all().into_iter().find(|preset| preset.name == *name);
    for preset in PRESETS.iter().filter_map(wanted) {
        for kind in ["point", "spot", "sun"] {
            for shadows in [false, true] {
                row(preset.name, &lit(json!(preset.scene), kind, shadows), kind, shadows, SMALL);
            }
        }
        row(preset.name, &lit(json!(preset.scene), "sky", false), "sky", false, SMALLER);
    }
}

/// A preset's scene with its lamps as lights of a kind.
fn lit(mut json: Value, kind: &str, shadows: bool) -> Value {
    json["fog"]["airlight"] = "auto".into();
    let at = |name: &str, k: usize| json["camera"][name][k].as_f64().unwrap();
    let ahead: Vec<f64> = (0..3).map(|k| at("target", k) - at("position", k)).collect();
    let lamps = json["lights"].as_array().unwrap();
    let lights: Vec<Value> = match kind {
        "sky" => vec![json!({ "kind": "environment", "radiance": { "kind": "gradient" } })],
        "sun" => {
            vec![json!({ "kind": "sun", "direction": [0.5, -0.6, -0.3], "irradiance": [3, 2.6, 2],
            "shadows": shadows })]
        }
        _ => lamps
            .iter()
            .map(|lamp| {
                let mut lamp = lamp.clone();
                lamp["kind"] = kind.into();
                lamp["shadows"] = shadows.into();
                if kind == "spot" {
                    lamp["direction"] = json!(ahead);
                    lamp["inner_angle_deg"] = json!(20);
                    lamp["outer_angle_deg"] = json!(35);
                }
                lamp
            })
            .collect(),
    };
    json["lights"] = json!(lights);
    json
}

fn row(name: &str, json: &Value, kind: &str, shadows: bool, small: [u32; 2]) {
    let [draft, full] = [Quality::Draft, Quality::Full].map(|how| measure(json, SIZE, how));
    let pass = full.passes.get("shadows").copied().unwrap_or_default();
    let picture = |quality: Quality, estimator: Option<Method>| -> (Frame, f64) {
        let view = View {
            for_screen: estimator.is_none(),
            estimator,
            ..view(small[0], small[1], Layer::Airlight, quality)
        };
        let since = Instant::now();
        let frame = Renderer::default().render(&scene(json), &view, &Progress::default()).unwrap();
        (frame, since.elapsed().as_secs_f64() * 1e3)
    };
    let count = (small[0] * small[1]) as usize;
    let values = |frame: &Frame| (0..count).map(|at| luminance_at(frame, at)).collect::<Vec<_>>();
    let exact = values(&picture(Quality::Full, Some(Method::Reference)).0);
    let off = |frame: &Frame| {
        let errors = signed_errors(values(frame).into_iter(), &exact, DARK);
        let [median, p95, _] = quantiles(errors.into_iter().map(f64::abs).collect());
        format!("{:.2} / {:.1}", 100.0 * median, 100.0 * p95)
    };
    let (marched, took) = picture(Quality::Full, Some(Method::March(STEPS)));
    let whole = took * f64::from(SIZE[0] * SIZE[1]) / count as f64;
    println!(
        "| {name} | {kind} | {} | {:.0} | {:.0} | {pass:.0} | {} | {} | {whole:.0} | {} |",
        if shadows { "yes" } else { "no" },
        draft.whole,
        full.whole,
        off(&picture(Quality::Draft, None).0),
        off(&picture(Quality::Full, None).0),
        off(&marched)
    );
}
