// First hits of planes, spheres and boxes: one bounding quad each, one intersection a pixel; the
// depth buffer keeps the nearest. So the work does not grow with the shapes that a pixel cannot
// see.
//
// Twins: Plane::meet and meet in core/src/geometry/hit.rs, meet_* in core/src/cpu/trace.rs.

#import fogbank::view
#import fogbank::surfaces
#import fogbank::screen

/// A shape as the host writes it, relative to the camera.
struct Shape {
    /// Plane: xyz unit normal, w its distance from the camera along that [m].
    /// Sphere: xyz centre, w radius [m]. Box: xyz smallest corner [m].
    first: vec4<f32>,
    /// Sphere: w power |centre|² − radius² of the camera [m²]. Box: xyz largest corner [m].
    second: vec4<f32>,
    /// PLANE, SPHERE or BOX.
    kind: u32,
    /// Place among the scene's surfaces.
    surface: u32,
}

struct Corner {
    @builtin(position) clip: vec4<f32>,
    @location(0) @interpolate(flat) shape: u32,
}

const PLANE: u32 = 0u;
const SPHERE: u32 = 1u;
const BOX: u32 = 2u;
/// What a ray that misses answers.
const MISSED: f32 = -1.0;

@group(0) @binding(0) var<uniform> frame: view::View;
@group(0) @binding(1) var<storage, read> shapes: array<Shape>;

@vertex
fn bound(@builtin(vertex_index) index: u32, @builtin(instance_index) instance: u32) -> Corner {
    let shape = shapes[instance];
    var area = screen::whole();
    switch shape.kind {
        case SPHERE: { area = screen::around_ball(frame, shape.first.xyz, shape.first.w); }
        case BOX: {
            let half = 0.5 * (shape.second.xyz - shape.first.xyz);
            area = screen::around_ball(frame, shape.first.xyz + half, length(half));
        }
        default: {}
    }
    return Corner(screen::corner(area, index), instance);
}

@fragment
fn meet(corner: Corner) -> surfaces::Found {
    let shape = shapes[corner.shape];
    let ray = view::ray_of(frame, vec2<u32>(corner.clip.xy));
    var distance_m = MISSED;
    switch shape.kind {
        case SPHERE: { distance_m = to_sphere(shape, ray); }
        case BOX: { distance_m = to_box(shape, ray); }
        default: { distance_m = to_plane(shape, ray); }
    }
    if !(distance_m > 0.0 && distance_m < frame.far_m) {
        discard;
    }
    let point = ray.offset + distance_m * ray.direction;
    let normal = normal_at(shape, point);
    return surfaces::found(normal, normal, ray.direction, distance_m, shape.surface);
}

fn normal_at(shape: Shape, point: vec3<f32>) -> vec3<f32> {
    switch shape.kind {
        case SPHERE: { return point - shape.first.xyz; }
        case BOX: { return side_of_box(shape, point); }
        default: { return shape.first.xyz; }
    }
}

fn to_plane(shape: Shape, ray: view::Ray) -> f32 {
    let speed = dot(shape.first.xyz, ray.direction);
    let height = shape.first.w - dot(shape.first.xyz, ray.offset);
    return select(height / guarded(speed), MISSED, speed == 0.0);
}

fn to_sphere(shape: Shape, ray: view::Ray) -> f32 {
    let way = shape.first.xyz - ray.offset;
    let radius = shape.first.w;
    // The power of the ray's start; the host formed the camera's where it would cancel most.
    let power = shape.second.w + dot(ray.offset, ray.offset - 2.0 * shape.first.xyz);
    let along = dot(way, ray.direction);
    let aside = cross(way, ray.direction);
    let half_squared = radius * radius - dot(aside, aside);
    if half_squared < 0.0 {
        return MISSED;
    }
    let sum = along + sqrt(half_squared);
    if power <= 0.0 {
        return sum;
    }
    return select(MISSED, power / max(sum, 1e-37), sum > 0.0);
}

fn to_box(shape: Shape, ray: view::Ray) -> f32 {
    let d = ray.direction;
    let inverse = 1.0 / vec3<f32>(guarded(d.x), guarded(d.y), guarded(d.z));
    let a = (shape.first.xyz - ray.offset) * inverse;
    let b = (shape.second.xyz - ray.offset) * inverse;
    let enter = min(a, b);
    let leave = max(a, b);
    let near = max(enter.x, max(enter.y, enter.z));
    let far = min(leave.x, min(leave.y, leave.z));
    return select(select(far, near, near > 0.0), MISSED, far < near);
}

fn side_of_box(shape: Shape, point: vec3<f32>) -> vec3<f32> {
    let size = max(shape.second.xyz - shape.first.xyz, vec3<f32>(1e-30));
    let at = abs((point - 0.5 * (shape.first.xyz + shape.second.xyz)) / size);
    let largest = max(at.x, at.y);
    if at.z > largest {
        return vec3<f32>(0.0, 0.0, 1.0);
    }
    return select(vec3<f32>(1.0, 0.0, 0.0), vec3<f32>(0.0, 1.0, 0.0), at.y > at.x);
}

/// A ray within a plane, or within a side of a box, divides by this instead of by 0.
fn guarded(speed: f32) -> f32 {
    return select(speed, 1e-27, abs(speed) < 1e-27);
}
