//! A moment of a fog: the time, and how far the wind has carried everything by then (Biri 2002, section 5).

use crate::json::limits::{self, COUNTS};
use crate::json::{Checker, Code, Vec3, bounded};
use glam::DVec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What carries the fog along. Give `velocity` or `keys`, not both; calm air where neither is given.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
#[schemars(extend("not" = {
    "required": ["velocity", "keys"],
    "properties": { "velocity": { "type": "array" }, "keys": { "type": "array" } },
}))]
pub struct Wind {
    /// The same at all times [m/s].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub velocity: Option<Velocity>,
    /// Velocities at rising times, a straight line between two, and constant before the first and after the last.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[serde(deserialize_with = "bounded::list_or_null::<{ COUNTS.keys }, _, _>")]
    #[schemars(length(min = 1, max = COUNTS.keys))]
    pub keys: Option<Vec<WindKey>>,
}

/// The wind at a time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct WindKey {
    /// When [s].
    #[schemars(range(min = limits::TIME.min, max = limits::TIME.max))]
    pub time_s: f64,
    /// How fast the air moves then [m/s].
    pub velocity: Velocity,
}

/// A velocity `[x, y, z]` [m/s].
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(transparent)]
pub struct Velocity(
    #[schemars(inner(range(min = limits::VELOCITY.min, max = limits::VELOCITY.max)))] pub [f64; 3],
);

impl Velocity {
    /// As a vector of the maths.
    pub fn vector(self) -> DVec3 {
        Vec3(self.0).vector()
    }
}

impl Wind {
    /// Looks at all of its numbers; `at` names its members.
    pub fn check(&self, check: &mut Checker, at: &dyn Fn(&str) -> String) {
        if let Some(velocity) = self.velocity {
            check.triple(velocity.0, limits::VELOCITY, || at("velocity"));
        }
        let Some(keys) = &self.keys else { return };
        if self.velocity.is_some() {
            check.refuse(Code::Conflict, || at("keys"), "give velocity or keys, not both");
        }
        if keys.is_empty() {
            check.refuse(Code::WrongLength, || at("keys"), "there is at least one key");
        }
        for (i, key) in keys.iter().enumerate() {
            check.number(key.time_s, limits::TIME, || at(&format!("keys/{i}/time_s")));
            check.triple(key.velocity.0, limits::VELOCITY, || at(&format!("keys/{i}/velocity")));
            if i > 0 && key.time_s <= keys[i - 1].time_s {
                let detail = "times rise from key to key";
                check.refuse(Code::Conflict, || at(&format!("keys/{i}/time_s")), detail);
            }
        }
    }

    /// Whether nothing ever moves.
    pub fn is_calm(&self) -> bool {
        let still = |velocity: &Velocity| velocity.vector() == DVec3::ZERO;
        self.velocity.iter().all(still)
            && self.keys.iter().flatten().all(|key| still(&key.velocity))
    }

    /// How far the air moves from one time to another [m].
    pub fn carried(&self, from_s: f64, to_s: f64) -> DVec3 {
        match &self.keys {
            None => self.velocity.unwrap_or_default().vector() * (to_s - from_s),
            Some(keys) => since_first(keys, to_s) - since_first(keys, from_s),
        }
    }
}

/// How far the air has moved since the first key, or will until then if that is yet to come [m].
fn since_first(keys: &[WindKey], time_s: f64) -> DVec3 {
    let Some(first) = keys.first() else { return DVec3::ZERO };
    let (mut way, mut before) = (DVec3::ZERO, first);
    if time_s < first.time_s {
        return first.velocity.vector() * (time_s - first.time_s);
    }
    for key in keys {
        let (a, b) = (before.velocity.vector(), key.velocity.vector());
        let whole = key.time_s - before.time_s;
        if time_s < key.time_s {
            let part = time_s - before.time_s;
            return way + part * (a + 0.5 * (b - a) * part / whole);
        }
        way += 0.5 * whole * (a + b);
        before = key;
    }
    way + before.velocity.vector() * (time_s - before.time_s)
}

/// A time in a wind: all that a term's field depends on besides its own numbers.
#[derive(Clone, Debug, PartialEq)]
pub struct Moment {
    /// What all extinctions are multiplied by.
    pub density: f64,
    /// The time [s].
    pub time_s: f64,
    /// The wind.
    pub wind: Wind,
}

impl Default for Moment {
    fn default() -> Self {
        Self { density: 1.0, time_s: 0.0, wind: Wind::default() }
    }
}

impl Moment {
    /// How far what responds so to the wind has been carried since time 0 [m].
    pub fn shift(&self, response: f64) -> DVec3 {
        response * self.wind.carried(0.0, self.time_s)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quadrature::adaptive;

    fn keyed(keys: &[(f64, [f64; 3])]) -> Wind {
        let key = |(time_s, velocity): &(f64, [f64; 3])| WindKey {
            time_s: *time_s,
            velocity: Velocity(*velocity),
        };
        Wind { velocity: None, keys: Some(keys.iter().map(key).collect()) }
    }

    /// The displacement is the integral of the velocity, between keys and outside of them, whichever time is
    /// the later.
    #[test]
    fn what_is_carried_is_the_integral_of_the_velocity() {
        let keys = [(-1.0, [1.0, 0.0, -2.0]), (2.0, [3.0, 1.0, 0.0]), (2.5, [0.0, 0.0, 4.0])];
        let wind = keyed(&keys);
        let speed = |t: f64| {
            let after = keys.iter().position(|key| t < key.0);
            match after {
                Some(0) => keys[0].1[2],
                None => keys[2].1[2],
                Some(i) => {
                    let ((a, u), (b, v)) = (keys[i - 1], keys[i]);
                    u[2] + (v[2] - u[2]) * (t - a) / (b - a)
                }
            }
        };
        for (from, to) in [(0.0, 1.0), (-4.0, 9.0), (2.2, -3.0), (5.0, 7.0), (-9.0, -2.0)] {
            let (low, high) = (f64::min(from, to), f64::max(from, to));
            let mut panels: Vec<f64> = keys.iter().map(|key| key.0).collect();
            panels.retain(|t| (low..high).contains(t));
            panels.extend([low, high]);
            panels.sort_by(f64::total_cmp);
            let sum = adaptive(&panels, 1e-12, speed) * (to - from).signum();
            assert!((wind.carried(from, to).z - sum).abs() < 1e-9, "{from} {to}");
        }
        let steady = Wind { velocity: Some(Velocity([1.0, 2.0, 3.0])), keys: None };
        assert_eq!(steady.carried(1.0, 3.0), DVec3::new(2.0, 4.0, 6.0));
        assert!(Wind::default().is_calm() && !wind.is_calm());
    }
}
