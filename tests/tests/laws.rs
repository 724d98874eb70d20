//! Laws that hold for every medium and every airlight, whatever their numbers.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::print_stdout,
    reason = "a test stops where it fails, and says what it measured"
)]

use fogbank_core::airlight::{march, reference, sun2005};
use fogbank_core::geometry::Ray;
use fogbank_core::light::{Source, point::Place};
use fogbank_core::media::{Field, Moment, Velocity, Wind};
use fogbank_core::phase::PhaseFunction;
use fogbank_core::request::{Layer, ProbeRay, Quality};
use fogbank_core::scene::{CheckedScene, Fog, read};
use fogbank_tests::fields::variants;
use fogbank_tests::quadrature::integrate;
use fogbank_tests::scenes::*;
use glam::DVec3;
use serde_json::{Value, json};
use std::collections::BTreeSet;
use std::f64::consts::PI;

/// Kinds of fog that laws take in turn.
const KINDS: u64 = 9;

/// Rounds of each law: a round takes new fog and new points.
const ROUNDS: u64 = 60;

/// Relative rounding of an optical depth. A blob of radius 0.2 seen from 20 m away is at most 100 of
/// its radii off; the square of that in its exponent amplifies 2⁻⁵² to 1e-11.
const ROUNDING: f64 = 1e-10;

/// Terms of all media and of their sums, in turn.
fn terms(random: &mut Random, round: u64) -> Vec<Value> {
    let even = homogeneous(random.decades(1e-4, 3.0));
    let blobs = random.blobs(6, 5.0, [0.2, 4.0], [0.01, 3.0]);
    match round % KINDS {
        0 => vec![even],
        1 => vec![blobs],
        2 => vec![even, blobs],
        3 => layers(random),
        4 => vec![functions(random)],
        5 => vec![functions(random), blobs],
        6 => vec![fogmap(random)],
        7 => vec![fogmap(random), functions(random), even],
        _ => [layers(random), vec![even, blobs]].concat(),
    }
}

/// Fog that changes with height: a slab and an exponential.
fn layers(random: &mut Random) -> Vec<Value> {
    let min = random.between(-4.0, 2.0);
    let slab = json!({ "kind": "slab", "min_m": min, "max_m": min + random.decades(0.1, 4.0) });
    let base = random.between(-4.0, 4.0);
    let falloff = random.decades(1e-3, 3.0);
    let exponential = json!({ "kind": "exponential", "base_m": base, "falloff_per_m": falloff });
    let layer = |random: &mut Random, vertical: Value| json!({ "kind": "homogeneous", "extinction": random.decades(1e-3, 3.0), "vertical": vertical });
    vec![layer(random, slab), layer(random, exponential)]
}

/// Families of functions: two waves over a constant, polynomials with and without a period, fog around objects.
fn functions(random: &mut Random) -> Value {
    let wave = |random: &mut Random| {
        json!({ "kind": "cosine", "amplitude": random.between(-0.1, 0.1),
        "wave_vector": random.point(2.0).to_array(), "phase_rad": random.between(-9.0, 9.0) })
    };
    let object = match random.bits() % 3 {
        0 => json!({ "kind": "point", "position": random.point(4.0).to_array() }),
        1 => json!({ "kind": "line", "position": random.point(4.0).to_array(),
                     "direction": random.direction().to_array() }),
        _ => json!({ "kind": "sphere", "center": random.point(4.0).to_array(),
                     "radius": random.decades(0.3, 2.0) }),
    };
    let period = [0; 3].map(|_| random.decades(1.0, 8.0));
    let members = json!([
        { "kind": "cosine", "amplitude": 0.2, "wave_vector": [0, 0, 0] },
        wave(random),
        wave(random),
        { "kind": "polynomial", "period_m": [period[0], null, null], "monomials": [
            { "powers": [2, 0, 0], "coefficient": 0.3 }, { "coefficient": 0.1 }] },
        { "kind": "polynomial", "period_m": [null, period[1], period[2]], "monomials": [
            { "powers": [0, 2, 1], "coefficient": 0.4 }] },
        { "kind": "polynomial", "repeat": false, "period_m": period, "monomials": [
            { "powers": [1, 0, 2], "coefficient": 0.8 }, { "coefficient": 0.1 }] },
        { "kind": "equipotential", "object": object, "strength": random.decades(0.1, 1.0),
          "c": random.decades(0.5, 2.0), "d": random.decades(0.5, 4.0) },
    ]);
    json!({ "kind": "functions", "scale": random.decades(0.1, 3.0), "members": members })
}

/// A map of any degree, everywhere the same in height, in a slab, or thinning out.
fn fogmap(random: &mut Random) -> Value {
    let (columns, rows) = (2 + random.bits() % 4, 2 + random.bits() % 4);
    let row =
        |random: &mut Random| (0..columns).map(|_| random.between(0.0, 1.0)).collect::<Vec<_>>();
    let coefficients: Vec<_> = (0..rows).map(|_| row(random)).collect();
    let (base, falloff) = (random.between(-4.0, 4.0), random.decades(1e-3, 3.0));
    let vertical = match random.bits() % 3 {
        0 => json!({ "kind": "uniform" }),
        1 => json!({ "kind": "slab", "min_m": base, "max_m": base + 2.0 }),
        _ => json!({ "kind": "exponential", "base_m": base, "falloff_per_m": falloff }),
    };
    json!({ "kind": "fogmap", "degree": random.bits() % 3, "cell_m": random.decades(0.8, 2.5),
        "origin": [random.between(-6.0, 0.0), random.between(-6.0, 0.0)],
        "scale": random.decades(0.03, 1.0), "coefficients": coefficients, "vertical": vertical })
}

/// A point lamp there.
fn lamp(at: DVec3) -> Source {
    Source::Point(Place(at))
}

