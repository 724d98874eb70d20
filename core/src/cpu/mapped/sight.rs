//! What a few rays meet on their way, and what they see of one lamp.

use super::control::{self, Fields};
use super::patch::Patch;
use crate::airlight::mapped::OPAQUE;
use crate::frame::context::{Context, Lamp, Scatter};
use crate::frame::tolerance::Tolerance;
use crate::geometry::control::{Control, Each, PADDED};
use crate::media::{OnRays, Patched, Profile, Smooth, Sum};
use glam::Vec3;

/// Where quadratics are compared with what they stand for: neither even nor odd errors vanish here.
pub const CHECK: [f32; 2] = [0.55, 0.45];

/// Share of a lump, in thin fog, that does not matter to where nodes are placed.
const FAINT: f32 = 1e-5;

/// An edge of the fog no farther than this share behind a ray's end is its end: where fog lies on a floor.
const ALIKE: f32 = 1e-4;

/// A frame's fog before one lamp.
#[derive(Clone, Copy)]
pub struct ToLamp<'a> {
    /// The frame.
    pub context: &'a Context<'a>,
    /// The lamp.
    pub lamp: &'a Lamp,
    /// What is scattered of it.
    pub scatter: &'a Scatter,
    /// What may be missed.
    pub tolerance: &'a Tolerance,
}

/// A few rays of a row, and the fog that they cross.
pub struct Sight {
    /// The rays.
    pub rays: Control,
    /// What they cross.
    pub met: Sum<dyn OnRays>,
    /// Where β, or its slope, jumps on them [m].
    edges: Vec<Each>,
}

/// The rays that stand for a patch.
pub struct Sights {
    /// Around it.
    pub control: Sight,
    /// Through its middle: there nodes are placed.
    pub middle: Sight,
    /// Where quadratics are compared with what they stand for.
    pub check: Sight,
}

/// A part of the rays' way on which fog is smooth. A place on it is `begin` + share · `range` [m] on
/// each ray, so that the same share lies likewise between the edges of the fog on all of them.
#[derive(Clone, Copy, Debug)]
pub struct Section {
    /// The place of the share 0, ray by ray [m].
    pub begin: Each,
    /// What a share of 1 is long [m].
    pub range: Each,
    /// The shares between which it lies: 0 and 1 if an edge cuts it; else ray parameters, which are the
    /// same on all rays.
    pub ends: [f32; 2],
}

impl Section {
    /// Between two ray parameters [m].
    fn whole(from: f32, to: f32) -> Self {
        Self { begin: [0.0; PADDED], range: [1.0; PADDED], ends: [from, to] }
    }

    /// Two shares on eight rays each [m].
    pub fn at(&self, shares: &[f32]) -> Each {
        let half = PADDED / 2;
        let on_ray = |c: usize| {
            let share = shares[(c / half).min(shares.len() - 1)];
            self.range[c].mul_add(share, self.begin[c])
        };
        std::array::from_fn(on_ray)
    }

    /// Where it begins and ends on the first ray [m].
    pub fn on_first(&self) -> (f32, f32) {
        let [from, to] = self.ends.map(|share| self.range[0].mul_add(share, self.begin[0]));
        (from, to)
    }
}

/// The same sections of all sights of a patch, one after the other.
pub struct Sections {
    /// Of the rays around the patch.
    pub control: Vec<Section>,
    /// Of the ray through its middle.
    pub middle: Vec<Section>,
    /// Of the ray that is checked.
    pub check: Vec<Section>,
}

/// The edges of the fog that matter to rays, by their places among all.
#[derive(Debug, Default)]
pub struct Edges {
    /// All rays pass these before the first of them ends, in this order.
    pub passed: Vec<usize>,
    /// The rays end before this one, or on it.
    pub bound: Option<usize>,
}

impl Sight {
    fn new(context: &Context, fog: &Sum<dyn Patched>, rays: Control, least: f32) -> Self {
        let met = fog.on_rays(context.job.level, &rays, context.viewpoint.parallel, least);
        let edges = met.edges();
        Self { rays, met, edges }
    }

    /// Fields at ray parameters `t`.
    pub fn fields(&self, to: &ToLamp, t: &[Each]) -> Fields {
        let (level, group) = (to.context.job.level, to.scatter.group);
        let Profile { mut log_beta, other_beta, depth } = self.met.profile(level, group, t);
        for (log, depth) in log_beta.iter_mut().zip(&depth) {
            for (log, depth) in log.iter_mut().zip(depth) {
                *log -= depth.min(2.0 * OPAQUE as f32);
            }
        }
        let mean = control::toward_light(to.context, to.lamp, &self.rays, t);
        Fields { log: log_beta, other_beta, mean, depth }
    }

