// Things of a scene that stand somewhere: lamps, blobs, emitters, surfaces; and which of them a ray meets.

import { add, dot, scale, subtract } from "./camera.js";
import { valueAt } from "./pointer.js";

/** Where the position of a thing is in it, by the list that it is in and its kind. */
const LIGHT = ["position"];
const EMITTER = ["position"];
const BLOB = ["center"];
const SHAPES = { sphere: ["shape", "center"], box: ["shape", "min"], plane: ["shape", "point"] };

// A blob is thickest in its middle: nearer to the rim than this share of its radius, one means what is behind it.
const BLOB_SHARE = 0.5;
// Optical depth through a blob's middle below which nobody sees it.
const BLOB_SEEN = 0.02;
const SQRT_PI = Math.sqrt(Math.PI);

const largest = (value) => (Array.isArray(value) ? Math.max(...value) : value ?? 0);
const isShown = (thing) => thing?.enabled !== false;

/** `{path, at, title}`: the path of a thing in the scene, and the path of its position, if it has one. */
function thing(path, position, title) {
  return { path, at: position && [...path, ...position], title };
}

/** All lamps and emitters that stand somewhere. */
export function standing(scene) {
  const lights = (scene.lights ?? []).map((light, i) => [light, thing(["lights", i], LIGHT, light.id ?? `light ${i + 1}`)]);
  const terms = (scene.fog?.terms ?? []).map((term, i) => [term, thing(["fog", "terms", i], EMITTER, term.id ?? `term ${i + 1}`)]);
  return [...lights, ...terms].filter(([value]) => isShown(value) && Array.isArray(value.position)).map(([, found]) => found);
}

/** The position of a thing; of a box its middle. */
export function placeOf(scene, { path, at }) {
  const shape = valueAt(scene, path)?.shape;
  if (shape?.kind === "box") return scale(add(shape.min, shape.max), 0.5);
  return at ? valueAt(scene, at) : undefined;
}

/** The size of a thing in metres: what it should be framed by. */
export function radiusOf(scene, { path }) {
  const value = valueAt(scene, path);
  if (typeof value?.radius === "number") return value.radius;
  const shape = value?.shape;
  if (shape?.kind === "sphere") return shape.radius;
  if (shape?.kind === "box") return Math.hypot(...subtract(shape.max, shape.min)) / 2;
  return undefined;
}

/** The blob that a ray meets in front of `limit_m`, if it runs near a middle. */
export function blobOn(scene, { origin, direction }, limit_m) {
  const size = Math.hypot(...direction);
  const along = scale(direction, 1 / size);
  let best = null;
  let bestShare = BLOB_SHARE;
  (scene.fog?.terms ?? []).forEach((term, t) => {
    if (term.kind !== "gaussians" || !isShown(term)) return;
    term.blobs?.forEach((blob, b) => {
      const way = subtract(blob.center, origin);
      const far_m = dot(way, along);
      if (far_m <= 0 || far_m > limit_m) return;
      const aside_m = Math.sqrt(Math.max(dot(way, way) - far_m * far_m, 0));
      if (aside_m >= bestShare * blob.radius || SQRT_PI * blob.radius * largest(blob.extinction) < BLOB_SEEN) return;
      bestShare = aside_m / blob.radius;
      best = thing(["fog", "terms", t, "blobs", b], BLOB, `blob ${b + 1} of ${term.id ?? `term ${t + 1}`}`);
    });
  });
  return best;
}

/** The surface that a probe met. */
export function surfaceOf(scene, { surface: id, point }) {
  const index = (scene.surfaces ?? []).findIndex((surface) => surface.id === id);
  if (index === -1) return null;
  return { ...thing(["surfaces", index], SHAPES[scene.surfaces[index].shape?.kind], id), point };
}

/** `{path, value}` of what must be set to move a thing by `step` metres from where it was in `before`, its value then. */
export function moved({ path, at }, before, step) {
  const shape = before?.shape;
  if (shape?.kind === "box") {
    return { path: [...path, "shape"], value: { ...shape, min: rounded(add(shape.min, step)), max: rounded(add(shape.max, step)) } };
  }
  return { path: at, value: rounded(add(valueAt(before, at.slice(path.length)), step)) };
}

/** To a tenth of a millimetre: nobody drags more exactly. */
export const rounded = (point) => point.map((x) => Number(x.toFixed(4)));

/** Infinite planes of a scene. */
export const planesOf = (scene) =>
  (scene.surfaces ?? []).filter((surface) => isShown(surface) && surface.shape?.kind === "plane").map(({ shape }) => shape);