/// Planes at which fog jumps or kinks: the axis that they stand across, and where.
fn edges(terms: &[Value]) -> Vec<(usize, f64)> {
    /// No way of a law leads farther from the origin [m].
    const REACH: f64 = 12.0;
    let heights = ["min_m", "max_m", "base_m"];
    let of_layer = |term: &Value| heights.map(|name| term["vertical"][name].as_f64());
    let mut edges: Vec<_> =
        terms.iter().flat_map(of_layer).flatten().map(|height| (1, height)).collect();
    for map in terms.iter().filter(|term| term["kind"] == "fogmap") {
        let (degree, cell) = (map["degree"].as_u64().unwrap(), map["cell_m"].as_f64().unwrap());
        let rows = map["coefficients"].as_array().unwrap();
        let counts = [rows[0].as_array().unwrap().len(), rows.len()];
        for (k, axis) in [0, 2].into_iter().enumerate() {
            let first = map["origin"][k].as_f64().unwrap();
            let sides = 0..=counts[k] + degree as usize;
            edges.extend(sides.map(|i| (axis, first + cell * i as f64)));
        }
    }
    let members = terms.iter().filter_map(|term| term["members"].as_array()).flatten();
    for member in members.filter(|member| member["kind"] == "polynomial") {
        for axis in 0..3 {
            let Some(period) = member["period_m"][axis].as_f64() else { continue };
            let most = if member["repeat"] == false { 1.0 } else { (REACH / period).ceil() };
            let borders = (0..most as u32).map(|i| (f64::from(i) + 0.5) * period);
            edges.extend(borders.flat_map(|at| [(axis, -at), (axis, at)]));
        }
    }
    edges
}

/// ∫ f over a straight way through fog, piece by piece between its edges.
fn integrate_between_edges(
    terms: &[Value],
    point: impl Fn(f64) -> DVec3,
    [from, to]: [f64; 2],
    f: &dyn Fn(f64) -> f64,
) -> f64 {
    let place = |(axis, edge): (usize, f64)| {
        let (low, high) = (point(from)[axis], point(to)[axis]);
        if !(low.min(high) < edge && edge < low.max(high)) {
            return None;
        }
        // A coordinate grows or falls along the way: where it passes an edge is found by halving.
        let (mut a, mut b) = (from, to);
        for _ in 0..200 {
            let middle = 0.5 * (a + b);
            if (point(middle)[axis] < edge) == (low < high) { a = middle } else { b = middle }
        }
        Some(0.5 * (a + b))
    };
    let mut ends: Vec<_> = edges(terms).into_iter().filter_map(place).collect();
    ends.extend([from, to]);
    ends.sort_unstable_by(f64::total_cmp);
    ends.windows(2).map(|pair| integrate(pair[0], pair[1], f)).sum()
}

fn for_fields(mut law: impl FnMut(&mut Random, &[Value], &Field)) {
    for round in 0..ROUNDS {
        let mut random = Random(round);
        let terms = terms(&mut random, round);
        law(&mut random, &terms, &field(&terms));
    }
}

#[track_caller]
fn assert_close(what: &str, a: f64, b: f64, relative: f64, absolute: f64) {
    let allowed = relative * b.abs() + absolute;
    // An infinite expectation would allow anything.
    assert!(
        b.is_finite() && (a - b).abs() <= allowed,
        "{what}: {a} instead of {b}, {:.1e} off",
        (a / b - 1.0).abs()
    );
}

fn blobs_of(term: &mut Value) -> Option<&mut Vec<Value>> {
    term.get_mut("blobs")?.as_array_mut()
}

/// Scales every extinction of a term.
fn thicker(term: &Value, factor: f64) -> Value {
    let mut term = term.clone();
    let scale = |value: &mut Value| *value = json!(value.as_f64().unwrap() * factor);
    if term["kind"] == "functions" || term["kind"] == "fogmap" {
        scale(&mut term["scale"]);
        return term;
    }
    match blobs_of(&mut term) {
        Some(blobs) => blobs.iter_mut().for_each(|blob| scale(&mut blob["extinction"])),
        None => scale(&mut term["extinction"]),
    }
    term
}

/// The field of some terms, all moved.
fn moved(terms: &[Value], offset: DVec3) -> Field {
    let fog: Fog = read(json!({ "terms": terms }).to_string().as_bytes()).expect("a fog");
    // A second of wind.
    let wind = Wind { velocity: Some(Velocity(offset.to_array())), keys: None };
    Field::new(&fog.terms, 0, &Moment { time_s: 1.0, wind, ..Moment::default() })
}

/// Fog only takes light away: no optical depth is negative.
#[test]
fn optical_depths_are_not_negative() {
    for_fields(|random, _, field| {
        for _ in 0..50 {
            let (a, b) = (random.point(20.0), random.point(20.0));
            let depth = field.depth_between(a, b);
            assert!(depth >= 0.0 && depth.is_finite(), "{depth}");
            assert_eq!(field.depth_between(a, a), 0.0);
        }
    });
}

/// What a path meets is the sum of what its parts meet: T(a,b) + T(b,c) = T(a,c).
#[test]
fn optical_depths_of_parts_add() {
    for_fields(|random, _, field| {
        for _ in 0..50 {
            let (a, c) = (random.point(10.0), random.point(10.0));
            let b = a.lerp(c, random.between(0.0, 1.0));
            let parts = field.depth_between(a, b) + field.depth_between(b, c);
            // A part may hold only a far tail; its rounding counts against what lies nearby.
            assert_close("parts", parts, field.depth_between(a, c), ROUNDING, 1e-13);
        }
    });
}

