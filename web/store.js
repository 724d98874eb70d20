// The one state of the page: what is looked at and how (the view), and the scene, as the JSON that the server reads.

import { freshName } from "./document.js";
import { pointerOf, valueAt } from "./pointer.js";

/** What the panels read and write. Paths that begin with "scene" lead into the scene, all others into the view. */
export class Store {
  /** `{layer, camera, exposure_ev?, tonemap?, time_s?}` */
  view = { layer: "beauty" };
  #document;
  #onView;
  /** By pointer: what an absent object stands for, so that setting one of its fields keeps the others. */
  #seeds = new Map();
  /** Changes from the same control in one go are one step of undo. */
  #stroke = null;

  /** `onView()` is called after each change of the view. */
  constructor(document, onView) {
    this.#document = document;
    this.#onView = onView;
  }

  get scene() {
    return this.#document.scene;
  }

  /** The value at a path, or `undefined`. */
  get(path) {
    return valueAt({ ...this.view, scene: this.scene }, path);
  }

  /** Tells what the absent object at `path` stands for. */
  seed(path, value) {
    this.#seeds.set(pointerOf(path), value);
  }

  /** Sets the value at a path; `undefined` takes it out. Changes with the same `stroke` are one step of undo. */
  set(path, value, stroke = this.#strokeOf(path)) {
    const [at, whole] = this.#grown(path, value);
    if (path[0] === "scene") return this.#document.set(at.slice(1), whole, stroke);
    if (whole === undefined) delete valueAt(this.view, at.slice(0, -1))[at.at(-1)];
    else this.view = replaced(this.view, at, whole);
    this.#onView();
  }

  /** Puts a value into the list at a path, in front of the entry at `index`. */
  insert(path, index, value) {
    const list = this.get(path);
    if (list === undefined) this.set(path, [value]);
    else this.#document.insert(path.slice(1), index, value);
  }

  /** Takes an entry out of a list of the scene. */
  remove(path) {
    this.#document.remove(path.slice(1));
  }

  /** Forgets what it knows of the scene that was. */
  forget() {
    this.#seeds.clear();
    this.#stroke = null;
  }

  /** Whoever goes on at the same control within this time goes on with the same step of undo. */
  #strokeOf(path) {
    const SAME_MS = 1000;
    const [pointer, now_ms] = [pointerOf(path), performance.now()];
    const goesOn = this.#stroke?.pointer === pointer && now_ms - this.#stroke.at_ms < SAME_MS;
    const name = goesOn ? this.#stroke.name : freshName();
    this.#stroke = { pointer, at_ms: now_ms, name };
    return name;
  }

  /** Where something is missing on the way to `path`: from there on, the way is made from the seeds. */
  #grown(path, value) {
    const gap = path.findIndex((_, depth) => depth > 0 && isAbsent(this.get(path.slice(0, depth))));
    if (gap === -1 || value === undefined) return [path, value];
    const at = path.slice(0, gap);
    const make = (depth) => {
      if (depth === path.length) return value;
      const seed = structuredClone(this.#seeds.get(pointerOf(path.slice(0, depth)))) ?? (typeof path[depth] === "number" ? [] : {});
      return replaced(seed, [path[depth]], make(depth + 1));
    };
    return [at, make(gap)];
  }
}

const isAbsent = (value) => value === undefined || value === null;

/** A copy of `node` in which the value at `path` is `value`. */
function replaced(node, [key, ...rest], value) {
  const copy = Array.isArray(node) ? [...node] : { ...node };
  copy[key] = rest.length === 0 ? value : replaced(copy[key] ?? {}, rest, value);
  return copy;
}
