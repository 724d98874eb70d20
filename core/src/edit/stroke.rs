//! Strokes: points that a hand drew, brought onto what it draws on.

use super::particles::Spray;
use super::{Desk, Refused};
use crate::json::limits::{self, COUNTS};
use crate::json::{Checker, Code, Vec3};
use crate::scene::{CheckedScene, Projection};
use glam::DVec3;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::value::MapAccessDeserializer;
use serde::de::{Deserializer, Error, MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Serialize};
use std::fmt;

/// A point of a stroke: a position, or one with the pressure of the hand there.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct StrokePoint {
    /// Where [m].
    pub position: Vec3,
    /// How hard, from 0 to 1.
    pub pressure: f64,
}

/// A point of a stroke with the pressure of the hand there.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Pressed {
    /// Where [m].
    position: Vec3,
    /// How hard, from 0 to 1: the share of the extinction that is laid on.
    #[schemars(range(min = limits::FRACTION.min, max = limits::FRACTION.max))]
    pressure: f64,
}

impl<'de> Deserialize<'de> for StrokePoint {
    fn deserialize<D: Deserializer<'de>>(input: D) -> Result<Self, D::Error> {
        input.deserialize_any(PointVisitor)
    }
}

impl JsonSchema for StrokePoint {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "StrokePoint".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "description": "A point of a stroke: a position, or one with the pressure of the hand there.",
            "anyOf": [generator.subschema_for::<Vec3>(), generator.subschema_for::<Pressed>()],
        })
    }
}

struct PointVisitor;

impl<'de> Visitor<'de> for PointVisitor {
    type Value = StrokePoint;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("[x, y, z] or {position, pressure}")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut items: A) -> Result<StrokePoint, A::Error> {
        let mut position = [0.0; 3];
        for (i, value) in position.iter_mut().enumerate() {
            *value = items.next_element()?.ok_or_else(|| Error::invalid_length(i, &self))?;
        }
        Ok(StrokePoint { position: Vec3(position), pressure: 1.0 })
    }

    fn visit_map<A: MapAccess<'de>>(self, members: A) -> Result<StrokePoint, A::Error> {
        let Pressed { position, pressure } =
            Pressed::deserialize(MapAccessDeserializer::new(members))?;
        Ok(StrokePoint { position, pressure })
    }
}

/// What a stroke is drawn on.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum Onto {
    /// An infinite plane: points are brought to the nearest place of it.
    Plane(OntoPlane),
    /// The surfaces that the points are seen on.
    Word(OntoWord),
}

/// The surfaces, as the eye sees the points on them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum OntoWord {
    /// The first surface on the way from the eye through the point; a point that is seen on none is left out.
    Surfaces,
}

/// A plane to draw on.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct OntoPlane {
    /// Any point of it [m].
    pub point: Vec3,
    /// Its normal; any length but zero.
    #[schemars(extend("not" = { "const": [0, 0, 0] }))]
    pub normal: Vec3,
}

/// Looks at the points of a stroke.
pub fn check_points(points: &[StrokePoint], check: &mut Checker, at: &dyn Fn(&str) -> String) {
    check.count(points.len(), COUNTS.stroke_points, "points", || at("points"));
    if points.is_empty() {
        check.refuse(Code::WrongLength, || at("points"), "a stroke has at least one point");
    }
    for (i, point) in points.iter().enumerate().take(COUNTS.stroke_points) {
        check.triple(point.position.0, limits::COORDINATE, || at(&format!("points/{i}")));
        check.number(point.pressure, limits::FRACTION, || at(&format!("points/{i}/pressure")));
    }
}

/// Looks at what a stroke is drawn on.
pub fn check_onto(onto: Option<&Onto>, check: &mut Checker, at: &dyn Fn(&str) -> String) {
    if let Some(Onto::Plane(OntoPlane { point, normal })) = onto {
        check.triple(point.0, limits::COORDINATE, || at("plane/point"));
        check.direction(*normal, || at("plane/normal"));
    }
}

