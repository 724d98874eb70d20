// Airlight of a point light in homogeneous fog that takes nothing away (Macklin 2010): the angle that the ray turns
// through before the light, divided by the light's distance from it.
//
// Twin: core/src/airlight/macklin2010.rs.

#define_import_path fogbank::airlight::macklin2010

#import fogbank::num
#import fogbank::lamp
#import fogbank::beam

/// L_a per unit of ω·I₀ [1/m²] of a light between two parameters of a ray from `start` in the unit `direction` [m]:
/// what a ray or a slab of fog scatters.
fn within(
    beta: f32,
    light: lamp::Lamp,
    start: vec3<f32>,
    direction: vec3<f32>,
    ends: vec2<f32>,
) -> f32 {
    let there = lamp::beside(light, start, direction);
    let aside = ends - there.closest;
    var turn = num::angle(there.miss * (ends.y - ends.x), there.miss * there.miss + aside.x * aside.y);
    if lamp::is_beam(light) {
        let angles = vec2<f32>(beam::angle_at(there, ends.x), beam::angle_at(there, ends.y));
        turn = beam::turn(light, beam::beside(light, start, direction), angles);
    }
    return beta * turn / (4.0 * num::PI * there.miss);
}
