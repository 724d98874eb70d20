//! The one gate: every number of a scene is looked at once, before anything is computed from it.

use super::*;
use crate::airlight::Method;
use crate::json::limits::{self, COUNTS};
use crate::light::Source;
use crate::media::sign::{Negative, decides_sign, negative};
use crate::media::{Common, Field};
use crate::sky::Radiance;
use glam::DVec3;
use std::collections::HashSet;
use std::sync::Arc;

/// A scene whose every value was checked. Cloning is cheap.
#[derive(Clone, Debug)]
pub struct CheckedScene(Arc<Scene>);

/// A lamp, with where its light comes from.
#[derive(Clone, Copy, Debug)]
pub struct Lit<'a> {
    /// The lamp.
    pub light: &'a Light,
    /// Where its light comes from.
    pub source: Source,
    /// Colour and strength, in the unit of its kind.
    pub strength: DVec3,
}

impl CheckedScene {
    /// The enabled lamps with their places in the scene's list of lights.
    pub fn lamps(&self) -> impl Iterator<Item = (usize, Lit<'_>)> {
        let path_m = self.fog.light_path_m;
        self.enabled().filter_map(move |(i, light)| {
            let (source, strength) = light.lamp(path_m)?;
            Some((i, Lit { light, source, strength }))
        })
    }

    /// The enabled skies, likewise.
    pub fn skies(&self) -> impl Iterator<Item = (usize, &Radiance)> {
        self.enabled().filter_map(|(i, light)| Some((i, &light.sky()?.radiance)))
    }

    fn enabled(&self) -> impl Iterator<Item = (usize, &Light)> {
        self.lights.iter().enumerate().filter(|(_, light)| light.enabled())
    }

    /// What a ray in a direction sees where it meets nothing [W/(m² sr)].
    pub fn behind_all(&self, direction: DVec3) -> DVec3 {
        let mut skies = self.skies().map(|(_, sky)| sky.toward(direction)).peekable();
        if skies.peek().is_none() { self.background.vector() } else { skies.sum() }
    }

    /// The same scene as somebody sees it: through another camera, or at another time.
    ///
    /// # Errors
    /// What is wrong with these, with pointers into the scene.
    pub fn seen(&self, camera: Option<Camera>, time_s: Option<f64>) -> Result<Self, Vec<Problem>> {
        let mut scene = (**self).clone();
        scene.camera = camera.unwrap_or(scene.camera);
        scene.time_s = time_s.unwrap_or(scene.time_s);
        scene.check_after(self)
    }

    /// The same through a camera that is known to look somewhere.
    pub(crate) fn seen_by(&self, camera: Camera) -> Self {
        Self(Arc::new(Scene { camera, ..(**self).clone() }))
    }

    /// What computes airlight, if an estimator is asked for, in an extinction of this scene.
    pub fn matched(&self, asked: Method, field: &Field) -> Method {
        asked.matched(&self.fog.scatterings(), field)
    }
}

impl std::ops::Deref for CheckedScene {
    type Target = Scene;

    fn deref(&self) -> &Scene {
        &self.0
    }
}

impl Scene {
    /// Looks at every value, before anything is computed from it.
    ///
    /// # Errors
    /// Everything that is wrong, each with its JSON pointer relative to the scene.
    pub fn check(self) -> Result<CheckedScene, Vec<Problem>> {
        let mut check = Checker::default();
        self.check_into(&mut check);
        self.checked(check)
    }

    /// The same, of a scene that was made from a checked one: what they share is not looked at again.
    ///
    /// # Errors
    /// As [`Scene::check`].
    pub fn check_after(self, known: &CheckedScene) -> Result<CheckedScene, Vec<Problem>> {
        let mut check = Checker::default();
        self.check_beside(Some(known), &mut check);
        self.checked(check)
    }

    /// Gives ids to surfaces, lights and terms that have none: the first free one of `light-1`, `light-2` and so on.
    pub fn name_all(&mut self) {
        name_each("surface", self.surfaces.iter_mut().map(|surface| &mut surface.id));
        name_each("light", self.lights.iter_mut().map(Light::id_mut));
        name_each("term", self.fog.terms.iter_mut().map(Term::id_mut));
    }

