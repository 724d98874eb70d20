//! Smoke from the chimney and steam along the track: 1 223 particles, as many as blobs in the paper's figure.

use super::super::stage::{emitter, round_to, rounded};
use super::engine::CHIMNEY;
use crate::media::emitter::Emitter;
use crate::scene::Term;
use glam::DVec3;

/// How long smoke lives, a jet of steam, and steam that creeps [s].
const SMOKE_S: f64 = 8.0;
const JET_S: f64 = 4.0;
const CREEP_S: f64 = 7.0;
/// Particles alive at a time: 803 of smoke …
const SMOKE: [f64; 3] = [400.0, 200.0, 203.0];
/// … 140 of the two jets, and 280 that creep along eight places of the track.
const JET: f64 = 70.0;
const CREEP: f64 = 35.0;
/// Where steam creeps out along the track [m].
const PLACES: [f64; 4] = [-5.4, -2.4, 0.6, 3.6];

/// All of it.
pub fn terms() -> Vec<Term> {
    let mut terms = smoke();
    for (name, side) in [("left", -1.0), ("right", 1.0)] {
        terms.push(emitter(&format!("jet-{name}"), jet(side)));
        for (k, x) in PLACES.into_iter().enumerate() {
            terms.push(emitter(&format!("steam-{name}-{}", k + 1), creeping(x, side)));
        }
    }
    terms
}

/// The plume from the chimney: it rises, is blown back and widens. Three sources make it billow.
fn smoke() -> Vec<Term> {
    let source = |name: &str, k: usize, velocity: [f64; 3], radius: f64, growth: f64| {
        let smoke = Emitter {
            position: rounded(CHIMNEY, 1e3),
            rate_hz: SMOKE[k] / SMOKE_S,
            velocity,
            spread_deg: 14.0,
            acceleration: [-0.24, -0.05, -0.028],
            lifetime_s: SMOKE_S,
            radius,
            growth,
            extinction: 0.3.into(),
            seed: 1223 + k as u32,
            ..Emitter::default()
        };
        emitter(name, smoke)
    };
    vec![
        source("smoke", 0, [-0.4, 0.56, 0.0], 0.16, 3.4),
        source("smoke-high", 1, [-0.26, 0.66, 0.06], 0.14, 3.0),
        source("smoke-low", 2, [-0.56, 0.5, -0.06], 0.14, 4.0),
    ]
}

/// Drain cocks blow forwards and outwards.
fn jet(side: f64) -> Emitter {
    Emitter {
        position: rounded(DVec3::new(4.2, 0.75, 1.2 * side), 1e3),
        rate_hz: JET / JET_S,
        velocity: [0.44, -0.06, 0.36 * side],
        spread_deg: 16.0,
        acceleration: [-0.02, 0.0, 0.0],
        lifetime_s: JET_S,
        radius: 0.13,
        growth: 3.2,
        extinction: 0.42.into(),
        seed: 7,
        ..Emitter::default()
    }
}

/// Steam that creeps along the wheels and over the track.
fn creeping(x: f64, side: f64) -> Emitter {
    Emitter {
        position: rounded(DVec3::new(x, 0.3, 0.7 * side), 1e3),
        rate_hz: CREEP / CREEP_S,
        velocity: [0.3, 0.13, 0.16 * side],
        spread_deg: 80.0,
        acceleration: [0.0, -0.012, 0.0],
        lifetime_s: CREEP_S,
        radius: 0.45,
        growth: 0.8,
        extinction: 0.19.into(),
        // Each place has its own.
        seed: round_to(100.0 * x + 1000.0 * side, 1.0).abs() as u32,
        ..Emitter::default()
    }
}
