// A point light, and where it stands relative to a ray.
//
// Twins: Lamp in core/src/cpu/frame.rs, ToLight in core/src/airlight/mod.rs.

#define_import_path fogbank::lamp

/// A light as the passes need it.
struct Lamp {
    /// Where it is, from the camera [m].
    position: vec3<f32>,
    /// Its distance from the camera [m].
    distance_m: f32,
    /// Radiant intensity, rgb [W/sr].
    strength: vec3<f32>,
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
}

/// A light's nearest distance to a ray counts as at least this share of its distance from the ray's
/// origin: what rounding leaves of it. A ray through a light thereby has a finite answer.
const MISS_FLOOR: f32 = 1e-6;
/// And as no less than this [m]: the strongest light on the strongest reflection stays a number.
const LEAST_MISS: f32 = 1e-6;

/// Where a light stands relative to a ray from `start` in the unit `direction`.
fn beside(light: Lamp, start: vec3<f32>, direction: vec3<f32>) -> ToLight {
    return to_light(light.position - start, direction);
}

/// From the light's place relative to the ray's origin and the unit direction.
fn to_light(light: vec3<f32>, direction: vec3<f32>) -> ToLight {
    let floor = max(length(light) * MISS_FLOOR, LEAST_MISS);
    // A difference of squares would lose a small distance.
    return ToLight(dot(light, direction), max(length(cross(light, direction)), floor));
}