/// Fog takes as much from light that comes as from light that goes: T(a,b) = T(b,a).
#[test]
fn optical_depths_are_symmetric() {
    for_fields(|random, _, field| {
        for _ in 0..50 {
            let (a, b) = (random.point(10.0), random.point(10.0));
            let there = field.depth_between(a, b);
            assert_close("back", field.depth_between(b, a), there, ROUNDING, 1e-13);
        }
    });
}

/// Twice as many droplets take twice as much: T and β are linear in extinction.
#[test]
fn optical_depths_are_linear_in_extinction() {
    for_fields(|random, terms, thin| {
        let factor = random.decades(0.01, 100.0);
        let thick = field(&terms.iter().map(|t| thicker(t, factor)).collect::<Vec<_>>());
        for _ in 0..50 {
            let (a, b) = (random.point(10.0), random.point(10.0));
            // The factor is a factor of every term: only its product rounds.
            let depth = factor * thin.depth_between(a, b);
            assert_close("T", thick.depth_between(a, b), depth, 1e-14, 0.0);
            assert_close("β", thick.beta(a), factor * thin.beta(a), 1e-14, 0.0);
        }
    });
}

/// Extinction is what a path of optical depth gains with each metre: β = dT/ds.
#[test]
fn extinction_is_the_derivative_of_optical_depth() {
    const STEP: f64 = 1e-4;
    for_fields(|random, _, field| {
        for _ in 0..50 {
            let (x, along) = (random.point(6.0), random.direction());
            let ray = Ray { origin: x - STEP * along, direction: along };
            let slope = field.depth(&ray, 2.0 * STEP) / (2.0 * STEP);
            // The mean over ±h differs from the middle by h²/6 · β″, and |β″| ≤ 2c/radius² = 150/m³
            // a blob: 3e-7 for the sharpest one, one after the other.
            assert_close("β", slope, field.beta(x), 1e-10, 1e-6);
        }
    });
}

/// Two fogs in the same place take what each would take alone.
#[test]
fn overlapping_terms_add() {
    for round in 0..ROUNDS {
        let mut random = Random(round);
        let (a, b) = (terms(&mut random, round), terms(&mut random, round / 3));
        let [fog_a, fog_b, both] = [&a[..], &b, &[&a[..], &b].concat()].map(field);
        for _ in 0..50 {
            let (p, q) = (random.point(10.0), random.point(10.0));
            let alone = fog_a.depth_between(p, q) + fog_b.depth_between(p, q);
            // The same numbers summed in another order.
            assert_close("T", both.depth_between(p, q), alone, 1e-14, 0.0);
            assert_close("β", both.beta(p), fog_a.beta(p) + fog_b.beta(p), 1e-14, 0.0);
        }
    }
}

/// Space has no marked place: fog that the wind has moved answers the same to rays that it moved, too.
#[test]
fn a_common_move_changes_nothing() {
    for_fields(|random, terms, here| {
        let offset = random.point(1000.0);
        let there = moved(terms, offset);
        for _ in 0..50 {
            let (a, b) = (random.point(10.0), random.point(10.0));
            let depth = there.depth_between(a + offset, b + offset);
            // Coordinates near 1 km round to 1e-13 m: 5e-13 of the smallest radius, and up to 100
            // radii away its square changes by 1e-10.
            assert_close("T", depth, here.depth_between(a, b), 1e-9, 1e-12);
        }
    });
}

/// Optical depth is the integral of extinction: closed forms against adaptive quadrature of β.
#[test]
fn optical_depth_is_the_integral_of_extinction() {
    for_fields(|random, terms, field| {
        for _ in 0..10 {
            let (a, b) = (random.point(8.0), random.point(8.0));
            let length = a.distance(b);
            let along = (b - a) / length;
            let point = |t: f64| a + t * along;
            let beta = |t: f64| field.beta(a + t * along);
            let integral = integrate_between_edges(terms, point, [0.0, length], &beta);
            // Both sides are exact to 1e-10 or better.
            assert_close("T", field.depth_between(a, b), integral, 1e-9, 1e-13);
        }
    });
}

/// Every estimator, with the kinds of fog that it takes: homogeneous, Gaussians, both, layers, functions,
/// functions with Gaussians, a map, a map with functions, layers with Gaussians.
const AIRLIGHTS: [(&str, &[u64]); 6] = [
    ("none", &[0, 1, 2, 3, 4, 5, 6, 7, 8]),
    ("sun2005", &[0]),
    ("macklin2010", &[0]),
    ("fogshop2007", &[0, 1, 2]),
    ("reference", &[0, 1, 2, 3, 4, 5, 6, 7, 8]),
    ("auto", &[0, 1, 2, 3, 4, 5, 6, 7, 8]),
];

/// No estimator is left out.
#[test]
fn the_laws_hold_for_every_airlight() {
    let named: BTreeSet<_> = AIRLIGHTS.iter().map(|(name, _)| (*name).to_owned()).collect();
    assert_eq!(named, variants("Airlight").into_iter().collect());
}

/// The law for each estimator in all fogs that it takes, a few times.
fn for_airlights(mut law: impl FnMut(&mut Random, &str, &mut Value)) {
    for (method, media) in AIRLIGHTS {
        for round in 0..4 {
            for medium in media {
                let mut random = Random(round);
                let terms = terms(&mut random, *medium);
                let albedo = [0; 3].map(|_| random.between(0.1, 1.0));
                let lights = random.lamps(3, 6.0);
                law(
                    &mut random,
                    &format!("{method}, round {round}, medium {medium}"),
                    &mut json!({ "lights": lights, "far_m": 50, "fog": {
                        "airlight": method, "terms": terms, "albedo": albedo } }),
                );
            }
        }
    }
}

fn rays(random: &mut Random) -> Vec<ProbeRay> {
    (0..6).map(|_| segment(random.point(8.0), random.point(8.0))).collect()
}

