// The camera's maths: orbit, pan, zoom and the ray through a point of the picture.
// Cameras are the scene's own JSON objects and are never changed in place.

// What a scene's camera is where it says nothing.
const DEFAULTS = { position: [0, 1.7, 8], target: [0, 1, 0], up: [0, 1, 0] };
const PERSPECTIVE = { kind: "perspective", vertical_fov_deg: 45 };
const ORTHOGRAPHIC = { kind: "orthographic", height_m: 10 };

/** A scene's camera with its defaults filled in. */
export function completeCamera(camera) {
  const defaults = camera?.projection?.kind === "orthographic" ? ORTHOGRAPHIC : PERSPECTIVE;
  return { ...DEFAULTS, ...camera, projection: { ...defaults, ...camera?.projection } };
}

// How near the view may come to the up axis, where left and right lose their meaning.
const POLE_MARGIN_RAD = (1 * Math.PI) / 180;
const DISTANCE_RANGE_M = [1e-2, 1e8];

export const add = (a, b) => a.map((x, i) => x + b[i]);
export const subtract = (a, b) => a.map((x, i) => x - b[i]);
export const scale = (a, s) => a.map((x) => x * s);
export const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const clamp = (x, [low, high]) => Math.min(Math.max(x, low), high);
const radians = (angle_deg) => (angle_deg * Math.PI) / 180;

/** The unit vector along `a`, or `fallback` where `a` has no direction. */
function unit(a, fallback) {
  const size = Math.hypot(...a);
  return size > 1e-12 ? scale(a, 1 / size) : fallback;
}

/** Right-handed unit axes: where the camera looks, and what is right and up in its picture. */
function axes(camera) {
  const forward = unit(subtract(camera.target, camera.position), [0, 0, -1]);
  const up = unit(camera.up, [0, 1, 0]);
  const sideways = Math.abs(forward[0]) < 0.9 ? [1, 0, 0] : [0, 0, 1];
  const right = unit(cross(forward, up), unit(cross(forward, sideways), [1, 0, 0]));
  return { forward, right, up: cross(right, forward) };
}

/** Rotates `v` about the unit vector `axis` (Rodrigues). */
function rotate(v, axis, angle_rad) {
  const c = Math.cos(angle_rad);
  const along = scale(axis, dot(axis, v) * (1 - c));
  return add(add(scale(v, c), scale(cross(axis, v), Math.sin(angle_rad))), along);
}

const isOrthographic = (camera) => camera.projection.kind === "orthographic";
const distance_m = (camera) => Math.hypot(...subtract(camera.position, camera.target));

/** Half the height of what the picture shows at the target, in metres. */
function halfHeight_m(camera) {
  if (isOrthographic(camera)) return camera.projection.height_m / 2;
  return Math.tan(radians(camera.projection.vertical_fov_deg) / 2) * distance_m(camera);
}

/** The same view with coordinates that a person can read: six digits of what is seen. */
export function tidied(camera) {
  const seen_m = isOrthographic(camera) ? camera.projection.height_m : Infinity;
  const unit_m = 10 ** (Math.floor(Math.log10(Math.max(Math.min(distance_m(camera), seen_m), 1e-6))) - 5);
  const digits = Math.max(-Math.round(Math.log10(unit_m)), 0);
  const tidy = (point) => point.map((x) => Number((Math.round(x / unit_m) * unit_m).toFixed(digits)));
  return { ...camera, position: tidy(camera.position), target: tidy(camera.target) };
}

/**
 * Turns the camera about a point, which stays where it is in the picture: `yaw_rad` about the up axis, `pitch_rad` towards
 * it, as far as the view has a left and a right.
 */
export function orbit(camera, yaw_rad, pitch_rad, pivot = camera.target) {
  const up = unit(camera.up, [0, 1, 0]);
  const { right } = axes(camera);
  const backward = subtract(camera.position, camera.target);
  const size = Math.hypot(...backward);
  if (size === 0) return camera;
  const polar_rad = Math.acos(clamp(dot(backward, up) / size, [-1, 1]));
  const wanted_rad = clamp(polar_rad - pitch_rad, [POLE_MARGIN_RAD, Math.PI - POLE_MARGIN_RAD]);
  const turned = (point) => {
    const pitched = rotate(subtract(point, pivot), right, wanted_rad - polar_rad);
    return add(pivot, rotate(pitched, up, yaw_rad));
  };
  return { ...camera, position: turned(camera.position), target: turned(camera.target) };
}

/** Slides camera and target in the picture's plane; both in fractions of the picture's height. */
export function pan(camera, rightwards, upwards) {
  const { right, up } = axes(camera);
  const height_m = 2 * halfHeight_m(camera);
  const step = add(scale(right, rightwards * height_m), scale(up, upwards * height_m));
  return { ...camera, position: add(camera.position, step), target: add(camera.target, step) };
}

