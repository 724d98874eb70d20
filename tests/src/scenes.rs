//! Scenes, rays and frames for the laws: a seeded source of numbers, and both ways to look at a
//! scene, as a picture and ray by ray.

#![allow(clippy::expect_used, reason = "a test that cannot make its scene has failed")]

use fogbank_core::media::{Field, Moment};
use fogbank_core::probe::RayAnswer;
use fogbank_core::request::{Layer, ProbeRay, Quality, RenderRequest, View};
use fogbank_core::scene::{CheckedScene, Fog, Projection, Scene, read};
use fogbank_core::{Frame, Progress, Renderer};
use glam::{DVec2, DVec3};
use serde_json::{Value, json};

/// The extinction of some terms, red and at no time.
pub fn field(terms: &[Value]) -> Field {
    let fog: Fog = read(json!({ "terms": terms }).to_string().as_bytes()).expect("a fog");
    Field::new(&fog.terms, 0, &Moment::default())
}

/// SplitMix64: the same numbers in every run.
#[derive(Clone, Debug)]
pub struct Random(pub u64);

impl Random {
    /// 64 even bits.
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let a = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let b = (a ^ (a >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        b ^ (b >> 31)
    }

    /// Even between two numbers.
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * (self.bits() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Even in the logarithm.
    pub fn decades(&mut self, low: f64, high: f64) -> f64 {
        self.between(low.ln(), high.ln()).exp()
    }

    /// A point of a cube around the origin.
    pub fn point(&mut self, half: f64) -> DVec3 {
        DVec3::from_array([0; 3].map(|_| self.between(-half, half)))
    }

    /// A unit vector, even over the sphere.
    pub fn direction(&mut self) -> DVec3 {
        loop {
            let point = self.point(1.0);
            if (0.01..1.0).contains(&point.length_squared()) {
                return point.normalize();
            }
        }
    }

    /// A term of `count` blobs in a cube, with radii and extinctions even in the logarithm.
    pub fn blobs(
        &mut self,
        count: usize,
        half: f64,
        radius: [f64; 2],
        extinction: [f64; 2],
    ) -> Value {
        let mut blob = || {
            let center = self.point(half).to_array();
            let radius = self.decades(radius[0], radius[1]);
            let extinction = self.decades(extinction[0], extinction[1]);
            json!({ "center": center, "radius": radius, "extinction": extinction })
        };
        let blobs: Vec<_> = (0..count).map(|_| blob()).collect();
        json!({ "kind": "gaussians", "blobs": blobs })
    }

    /// Lamps in a cube.
    pub fn lamps(&mut self, count: usize, half: f64) -> Value {
        let mut lamp = || {
            let intensity = [0; 3].map(|_| self.between(5.0, 100.0));
            json!({ "kind": "point", "position": self.point(half).to_array(),
                    "intensity": intensity, "shadows": false })
        };
        (0..count).map(|_| lamp()).collect()
    }
}

/// A homogeneous term.
pub fn homogeneous(extinction: f64) -> Value {
    json!({ "kind": "homogeneous", "extinction": extinction })
}

/// A floor and one of every shape that has an end, in various materials.
pub fn surfaces() -> Value {
    json!([
        { "shape": { "kind": "plane", "point": [0, -2, 0], "normal": [0.1, 1, 0.05] },
          "material": { "diffuse": [0.6, 0.5, 0.4], "specular": [0.3, 0.3, 0.3], "shininess": 30 } },
        { "shape": { "kind": "sphere", "center": [-2, 0, -1], "radius": 1.2 },
          "material": { "diffuse": [0.8, 0.2, 0.2], "emission": [0.1, 0.2, 0.3] } },
        { "shape": { "kind": "box", "min": [0.5, -1.5, -2], "max": [2, 0.5, 0] },
          "material": { "diffuse": [0.2, 0.7, 0.3], "specular": [1, 1, 1], "shininess": 8 } },
        { "shape": { "kind": "mesh", "positions": [[-1, 1, -3], [2, 1, -3], [0.5, 3, -4]],
                     "indices": [[0, 1, 2]],
                     "normals": [[-0.3, 0, 1], [0.3, 0, 1], [0, 0.3, 1]] } },
        { "shape": { "kind": "heightfield", "origin": [-6, -2, -8], "size": [12, 5],
                     "heights": [[0, 1, 0.5, 0], [1, 2.5, 2, 0.3], [0, 0.5, 1, 0.1]] } },
    ])
}

/// The scene, checked.
pub fn scene(json: &Value) -> CheckedScene {
    let scene: Scene = read(json.to_string().as_bytes()).expect("a scene");
    scene.check().expect("a valid scene")
}

/// A request for a picture, checked.
pub fn request(json: &Value) -> (CheckedScene, View) {
    let request: RenderRequest = read(json.to_string().as_bytes()).expect("a render request");
    request.check().expect("a valid render request")
}

/// A view of that size with pixel centres only.
pub fn view(width: u32, height: u32, layer: Layer, quality: Quality) -> View {
    let size = json!({ "scene": {}, "width": width, "height": height });
    View { layer, quality, samples: Some(1), ..request(&size).1 }
}

/// Renders a view with a renderer of its own.
pub fn render(scene: &CheckedScene, view: &View) -> Frame {
    Renderer::default().render(scene, view, &Progress::default()).expect("not interrupted")
}

/// Evaluates rays in f64.
pub fn probe(scene: &CheckedScene, rays: &[ProbeRay]) -> Vec<RayAnswer> {
    Renderer::default().probe(scene, rays, &Progress::default()).expect("not interrupted")
}

/// A ray between two points.
pub fn segment(from: DVec3, to: DVec3) -> ProbeRay {
    let direction = (to - from).normalize();
    ProbeRay { origin: from, direction, max_distance_m: Some(from.distance(to)) }
}

/// The rays through the pixels' centres, top row first, as the contract states them.
pub fn pixel_rays(scene: &CheckedScene, width: u32, height: u32) -> Vec<ProbeRay> {
    let camera = &scene.camera;
    let position = camera.position.vector();
    let forward = (camera.target.vector() - position).normalize();
    let right = forward.cross(camera.up.vector()).normalize();
    let up = right.cross(forward);
    let size = DVec2::new(f64::from(width), f64::from(height));
    let ray = |x: u32, y: u32| {
        let at = DVec2::new(f64::from(x), f64::from(y)) + 0.5;
        // From the picture's middle, in units of half its height.
        let (across, down) = ((2.0 * at.x - size.x) / size.y, (2.0 * at.y - size.y) / size.y);
        let aside = across * right - down * up;
        let (origin, direction) = match &camera.projection {
            Projection::Perspective(p) => {
                let half = (0.5 * p.vertical_fov_deg.to_radians()).tan();
                (position, (forward + half * aside).normalize())
            }
            Projection::Orthographic(o) => (position + 0.5 * o.height_m * aside, forward),
        };
        ProbeRay { origin, direction, max_distance_m: None }
    };
    (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| ray(x, y)).collect()
}
