//! How a lamp glows in fog that is the same everywhere and hides nothing: M(t) = ∫ k(α) dt/d² from the eye, the
//! phase function over the angle that the ray turns through before the lamp, divided by its distance from
//! the ray (Macklin 2010, for any phase function).

use crate::geometry::control::{Each, PADDED};
use crate::light::ToLight;
use crate::num::{Lanes, Num};
use crate::phase::{PhaseFunction, STEPS};
use fearless_simd::Simd;
use std::f64::consts::PI;

/// Below this angle [rad] the phase function is as good as constant: a difference of its integrals has few digits.
const NARROW: f32 = 0.02;

/// A phase function with its integral, by the angle between the light's direction and that to the eye.
pub struct Glow {
    /// k and ∫ k dα at even steps from 0 to π; none if it is isotropic.
    table: Option<[Vec<f32>; 2]>,
}

impl Glow {
    /// Of a phase function.
    pub fn new(phase: PhaseFunction) -> Self {
        Self { table: (!phase.is_isotropic()).then(|| phase.tabulated()) }
    }

    /// ∫ k dα over a turn from an angle on.
    #[inline(always)]
    pub fn over<S: Simd>(&self, simd: S, from: Lanes<S>, turn: Lanes<S>) -> Lanes<S> {
        let Some([values, sums]) = &self.table else {
            return turn * turn.lit(PhaseFunction::ISOTROPIC.value(0.0));
        };
        let mut lanes: [Each; 2] = [[0.0; PADDED]; 2];
        from.store(&mut lanes[0]);
        turn.store(&mut lanes[1]);
        let mut whole = [0.0; PADDED];
        for lane in 0..Lanes::<S>::COUNT {
            let (from, turn) = (lanes[0][lane], lanes[1][lane]);
            whole[lane] = if turn < NARROW {
                look_up(values, from + 0.5 * turn) * turn
            } else {
                look_up(sums, from + turn) - look_up(sums, from)
            };
        }
        Lanes::load(simd, &whole)
    }

    /// ∫ k(α) dt/d² between two ray parameters [1/m].
    #[inline(always)]
    pub fn between<S: Simd>(
        &self,
        simd: S,
        to: &ToLight<Lanes<S>>,
        from: Lanes<S>,
        until: Lanes<S>,
    ) -> Lanes<S> {
        let before = to.first_angle() + to.angle(from.lit(0.0), from);
        self.over(simd, before, to.angle(from, until)) / to.miss
    }
}

/// A straight line between a table's values.
#[inline(always)]
fn look_up(table: &[f32], angle: f32) -> f32 {
    let at = angle * (STEPS as f64 / PI) as f32;
    let i = (at.max(0.0) as usize).min(STEPS - 1);
    let part = at - i as f32;
    table[i].mul_add(1.0 - part, table[i + 1] * part)
}