    /// The section from a ray parameter to an edge, or to another one that is the same on all rays. What
    /// lies on the edge itself counts as before it: there rays end whose way it bounds.
    pub fn up_to(&self, from: f32, edge: Option<usize>, to: f32) -> Section {
        let Some(edge) = edge else {
            let range = [to - from; PADDED];
            return Section { begin: [from; PADDED], range, ends: [0.0, 1.0] };
        };
        let bound = self.edges[edge].map(|t| t * (1.0 - 0.1 * ALIKE));
        let begin = bound.map(|t| t.min(from));
        let range = std::array::from_fn(|c| bound[c] - begin[c]);
        Section { begin, range, ends: [0.0, 1.0] }
    }

    /// Sections between two ray parameters, cut at some of the edges.
    fn cut(&self, edges: &[usize], from: f32, to: f32) -> Vec<Section> {
        if edges.is_empty() {
            return vec![Section::whole(from, to)];
        }
        let inner = edges.iter().map(|i| self.edges[*i].map(|t| t.clamp(from, to)));
        let ends: Vec<_> =
            [[from; PADDED]].into_iter().chain(inner).chain([[to; PADDED]]).collect();
        let between = |pair: &[Each]| Section {
            begin: pair[0],
            range: std::array::from_fn(|c| (pair[1][c] - pair[0][c]).max(0.0)),
            ends: [0.0, 1.0],
        };
        ends.windows(2).map(between).collect()
    }
}

impl Sights {
    /// Of a patch, in the fog around it.
    pub fn new(context: &Context, fog: &Sum<dyn Patched>, patch: &Patch) -> Self {
        let within = |place| control::within(context, patch, place);
        Self {
            control: Sight::new(context, fog, control::around(context, patch), 0.0),
            middle: Sight::new(context, fog, within([0.0; 2]), FAINT),
            check: Sight::new(context, fog, within(CHECK), 0.0),
        }
    }

    /// The parts of the way between two ray parameters on which fog is smooth.
    pub fn sections(&self, from: f32, to: f32, passed: &[usize]) -> Sections {
        let [control, middle, check] =
            [&self.control, &self.middle, &self.check].map(|sight| sight.cut(passed, from, to));
        Sections { control, middle, check }
    }

    /// What some rays that end between `first` and `last`, each given with where it ends, have to do with
    /// the edges of the fog; `None` if they are too different for one patch.
    pub fn edges<'a>(
        &self,
        haze: &Sum<dyn Smooth>,
        rays: impl Iterator<Item = (Vec3, Vec3, f32)> + 'a,
        [from, first, last]: [f32; 3],
    ) -> Option<Edges> {
        let edges = &self.control.edges;
        let mut passing: Vec<Option<bool>> = vec![None; edges.len()];
        let mut own = Vec::with_capacity(edges.len());
        for (start, direction, end) in rays {
            own.clear();
            haze.edges(start, direction, &mut own);
            for (passing, t) in passing.iter_mut().zip(&own) {
                // Behind the start an edge is as good as beyond the end: nobody passes it.
                let passes = from < *t && *t < end * (1.0 - ALIKE);
                if *passing.get_or_insert(passes) != passes {
                    return None;
                }
            }
        }
        let all = |i: &usize, is: &dyn Fn(f32) -> bool| edges[*i].iter().all(|t| is(*t));
        let some = |i: &usize, is: &dyn Fn(f32) -> bool| edges[*i].iter().any(|t| is(*t));
        let middle = |i: &usize| self.middle.edges[*i][0];
        let (mut passed, rest): (Vec<_>, Vec<_>) =
            (0..edges.len()).partition(|i| passing[*i] == Some(true));
        passed.sort_unstable_by(|a, b| middle(a).total_cmp(&middle(b)));
        let in_order = passed.windows(2).all(|pair| {
            edges[pair[0]].iter().zip(&edges[pair[1]]).all(|(before, behind)| before <= behind)
        });
        let inside = passed.iter().all(|i| all(i, &|t| from < t && t < first));
        let outside = rest.iter().all(|i| !some(i, &|t| from < t && t < first * (1.0 - ALIKE)));
        let ahead = rest.into_iter().filter(|i| some(i, &|t| from < t && t < last * (1.0 + ALIKE)));
        let bound = ahead.min_by(|a, b| middle(a).total_cmp(&middle(b)));
        let is_bound = bound.is_none_or(|i| all(&i, &|t| from < t));
        (in_order && inside && outside && is_bound).then_some(Edges { passed, bound })
    }

    /// Whether the fog has edges at all.
    pub fn has_edges(&self) -> bool {
        !self.control.edges.is_empty()
    }
}
