//! A city at night with fog drifting through its streets.

use super::Preset;
use super::geometry::{Facade, MeshBuilder, rod};
use super::stage::{blob, camera, gaussians, glossy, glowing, lamp, matte, mesh, sky};
use crate::random::Random;
use crate::scene::{Blob, Fog, Light, Rgb, Scene, Surface};
use glam::{DVec2, DVec3};

/// Blobs of fog in the paper's figure.
const BLOBS: usize = 353;
/// City blocks along each side.
const BLOCKS: i32 = 6;
/// From street to street [m].
const PITCH: f64 = 46.0;
/// Width of a street with its pavements [m].
const STREET: f64 = 16.0;

/// Fog in the streets of a city, by night and by day.
pub fn presets() -> [Preset; 2] {
    [
        Preset {
            name: "city-353",
            title: "City in drifting fog",
            description: "Fog drifts through the streets of a city at night and takes the colour of \
                the lamps below it: 353 blobs, as in the city of Fogshop 2007, and four lamps.",
            scene: scene(),
        },
        Preset {
            name: "city-sky",
            title: "City on a foggy morning",
            description: "The same city and the same 353 blobs by day: a hazy sky, brighter towards the \
                sun that it hides, is all the light.",
            scene: under_sky(),
        },
    ]
}

fn under_sky() -> Scene {
    let mut scene = scene();
    scene.lights = vec![sky(morning)];
    scene.background = Rgb::splat(0.0);
    scene.fog.ambient = Rgb::splat(0.0);
    for surface in &mut scene.surfaces {
        // By day no window shines.
        if surface
            .id
            .as_deref()
            .is_some_and(|id| id.ends_with("m-windows") || id.ends_with("l-windows"))
        {
            surface.material = glossy([0.05, 0.06, 0.08], 0.3, 50.0);
        }
    }
    scene
}

/// Radiance of a hazy sky with the sun low on the right; streets send up some of it [W/(m² sr)].
fn morning(d: DVec3) -> DVec3 {
    let glow = (0.5 + 0.5 * d.dot(DVec3::new(0.75, 0.4, -0.53).normalize())).powi(7);
    let (zenith, horizon, ground) =
        (DVec3::new(0.32, 0.42, 0.6), DVec3::new(0.52, 0.54, 0.56), DVec3::new(0.1, 0.1, 0.1));
    let even = if d.y > 0.0 {
        horizon.lerp(zenith, d.y)
    } else {
        horizon.lerp(ground, (-3.0 * d.y).min(1.0))
    };
    even + DVec3::new(1.5, 1.2, 0.8) * glow
}

fn scene() -> Scene {
    let mut random = Random::new(353);
    Scene {
        camera: camera([22.0, 92.0, 205.0], [-3.0, 17.0, 10.0], 44.0),
        background: Rgb([0.012, 0.017, 0.032]),
        surfaces: surfaces(&mut random),
        lights: lights(),
        fog: Fog {
            ambient: Rgb([0.03, 0.036, 0.055]),
            terms: vec![gaussians("street-fog", street_fog(&mut random))],
            ..Fog::default()
        },
        far_m: 700.0,
        ..Scene::default()
    }
}

fn lights() -> Vec<Light> {
    vec![
        lamp("square", DVec3::new(0.0, 13.0, 88.0), [5200.0, 3300.0, 1500.0]),
        lamp("boulevard", DVec3::new(0.0, 16.0, -4.0), [6400.0, 3900.0, 1700.0]),
        lamp("side-street", DVec3::new(-46.0, 14.0, 40.0), [1500.0, 3000.0, 3400.0]),
        lamp("moon", DVec3::new(260.0, 420.0, 330.0), [1.6e5, 2.2e5, 3.7e5]),
    ]
}

/// What the towers are made of.
#[derive(Default)]
struct City {
    stone: MeshBuilder,
    brick: MeshBuilder,
    dark_panes: MeshBuilder,
    warm_panes: MeshBuilder,
    cool_panes: MeshBuilder,
}

