// What is chosen: a ring on the picture, and what may be done with it.

import { pointAtDepthOf, project, rayThrough, subtract } from "./camera.js";
import { freshName } from "./document.js";
import { putAt } from "./dom.js";
import { blobOn, moved, placeOf, standing, surfaceOf } from "./places.js";
import { pointerOf, valueAt } from "./pointer.js";

// As near as a finger can tell.
const GRAB_PX = 18;

/** The chosen thing of the scene, if any. */
export class Selection {
  #store;
  #ring;
  #getFrame;
  #onChange;
  #chosen = null;

  /** `ring` marks it; `getFrame()` answers `{camera, aspect, width, height}` of the picture; `onChange(thing)` is told. */
  constructor(store, ring, getFrame, onChange) {
    this.#store = store;
    this.#ring = ring;
    this.#getFrame = getFrame;
    this.#onChange = onChange;
  }

  get thing() {
    return this.#chosen;
  }

  choose(thing) {
    this.#chosen = thing && { ...thing, id: valueAt(this.#store.scene, thing.path)?.id };
    this.refresh();
    this.#onChange(thing);
  }

  /** Puts the ring where the thing is; what is gone is no longer chosen. */
  refresh() {
    if (this.#chosen && !this.#follow()) return this.choose(null);
    const { camera, aspect } = this.#getFrame();
    const place = this.#chosen && placeOf(this.#store.scene, this.#chosen);
    const seen = place && project(camera, place, aspect);
    this.#ring.hidden = !seen;
    if (!seen) return;
    putAt(this.#ring, seen);
    this.#ring.title = this.#chosen.title;
  }

  /** Finds the chosen thing again if its list has changed; answers whether it is there. */
  #follow() {
    const { id, path, at } = this.#chosen;
    const { scene } = this.#store;
    const there = valueAt(scene, path);
    if (id === undefined || there?.id === id) return there !== undefined;
    const index = (valueAt(scene, path.slice(0, -1)) ?? []).findIndex((other) => other.id === id);
    if (index === -1) return false;
    const moved = [...path.slice(0, -1), index];
    this.#chosen = { ...this.#chosen, path: moved, at: at && [...moved, ...at.slice(path.length)] };
    return true;
  }

  /** The lamp, emitter or chosen thing that can be grabbed at a point of the picture. */
  handleAt(point) {
    const { camera, aspect, width, height } = this.#getFrame();
    const { scene } = this.#store;
    const away_px = (thing) => {
      const place = placeOf(scene, thing);
      const seen = place && project(camera, place, aspect);
      return seen ? Math.hypot((seen.x - point.x) * width, (seen.y - point.y) * height) : Infinity;
    };
    const all = [...(this.#chosen?.at ? [this.#chosen] : []), ...standing(scene)];
    const near = all.map((thing) => [away_px(thing), thing]).filter(([px]) => px <= GRAB_PX);
    return near.sort(([a], [b]) => a - b)[0]?.[1] ?? null;
  }

  /** What a click at a point means; `hit` is the surface that the probe met there. */
  pick(point, hit) {
    const { camera, aspect } = this.#getFrame();
    const ray = rayThrough(camera, point.x, point.y, aspect);
    const { scene } = this.#store;
    return this.handleAt(point) ?? blobOn(scene, ray, hit?.distance_m ?? Infinity) ?? (hit ? surfaceOf(scene, hit) : null);
  }

  /** Begins to drag the chosen thing from a point of the picture; answers `move(point)`, which puts it under another one. */
  drag(from) {
    const thing = this.#chosen;
    const { path } = thing;
    const before = structuredClone(valueAt(this.#store.scene, path));
    const start = placeOf(this.#store.scene, thing);
    const stroke = freshName();
    const { camera, aspect } = this.#getFrame();
    const grabbed = pointAtDepthOf(camera, from, aspect, start);
    return (point) => {
      const there = pointAtDepthOf(camera, point, aspect, start);
      if (!this.#chosen) return;
      const { path: at, value } = moved(this.#chosen, before, subtract(there, grabbed));
      this.#store.set(["scene", ...at], value, stroke);
    };
  }

  /** Takes the chosen thing out of the scene. */
  remove() {
    const thing = this.#chosen;
    if (!thing) return;
    this.choose(null);
    this.#store.remove(["scene", ...thing.path]);
  }

  /** The pointer of the chosen thing's panel. */
  get pointer() {
    return this.#chosen ? pointerOf(["scene", ...this.#chosen.path]) : null;
  }
}
