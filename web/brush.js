// The brush and the eraser: strokes on surfaces, or on the plane that faces the eye.

import { facingPlane, pointAtDepthOf, rayThrough, add, scale } from "./camera.js";
import { freshName } from "./document.js";
import { blobOn, placeOf, rounded } from "./places.js";

// A point more is worth it when the hand has moved by this share of the brush.
const STEP_SHARE = 0.25;
const WHEEL_SHARE = 0.0015;
const RADIUS_M = [1e-3, 1e4];
const DIGITS = 3;

const clamp = (x, [low, high]) => Math.min(Math.max(x, low), high);
const seedOf = () => Math.floor(Math.random() * 2 ** 32);

/** Draws strokes and sends them as edits while they are drawn. */
export class Brush {
  radius_m = 0.5;
  extinction = 0.5;
  /** `surfaces`, or `plane`: through the point that is looked at, facing the eye. */
  onto = "surfaces";
  #document;
  #getFrame;
  #stroke = null;

  /** `getFrame()` answers `{camera, aspect}` of the picture. */
  constructor(document, getFrame) {
    this.#document = document;
    this.#getFrame = getFrame;
  }

  /** A wheel's turn makes it larger or smaller. */
  resize(delta_px) {
    const radius_m = clamp(this.radius_m * Math.exp(-delta_px * WHEEL_SHARE), RADIUS_M);
    this.radius_m = Number(radius_m.toPrecision(DIGITS));
  }

  /** Begins a stroke: a brush's or (`erases`) an eraser's. `hit` is what the probe met under the hand. */
  begin(point, hit, erases) {
    const { camera } = this.#getFrame();
    this.#stroke = {
      erases, camera, seed: seedOf(), name: freshName(),
      plane: facingPlane(camera, camera.target), last: null, depth: this.place(point, hit, erases),
    };
    this.move(point, hit);
  }

  /** Where the hand is in the scene: an eraser at the blob that is seen there, a brush on the surface or the plane. */
  place(point, hit, erases) {
    const { camera, aspect } = this.#getFrame();
    const ray = rayThrough(camera, point.x, point.y, aspect);
    const blob = erases ? blobOn(this.#document.scene, ray, hit?.distance_m ?? Infinity) : null;
    if (blob) return pointAtDepthOf(camera, point, aspect, placeOf(this.#document.scene, blob));
    if (this.onto === "plane" || !hit) return pointAtDepthOf(camera, point, aspect, this.#stroke?.depth ?? camera.target);
    return add(ray.origin, scale(ray.direction, hit.distance_m / Math.hypot(...ray.direction)));
  }

  /** Goes on to a point of the picture. */
  move(point, hit) {
    const stroke = this.#stroke;
    if (!stroke) return;
    const { camera, aspect } = this.#getFrame();
    // On surfaces the server finds out where; only the direction from the eye matters then.
    const at = stroke.erases || this.onto === "plane" ? this.place(point, hit, stroke.erases) : pointAtDepthOf(camera, point, aspect, stroke.depth);
    const { last } = stroke;
    if (last && Math.hypot(...at.map((x, i) => x - last[i])) < STEP_SHARE * this.radius_m) return;
    const position = rounded(at);
    this.#document.edit(stroke.erases ? this.#erasing(last, position) : this.#painting(position), stroke.name);
    stroke.last = position;
  }

  end() {
    this.#stroke = null;
  }

  #painting(position) {
    const { seed, name, plane, camera } = this.#stroke;
    const isFlat = this.onto === "plane" || camera.projection.kind === "orthographic";
    const where = isFlat ? { plane } : { plane: "surfaces", eye: camera.position };
    return { op: "paint_stroke", points: [position], ...where, radius: this.radius_m, extinction: this.extinction, seed, stroke: name };
  }

  #erasing(last, position) {
    const { name } = this.#stroke;
    return { op: "erase", points: last ? [last, position] : [position], radius: this.radius_m, stroke: name };
  }
}
