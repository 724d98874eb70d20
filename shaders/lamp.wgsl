// A light, and where it stands relative to a ray.
//
// Twins: Lamp in core/src/frame/context.rs, core/src/light/.

#define_import_path fogbank::lamp

/// A light as the passes need it.
struct Lamp {
    /// Where it is, from the camera; of the sun where its table begins [m].
    position: vec3<f32>,
    /// Its distance from the camera [m].
    distance_m: f32,
    /// Radiant intensity, rgb [W/sr].
    strength: vec3<f32>,
    /// Fog without an end towards the sun counts so far [m].
    path_m: f32,
    /// Unit vector towards the sun; zero for what stands at a place.
    toward: vec3<f32>,
    /// 1 − cos of the half angle within which a cone is full.
    inner: f32,
    /// Unit vector along the middle of a cone of light; zero for what shines everywhere.
    axis: vec3<f32>,
    /// 1 − cos of the half angle where it ends.
    outer: f32,
    /// 1 if some surface may hide it from what is seen.
    is_shaded: u32,
    /// The table of the sky of which it stands for a channel, from 1; 0 for all others.
    sky: u32,
    /// That channel, by its place in the table.
    channel: u32,
    /// Mean cosine of the phase function that scatters it.
    sky_g: f32,
    /// ln of the most radiance that goes on of it anywhere.
    log_most: f32,
}

/// What a group of terms scatters of a lamp.
struct Scatter {
    /// The lamp's strength times the group's albedo, rgb [W/sr].
    colour: vec3<f32>,
    /// Mean cosine of the group's phase function.
    g: f32,
    /// The lamp.
    lamp: u32,
    /// The group.
    group: u32,
    /// Share that reaches the eye of the light in fog that is the same everywhere: that of the group in
    /// all extinction (sun2005), or C_sv (Fogshop 2007, eq. 16).
    share: f32,
}

/// Where a light stands relative to a ray.
struct ToLight {
    /// Ray parameter of the point closest to the light [m].
    closest: f32,
    /// Distance of the light from the ray's line [m], floored.
    miss: f32,
    /// What stands for the cosine towards the sun; 0 for all others.
    tilt: f32,
}

/// How far away the sun is, and farther than any blob [m].
const SUN_M: f32 = 1.4959787e11;
const EVERYWHERE_M: f32 = 1e10;

/// A light's nearest distance to a ray counts as at least this share of its distance from the ray's
/// origin: what rounding leaves of it. A ray through a light thereby has a finite answer.
const MISS_FLOOR: f32 = 1e-6;
/// And as no less than this [m]: the strongest light on the strongest reflection stays a number.
const LEAST_MISS: f32 = 1e-6;

/// Where a light stands relative to a ray from `start` in the unit `direction`.
fn beside(light: Lamp, start: vec3<f32>, direction: vec3<f32>) -> ToLight {
    if is_sun(light) {
        return ToLight(0.0, SUN_M, dot(light.toward, direction));
    }
    return to_light(light.position - start, direction);
}

fn is_sun(light: Lamp) -> bool {
    return any(light.toward != vec3<f32>(0.0));
}

/// Whether it shines into a cone.
fn is_beam(light: Lamp) -> bool {
    return any(light.axis != vec3<f32>(0.0));
}

/// From a point to a light [m].
fn way_to(light: Lamp, point: vec3<f32>) -> vec3<f32> {
    return select(light.position - point, SUN_M * light.toward, is_sun(light));
}

/// From the light's place relative to the ray's origin and the unit direction.
fn to_light(light: vec3<f32>, direction: vec3<f32>) -> ToLight {
    let floor = max(length(light) * MISS_FLOOR, LEAST_MISS);
    // A difference of squares would lose a small distance.
    return ToLight(dot(light, direction), max(length(cross(light, direction)), floor), 0.0);
}
