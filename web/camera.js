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

const add = (a, b) => a.map((x, i) => x + b[i]);
const subtract = (a, b) => a.map((x, i) => x - b[i]);
const scale = (a, s) => a.map((x) => x * s);
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
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

/** The same view with coordinates that a person can read: six digits of the distance to the target. */
export function tidied(camera) {
  const unit_m = 10 ** (Math.floor(Math.log10(Math.max(distance_m(camera), 1e-6))) - 5);
  const digits = Math.max(-Math.round(Math.log10(unit_m)), 0);
  const tidy = (point) => point.map((x) => Number((Math.round(x / unit_m) * unit_m).toFixed(digits)));
  return { ...camera, position: tidy(camera.position), target: tidy(camera.target) };
}

/** Turns the camera about its target: `yaw_rad` about the up axis, `pitch_rad` towards it. */
export function orbit(camera, yaw_rad, pitch_rad) {
  const up = unit(camera.up, [0, 1, 0]);
  const { right } = axes(camera);
  const offset = subtract(camera.position, camera.target);
  const size = Math.hypot(...offset);
  if (size === 0) return camera;
  const polar_rad = Math.acos(clamp(dot(offset, up) / size, [-1, 1]));
  const wanted_rad = clamp(polar_rad - pitch_rad, [POLE_MARGIN_RAD, Math.PI - POLE_MARGIN_RAD]);
  const pitched = rotate(offset, right, wanted_rad - polar_rad);
  return { ...camera, position: add(camera.target, rotate(pitched, up, yaw_rad)) };
}

/** Slides camera and target in the picture's plane; both in fractions of the picture's height. */
export function pan(camera, rightwards, upwards) {
  const { right, up } = axes(camera);
  const height_m = 2 * halfHeight_m(camera);
  const step = add(scale(right, rightwards * height_m), scale(up, upwards * height_m));
  return { ...camera, position: add(camera.position, step), target: add(camera.target, step) };
}

/** Brings the target nearer (`factor` below 1) or takes it away. */
export function zoom(camera, factor) {
  if (isOrthographic(camera)) {
    const height_m = Number(clamp(camera.projection.height_m * factor, DISTANCE_RANGE_M).toPrecision(6));
    return { ...camera, projection: { ...camera.projection, height_m } };
  }
  const offset = subtract(camera.position, camera.target);
  const size = Math.hypot(...offset);
  if (size === 0) return camera;
  const wanted_m = clamp(size * factor, DISTANCE_RANGE_M);
  return { ...camera, position: add(camera.target, scale(offset, wanted_m / size)) };
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