    /// The scene, if nothing was refused in it nor around it.
    pub(crate) fn checked(self, check: Checker) -> Result<CheckedScene, Vec<Problem>> {
        check.finish(()).map(|()| CheckedScene(Arc::new(self)))
    }

    pub(crate) fn check_into(&self, check: &mut Checker) {
        self.check_beside(None, check);
    }

    fn check_beside(&self, known: Option<&Scene>, check: &mut Checker) {
        self.camera.check(check);
        check.triple(self.background.0, limits::INTENSITY, || "/background".into());
        check_surfaces(check, &self.surfaces, known.map_or(&[], |known| &known.surfaces));
        check_lights(check, &self.lights);
        check_fog(check, &self.fog, self.far_m, known);
        if let Some(detail) = self.fog.refusal(self.fog.airlight) {
            check.refuse(Code::Conflict, || "/fog/airlight".into(), detail);
        }
        check.number(self.time_s, limits::TIME, || "/time_s".into());
        check.number(self.far_m, limits::FAR, || "/far_m".into());
    }
}

fn name_each<'a>(what: &str, ids: impl Iterator<Item = &'a mut Option<String>>) {
    let ids: Vec<_> = ids.collect();
    if ids.iter().all(|id| id.is_some()) {
        return;
    }
    let taken: HashSet<_> = ids.iter().filter_map(|id| (**id).clone()).collect();
    let mut free = (1..).map(|i| format!("{what}-{i}")).filter(|id| !taken.contains(id));
    for id in ids.into_iter().filter(|id| id.is_none()) {
        *id = free.next();
    }
}

fn check_ids<'a>(check: &mut Checker, list: &str, ids: impl Iterator<Item = Option<&'a str>>) {
    let mut seen = HashSet::new();
    for (i, id) in ids.enumerate() {
        let Some(id) = id else { continue };
        let pointer = || format!("/{list}/{i}/id");
        if id.is_empty() || id.chars().count() > COUNTS.id_chars {
            let detail = format!("an id has 1 to {} characters", COUNTS.id_chars);
            check.refuse(Code::WrongLength, pointer, detail);
        } else if !seen.insert(id) {
            let detail = format!("`{id}` is not unique in {list}");
            check.refuse(Code::DuplicateId, pointer, detail);
        }
    }
}

impl Camera {
    /// Looks at all of its numbers, and whether it looks anywhere; pointers begin with `/camera`.
    pub(crate) fn check(&self, check: &mut Checker) {
        check_camera(check, self);
    }
}

fn check_camera(check: &mut Checker, camera: &Camera) {
    let at = |name: &str| format!("/camera/{name}");
    let found = check.found();
    check.triple(camera.position.0, limits::COORDINATE, || at("position"));
    check.triple(camera.target.0, limits::COORDINATE, || at("target"));
    check.direction(camera.up, || at("up"));
    match &camera.projection {
        Projection::Perspective(p) => {
            check.number(p.vertical_fov_deg, limits::FIELD_OF_VIEW, || {
                at("projection/vertical_fov_deg")
            });
        }
        Projection::Orthographic(o) => {
            check.number(o.height_m, limits::RADIUS, || at("projection/height_m"));
        }
    }
    if check.found() > found {
        return;
    }
    let forward = (camera.target.vector() - camera.position.vector()).normalize_or_zero();
    if forward == DVec3::ZERO {
        check.refuse(Code::Conflict, || at("target"), "the target must differ from the position");
    } else if forward.cross(camera.up.vector().normalize()).length() < 1e-9 {
        check.refuse(Code::Conflict, || at("up"), "up must not lie along the view");
    }
}

