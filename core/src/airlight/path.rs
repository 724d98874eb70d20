//! The fog along one view ray and from there to one light, exact and in f64: what the methods that sum
//! up the integrand itself have in common.

use crate::geometry::{Beyond, Ray, parts::without};
use crate::light::{Arrival, Crossed, Source, ToLight, sun};
use crate::media::{Along, Field, Sum, Ways};
use crate::phase::PhaseFunction;
use crate::progress::{Progress, Watch};
use crate::sky::SkyWays;
use glam::DVec3;
use std::rc::Rc;

/// A view ray and a light, with the fog that matters to them to rounding.
///
/// When the job that it belongs to is over there is no fog any more, so that whatever sums it up comes
/// to an end; the sum is for nobody then.
pub(crate) struct Path<'a> {
    /// The group of terms whose light it is.
    group: usize,
    /// Whether there is no other.
    is_alone: bool,
    /// Whether only differences of T tell what is there.
    is_rippled: bool,
    /// The ray.
    ray: Ray,
    /// How far it goes [m].
    pub length: f64,
    /// Where the light stands.
    pub to_light: ToLight<f64>,
    /// How the ray passes its cone.
    crossed: Option<Crossed<f64>>,
    /// The parts of the ray that it reaches [m].
    lit: Vec<[f64; 2]>,
    /// What is smooth along the ray.
    smooth: Sum<dyn Along>,
    /// What is not.
    lumps: Sum<dyn Along>,
    /// Between the light and the ray.
    shading: Shading,
    watch: Option<Watch<'a>>,
}

impl<'a> Path<'a> {
    /// Gathers the fog for a ray up to `length` [m], of which one group scatters the light.
    pub fn new(field: &Field, group: usize, light: Source, ray: Ray, length: f64) -> Self {
        let [smooth, lumps] = field.along(&ray, length).parted();
        let to_light = light.beside(ray.origin.into(), ray.direction.into());
        let crossed = light.crossed(ray.origin.into(), ray.direction.into());
        let lit = crossed.map_or([0.0, length], |cone| within(&to_light, cone.within(), length));
        Self {
            group,
            is_alone: field.groups().len() == 1,
            is_rippled: field.is_rippled(),
            ray,
            length,
            to_light,
            crossed,
            lit: vec![lit],
            smooth,
            lumps,
            shading: Shading::Lamp(field.ways(light.origin(), [ray.origin, ray.at(length)])),
            watch: None,
        }
    }

    /// The same under one channel of a sky, to be summed up as a sun that is as strong and scattered evenly.
    pub fn under(
        field: &Field,
        group: usize,
        (sky, channel): (&Rc<SkyWays>, usize),
        ray: Ray,
        length: f64,
    ) -> Self {
        let sun = Source::Sun(sun::Place(Beyond { toward: DVec3::Y, path_m: 0.0 }));
        let shading = Shading::Sky(Rc::clone(sky), channel);
        Self { shading, ..Self::new(field, group, sun, ray, length) }
    }

    /// Where nothing stands between the ray and the light but in some parts of it, ascending [m].
    pub fn shaded(mut self, shadows: &[[f64; 2]]) -> Self {
        self.lit = self.lit.iter().flat_map(|lit| without(*lit, shadows)).collect();
        self
    }

    /// As a part of a job.
    pub fn of(self, progress: &'a Progress) -> Self {
        Self { watch: Some(Watch::new(progress)), ..self }
    }

    /// Whether so many terms may be summed up.
    fn goes_on(&self, terms: usize) -> bool {
        self.watch.as_ref().is_none_or(|watch| watch.allows(terms + 1))
    }

    /// By how much farther apart two rules may be that agree: the sum over a sky's parts is no better.
    pub fn slack(&self) -> f64 {
        match self.shading {
            Shading::Lamp(_) => 1.0,
            Shading::Sky(..) => 10.0,
        }
    }

    /// β [1/m] at the ray parameter `t` [m].
    pub fn extinction(&self, t: f64) -> f64 {
        self.smooth.beta(t) + self.extinction_of_lumps(t)
    }

    /// Whether all fog scatters alike.
    pub fn is_alone(&self) -> bool {
        self.is_alone
    }

    /// Whether the fog changes in places so fast that only differences of T tell what is there.
    pub fn is_rippled(&self) -> bool {
        self.is_rippled
    }

    /// The same of the group.
    pub fn own_extinction(&self, t: f64) -> f64 {
        if self.is_alone {
            return self.extinction(t);
        }
        let smooth = self.smooth.beta_of(self.group, t);
        if self.goes_on(self.lumps.terms()) {
            smooth + self.lumps.beta_of(self.group, t)
        } else {
            smooth
        }
    }

    /// The same of the lumps alone.
    pub fn extinction_of_lumps(&self, t: f64) -> f64 {
        if self.goes_on(self.lumps.terms()) { self.lumps.beta(t) } else { 0.0 }
    }

    /// T from the eye to the ray parameter `t` [m].
    pub fn depth(&self, t: f64) -> f64 {
        self.smooth.depth(t) + self.depth_of_lumps(t)
    }

    /// The same of the lumps alone.
    pub fn depth_of_lumps(&self, t: f64) -> f64 {
        if self.goes_on(self.lumps.terms()) { self.lumps.depth(t) } else { 0.0 }
    }

