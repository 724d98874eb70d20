//! An emitter of particles, each a Gaussian blob (Fogshop 2007, section 6). Particle k is born at k/rate, k any whole
//! number, so that the plume is full at every time, and any time is reached by looking at those alive then.
//!
//! At the age a, a share f of its life, it is at position + v a + acceleration a²/2, and where the wind has carried it
//! since; its radius is radius · (1 + growth · f) and its extinction falls as 1 − f.

use super::gaussians::{Blob, Blobs, Draw, Gaussians};
use super::{Moment, Term, TermKind};
use crate::json::document::Part;
use crate::json::limits::{self, COUNTS};
use crate::json::{Albedo, Checker, Spectrum, Vec3};
use crate::phase::Phase;
use crate::random::lattice;
use glam::DVec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// A source of smoke: particles that are born at a rate, fly, grow and fade.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Emitter {
    /// Name of this term, unique among the terms.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(length(min = 1, max = limits::COUNTS.id_chars))]
    pub id: Option<String>,
    /// False removes it from the fog.
    pub enabled: bool,
    /// Share of the extinguished light that this term scatters; the fog's own where nothing is said.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub albedo: Option<Albedo>,
    /// Into which directions this term scatters; as the fog's own where nothing is said.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub phase: Option<Phase>,
    /// Share of the wind that moves the particles, from 0 to 1; the emitter stands still.
    #[schemars(range(min = limits::FRACTION.min, max = limits::FRACTION.max))]
    pub wind_response: f64,
    /// Where particles are born [m].
    pub position: Vec3,
    /// How many a second [Hz]. Times the lifetime it counts as blobs.
    #[schemars(range(min = limits::RATE.min, max = limits::RATE.max))]
    pub rate_hz: f64,
    /// With which velocity [m/s].
    #[schemars(inner(range(min = limits::VELOCITY.min, max = limits::VELOCITY.max)))]
    pub velocity: [f64; 3],
    /// By up to which angle that is turned, evenly within the cone [degrees].
    #[schemars(range(min = limits::SPREAD.min, max = limits::SPREAD.max))]
    pub spread_deg: f64,
    /// What accelerates them: buoyancy, or gravity [m/s²].
    #[schemars(inner(range(min = limits::VELOCITY.min, max = limits::VELOCITY.max)))]
    pub acceleration: [f64; 3],
    /// How long they live [s].
    #[schemars(range(min = limits::PERIOD.min, max = limits::PERIOD.max))]
    pub lifetime_s: f64,
    /// Their radius at birth [m].
    #[schemars(range(min = limits::RADIUS.min, max = limits::RADIUS.max))]
    pub radius: f64,
    /// By which share of that it has grown at the end.
    #[schemars(range(min = limits::GROWTH.min, max = limits::GROWTH.max))]
    pub growth: f64,
    /// Extinction in their middle at birth [1/m].
    #[schemars(schema_with = "Spectrum::extinction")]
    pub extinction: Spectrum,
    /// Chooses where each of them flies.
    #[schemars(range(max = u32::MAX))]
    pub seed: u32,
    /// How view rays see the particles.
    pub draw: Draw,
}

impl Part for Emitter {}

impl Default for Emitter {
    fn default() -> Self {
        Self {
            id: None,
            enabled: true,
            albedo: None,
            phase: None,
            wind_response: 1.0,
            position: Vec3::splat(0.0),
            rate_hz: 20.0,
            velocity: [0.0, 1.0, 0.0],
            spread_deg: 10.0,
            acceleration: [0.0; 3],
            lifetime_s: 4.0,
            radius: 0.4,
            growth: 1.0,
            extinction: Spectrum::Grey(0.5),
            seed: 1,
            draw: Draw::Gaussian,
        }
    }
}

impl Emitter {
    /// The most particles that are alive at a time.
    fn most(&self) -> f64 {
        (self.rate_hz * self.lifetime_s).ceil()
    }

    /// The particles alive at a moment.
    pub fn alive(&self, moment: &Moment) -> Vec<Blob> {
        let Moment { time_s, wind, .. } = moment;
        let newest = (time_s * self.rate_hz).floor();
        let count = self.most() as i64 + 1;
        let ages =
            (0..count).map(|i| (newest as i64 - i, time_s - (newest - i as f64) / self.rate_hz));
        let alive = ages.filter(|(_, age)| (0.0..self.lifetime_s).contains(age));
        let particle = |(k, age): (i64, f64)| {
            let share = age / self.lifetime_s;
            let carried = self.wind_response * wind.carried(time_s - age, *time_s);
            let way = age * self.velocity_of(k) + 0.5 * age * age * DVec3::from(self.acceleration);
            Blob {
                center: Vec3((self.position.vector() + way + carried).to_array()),
                radius: self.radius * (1.0 + self.growth * share),
                extinction: self.extinction.times(1.0 - share),
            }
        };
        alive.map(particle).collect()
    }

    /// With which velocity a particle is born: even in the cone around that of all.
    fn velocity_of(&self, k: i64) -> DVec3 {
        let velocity = DVec3::from(self.velocity);
        let Some(axis) = velocity.try_normalize() else { return velocity };
        let [height, turn] = [0, 1].map(|i| lattice(k, i, self.seed.into()));
        let cos = 1.0 - height * (1.0 - self.spread_deg.to_radians().cos());
        let sin = (1.0 - cos * cos).max(0.0).sqrt();
        let (across, up) = axis.any_orthonormal_pair();
        let (side, other) = (TAU * turn).sin_cos();
        velocity.length() * (cos * axis + sin * (other * across + side * up))
    }
}