/// Looks at a stroke's id.
pub fn check_stroke(stroke: Option<&str>, check: &mut Checker, at: &dyn Fn(&str) -> String) {
    if stroke.is_some_and(|id| id.is_empty() || id.chars().count() > COUNTS.id_chars) {
        let detail = format!("an id has 1 to {} characters", COUNTS.id_chars);
        check.refuse(Code::WrongLength, || at("stroke"), detail);
    }
}

/// The points where they are drawn.
pub fn drawn(
    points: &[StrokePoint],
    (onto, eye): (Option<&Onto>, Option<Vec3>),
    scene: &CheckedScene,
    desk: &Desk,
) -> Result<Vec<StrokePoint>, Refused> {
    let moved = |to: &dyn Fn(DVec3) -> Option<DVec3>| -> Vec<StrokePoint> {
        let each = points.iter().filter_map(|point| {
            let position = Vec3(to(point.position.vector())?.to_array());
            Some(StrokePoint { position, ..*point })
        });
        each.collect()
    };
    match onto {
        None => Ok(points.to_vec()),
        Some(Onto::Plane(OntoPlane { point, normal })) => {
            let (origin, normal) = (point.vector(), normal.vector().normalize());
            Ok(moved(&|p| Some(p - (p - origin).dot(normal) * normal)))
        }
        Some(Onto::Word(OntoWord::Surfaces)) => {
            let surfaces = (desk.surfaces)(scene)?;
            Ok(moved(&|p| {
                let (from, direction) = sight(scene, eye, p)?;
                let hit = surfaces.first_hit(from, direction, scene.far_m)?;
                Some(from + hit.distance * direction)
            }))
        }
    }
}

/// The view ray through a point, from the eye or as the scene's camera sees it.
fn sight(scene: &CheckedScene, eye: Option<Vec3>, point: DVec3) -> Option<(DVec3, DVec3)> {
    let camera = &scene.camera;
    let from = eye.unwrap_or(camera.position).vector();
    if let (None, Projection::Orthographic(_)) = (eye, &camera.projection) {
        let forward = (camera.target.vector() - from).normalize();
        return Some((point - (point - from).dot(forward) * forward, forward));
    }
    Some((from, (point - from).try_normalize()?))
}

/// Strokes that may go on.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Strokes(Vec<(String, Trail)>);

/// Strokes that are remembered: the newest, one a hand.
const MOST_STROKES: usize = 32;

/// Where a stroke left off.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Trail {
    /// Of the brush.
    Brush(Brush),
    /// Of the airbrush, whose particles are still in the air.
    Spray(Spray),
}

/// Where a brush left off.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Brush {
    /// The last point.
    last: Option<StrokePoint>,
    /// How far behind it the next dab is due [m].
    due_m: f64,
    /// Dabs so far.
    count: u32,
}

/// A place where a brush lays something on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dab {
    /// Where [m].
    pub center: DVec3,
    /// Which way the stroke goes there; its first dab has none.
    pub along: Option<DVec3>,
    /// How hard the hand presses.
    pub pressure: f64,
    /// Its number in the stroke.
    pub number: u32,
}

impl Brush {
    /// Goes on along some points: a dab at the first point, and then one every `spacing_m`, however the stroke is cut
    /// into points and calls.
    ///
    /// # Errors
    /// That there would be more than a scene may hold.
    pub(super) fn go(
        &mut self,
        points: &[StrokePoint],
        spacing_m: f64,
    ) -> Result<Vec<Dab>, Refused> {
        let position = |point: &StrokePoint| point.position.vector();
        let way = self.last.iter().chain(points);
        let lengths = way.clone().zip(way.skip(1)).map(|(a, b)| position(a).distance(position(b)));
        if lengths.sum::<f64>() / spacing_m > COUNTS.blobs as f64 {
            let detail = format!("this stroke is more than {} blobs long", COUNTS.blobs);
            return Err(Refused::Member { member: "points".into(), code: Code::TooMany, detail });
        }
        let mut dabs = Vec::new();
        for point in points {
            match self.last {
                None => {
                    let center = position(point);
                    self.lay(
                        Dab { center, along: None, pressure: point.pressure, number: 0 },
                        &mut dabs,
                    );
                    self.due_m = spacing_m;
                }
                Some(last) => self.follow(&last, point, spacing_m, &mut dabs),
            }
            self.last = Some(*point);
        }
        Ok(dabs)
    }