/// Those that stand in `known` at the same place are known to be right.
fn check_surfaces(check: &mut Checker, surfaces: &[Surface], known: &[Surface]) {
    check.count(surfaces.len(), COUNTS.surfaces, "surfaces", || "/surfaces".into());
    check_ids(check, "surfaces", surfaces.iter().map(|s| s.id.as_deref()));
    let (mut triangles, mut vertices) = (0usize, 0usize);
    for (i, surface) in surfaces.iter().enumerate() {
        let at = |name: &str| format!("/surfaces/{i}/{name}");
        if known.get(i) != Some(surface) {
            check_material(check, &surface.material, at);
            check_shape(check, &surface.shape, at);
        }
        let (t, v) = surface.shape.counts();
        (triangles, vertices) = (triangles.saturating_add(t), vertices.saturating_add(v));
        let list = || {
            at(if matches!(surface.shape, Shape::Mesh(_)) {
                "shape/indices"
            } else {
                "shape/heights"
            })
        };
        check.count(triangles, COUNTS.triangles, "triangles", list);
        check.count(vertices, COUNTS.vertices, "vertices", || at("shape/positions"));
        if triangles > COUNTS.triangles || vertices > COUNTS.vertices {
            return;
        }
    }
}

fn check_material(check: &mut Checker, material: &Material, at: impl Fn(&str) -> String) {
    check.triple(material.diffuse.0, limits::FRACTION, || at("material/diffuse"));
    check.triple(material.specular.0, limits::INTENSITY, || at("material/specular"));
    check.number(material.shininess, limits::SHININESS, || at("material/shininess"));
    check.triple(material.emission.0, limits::INTENSITY, || at("material/emission"));
}

impl Shape {
    /// Triangles and vertices that this shape adds to the scene's sums.
    fn counts(&self) -> (usize, usize) {
        match self {
            Self::Mesh(mesh) => (mesh.indices.len(), mesh.positions.len()),
            Self::Heightfield(field) => {
                let columns = field.heights.first().map_or(0, Vec::len);
                let cells = field.heights.len().saturating_sub(1) * columns.saturating_sub(1);
                (2 * cells, 0)
            }
            Self::Plane(_) | Self::Sphere(_) | Self::Box(_) => (0, 0),
        }
    }
}

fn check_shape(check: &mut Checker, shape: &Shape, at: impl Fn(&str) -> String + Copy) {
    match shape {
        Shape::Plane(plane) => {
            check.triple(plane.point.0, limits::COORDINATE, || at("shape/point"));
            check.direction(plane.normal, || at("shape/normal"));
        }
        Shape::Sphere(sphere) => {
            check.triple(sphere.center.0, limits::COORDINATE, || at("shape/center"));
            check.number(sphere.radius, limits::RADIUS, || at("shape/radius"));
        }
        Shape::Box(b) => {
            check.triple(b.min.0, limits::COORDINATE, || at("shape/min"));
            check.triple(b.max.0, limits::COORDINATE, || at("shape/max"));
            for axis in (0..3).filter(|&k| b.min.0[k] >= b.max.0[k]) {
                check.refuse(
                    Code::Conflict,
                    || at(&format!("shape/max/{axis}")),
                    "max must lie above min",
                );
            }
        }
        Shape::Mesh(mesh) => check_mesh(check, mesh, at),
        Shape::Heightfield(field) => check_heightfield(check, field, at),
    }
}

fn check_mesh(check: &mut Checker, mesh: &Mesh, at: impl Fn(&str) -> String + Copy) {
    for (i, position) in mesh.positions.iter().enumerate() {
        check.triple(position.0, limits::COORDINATE, || at(&format!("shape/positions/{i}")));
    }
    let vertices = mesh.positions.len();
    for (i, triangle) in mesh.indices.iter().enumerate() {
        for (k, _) in triangle.iter().enumerate().filter(|(_, v)| **v as usize >= vertices) {
            let detail = format!("there are only {vertices} positions");
            check.refuse(Code::Conflict, || at(&format!("shape/indices/{i}/{k}")), detail);
        }
    }
    let Some(normals) = &mesh.normals else { return };
    if normals.len() != vertices {
        let detail = format!("{} normals do not match {vertices} positions", normals.len());
        check.refuse(Code::Conflict, || at("shape/normals"), detail);
    }
    for (i, normal) in normals.iter().enumerate() {
        check.direction(*normal, || at(&format!("shape/normals/{i}")));
    }
}

