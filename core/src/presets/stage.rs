//! Short ways to write the parts of a scene; every number is rounded, so that its JSON is short.

use super::geometry::MeshBuilder;
use crate::light::{Spot, Sun};
use crate::media::emitter::Emitter;
use crate::media::functions::{Cosine, Functions, Member, WaveVector};
pub use crate::rounding::{round_to, rounded};
use crate::scene::{
    Airlight, Albedo, Blob, Camera, Environment, Fog, Gaussians, Heightfield, Homogeneous, Light,
    Material, Mesh, Perspective, Point, Projection, Radiance, Rgb, Shape, Sphere, Surface,
    SurfaceLighting, Term, Vec3,
};
use crate::sky::{Fineness, HarmonicSky, around, harmonics};
use glam::DVec3;

/// A perspective camera.
pub fn camera(position: [f64; 3], target: [f64; 3], vertical_fov_deg: f64) -> Camera {
    Camera {
        position: Vec3(position),
        target: Vec3(target),
        projection: Projection::Perspective(Perspective { vertical_fov_deg }),
        ..Camera::default()
    }
}

/// A surface of triangles.
pub fn mesh(id: &str, mesh: Mesh, material: Material) -> Surface {
    Surface { id: Some(id.into()), shape: Shape::Mesh(mesh), material, ..Surface::default() }
}

/// A ball.
pub fn sphere(id: &str, center: DVec3, radius: f64, material: Material) -> Surface {
    let shape = Shape::Sphere(Sphere { center: rounded(center, 1e3), radius });
    Surface { id: Some(id.into()), shape, material, ..Surface::default() }
}

/// A material without gloss.
pub fn matte(diffuse: [f64; 3]) -> Material {
    Material { diffuse: Albedo(diffuse), ..Material::default() }
}

/// A material with a highlight: its strength and its exponent.
pub fn glossy(diffuse: [f64; 3], specular: f64, shininess: f64) -> Material {
    Material { specular: Rgb::splat(specular), shininess, ..matte(diffuse) }
}

/// A material that glows by itself.
pub fn glowing(emission: [f64; 3]) -> Material {
    Material { emission: Rgb(emission), ..matte([0.02, 0.02, 0.02]) }
}

/// A point lamp.
pub fn lamp(id: &str, position: DVec3, intensity: [f64; 3]) -> Light {
    Light::Point(Point {
        id: Some(id.into()),
        position: rounded(position, 1e3),
        intensity: Rgb(intensity),
        ..Point::default()
    })
}

/// A lamp that shines into a cone: half angles of where it is full and where it ends [degrees].
pub fn spot(
    id: &str,
    position: DVec3,
    direction: DVec3,
    [inner_angle_deg, outer_angle_deg]: [f64; 2],
    intensity: [f64; 3],
) -> Light {
    Light::Spot(Spot {
        id: Some(id.into()),
        position: rounded(position, 1e3),
        direction: rounded(direction, 1e3),
        inner_angle_deg,
        outer_angle_deg,
        intensity: Rgb(intensity),
        ..Spot::default()
    })
}

/// The same light where it stands for what comes from everywhere: nothing hides it.
pub fn fill(light: Light) -> Light {
    match light {
        Light::Point(light) => Light::Point(Point { shadows: false, ..light }),
        Light::Spot(light) => Light::Spot(Spot { shadows: false, ..light }),
        Light::Sun(light) => Light::Sun(Sun { shadows: false, ..light }),
        Light::Environment(sky) => Light::Environment(sky),
    }
}

/// The same surface as glass: it throws no shadow.
pub fn glass(surface: Surface) -> Surface {
    Surface { shadows: false, ..surface }
}

/// A sky as bright as a function of the direction says, to six bands of harmonics.
pub fn sky(radiance: impl Fn(DVec3) -> DVec3) -> Light {
    const ORDER: usize = 6;
    let mut sums = vec![DVec3::ZERO; ORDER * ORDER];
    let fineness = Fineness::REFERENCE;
    for (toward, weight) in around(DVec3::Y, &fineness.even(), fineness.azimuths) {
        let values = harmonics::all(ORDER, toward);
        let light = radiance(toward) * weight;
        sums.iter_mut().zip(values).for_each(|(sum, value)| *sum += light * value);
    }
    let coefficients = sums.into_iter().map(|sum| Rgb(rounded(sum, 1e4).0)).collect();
    Light::Environment(Environment {
        id: Some("sky".into()),
        radiance: Radiance::HarmonicSky(HarmonicSky { coefficients }),
        ..Environment::default()
    })
}