fn surfaces(random: &mut Random) -> Vec<Surface> {
    let mut city = City::default();
    let half = f64::from(BLOCKS) / 2.0;
    for i in 0..BLOCKS {
        for j in 0..BLOCKS {
            let center = DVec2::new(f64::from(i) - half + 0.5, f64::from(j) - half + 0.5) * PITCH;
            tower(&mut city, center, random);
        }
    }
    let (pavements, road, markings) = ground();
    vec![
        mesh("stone-towers", city.stone.flat(), matte([0.36, 0.34, 0.31])),
        mesh("brick-towers", city.brick.flat(), matte([0.33, 0.23, 0.18])),
        mesh("dark-windows", city.dark_panes.flat(), glossy([0.03, 0.035, 0.05], 0.3, 50.0)),
        mesh("warm-windows", city.warm_panes.flat(), glowing([0.95, 0.58, 0.22])),
        mesh("cool-windows", city.cool_panes.flat(), glowing([0.4, 0.55, 0.62])),
        mesh("pavements", pavements.flat(), matte([0.24, 0.23, 0.22])),
        mesh("road", road.flat(), glossy([0.08, 0.08, 0.085], 0.08, 20.0)),
        mesh("markings", markings.flat(), matte([0.6, 0.58, 0.5])),
        mesh("masts", masts().flat(), matte([0.12, 0.12, 0.13])),
    ]
}

/// One block: a tower that steps back one to three times.
fn tower(city: &mut City, center: DVec2, random: &mut Random) {
    let brick = random.chance(0.45);
    let distance = center.length() / (PITCH * 3.0);
    let tall = random.between(20.0, 44.0) + 46.0 * (1.1 - distance).max(0.0) * random.unit();
    let mut half = DVec2::new(random.between(12.0, 14.5), random.between(12.0, 14.5));
    let steps = 1 + (random.unit() * 2.6) as usize;
    let mut foot = 0.2;
    for step in 0..steps {
        let share = if step + 1 == steps { 1.0 } else { random.between(0.45, 0.7) };
        let rise = ((tall - foot) * share).max(8.0);
        storey_stack(city, brick, [center - half, center + half], [foot, foot + rise], random);
        foot += rise;
        half *= random.between(0.62, 0.8);
    }
    rooftop(city, brick, center, half, foot, random);
}

/// Four facades, a cornice and a roof.
fn storey_stack(
    city: &mut City,
    brick: bool,
    [low, high]: [DVec2; 2],
    [foot, top]: [f64; 2],
    random: &mut Random,
) {
    let sides = [
        (DVec2::new(low.x, high.y), DVec3::X, high.x - low.x),
        (high, DVec3::NEG_Z, high.y - low.y),
        (DVec2::new(high.x, low.y), DVec3::NEG_X, high.x - low.x),
        (low, DVec3::Z, high.y - low.y),
    ];
    let opening = [random.between(0.45, 0.72), random.between(0.5, 0.7)];
    for (corner, right, width) in sides {
        // What looks away from the camera has larger bays.
        let bay = if right == DVec3::NEG_X { 9.0 } else { 4.6 };
        let wall = Facade {
            corner: DVec3::new(corner.x, foot, corner.y),
            right,
            width,
            height: top - foot,
            columns: (width / bay).round().max(1.0) as usize,
            rows: ((top - foot) / (bay * 0.9)).round().max(1.0) as usize,
            opening,
            recess: 0.5,
        };
        let builder = if brick { &mut city.brick } else { &mut city.stone };
        let panes = wall.build(builder);
        for pane in panes {
            city.glaze(pane, random);
        }
    }
    let builder = if brick { &mut city.brick } else { &mut city.stone };
    let edge = DVec2::splat(0.55);
    let (a, b) = (low - edge, high + edge);
    builder.block(DVec3::new(a.x, top - 0.7, a.y), DVec3::new(b.x, top + 0.5, b.y));
}

impl City {
    /// Puts a pane behind an opening: most are dark.
    fn glaze(&mut self, pane: [DVec3; 4], random: &mut Random) {
        let drawn = random.unit();
        let panes = match drawn {
            d if d < 0.14 => &mut self.warm_panes,
            d if d < 0.18 => &mut self.cool_panes,
            _ => &mut self.dark_panes,
        };
        panes.face(pane);
    }
}