fn check_heightfield(check: &mut Checker, field: &Heightfield, at: impl Fn(&str) -> String + Copy) {
    check.triple(field.origin.0, limits::COORDINATE, || at("shape/origin"));
    for (k, size) in field.size.into_iter().enumerate() {
        check.number(size, limits::RADIUS, || at(&format!("shape/size/{k}")));
    }
    let columns = field.heights.first().map_or(0, Vec::len);
    let detail = "a heightfield has at least 2×2 heights";
    if field.heights.len() < 2 {
        check.refuse(Code::WrongLength, || at("shape/heights"), detail);
    } else if columns < 2 {
        check.refuse(Code::WrongLength, || at("shape/heights/0"), detail);
    }
    for (j, row) in field.heights.iter().enumerate() {
        if row.len() != columns {
            let detail = format!("this row has {} heights, the first {columns}", row.len());
            check.refuse(Code::Conflict, || at(&format!("shape/heights/{j}")), detail);
        }
        for (i, height) in row.iter().enumerate() {
            check.number(*height, limits::COORDINATE, || at(&format!("shape/heights/{j}/{i}")));
        }
    }
}

fn check_lights(check: &mut Checker, lights: &[Light]) {
    check.count(lights.len(), COUNTS.lights, "lights", || "/lights".into());
    check_ids(check, "lights", lights.iter().map(Light::id));
    for (i, light) in lights.iter().enumerate().take(COUNTS.lights) {
        light.check(check, &|name| format!("/lights/{i}/{name}"));
    }
}

fn check_common(check: &mut Checker, term: &Term, at: &dyn Fn(&str) -> String) {
    let Common { albedo, phase, wind_response, .. } = term.common();
    if let Some(albedo) = albedo {
        check.triple(albedo.0, limits::FRACTION, || at("albedo"));
    }
    if let Some(phase) = phase {
        phase.check(check, || at("phase"));
    }
    check.number(wind_response, limits::FRACTION, || at("wind_response"));
}

fn check_fog(check: &mut Checker, fog: &Fog, far_m: f64, known: Option<&Scene>) {
    let found = check.found();
    check.triple(fog.albedo.0, limits::FRACTION, || "/fog/albedo".into());
    fog.phase.check(check, || "/fog/phase".into());
    check.triple(fog.ambient.0, limits::INTENSITY, || "/fog/ambient".into());
    check.number(fog.light_path_m, limits::DISTANCE, || "/fog/light_path_m".into());
    let at = |name: &str| format!("/fog/multiple_scattering/{name}");
    fog.multiple_scattering.check(check, &at);
    fog.noise.check(check, &|name| format!("/fog/noise/{name}"));
    fog.wind.check(check, &|name| format!("/fog/wind/{name}"));
    check.count(fog.terms.len(), COUNTS.terms, "terms", || "/fog/terms".into());
    check_ids(check, "fog/terms", fog.terms.iter().map(|term| term.common().id));
    // Terms of `known` at the same place are known to be right, for rays of the same length.
    let known = known.filter(|known| known.far_m == far_m).map(|known| &known.fog);
    let mut blobs = 0usize;
    for (i, term) in fog.terms.iter().enumerate().take(COUNTS.terms) {
        let at = |name: &str| format!("/fog/terms/{i}/{name}");
        blobs = blobs.saturating_add(term.blobs());
        check.count(blobs, COUNTS.blobs, "blobs", || at(term.counted_at()));
        if blobs > COUNTS.blobs {
            return;
        }
        if known.and_then(|known| known.terms.get(i)) != Some(term) {
            check_common(check, term, &at);
            term.check(check, &at, far_m);
        }
    }
    // What was refused may be anything.
    if check.found() == found
        && !known.is_some_and(|known| is_as_positive(fog, known))
        && let Some(Negative { point, time_s, beta }) = negative(&fog.terms, &fog.wind)
    {
        let detail = format!("the extinction is negative, {beta} 1/m, at {point} m and {time_s} s");
        check.refuse(Code::Conflict, || "/fog/terms".into(), detail);
    }
}

/// Whether a fog is the same as another in all that could make it negative.
fn is_as_positive(fog: &Fog, other: &Fog) -> bool {
    let signed = |fog: &Fog| -> Vec<Term> {
        fog.terms.iter().filter(|term| decides_sign(term)).cloned().collect()
    };
    fog.wind == other.wind && signed(fog) == signed(other)
}