fn airlights(scene: &Value, rays: &[ProbeRay]) -> Vec<DVec3> {
    probe(&crate::scene(scene), rays).iter().map(|answer| answer.airlight.vector()).collect()
}

#[track_caller]
fn assert_same(what: &str, a: &[DVec3], b: &[DVec3], relative: f64) {
    assert_eq!(a.len(), b.len(), "{what}");
    for (a, b) in a.iter().zip(b) {
        (0..3).for_each(|k| assert_close(what, a[k], b[k], relative, 0.0));
    }
}

fn scaled(triple: &Value, factor: f64) -> Value {
    json!([0, 1, 2].map(|k| triple[k].as_f64().unwrap() * factor))
}

/// Clear air does not glow, however it is written.
#[test]
fn without_fog_there_is_no_airlight() {
    for_airlights(|random, what, scene| {
        let rays = rays(random);
        let empty = [
            json!([]),
            json!([homogeneous(0.0)]),
            json!([{ "kind": "homogeneous", "extinction": 1, "enabled": false }]),
        ];
        for terms in empty {
            scene["fog"]["terms"] = terms;
            assert!(airlights(scene, &rays).iter().all(|v| *v == DVec3::ZERO), "{what}");
        }
    });
}

/// Light adds: no ray gets a negative or endless amount, not even through a lamp.
#[test]
fn airlight_is_finite_and_not_negative() {
    for_airlights(|random, what, scene| {
        let lamp = random.point(5.0);
        // Polynomials of several variables take their time, period by period.
        let repeats = scene["fog"]["terms"].to_string().contains("polynomial");
        let far = if repeats { 1e2 } else { 1e9 };
        scene["lights"][0]["position"] = json!(lamp.to_array());
        // A blob around a lamp, and a lamp far away from everything.
        scene["lights"][1]["position"] = json!([far, -far, far]);
        if let Some(blobs) = blobs_of(&mut scene["fog"]["terms"][0]) {
            blobs[0]["center"] = json!(lamp.to_array());
        }
        let aside = lamp + random.direction();
        let mut rays = rays(random);
        rays.push(segment(aside, 2.0 * lamp - aside));
        rays.push(segment(aside, lamp));
        rays.push(segment(lamp, aside));
        let toward = (lamp - aside).normalize();
        for distance in [0.0, 1e-300, 1e-9, 1.0 - 1e-12, 1.0, far] {
            let max_distance_m = Some(distance);
            rays.push(ProbeRay { origin: aside, direction: toward, max_distance_m });
            rays.push(ProbeRay { origin: lamp, direction: -toward, max_distance_m });
            rays.push(ProbeRay { origin: aside, direction: -toward, max_distance_m });
        }
        for (airlight, ray) in airlights(scene, &rays).into_iter().zip(&rays) {
            assert!(airlight.is_finite() && airlight.min_element() >= 0.0, "{what}: {airlight}");
            if ray.max_distance_m == Some(0.0) {
                assert_eq!(airlight, DVec3::ZERO, "{what}: no path, no light");
            }
        }
    });
}

/// A lamp twice as bright, or a fog that absorbs half, changes its glow by just that factor.
#[test]
fn airlight_is_linear_in_intensity_and_albedo() {
    for_airlights(|random, what, scene| {
        let rays = rays(random);
        let before = airlights(scene, &rays);
        let factor = random.decades(1e-3, 1.0);
        let expected: Vec<_> = before.iter().map(|v| factor * *v).collect();
        let mut dimmed = scene.clone();
        for light in dimmed["lights"].as_array_mut().unwrap() {
            light["intensity"] = scaled(&light["intensity"], factor);
        }
        // Products round, and nothing else.
        assert_same(what, &airlights(&dimmed, &rays), &expected, 1e-14);
        let mut darker = scene.clone();
        darker["fog"]["albedo"] = scaled(&scene["fog"]["albedo"], factor);
        assert_same(what, &airlights(&darker, &rays), &expected, 1e-14);
    });
}

/// Light does not see light: the glow of many lamps is the sum of their glows.
#[test]
fn airlight_adds_over_lights() {
    for_airlights(|random, what, scene| {
        let rays = rays(random);
        let all = probe(&crate::scene(scene), &rays);
        let lights = scene["lights"].clone();
        let mut sums = vec![DVec3::ZERO; rays.len()];
        for (i, light) in lights.as_array().unwrap().iter().enumerate() {
            scene["lights"] = json!([light]);
            let alone = airlights(scene, &rays);
            let shares: Vec<_> = all.iter().map(|a| a.airlight_by_light[i].vector()).collect();
            assert_same(what, &shares, &alone, 0.0);
            sums.iter_mut().zip(alone).for_each(|(sum, alone)| *sum += alone);
        }
        let airlight: Vec<_> = all.iter().map(|a| a.airlight.vector()).collect();
        assert_same(what, &airlight, &sums, 1e-14);
    });
}