    fn follow(
        &mut self,
        last: &StrokePoint,
        point: &StrokePoint,
        spacing_m: f64,
        dabs: &mut Vec<Dab>,
    ) {
        let way = point.position.vector() - last.position.vector();
        let length = way.length();
        while self.due_m <= length {
            let share = if length > 0.0 { self.due_m / length } else { 0.0 };
            let dab = Dab {
                center: last.position.vector() + share * way,
                along: way.try_normalize(),
                pressure: last.pressure + share * (point.pressure - last.pressure),
                number: 0,
            };
            self.lay(dab, dabs);
            self.due_m += spacing_m;
        }
        self.due_m -= length;
    }

    fn lay(&mut self, dab: Dab, dabs: &mut Vec<Dab>) {
        dabs.push(Dab { number: self.count, ..dab });
        self.count = self.count.wrapping_add(1);
    }
}

impl Strokes {
    /// Where that stroke of a brush left off.
    pub fn brush(&self, stroke: Option<&str>) -> Brush {
        match self.find(stroke) {
            Some(Trail::Brush(brush)) => brush.clone(),
            _ => Brush::default(),
        }
    }

    /// The particles of that stroke that are still in the air.
    pub fn spray(&self, stroke: Option<&str>) -> Option<Spray> {
        match self.find(stroke) {
            Some(Trail::Spray(spray)) => Some(spray.clone()),
            _ => None,
        }
    }

    fn find(&self, stroke: Option<&str>) -> Option<&Trail> {
        let (_, trail) = self.0.iter().find(|(id, _)| Some(id.as_str()) == stroke)?;
        Some(trail)
    }

    /// Remembers where a stroke left off.
    pub fn leave(&mut self, stroke: Option<&str>, trail: Trail) {
        let Some(id) = stroke else { return };
        self.0.retain(|(other, _)| other != id);
        self.0.push((id.to_owned(), trail));
        let excess = self.0.len().saturating_sub(MOST_STROKES);
        self.0.drain(..excess);
    }

    /// Freezes what is in the air, but for one stroke: other changes may shift its blobs.
    pub fn settle_but(&mut self, stroke: Option<&str>) {
        self.0
            .retain(|(id, trail)| matches!(trail, Trail::Brush(_)) || Some(id.as_str()) == stroke);
    }
}

/// How far a point is from a polyline [m].
pub fn distance(points: &[StrokePoint], to: DVec3) -> f64 {
    let each = |a: DVec3, b: DVec3| {
        let way = b - a;
        let share = ((to - a).dot(way) / way.length_squared()).clamp(0.0, 1.0);
        let nearest = if share.is_finite() { a + share * way } else { a };
        to.distance(nearest)
    };
    let positions = || points.iter().map(|point| point.position.vector());
    let first = positions().next().map_or(f64::INFINITY, |p| to.distance(p));
    positions().zip(positions().skip(1)).map(|(a, b)| each(a, b)).fold(first, f64::min)
}

/// The box around some points, and so much around that [m].
pub fn bounds(points: &[StrokePoint], margin: f64) -> (DVec3, DVec3) {
    let positions = points.iter().map(|point| point.position.vector());
    let none = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let (min, max) = positions.fold(none, |(min, max), p| (min.min(p), max.max(p)));
    (min - margin, max + margin)
}