/** Goes towards a point (`factor` below 1) or away from it; it stays where it is in the picture. */
export function zoom(camera, factor, point = camera.target) {
  const size = distance_m(camera);
  if (size === 0) return camera;
  if (isOrthographic(camera)) {
    const height_m = Number(clamp(camera.projection.height_m * factor, DISTANCE_RANGE_M).toPrecision(6));
    const { forward } = axes(camera);
    const aside = subtract(point, camera.target);
    const inPlane = subtract(aside, scale(forward, dot(aside, forward)));
    const step = scale(inPlane, 1 - height_m / camera.projection.height_m);
    const moved = { position: add(camera.position, step), target: add(camera.target, step) };
    return { ...camera, ...moved, projection: { ...camera.projection, height_m } };
  }
  const share = clamp(size * factor, DISTANCE_RANGE_M) / size;
  const nearer = (from) => add(point, scale(subtract(from, point), share));
  return { ...camera, position: nearer(camera.position), target: nearer(camera.target) };
}

/** Looks at a ball from where it fills the picture, in the same direction. */
export function framing(camera, center, radius) {
  const { forward } = axes(camera);
  if (isOrthographic(camera)) {
    const projection = { ...camera.projection, height_m: 4 * radius };
    return { ...camera, projection, target: center, position: subtract(center, scale(forward, Math.max(distance_m(camera), 4 * radius))) };
  }
  const away_m = clamp((2 * radius) / Math.sin(radians(camera.projection.vertical_fov_deg) / 2), DISTANCE_RANGE_M);
  return { ...camera, target: center, position: subtract(center, scale(forward, away_m)) };
}

// How near the eye may come to an infinite plane, as a share of its distance to what it looks at.
const ABOVE_SHARE = 0.01;

/** The camera on the side of every plane `{point, normal}` on which `before` was: nobody means to go below the floor. */
export function keptBeside(camera, before, planes) {
  return planes.reduce((kept, { point, normal }) => {
    const n = unit(normal, [0, 1, 0]);
    const height_m = (from) => dot(subtract(from.position, point), n);
    const [side, least_m] = [Math.sign(height_m(before)) || 1, ABOVE_SHARE * distance_m(kept)];
    const missing_m = Math.min(least_m, Math.abs(height_m(before))) - side * height_m(kept);
    return missing_m > 0 ? { ...kept, position: add(kept.position, scale(n, side * missing_m)) } : kept;
  }, camera);
}

/** The ray through a point of the picture: `x`, `y` from 0 to 1, from the upper left corner. */
export function rayThrough(camera, x, y, aspect) {
  const { forward, right, up } = axes(camera);
  const acrossUnit = (2 * x - 1) * aspect;
  const upUnit = 1 - 2 * y;
  const inPlane = (half) => add(scale(right, acrossUnit * half), scale(up, upUnit * half));
  if (isOrthographic(camera)) {
    return { origin: add(camera.position, inPlane(halfHeight_m(camera))), direction: forward };
  }
  const half = Math.tan(radians(camera.projection.vertical_fov_deg) / 2);
  return { origin: camera.position, direction: add(forward, inPlane(half)) };
}

/** Where a point is in the picture, `{x, y, depth_m}` with `x` and `y` from 0 to 1; none behind the eye. */
export function project(camera, point, aspect) {
  const { forward, right, up } = axes(camera);
  const way = subtract(point, camera.position);
  const depth_m = dot(way, forward);
  const half_m = isOrthographic(camera) ? halfHeight_m(camera) : Math.tan(radians(camera.projection.vertical_fov_deg) / 2) * depth_m;
  if (!(half_m > 0) || (!isOrthographic(camera) && depth_m <= 0)) return null;
  return { x: (dot(way, right) / (half_m * aspect) + 1) / 2, y: (1 - dot(way, up) / half_m) / 2, depth_m };
}

/** The height of what the picture shows at a point, in metres. */
export function heightAt_m(camera, point) {
  if (isOrthographic(camera)) return camera.projection.height_m;
  const depth_m = Math.max(dot(subtract(point, camera.position), axes(camera).forward), 1e-6);
  return 2 * Math.tan(radians(camera.projection.vertical_fov_deg) / 2) * depth_m;
}

/** Where the ray through a point of the picture is as deep as `like`. */
export function pointAtDepthOf(camera, { x, y }, aspect, like) {
  const { forward } = axes(camera);
  const { origin, direction } = rayThrough(camera, x, y, aspect);
  const share = dot(subtract(like, origin), forward) / dot(direction, forward);
  return add(origin, scale(direction, share));
}

/** The plane through a point that faces the eye. */
export const facingPlane = (camera, point) => ({ point, normal: scale(axes(camera).forward, -1) });
