// The one state of the page: the render request, its scene included, as the JSON that the server reads.

/** A JSON pointer (RFC 6901) from the body's root. */
export function pointerOf(path) {
  return path.map((key) => `/${String(key).replaceAll("~", "~0").replaceAll("/", "~1")}`).join("");
}

// From this many characters on, a part's text is kept outside the page, where requests refer to it without a copy.
const BLOB_FROM = 100_000;

/**
 * Holds the request and the JSON text of each part of its scene. A mesh of megabytes is written as text once
 * and spliced into every body, until somebody changes the part that it lies in.
 */
export class RequestStore {
  /** `{scene, layer, exposure_ev?, tonemap?, …}`: the render request without size and quality. */
  request = { scene: {}, layer: "beauty" };
  /** JSON text, or a blob of it, by key of the scene. */
  #parts = new Map();
  /** By pointer: what an absent object stands for, so that setting one of its fields keeps the others. */
  #seeds = new Map();
  #onChange;

  /** `onChange(path)` is called after each change. */
  constructor(onChange) {
    this.#onChange = onChange;
  }

  get scene() {
    return this.request.scene;
  }

  /** The value at a path, or `undefined`. */
  get(path) {
    return path.reduce((node, key) => node?.[key], this.request);
  }

  /** Tells what the absent object at `path` stands for. */
  seed(path, value) {
    this.#seeds.set(pointerOf(path), value);
  }

  /** Sets the value at a path; `undefined` takes it out. */
  set(path, value) {
    const key = path.at(-1);
    const parent = this.#parentAt(path);
    if (value === undefined) delete parent[key];
    else parent[key] = value;
    if (path[0] === "scene") this.#parts.delete(path[1]);
    this.#onChange(path);
  }

  /** Takes a whole scene; the view settings stay. */
  load(scene) {
    this.request.scene = scene;
    this.#parts.clear();
    this.#seeds.clear();
    this.#onChange(["scene"]);
  }

  /** The JSON of a body with the scene and `fields`: text, or a blob where the scene is large. */
  sceneBody(fields) {
    const parts = Object.keys(this.scene).flatMap((key, i) => [`${i ? "," : ""}${JSON.stringify(key)}:`, this.#part(key)]);
    const rest = JSON.stringify(fields).slice(1);
    const pieces = ['{"scene":{', ...parts, `}${rest === "}" ? "" : ","}${rest}`];
    return pieces.some((piece) => piece instanceof Blob) ? new Blob(pieces) : pieces.join("");
  }

  /** The JSON of the render request with `fields` (size and quality). */
  renderBody(fields) {
    const { scene: _, ...view } = this.request;
    return this.sceneBody({ ...view, ...fields });
  }

  #part(key) {
    if (!this.#parts.has(key)) {
      const text = JSON.stringify(this.scene[key]);
      this.#parts.set(key, text.length < BLOB_FROM ? text : new Blob([text]));
    }
    return this.#parts.get(key);
  }

  /** The object that holds the last key of `path`, made from the seeds where it is absent. */
  #parentAt(path) {
    let node = this.request;
    for (let depth = 1; depth < path.length; depth += 1) {
      const key = path[depth - 1];
      if (node[key] === undefined || node[key] === null) {
        const seed = this.#seeds.get(pointerOf(path.slice(0, depth)));
        node[key] = structuredClone(seed) ?? (typeof path[depth] === "number" ? [] : {});
      }
      node = node[key];
    }
    return node;
  }
}
