//! A brush for fogmaps: raises or lowers the coefficients under a stroke.

use super::stroke::{StrokePoint, bounds, check_points, distance};
use super::term::{Name, fogmap};
use super::{Desk, Refused, Tool};
use crate::json::limits::{self, COUNTS};
use crate::json::{Checker, Vec3, bounded};
use crate::media::fogmap::Fogmap;
use crate::rounding::round_to;
use crate::scene::{CheckedScene, Scene};
use glam::DVec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Steps that a coefficient is rounded to, as a share of what is laid on: patches are short, and it is not seen.
const STEPS: f64 = 1e4;

/// Raises or lowers a fogmap under a stroke, most in its middle, not at all from its radius on.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FogmapPaint {
    /// The map: its id, or its place among the terms.
    pub term: Name,
    /// The stroke, seen from above: positions [m], whose height does not matter.
    #[serde(deserialize_with = "bounded::list::<{ COUNTS.stroke_points }, _, _>")]
    #[schemars(length(min = 1, max = COUNTS.stroke_points))]
    pub points: Vec<StrokePoint>,
    /// How far around it the brush reaches [m].
    #[schemars(range(min = limits::RADIUS.min, max = limits::RADIUS.max))]
    pub radius: f64,
    /// What is added to the coefficients under its middle; none falls below 0.
    #[schemars(range(min = limits::SIGNED_EXTINCTION.min, max = limits::SIGNED_EXTINCTION.max))]
    pub delta: f64,
}

impl Tool for FogmapPaint {
    fn check(&self, check: &mut Checker, at: &dyn Fn(&str) -> String) {
        check_points(&self.points, check, at);
        check.number(self.radius, limits::RADIUS, || at("radius"));
        check.number(self.delta, limits::SIGNED_EXTINCTION, || at("delta"));
    }

    fn apply(&self, scene: &CheckedScene, _desk: &mut Desk) -> Result<Scene, Refused> {
        let mut after = (**scene).clone();
        let map = fogmap(&mut after, &self.term)?;
        let flat: Vec<_> = self.points.iter().map(flat).collect();
        let (min, max) = bounds(&flat, self.radius);
        let (x, z) = (Splines::along(map, 0), Splines::along(map, 1));
        let (columns, rows) = (x.between(min.x, max.x), z.between(min.z, max.z));
        if columns.is_empty() || rows.is_empty() {
            return Ok(after);
        }
        let steps = STEPS / self.delta.abs().max(limits::EXTINCTION.max.recip());
        for j in rows {
            for i in columns.clone() {
                let place = DVec3::new(x.center(i), 0.0, z.center(j));
                let near = distance(&flat, place) / self.radius;
                if near < 1.0 {
                    // Smooth in its middle and at its rim.
                    let share = (1.0 - near * near).powi(2);
                    let value = map.coefficients[j][i] + self.delta * share;
                    let value = value.clamp(limits::EXTINCTION.min, limits::EXTINCTION.max);
                    map.coefficients[j][i] = round_to(value, steps);
                }
            }
        }
        Ok(after)
    }
}

fn flat(point: &StrokePoint) -> StrokePoint {
    let [x, _, z] = point.position.0;
    StrokePoint { position: Vec3([x, 0.0, z]), ..*point }
}

/// The splines of a map along one axis.
struct Splines {
    first: f64,
    cell: f64,
    count: usize,
}

impl Splines {
    fn along(map: &Fogmap, axis: usize) -> Self {
        let columns = map.coefficients.first().map_or(0, Vec::len);
        let count = if axis == 0 { columns } else { map.coefficients.len() };
        // A spline of degree d reaches over d + 1 cells.
        let first = map.origin[axis] + 0.5 * f64::from(map.degree + 1) * map.cell_m;
        Self { first, cell: map.cell_m, count }
    }

    fn center(&self, i: usize) -> f64 {
        self.first + self.cell * i as f64
    }

    fn between(&self, min: f64, max: f64) -> std::ops::Range<usize> {
        let place = |x: f64| ((x - self.first) / self.cell).clamp(-1.0, self.count as f64);
        let (begin, end) =
            (place(min).ceil().max(0.0) as usize, (place(max).floor() + 1.0) as usize);
        begin..end.min(self.count)
    }
}