/// A tank, an engine house or a spire.
fn rooftop(
    city: &mut City,
    brick: bool,
    center: DVec2,
    half: DVec2,
    foot: f64,
    random: &mut Random,
) {
    let builder = if brick { &mut city.brick } else { &mut city.stone };
    let at = |x: f64, y: f64, z: f64| DVec3::new(center.x + x, foot + y, center.y + z);
    let (x, z) = (half.x * random.between(-0.4, 0.4), half.y * random.between(-0.4, 0.4));
    builder.block(at(x - 2.6, 0.0, z - 2.0), at(x + 2.6, 3.0, z + 2.0));
    match (random.unit() * 3.0) as usize {
        0 => {
            let ends = [at(-x, 1.6, -z - 1.0), at(-x, 5.4, -z - 1.0)];
            builder.add_at(&rod(ends[0], ends[1], 1.9, 14), DVec3::ZERO);
            for (dx, dz) in [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)] {
                let leg = at(dx * 1.2 - x, 0.0, dz * 1.2 - z - 1.0);
                builder.add_at(&rod(leg, leg + DVec3::Y * 1.8, 0.18, 4), DVec3::ZERO);
            }
        }
        1 => builder.frustum(
            [at(-half.x * 0.6, 0.0, -half.y * 0.6), at(half.x * 0.6, 15.0, half.y * 0.6)],
            DVec3::new(half.x * 0.58, 0.0, half.y * 0.58),
        ),
        _ => builder.block(at(-x - 1.5, 0.0, -z - 1.5), at(-x + 1.5, 2.2, -z + 1.5)),
    }
}

/// Pavements around the blocks, the road between them and its markings.
fn ground() -> (MeshBuilder, MeshBuilder, MeshBuilder) {
    let (mut pavements, mut road, mut markings) =
        (MeshBuilder::default(), MeshBuilder::default(), MeshBuilder::default());
    let half = f64::from(BLOCKS) / 2.0;
    let side = (PITCH - STREET) / 2.0 + 2.6;
    for i in 0..BLOCKS {
        for j in 0..BLOCKS {
            let x = (f64::from(i) - half + 0.5) * PITCH;
            let z = (f64::from(j) - half + 0.5) * PITCH;
            let max = DVec3::new(x + side, 0.2, z + side);
            pavements.beveled_block(DVec3::new(x - side, -0.3, z - side), max, 0.12);
        }
    }
    let edge = half * PITCH + 900.0;
    road.block(DVec3::new(-edge, -1.0, -edge), DVec3::new(edge, 0.0, edge));
    for line in 0..=BLOCKS {
        let across = (f64::from(line) - half) * PITCH;
        let mut along = -half * PITCH - 20.0;
        while along < half * PITCH + 20.0 {
            let mut dash = |x: [f64; 2], z: [f64; 2]| {
                markings.block(DVec3::new(x[0], -0.1, z[0]), DVec3::new(x[1], 0.02, z[1]));
            };
            dash([across - 0.12, across + 0.12], [along, along + 2.4]);
            dash([along, along + 2.4], [across - 0.12, across + 0.12]);
            along += 5.75;
        }
    }
    (pavements, road, markings)
}

/// The masts under the street lamps.
fn masts() -> MeshBuilder {
    let mut masts = MeshBuilder::default();
    for (x, height, z) in [(0.0, 12.6, 88.0), (0.0, 15.6, -4.0), (-46.0, 13.6, 40.0)] {
        let foot = DVec3::new(x, 0.0, z);
        masts.add_at(&rod(foot, foot + DVec3::Y * height, 0.22, 8), DVec3::ZERO);
    }
    masts
}

/// Banks that follow the streets; lower ones are larger.
fn street_fog(random: &mut Random) -> Vec<Blob> {
    let half = f64::from(BLOCKS) / 2.0;
    (0..BLOBS)
        .map(|k| {
            let line = (random.unit() * f64::from(BLOCKS + 1)).floor();
            // Every third blob keeps to the boulevard in the middle.
            let across = if k % 3 == 0 { 0.0 } else { (line - half) * PITCH };
            let along = random.between(-1.15, 0.95) * half * PITCH;
            let wander = random.bell() * 3.5;
            let up = 1.0 + 15.0 * random.unit().powi(2);
            let center = match k % 2 == 0 {
                true => DVec3::new(across + wander, up, along),
                false => DVec3::new(along, up, across + wander),
            };
            blob(center, random.between(6.5, 14.0) * (1.25 - up / 32.0), random.between(0.3, 0.8))
        })
        .collect()
}
