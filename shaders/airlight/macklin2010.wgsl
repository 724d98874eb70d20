// Airlight of a point light in homogeneous fog that takes nothing away (Macklin 2010): the angle that the ray turns
// through before the light, divided by the light's distance from it.
//
// Twin: core/src/airlight/macklin2010.rs.

#define_import_path fogbank::airlight::macklin2010

#import fogbank::num
#import fogbank::lamp

/// L_a per unit of ω·I₀ [1/m²] along a ray from where the light stands `toward` [m], in the unit `direction`.
fn airlight(beta: f32, toward: vec3<f32>, direction: vec3<f32>, length_m: f32) -> f32 {
    return between(beta, toward, direction, vec2<f32>(0.0, length_m));
}

/// The same between two ray parameters [m]: what a slab of fog scatters.
fn between(beta: f32, toward: vec3<f32>, direction: vec3<f32>, ends: vec2<f32>) -> f32 {
    let miss = max(length(cross(toward, direction)), length(toward) * lamp::MISS_FLOOR);
    let aside = ends - dot(toward, direction);
    let angle = num::angle(miss * (ends.y - ends.x), miss * miss + aside.x * aside.y);
    return beta * angle / (4.0 * num::PI * miss);
}