/// Fog between lamp, air and eye only takes light away: ∫ β/(4π d²) is more than any ray gets.
#[test]
fn airlight_stays_below_what_no_fog_attenuates() {
    for_airlights(|random, what, scene| {
        // The published method exceeds it next to a lamp close to a blob.
        if what.starts_with("fogshop2007") && !what.ends_with("medium 0") {
            return;
        }
        let estimated = what.starts_with("auto") && !what.ends_with("medium 0");
        let field = field(scene["fog"]["terms"].as_array().unwrap());
        scene["fog"]["albedo"] = json!([1, 1, 1]);
        scene["lights"] = json!([{ "kind": "point", "position": random.point(6.0).to_array(),
                                   "intensity": [1, 1, 1] }]);
        let light = crate::scene(scene).lamps().next().unwrap().1.source.place();
        let rays = rays(random);
        for (airlight, ray) in airlights(scene, &rays).iter().zip(&rays) {
            let closest = (light - ray.origin).dot(ray.direction);
            let miss = (light - ray.origin).cross(ray.direction).length();
            let angle = |t: f64| ((t - closest) / miss).atan();
            // With t = h tan θ, dt/d² is dθ/h.
            let glow = |angle: f64| {
                let t = closest + miss * angle.tan();
                field.beta(ray.origin + t * ray.direction) / (4.0 * PI * miss)
            };
            let length = ray.max_distance_m.unwrap();
            let bound = integrate(angle(0.0), angle(length), &glow);
            // sun2005 is exact to 7e-5, `auto` to 2e-2; where there is next to no fog nothing is
            // taken away.
            let spare = if estimated { 2e-2 } else { 1e-4 };
            assert!(airlight.x <= bound * (1.0 + spare), "{what}: {} > {bound}", airlight.x);
        }
    });
}

/// Where no blob is, Fogshop's method is Sun's, of which it takes its homogeneous part.
#[test]
fn fogshop_without_blobs_is_sun() {
    for round in 0..ROUNDS {
        let mut random = Random(round);
        let terms = json!([homogeneous(random.decades(1e-4, 3.0))]);
        let lights = random.lamps(2, 6.0);
        let rays = rays(&mut random);
        let airlight = |method: &str| {
            let fog = json!({ "airlight": method, "terms": terms });
            airlights(&json!({ "lights": lights, "fog": fog }), &rays)
        };
        assert_eq!(airlight("fogshop2007"), airlight("sun2005"));
    }
}

/// Sun's closed form is the airlight integral at every angle: along the ray to the lamp, past it,
/// aside of it and away from it, in thin and dense fog, ending before and behind the lamp.
#[test]
fn sun_is_the_integral_at_every_angle() {
    const ANGLES: u32 = 48;
    let even = (1..ANGLES).map(|i| PI * f64::from(i) / f64::from(ANGLES));
    let edges = [0.0, 1e-6, 1e-4, 1e-3, 0.01];
    let gammas: Vec<_> = edges.into_iter().chain(even).chain(edges.map(|edge| PI - edge)).collect();
    let distance = 5.0;
    let mut worst = 0.0f64;
    for thickness in [1e-3, 0.01, 0.1, 0.3, 1.0, 3.0, 10.0, 30.0] {
        let beta = thickness / distance;
        let fog = field(&[homogeneous(beta)]);
        for end in [0.01, 0.3, 0.9, 0.999, 1.001, 1.1, 2.0, 10.0, 100.0, 1000.0] {
            for gamma in &gammas {
                let light = distance * DVec3::new(gamma.sin(), 0.0, gamma.cos());
                let length = end * distance;
                let exact = reference::airlight(
                    &fog,
                    PhaseFunction::ISOTROPIC,
                    lamp(light),
                    Ray { origin: DVec3::ZERO, direction: DVec3::Z },
                    length,
                );
                let closed = sun2005::airlight(
                    beta,
                    lamp(light).beside(DVec3::ZERO.into(), DVec3::Z.into()),
                    length,
                );
                let error = (closed / exact - 1.0).abs();
                assert!(
                    error <= 1e-3,
                    "γ {gamma}, β·D {thickness}, end {end}: {closed} instead of {exact}"
                );
                worst = worst.max(error);
            }
        }
    }
    println!("sun2005 differs from reference by at most {worst:.1e}");
}

/// The reference is the integral for every phase function: against a rule of another kind, in another
/// variable (the angle around the lamp), through homogeneous fog and Gaussians. Both are smooth in
/// theirs, so that little more than rounding lies between them.
#[test]
fn reference_is_the_integral_for_every_phase_function() {
    for_fields(|random, terms, fog| {
        let (from, to, light) = (random.point(6.0), random.point(6.0), random.point(6.0));
        let (length, direction) = (from.distance(to), (to - from).normalize());
        let closest = (light - from).dot(direction);
        let miss = (light - from).cross(direction).length();
        for g in [-0.99, -0.5, 0.5, 0.99] {
            let phase = PhaseFunction { g };
            let glow = |angle: f64| {
                let x = from + (closest + miss * angle.tan()) * direction;
                let depth = fog.depth_between(from, x) + fog.depth_between(light, x);
                let cos = (x - light).normalize().dot(-direction);
                fog.beta(x) * phase.value(cos) * (-depth).exp() / miss
            };
            let angle = |t: f64| ((t - closest) / miss).atan();
            let point = |angle: f64| from + (closest + miss * angle.tan()) * direction;
            let ends = [angle(0.0), angle(length)];
            let sum = integrate_between_edges(terms, point, ends, &glow);
            let ray = Ray { origin: from, direction };
            let exact = reference::airlight(fog, phase, lamp(light), ray, length);
            // Corners of cells and periods between the light and the ray kink the shade, which neither rule knows:
            // there the reference is as exact as it asks to be.
            let has_corners =
                terms.iter().any(|term| term["kind"] == "functions" || term["kind"] == "fogmap");
            let allowed = if has_corners { 1e-7 } else { 1e-9 };
            assert_close(&format!("g = {g}"), exact, sum, allowed, 1e-30);
        }
    });
}