/// Light from the sun or a part of the sky: where it travels, and what a surface facing it gets [W/m²].
pub fn sun(id: &str, direction: [f64; 3], irradiance: [f64; 3]) -> Light {
    Light::Sun(Sun {
        id: Some(id.into()),
        direction: Vec3(direction),
        irradiance: Rgb(irradiance),
        ..Sun::default()
    })
}

/// A square of land about the origin: its side [m], heights along each side, what each is rounded to 1 / of,
/// and how high the ground lies at x and z [m].
pub fn land(
    id: &str,
    size: f64,
    side: usize,
    steps: f64,
    height: impl Fn(f64, f64) -> f64,
    material: Material,
) -> Surface {
    let at = |k: usize| size * (k as f64 / (side - 1) as f64 - 0.5);
    let row = |j: usize| (0..side).map(|i| round_to(height(at(i), at(j)), steps)).collect();
    let heights = (0..side).map(row).collect();
    let origin = Vec3([-size / 2.0, 0.0, -size / 2.0]);
    let shape = Shape::Heightfield(Heightfield { origin, size: [size, size], heights });
    Surface { id: Some(id.into()), shape, material, ..Surface::default() }
}

/// Still water about the origin: the side of its square and its level [m].
pub fn water(id: &str, size: f64, level: f64, material: Material) -> Surface {
    let mut sheet = MeshBuilder::default();
    let half = size / 2.0;
    let corners = [[-half, half], [half, half], [half, -half], [-half, -half]];
    sheet.face(corners.map(|[x, z]| DVec3::new(x, level, z)));
    mesh(id, sheet.flat(), material)
}

/// A blob whose length along a ray through its centre holds `depth` of optical depth.
pub fn blob(center: DVec3, radius: f64, depth: f64) -> Blob {
    let radius = round_to(radius, 1e3);
    let extinction = depth / (radius * std::f64::consts::PI.sqrt());
    Blob { center: rounded(center, 1e3), radius, extinction: round_to(extinction, 1e6).into() }
}

/// Fog as Biri and Giroud draw it: a veil of some radiance, and light as in clear air.
pub fn veil(ambient: [f64; 3], term: Term) -> Fog {
    Fog {
        ambient: Rgb(ambient),
        airlight: Airlight::None,
        surface_lighting: SurfaceLighting::Clear,
        terms: vec![term],
        ..Fog::default()
    }
}

/// Fog made of blobs.
pub fn gaussians(id: &str, blobs: Vec<Blob>) -> Term {
    Term::Gaussians(Gaussians { id: Some(id.into()), blobs: blobs.into(), ..Gaussians::default() })
}

/// Fog that is the same everywhere.
pub fn homogeneous(id: &str, extinction: f64) -> Term {
    Term::Homogeneous(Homogeneous {
        id: Some(id.into()),
        extinction: Some(extinction.into()),
        ..Homogeneous::default()
    })
}

/// Fog made of functions, their sum times `scale` [1/m].
pub fn functions(id: &str, scale: f64, members: Vec<Member>) -> Term {
    Term::Functions(Functions {
        id: Some(id.into()),
        scale: scale.into(),
        members,
        ..Functions::default()
    })
}

/// A wave, or a constant where the wave vector [rad/m] is 0.
pub fn wave(amplitude: f64, wave_vector: [f64; 3]) -> Member {
    let wave_vector = WaveVector(wave_vector.map(|k| round_to(k, 1e6)));
    Member::Cosine(Cosine { amplitude, wave_vector, ..Cosine::default() })
}

/// A source of particles, with a name.
pub fn emitter(id: &str, emitter: Emitter) -> Term {
    Term::Emitter(Emitter { id: Some(id.into()), ..emitter })
}
