// The column of panels: which part of the request each one shows, and where the server's complaints appear.

import { button, element } from "./dom.js";
import { Form, buildField, buildProperties } from "./fields.js";
import { buildAbout, buildFold, ensureBuilt } from "./groups.js";
import { pointerOf } from "./pointer.js";

// Set by the page itself: the picture's size, the frame loop's quality, the layer switch.
const NOT_IN_VIEW = ["scene", "camera", "width", "height", "quality", "layer"];
// Parts of the scene with a panel of their own, in this order; the others share "World". The camera is the view's own.
const SCENE_PANELS = ["fog", "lights", "camera", "surfaces"];
const CAMERA = "camera";
// For editors of files.
const NOT_IN_WORLD = ["$schema"];
const INPUTS = ":scope > .control :is(input, select, textarea, button)";
const OPEN_AT_FIRST = ["view", "fog"];

export class Panels {
  #root;
  #form;
  #requestSchema;
  #keepCamera;
  #errors = [];

  /** `getFocus()` answers the point that is looked at; `keepCamera()` makes the view's camera the scene's. */
  constructor(root, schemas, store, { getFocus, keepCamera }) {
    this.#root = root;
    this.#form = new Form(schemas, store, getFocus);
    this.#keepCamera = keepCamera;
    this.#requestSchema = schemas.body("/v1/render");
  }

  /** Builds all panels anew, for another scene. Panels stay as open as they were; groups fold. */
  rebuild() {
    const { schemas, open } = this.#form;
    for (const key of open.keys()) if (key.startsWith("/")) open.delete(key);
    const ofRequest = schemas.resolve(this.#requestSchema.properties?.scene);
    const scene = ofRequest.properties ? ofRequest : schemas.component("Scene");
    const view = without(this.#requestSchema, NOT_IN_VIEW);
    const world = without(scene, [...SCENE_PANELS, ...NOT_IN_WORLD]);
    const parts = SCENE_PANELS.filter((key) => scene.properties?.[key]);
    this.#root.replaceChildren(
      this.#panel("view", (body) => body.append(...buildProperties({ form: this.#form, path: [] }, view))),
      ...parts.map((key) => this.#scenePanel(key, scene.properties[key])),
      this.#panel("world", (body) => body.append(...buildProperties({ form: this.#form, path: ["scene"] }, world))),
    );
  }

  #panel(key, fill) {
    const title = element("span", { textContent: key });
    return buildFold(this.#form, `panel ${key}`, { className: "panel", title, isOpen: OPEN_AT_FIRST.includes(key), fill });
  }

  #scenePanel(key, schema) {
    const path = key === CAMERA ? [key] : ["scene", key];
    const panel = this.#panel(key, (body) => {
      this.#fillPart(body, schema, path);
      if (key === CAMERA) body.append(button("Keep as the scene's camera", this.#keepCamera, { className: "small" }));
    });
    panel.dataset.pointer = pointerOf(path);
    return panel;
  }

  /** Fills a panel with an object's fields, or with the field of what is no object. */
  #fillPart(body, rawSchema, path) {
    const { schemas, store } = this.#form;
    const schema = schemas.resolve(rawSchema);
    if (schemas.shape(schema) !== "object") {
      body.append(buildField(this.#form, rawSchema, path, { label: path.at(-1), isRequired: true, isPanel: true }));
      return;
    }
    if (store.get(path) === undefined) store.seed(path, schema.default ?? {});
    body.append(...buildAbout(schema.description), ...buildProperties({ form: this.#form, path }, listsFirst(schemas, schema)));
  }

  /** Brings every control up to date with the request. */
  refresh() {
    this.#form.refresh();
  }

  /** Marks the controls that the server's errors point at; an empty list clears all marks. */
  showErrors(errors) {
    this.#errors = errors;
    for (const node of this.#root.querySelectorAll(".has-error")) unmark(node);
    for (const { pointer, detail } of errors) {
      const node = this.#nearest(pointer ?? "");
      if (node) mark(node, detail);
    }
  }

  /** Unfolds the way to what a pointer names and, if it `takesFocus`, puts the focus there. */
  reveal(pointer, takesFocus = true) {
    let node = null;
    for (let next = this.#nearest(pointer); next && next !== node; next = this.#nearest(pointer)) {
      node = next;
      unfold(node, pointer);
    }
    this.showErrors(this.#errors);
    for (let fold = node?.closest("details"); fold; fold = fold.parentElement.closest("details")) fold.open = true;
    if (takesFocus) node?.querySelector("input, select, textarea, button, summary")?.focus();
    node?.scrollIntoView({ block: "nearest" });
  }

  /** The control of the longest part of the pointer that has one on the page. */
  #nearest(pointer) {
    for (let part = pointer; part !== ""; part = part.slice(0, part.lastIndexOf("/"))) {
      const nodes = this.#root.querySelectorAll(`[data-pointer="${CSS.escape(part)}"]`);
      if (nodes.length > 0) return nodes[nodes.length - 1];
    }
    return null;
  }
}

/** An object's schema without some of its properties. */
function without(schema, keys) {
  const properties = Object.entries(schema.properties ?? {}).filter(([key]) => !keys.includes(key));
  return { ...schema, properties: Object.fromEntries(properties) };
}

/** The same schema with its lists in front: what a part of the scene is made of comes before how it is treated. */
function listsFirst(schemas, schema) {
  const isList = ([, property]) => schemas.shape(schemas.resolve(property)) === "list";
  const all = Object.entries(schema.properties);
  const properties = [...all.filter(isList), ...all.filter((entry) => !isList(entry))];
  return { ...schema, properties: Object.fromEntries(properties) };
}

function unfold(node, pointer) {
  if (node.tagName === "DETAILS") ensureBuilt(node);
  const index = Number(pointer.slice(node.dataset.pointer.length + 1).split("/")[0]);
  const pager = node.querySelector(":scope > .pager, :scope > .body > .list > .pager");
  if (Number.isInteger(index)) pager?.showIndex(index);
}

function mark(node, detail) {
  const text = node.querySelector(".field-error");
  if (text) {
    // Several numbers of one colour may be wrong, each in its own way.
    const others = node.classList.contains("has-error") ? `${text.textContent}; ` : "";
    text.textContent = `${others}${detail}`;
    text.hidden = false;
  }
  node.classList.add("has-error");
  for (const input of node.querySelectorAll(INPUTS)) input.setAttribute("aria-invalid", "true");
}

function unmark(node) {
  node.classList.remove("has-error");
  const text = node.querySelector(".field-error");
  if (text) text.hidden = true;
  for (const input of node.querySelectorAll(INPUTS)) input.removeAttribute("aria-invalid");
}