impl TermKind for Emitter {
    type Medium = Blobs;

    const SOURCE: &'static str = "Zhou, Hou, Gong, Snyder, Guo, Shum: Fogshop (Pacific Graphics 2007), section 6: a \
        particle system whose particles are Gaussians.";

    const TRIAL: &'static str = r#"[{"kind": "emitter", "position": [0.3, 0, -1], "rate_hz": 12,
        "velocity": [0.2, 0.9, 0.1], "spread_deg": 25, "acceleration": [0, 0.2, 0], "lifetime_s": 3,
        "radius": 0.5, "growth": 1.5, "extinction": 0.6, "seed": 7}]"#;

    fn what(&self) -> &'static str {
        match self.draw {
            Draw::Gaussian => "an emitter",
            Draw::Slab => "an emitter as slabs",
        }
    }

    fn check(&self, check: &mut Checker, at: &dyn Fn(&str) -> String, _far_m: f64) {
        check.triple(self.position.0, limits::COORDINATE, || at("position"));
        check.number(self.rate_hz, limits::RATE, || at("rate_hz"));
        check.triple(self.velocity, limits::VELOCITY, || at("velocity"));
        check.number(self.spread_deg, limits::SPREAD, || at("spread_deg"));
        check.triple(self.acceleration, limits::VELOCITY, || at("acceleration"));
        check.number(self.lifetime_s, limits::PERIOD, || at("lifetime_s"));
        check.number(self.radius, limits::RADIUS, || at("radius"));
        check.number(self.growth, limits::GROWTH, || at("growth"));
        check.spectrum(self.extinction, limits::EXTINCTION, || at("extinction"));
    }

    fn blobs(&self) -> usize {
        // What is out of range is refused by itself.
        let most = self.most();
        if most.is_finite() && most <= COUNTS.blobs as f64 {
            most as usize
        } else {
            COUNTS.blobs + 1
        }
    }

    fn counted_at(&self) -> &'static str {
        "rate_hz"
    }

    fn changes(&self) -> bool {
        true
    }

    fn is_grey(&self) -> bool {
        self.extinction.is_grey()
    }

    fn stands_for(&self, moment: &Moment) -> Option<Term> {
        Some(Term::Gaussians(Gaussians {
            enabled: self.enabled,
            albedo: self.albedo,
            phase: self.phase.clone(),
            // The particles are where the wind has carried them.
            wind_response: 0.0,
            blobs: self.alive(moment).into(),
            draw: self.draw,
            ..Gaussians::default()
        }))
    }

    /// Its particles are blobs among all others.
    fn merge(_terms: &[&Self], _channel: usize, _moment: &Moment) -> Blobs {
        Blobs::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::media::{Velocity, Wind};

    fn at(time_s: f64) -> Moment {
        Moment { time_s, ..Moment::default() }
    }

    /// A plume is as full at any time, before 0 as well, and repeats nothing.
    #[test]
    fn the_plume_is_full_at_every_time() {
        let emitter = Emitter { rate_hz: 7.3, lifetime_s: 3.1, ..Emitter::default() };
        for time in [-1e6, -0.1, 0.0, 0.05, 12.34, 1e8] {
            let count = emitter.alive(&at(time)).len() as f64;
            assert!((count - 7.3 * 3.1).abs() <= 1.0, "{count} at {time} s");
        }
    }

    /// A particle flies on, grows and fades as time goes on, whatever time one begins to look.
    #[test]
    fn particles_keep_their_ways() {
        let emitter = Emitter { rate_hz: 1.0, lifetime_s: 10.0, ..Emitter::default() };
        let (now, later) = (emitter.alive(&at(100.25)), emitter.alive(&at(101.25)));
        for (now, later) in now.iter().zip(&later[1..]) {
            let way = later.center.vector() - now.center.vector();
            assert!((way.length() - 1.0).abs() < 1e-9, "{way}");
            assert!((later.radius - now.radius - 0.04).abs() < 1e-9);
            assert!(later.extinction.channels()[0] < now.extinction.channels()[0]);
        }
    }

    /// The wind moves particles over their age, and not the emitter.
    #[test]
    fn wind_carries_particles_from_their_birth_on() {
        let emitter = Emitter { velocity: [0.0; 3], wind_response: 0.5, ..Emitter::default() };
        let wind = Wind { velocity: Some(Velocity([2.0, 0.0, 0.0])), keys: None };
        for blob in emitter.alive(&Moment { time_s: 50.0, wind, ..Moment::default() }) {
            let share = (blob.radius / 0.4) - 1.0;
            assert!((blob.center.0[0] - share * 4.0).abs() < 1e-9, "{:?}", blob.center);
        }
    }

    /// Directions fill the cone, and no more.
    #[test]
    fn velocities_are_even_in_the_cone() {
        let emitter = Emitter { spread_deg: 60.0, ..Emitter::default() };
        let cos: Vec<_> = (0..4000).map(|k| emitter.velocity_of(k).y).collect();
        assert!(cos.iter().all(|cos| (0.5 - 1e-12..=1.0 + 1e-12).contains(cos)));
        let mean = cos.iter().sum::<f64>() / cos.len() as f64;
        // Even in the cosine: 0.75, of 4000 draws to three standard deviations.
        assert!((mean - 0.75).abs() < 3.0 * 0.5 / 12f64.sqrt() / 4000f64.sqrt(), "{mean}");
    }
}