/// Ray marching comes to the reference as its steps grow, in proportion to them: a step's light is
/// attenuated as at its beginning, which is off by half its own optical depth. Next to a lamp steps
/// would have to be shorter than its distance from the ray: those rays are left out.
#[test]
fn marching_comes_to_the_reference_step_by_step() {
    let mut checked = 0;
    for_fields(|random, terms, fog| {
        let (from, to, light) = (random.point(6.0), random.point(6.0), random.point(6.0));
        let (length, direction) = (from.distance(to), (to - from).normalize());
        if (light - from).cross(direction).length() < 0.5 {
            return;
        }
        checked += 1;
        let phase = PhaseFunction { g: 0.4 };
        let ray = Ray { origin: from, direction };
        let exact = reference::airlight(fog, phase, lamp(light), ray, length);
        let march = |steps| march::airlight(fog, phase, lamp(light), ray, length, steps);
        let error = |steps| (march(steps) - exact).abs();
        let betas = (0..=1000).map(|i| fog.beta(from + length * f64::from(i) / 1e3 * direction));
        let peak = betas.fold(0.0, f64::max);
        // Where fog jumps, what a step misses depends on where in it that is: up to half a step of what
        // is scattered there, k(α) straight ahead at the ray's distance from the lamp.
        let miss = (light - from).cross(direction).length();
        let jump = 0.5 * peak * length * phase.value(1.0) / (miss * miss);
        let jumps = edges(terms).len() as f64 * jump;
        for steps in [1024, 4096] {
            // Half the depth of the densest step; its middle's own error falls with the square.
            let allowed =
                exact * (0.51 * peak * length / f64::from(steps) + 1e-4) + jumps / f64::from(steps);
            assert!(error(steps) <= allowed, "{steps}: {} of {exact}", error(steps));
        }
        assert!(!edges(terms).is_empty() || error(4096) <= 0.3 * error(1024) + 1e-6 * exact);
    });
    assert!(checked > 30);
}

/// The sign of g: above 0 the fog glows when one looks towards the lamp, below 0 away from it.
#[test]
fn fog_glows_towards_the_light_where_g_is_positive() {
    let airlight = |g: f64, direction: [f64; 3]| {
        let scene = json!({
            "lights": [{ "kind": "point", "position": [1, 0, -9], "shadows": false }],
            "fog": { "phase": { "kind": "henyey_greenstein", "g": g },
                     "terms": [homogeneous(0.05)] },
        });
        let direction = DVec3::from(direction);
        let ray = ProbeRay { origin: DVec3::ZERO, direction, max_distance_m: Some(8.0) };
        airlights(&scene, &[ray])[0].x
    };
    let (ahead, back) = ([0.0, 0.0, -1.0], [0.0, 0.0, 1.0]);
    assert!(airlight(0.7, ahead) > 2.0 * airlight(0.0, ahead));
    assert!(airlight(0.7, back) < 0.5 * airlight(0.0, back));
    assert_eq!(airlight(0.0, ahead), airlight(-0.0, ahead));
    assert!(airlight(-0.7, back) > 2.0 * airlight(0.0, back));
}

/// What an f32 ray leaves open: its direction, the places that are compared with it and their
/// products each round by 6e-8, and two dozen of them make a distance from the ray.
const RAY_ROUNDING: f64 = 2e-6;

/// The layers with the relative difference from f64 that they may have, and an absolute one, for
/// light in units of the picture's brightest value. Optical depth: what culling may drop. Light:
/// four digits are more than 8 bits or an eye tell apart, and below 1e-6 of the brightest value
/// lies what culled blobs scatter.
const LAYERS: [(Layer, f64, f64); 5] = [
    (Layer::OpticalDepth, 1e-4, 1e-5),
    (Layer::Airlight, 1e-3, 1e-6),
    (Layer::Surface, 1e-3, 1e-6),
    (Layer::Depth, 1e-3, 0.0),
    (Layer::Beauty, 1e-3, 1e-6),
];

/// The layers' values along rays, in the order of [`LAYERS`].
fn exact(scene: &CheckedScene, rays: &[ProbeRay]) -> Vec<[[f64; 3]; 5]> {
    let values = |answer: fogbank_core::probe::RayAnswer| {
        let surface = answer.hit.as_ref().map_or(scene.background.0, |h| h.surface_radiance.0);
        let depth = answer.hit.as_ref().map_or(scene.far_m, |hit| hit.distance_m);
        [answer.optical_depth.channels(), answer.airlight.0, surface, [depth; 3], answer.radiance.0]
    };
    probe(scene, rays).into_iter().map(values).collect()
}

/// The ray turned and shifted by what rounding leaves open.
fn rounded(ray: &ProbeRay) -> Vec<ProbeRay> {
    let (right, up) = ray.direction.any_orthonormal_pair();
    let turn = |k: u32| {
        let (sin, cos) = (PI / 4.0 * f64::from(k)).sin_cos();
        let direction = (ray.direction + RAY_ROUNDING * (sin * right + cos * up)).normalize();
        ProbeRay { direction, ..*ray }
    };
    (0..8).map(turn).collect()
}

/// Compares all layers of a small picture with its pixels' probes.
fn compare(name: &str, json: &Value) {
    compare_pixels(name, json, (32, 24));
}

fn compare_pixels(name: &str, json: &Value, size: (u32, u32)) {
    let mut published = json.clone();
    published["fog"]["airlight"] = "fogshop2007".into();
    compare_airlight(name, &published, size, 0.0);
    if json == &published {
        return;
    }
    // One rule along a probe's own ray, and one for a patch of pixels: each has its own error, the
    // larger the smaller blobs are against the ray. One value in 50 may differ by ten times that.
    compare_airlight(&format!("{name}, auto"), json, size, 2e-2);
}