    /// T of the group from the eye to the ray parameter `t` [m].
    pub fn own_depth(&self, t: f64) -> f64 {
        let smooth = self.smooth.depth_of(self.group, t);
        if self.goes_on(self.lumps.terms()) {
            smooth + self.lumps.depth_of(self.group, t)
        } else {
            smooth
        }
    }

    /// T from the light to the ray parameter `t` [m].
    pub fn shade(&self, t: f64) -> f64 {
        if !self.goes_on(self.shading.terms()) {
            return 0.0;
        }
        match &self.shading {
            Shading::Lamp(ways) => ways.depth_to(self.ray.at(t)),
            Shading::Sky(ways, channel) => ways.depth_to(t, self.ray.at(t), *channel),
        }
    }

    /// β k(α) e^(−T(v,x)−T(x,s)) of the group at the ray parameter `t` [m], and what arrives there of the light.
    pub fn scattered(&self, phase: PhaseFunction, t: f64) -> (f64, Arrival<f64>) {
        let arrival = self.to_light.at(t);
        let through = (-self.depth(t) - self.shade(t)).exp();
        (self.own_extinction(t) * phase.value(arrival.cos) * through * self.weight(t), arrival)
    }

    /// Share of the light that goes to the ray parameter `t` [m].
    pub fn weight(&self, t: f64) -> f64 {
        self.crossed.map_or(1.0, |cone| cone.weight(self.to_light.angle_at(t)))
    }

    /// Whether the light reaches the ray parameter `t` [m] at all.
    pub fn is_lit(&self, t: f64) -> bool {
        self.lit.iter().any(|[from, to]| *from <= t && t <= *to)
    }

    /// The parts between two ray parameters that the light reaches [m].
    pub fn lit(&self, from: f64, to: f64) -> impl Iterator<Item = [f64; 2]> + '_ {
        let parts = self.lit.iter().map(move |[a, b]| [a.max(from), b.min(to)]);
        parts.filter(|[a, b]| a < b)
    }

    /// Whether nothing on the ray scatters, not even the tails of lumps.
    pub fn is_clear(&self) -> bool {
        let has_smooth = self.smooth.span_of(self.group).is_some();
        self.length <= 0.0 || !has_smooth && self.lumps.terms_of(self.group) == 0
    }

    /// From where to where there is fog of the group on the ray [m]; `None` if there is none.
    pub fn span(&self) -> Option<(f64, f64)> {
        match (self.smooth.span_of(self.group), self.lumps.span_of(self.group)) {
            (Some(a), Some(b)) => Some((a.0.min(b.0), a.1.max(b.1))),
            (smooth, lumps) => smooth.or(lumps),
        }
    }

    /// The same of the lumps of all groups.
    pub fn dense(&self) -> Option<(f64, f64)> {
        self.lumps.span()
    }

    /// The ray parameters from one to another between which fog and light are smooth [m].
    pub fn sections(&self, from: f64, to: f64) -> Vec<f64> {
        let mut ends = vec![from, to];
        if let Some(cone) = self.crossed {
            let full = within(&self.to_light, cone.full(), self.length);
            ends.extend(full.into_iter().filter(|t| from < *t && *t < to));
        }
        ends.extend(self.smooth.edges_between(from, to));
        ends.extend(self.lumps.edges_between(from, to));
        ends.sort_unstable_by(f64::total_cmp);
        ends
    }

    /// Where T reaches `opaque` between two ray parameters, else the second one [m].
    pub fn reaches(&self, opaque: f64, from: f64, to: f64) -> f64 {
        let (mut low, mut high) = (from, to);
        if self.depth(to) <= opaque {
            return to;
        }
        // To a thousandth of itself is near enough for an end that nothing is seen of.
        while high - low > 1e-3 * (high - from) && high - low > 1e-12 * high {
            let middle = 0.5 * (low + high);
            if self.depth(middle) > opaque {
                high = middle;
            } else {
                low = middle;
            }
        }
        high
    }

    /// The finest length over which the fog changes between two ray parameters [m].
    pub fn finest_m(&self, from: f64, to: f64) -> f64 {
        if self.goes_on(self.lumps.terms()) { self.lumps.finest_m(from, to) } else { f64::INFINITY }
    }

    /// The longest panel that still sees every lump between two ray parameters [m].
    pub fn resolution(&self, start: f64, end: f64) -> f64 {
        /// Its radii that a panel of fifteen nodes may be long.
        const RADII: f64 = 5.0;
        RADII * self.finest_m(start, end)
    }
}

/// What lies between a light and a ray.
enum Shading {
    /// On the ways of a lamp's light.
    Lamp(Sum<dyn Ways>),
    /// On those of all parts of a sky, of which one channel is looked at.
    Sky(Rc<SkyWays>, usize),
}

impl Shading {
    fn terms(&self) -> usize {
        match self {
            Self::Lamp(ways) => ways.terms(),
            Self::Sky(ways, _) => ways.terms(),
        }
    }
}

/// The part of a ray between two angles at a light, no longer than the ray [m].
fn within(light: &ToLight<f64>, [from, to]: [f64; 2], length: f64) -> [f64; 2] {
    let last = light.angle_at(length);
    let begin = if from > 0.0 { light.t_at(from.min(last)) } else { 0.0 };
    let end = if to < last { light.t_at(to.max(0.0)) } else { length };
    [begin.clamp(0.0, length), end.clamp(0.0, length)]
}