fn compare_airlight(name: &str, json: &Value, size: (u32, u32), estimate: f64) {
    let scene = scene(json);
    let rays = pixel_rays(&scene, size.0, size.1);
    let exact_values = exact(&scene, &rays);
    for (l, (layer, relative, absolute)) in LAYERS.into_iter().enumerate() {
        let shows_airlight = matches!(layer, Layer::Airlight | Layer::Beauty);
        let relative = if shows_airlight { relative.max(estimate) } else { relative };
        let frame = render(&scene, &view(size.0, size.1, layer, Quality::Full));
        let channels = layer.channels(1);
        let colour = channels == 3;
        let most = exact_values.iter().flat_map(|v| v[l]).fold(0.0, f64::max);
        // Below 1e-30 an f32 exponential has flushed what f64 still carries.
        let floor = (absolute * if colour { most } else { 1.0 }).max(1e-30);
        let (mut worst, mut open, mut estimated) = (0.0f64, 0, 0);
        for (i, pixel) in frame.pixels.chunks(channels).enumerate() {
            for (k, value) in pixel.iter().map(|v| f64::from(*v)).enumerate() {
                let expected = exact_values[i][l][k];
                assert!(expected.is_finite(), "{name}, {layer:?}, pixel {i}: {expected}");
                let allowed = floor.max(relative * expected.abs());
                let error = (value - expected).abs();
                if error <= allowed {
                    worst = worst.max(error / expected.abs().max(floor / relative));
                    continue;
                }
                if shows_airlight && error <= 10.0 * estimate * expected.abs() {
                    estimated += 1;
                    continue;
                }
                open += 1;
                let near = exact(&scene, &rounded(&rays[i]));
                let near = || near.iter().map(|v| v[l][k]).chain([expected]);
                let low = near().fold(f64::INFINITY, f64::min);
                let high = near().fold(f64::NEG_INFINITY, f64::max);
                assert!(
                    value >= low - floor - relative * low.abs()
                        && value <= high + floor + relative * high.abs(),
                    "{name}, {layer:?}, pixel {i}, channel {k}: {value} instead of {expected} \
                     ({low} to {high})"
                );
            }
        }
        assert!(50 * estimated <= frame.pixels.len(), "{name}, {layer:?}: {estimated} differ");
        println!("{name:24} {layer:?}: {worst:.1e}, {open} decided by rounding of rays");
    }
}

/// A scene with something of everything.
fn everything(random: &mut Random, terms: Value) -> Value {
    json!({
        "camera": { "position": [0.3, 1, 7], "target": [0, 0.2, 0] },
        "background": [0.05, 0.1, 0.2],
        "surfaces": surfaces(),
        "lights": random.lamps(3, 4.0),
        "fog": { "terms": terms, "ambient": [0.3, 0.2, 0.1], "albedo": [0.9, 0.8, 0.7] },
        "far_m": 200,
    })
}

fn parallel(mut scene: Value) -> Value {
    scene["camera"]["projection"] = json!({ "kind": "orthographic", "height_m": 7 });
    scene
}

fn compare_both(name: &str, scene: Value) {
    compare(name, &scene);
    compare(&format!("{name}, parallel"), &parallel(scene));
}

fn blob(center: DVec3, radius: f64, extinction: f64) -> Value {
    json!({ "center": center.to_array(), "radius": radius, "extinction": extinction })
}

/// A picture shows what a probe of its pixel says: random fog before, around and behind surfaces.
#[test]
fn pictures_agree_with_probes() {
    for seed in 0..3 {
        let mut random = Random(seed);
        let blobs = random.blobs(20, 5.0, [0.05, 5.0], [1e-3, 2.0]);
        let terms = json!([homogeneous(random.decades(1e-3, 0.2)), blobs]);
        compare_both(&format!("seed {seed}"), everything(&mut random, terms));
    }
}

/// The same without blobs, in the thinnest and in dense homogeneous fog.
#[test]
fn pictures_of_homogeneous_fog_agree_with_probes() {
    for extinction in [1e-9, 0.02, 1.0, 1e6] {
        let mut random = Random(7);
        let terms = json!([homogeneous(extinction)]);
        compare_both(&format!("β {extinction}"), everything(&mut random, terms));
    }
}

/// The eye in the middle of fog: blobs around the camera, one centred on it.
#[test]
fn pictures_from_inside_blobs_agree_with_probes() {
    let mut random = Random(11);
    let eye = DVec3::new(0.3, 1.0, 7.0);
    let blobs = [blob(eye, 2.0, 0.2), blob(eye + 0.5, 6.0, 0.1), blob(eye - 0.3, 0.3, 1.0)];
    let terms = json!([{ "kind": "gaussians", "blobs": blobs }]);
    compare_both("inside", everything(&mut random, terms));
}

fn blobs_only(blobs: Vec<Value>) -> Value {
    everything(&mut Random(12), json!([{ "kind": "gaussians", "blobs": blobs }]))
}

/// The smallest and densest blobs, on the pixels' own rays.
#[test]
fn pictures_of_the_smallest_blobs_agree_with_probes() {
    let mut random = Random(12);
    let bare = scene(&everything(&mut random, json!([])));
    let rays = pixel_rays(&bare, 32, 24);
    let tiny: Vec<_> = (0..40)
        .map(|i| {
            let ray = &rays[(i * 19) % rays.len()];
            let at = ray.origin + random.between(1.0, 6.0) * ray.direction;
            blob(at, 1e-4, random.decades(10.0, 1e6))
        })
        .collect();
    let dense = vec![blob(DVec3::new(0.5, 0.5, 1.0), 1.0, 1e6)];
    // Opaque within less than the way between two nodes or two pixels, which `auto` does not
    // resolve: for the published method.
    for (name, blobs) in [("tiny", tiny), ("dense", dense)] {
        let mut scene = blobs_only(blobs);
        scene["fog"]["airlight"] = "fogshop2007".into();
        compare_both(name, scene);
    }
}

/// The largest blobs: as good as homogeneous fog, or its rim.
#[test]
fn pictures_of_the_largest_blobs_agree_with_probes() {
    let mut random = Random(12);
    let mut wide = |distance: f64| vec![blob(distance * random.direction(), 1e8, 0.02)];
    for (i, wide) in [0.0, 0.5e8, 2e8].map(&mut wide).into_iter().enumerate() {
        compare_both(&format!("wide {i}"), blobs_only(wide));
    }
    for radius in [1e2, 1e3, 1e4, 1e6] {
        let wide = vec![blob(0.3 * radius * random.direction(), radius, 0.05)];
        compare_both(&format!("radius {radius}"), blobs_only(wide));
    }
}

/// Fog that is thick far behind a blob hides nothing of the light that the blob itself scatters.
#[test]
fn pictures_of_a_blob_before_thick_fog_agree_with_probes() {
    let scene = json!({
        "lights": [{ "kind": "point", "position": [-0.5, 2.2, 1], "intensity": [40, 34, 24], "shadows": false }],
        "fog": { "terms": [
            { "kind": "homogeneous", "extinction": 0.03 },
            { "kind": "gaussians",
              "blobs": [{ "center": [-1, 0.6, 0], "radius": 1.2, "extinction": 0.5 }] },
        ] },
    });
    compare_both("before thick fog", scene);
}

/// Homogeneous fog dims the light of an opaque blob once, not twice.
#[test]
fn pictures_of_an_opaque_blob_in_fog_agree_with_probes() {
    let scene = json!({
        "lights": [{ "kind": "point", "position": [-0.5, 2.2, 1], "intensity": [40, 34, 24], "shadows": false }],
        "fog": { "terms": [
            { "kind": "homogeneous", "extinction": 0.05 },
            { "kind": "gaussians",
              "blobs": [{ "center": [-1, 0.6, 0], "radius": 1.2, "extinction": 200 }] },
        ] },
    });
    compare_both("opaque in fog", scene);
}

/// A scene a thousand kilometres from the origin looks like the same scene at home.
#[test]
fn pictures_far_from_the_origin_agree_with_probes() {
    let mut random = Random(13);
    let offset = DVec3::new(1e6, -1e6, 1e6);
    let mut blobs = random.blobs(20, 5.0, [0.3, 3.0], [0.01, 1.0]);
    let shift = |v: &mut Value| {
        (0..3).for_each(|k| v[k] = json!(v[k].as_f64().unwrap() + offset[k]));
    };
    blobs_of(&mut blobs).unwrap().iter_mut().for_each(|blob| shift(&mut blob["center"]));
    let mut scene = everything(&mut random, json!([homogeneous(0.02), blobs]));
    shift(&mut scene["camera"]["position"]);
    shift(&mut scene["camera"]["target"]);
    scene["lights"].as_array_mut().unwrap().iter_mut().for_each(|l| shift(&mut l["position"]));
    for surface in scene["surfaces"].as_array_mut().unwrap() {
        for (name, value) in surface["shape"].as_object_mut().unwrap() {
            match name.as_str() {
                "point" | "center" | "min" | "max" | "origin" => shift(value),
                "positions" => value.as_array_mut().unwrap().iter_mut().for_each(shift),
                _ => {}
            }
        }
    }
    compare_both("far", scene);
}

/// As many lamps as a scene may hold, some of them right on a pixel's ray.
#[test]
fn pictures_of_many_lamps_agree_with_probes() {
    let mut random = Random(14);
    let terms = json!([homogeneous(0.05), random.blobs(10, 4.0, [0.5, 2.0], [0.05, 0.5])]);
    let mut scene = everything(&mut random, terms);
    let rays = pixel_rays(&crate::scene(&scene), 32, 24);
    scene["lights"] = random.lamps(64, 5.0);
    for i in 0..4 {
        let ray = &rays[i * 101];
        scene["lights"][i]["position"] = json!((ray.origin + 3.0 * ray.direction).to_array());
    }
    compare_both("lamps", scene);
}

/// A floor seen almost from its side, up to where it ends in the fog.
#[test]
fn pictures_of_grazing_planes_agree_with_probes() {
    for height in [0.5, 0.01, 1e-4] {
        let mut random = Random(15);
        let terms = json!([homogeneous(1e-3), random.blobs(10, 4.0, [0.5, 2.0], [0.05, 0.5])]);
        let mut scene = everything(&mut random, terms);
        scene["surfaces"] = json!([{ "shape": { "kind": "plane" } }]);
        scene["camera"] = json!({ "position": [0, height, 5], "target": [0, height, 0],
            "projection": { "kind": "perspective", "vertical_fov_deg": 0.5 } });
        scene["far_m"] = json!(1e6);
        compare(&format!("height {height}"), &scene);
    }
}

/// Two thousand blobs, of which culling leaves out most along any one ray.
#[test]
fn pictures_of_many_blobs_agree_with_probes() {
    let mut random = Random(16);
    let terms = json!([random.blobs(2000, 8.0, [0.05, 1.0], [1e-3, 1.0])]);
    let mut scene = everything(&mut random, terms);
    scene["lights"] = random.lamps(2, 4.0);
    compare_pixels("2000 blobs", &scene, (20, 12));
    // In parallel each ray is an eye of its own for the published airlight, which costs n².
    compare_pixels("2000 blobs, parallel", &parallel(scene), (8, 6));
}

/// The widest and the narrowest lens.
#[test]
fn pictures_through_any_lens_agree_with_probes() {
    for angle in [0.1, 120.0, 179.0] {
        let mut random = Random(17);
        let terms = json!([homogeneous(0.02), random.blobs(20, 6.0, [0.2, 3.0], [0.01, 1.0])]);
        let mut scene = everything(&mut random, terms);
        let lens = json!({ "kind": "perspective", "vertical_fov_deg": angle });
        scene["camera"]["projection"] = lens;
        compare(&format!("lens {angle}"), &scene);
    }
}
