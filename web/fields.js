// From a schema to a form: fields with labels and tooltips, groups, unions, lists.

import { bindAlternatives } from "./alternatives.js";
import { LEAVES } from "./controls.js";
import { button, element } from "./dom.js";
import { buildFrame, clearButton, kindOptions } from "./frame.js";
import { buildGroup, buildList, placed } from "./groups.js";
import { pointerOf } from "./pointer.js";

/** What the fields of one form share. */
export class Form {
  /** `{node, refresh}` of each control that is on the page. */
  #bindings = [];

  /** `getFocus()` answers the point that is looked at: what is added stands there. */
  constructor(schemas, store, getFocus) {
    this.schemas = schemas;
    this.store = store;
    this.getFocus = getFocus;
    /** Pointers of the groups that the reader has opened or closed, and which. */
    this.open = new Map();
  }

  /** Has `refresh()` called whenever the request may have changed, while `node` is on the page. */
  bind(node, refresh) {
    this.#bindings.push({ node, refresh });
    refresh();
  }

  refresh() {
    this.#bindings = this.#bindings.filter(({ node }) => node.isConnected);
    for (const { refresh } of this.#bindings) refresh();
  }
}

/**
 * Builds the field of the value at `path`. `place` tells of its surroundings: `label`, `isRequired`, and
 * `isItem` for an entry of a list, whose own list removes it, `isPanel` where a panel's title names it; `title` is
 * shown instead of the label, and `write(value)` stores the value where that takes more than setting it.
 */
export function buildField(form, rawSchema, path, place) {
  const schema = form.schemas.resolve(rawSchema);
  const shape = form.schemas.shape(schema);
  const stored = form.store.get(path);
  const value = stored ?? schema.default ?? (isContainer(shape) ? emptyOf(shape) : undefined);
  const spot = { form, rawSchema, schema, path, place, value };
  spot.rebuild = () => rebuild(spot);
  // Handed down, because groups and lists hold fields and fields hold groups and lists.
  spot.child = (childSchema, childPath, childPlace) => buildField(form, childSchema, childPath, childPlace);
  if (stored === undefined && value !== undefined) form.store.seed(path, value);
  spot.node = value === undefined || value === null ? buildUnset(spot) : buildShape(spot, shape);
  spot.node.dataset.pointer = pointerOf(path);
  follow(spot, shape);
  return spot.node;
}

/** Builds the field anew when its value has another form: an undo, or somebody else, may add and remove. */
function follow({ form, schema, path, node, rebuild }, shape) {
  const formOf = () => {
    const value = form.store.get(path) ?? schema.default ?? (isContainer(shape) ? emptyOf(shape) : null);
    if (value === null) return "absent";
    if (shape === "list") return value.length;
    if (shape === "tagged") return value[form.schemas.tag(schema)];
    return shape === "choice" ? form.schemas.choiceIndex(schema, value) : "present";
  };
  const built = formOf();
  form.bind(node, () => {
    if (!node.isConnected || formOf() === built) return;
    const active = document.activeElement;
    // Whoever types goes on, and sees the rest afterwards.
    if (node.contains(active) && active.matches(TYPED)) active.addEventListener("blur", () => form.refresh(), { once: true });
    else rebuild();
  });
}

const TYPED = "input:not([type=range], [type=checkbox], [type=color]), textarea";

const isContainer = (shape) => shape === "object" || shape === "list";
const emptyOf = (shape) => (shape === "list" ? [] : {});

function buildShape(spot, shape) {
  if (shape === "object") return buildGroup(spot, (body) => body.append(...buildProperties(spot, spot.schema)));
  if (shape === "list") return buildList(spot);
  if (shape === "tagged") return buildTagged(spot);
  if (shape === "choice") return buildChoice(spot);
  return buildLeaf(spot, LEAVES[shape]);
}

/** The fields of an object's properties; two that are ways to say the same share one. */
export function buildProperties({ form, path }, schema) {
  const required = schema.required ?? [];
  const pairs = form.schemas.reciprocals(schema);
  const isSecond = (key) => pairs.some((pair) => pair.keys[1] === key);
  return Object.keys(schema.properties).filter((key) => !isSecond(key)).map((key) => {
    const pair = pairs.find(({ keys }) => keys[0] === key);
    if (pair) return buildAlternatives(form, path, schema, pair);
    return buildField(form, schema.properties[key], [...path, key], { label: key, isRequired: required.includes(key) });
  });
}

/** The field of the one of two properties that the value is given by, under a select of both. */
function buildAlternatives(form, path, schema, pair) {
  const alternatives = bindAlternatives(form, path, schema, pair);
  const { key, title, write } = alternatives;
  const own = { ...form.schemas.resolve(schema.properties[key]), nullable: false, default: pair.fallback };
  const node = buildField(form, own, [...path, key], { label: key, isRequired: true, title, write });
  alternatives.onSwitch(node, () => {
    const hadFocus = node.contains(document.activeElement);
    const next = buildAlternatives(form, path, schema, pair);
    node.replaceWith(next);
    if (hadFocus) next.querySelector("select").focus();
  });
  return node;
}

/** Builds the field anew, after a change of what it consists of. */
function rebuild({ form, rawSchema, path, place, node }) {
  const hadFocus = node.contains(document.activeElement);
  const next = buildField(form, rawSchema, path, place);
  node.replaceWith(next);
  if (hadFocus) next.querySelector("input, select, textarea, button, summary")?.focus();
}

function buildUnset(spot) {
  const { form, schema, path, rebuild } = spot;
  const { node, row, control, names } = buildFrame(spot);
  const set = () => {
    form.store.set(path, form.schemas.initial({ ...schema, nullable: false, default: schema.default ?? undefined }));
    rebuild();
  };
  control.append(button("Set…", set, { id: names.id, className: "small", "aria-label": `Set ${names["aria-label"]}` }));
  node.classList.add("inline", "tight", "unset");
  return node;
}

function buildLeaf(spot, make) {
  const { form, schema, path, place } = spot;
  const { node, row, control, names } = buildFrame(spot);
  const write = place.write ?? ((value) => form.store.set(path, value));
  const { nodes, show } = make(form.schemas, schema, names, write);
  control.append(...nodes);
  row.append(...clearButton(spot));
  if (nodes[0].type === "select-one") node.classList.add("inline");
  if (nodes[0].type === "checkbox") node.classList.add("inline", "tight");
  form.bind(node, () => show(form.store.get(path) ?? schema.default));
  return node;
}

/** A tagged union: a select of its kinds, and the chosen kind's own fields below. */
function buildTagged(spot) {
  const { form, schema, path, value, rebuild } = spot;
  const { schemas, store } = form;
  const tag = schemas.tag(schema);
  const variants = schemas.variants(schema);
  const chosen = variants.find((variant) => variant.value === value[tag]) ?? variants[0];
  const docs = [schema.description, chosen.schema.description];
  const { node, row, control, names } = buildFrame(spot, [...new Set(docs)].filter(Boolean).join(" "));
  const select = element("select", names, ...kindOptions(variants));
  select.value = chosen.value;
  select.addEventListener("change", async () => {
    const variant = variants[select.selectedIndex];
    const next = schemas.initialVariant(schema, variant, store.get(path) ?? value);
    store.set(path, await placed(form, variant.schema, next, store.get(path) ?? value));
    rebuild();
  });
  control.append(select);
  row.append(...clearButton(spot));
  const nested = element("div", { className: "nested" }, ...buildProperties(spot, chosen.schema));
  if (nested.childElementCount > 0) node.append(nested);
  node.classList.add("inline");
  return node;
}

/** An untagged union, such as a number or a colour: a select of its shapes, and the chosen one's field below. */
function buildChoice(spot) {
  const { form, schema, path, value, place, rebuild } = spot;
  const { schemas, store } = form;
  const index = schemas.choiceIndex(schema, value);
  const variants = schema.oneOf.map((raw) => schemas.resolve(raw));
  const { node, row, control, names } = buildFrame(spot);
  const nameOf = (variant) => variant.title ?? variant.refName ?? variant.type;
  const select = element("select", names, ...variants.map((v) => element("option", { textContent: nameOf(v) })));
  select.selectedIndex = index;
  select.addEventListener("change", () => {
    store.set(path, schemas.asVariant(variants[select.selectedIndex], store.get(path) ?? value));
    rebuild();
  });
  control.append(select);
  row.append(...clearButton(spot));
  node.classList.add("inline", "choice");
  const chosen = { ...variants[index], default: value };
  const inner = buildField(form, chosen, path, { label: place.label, isRequired: true, write: place.write });
  node.append(element("div", { className: "nested" }, inner));
  return node;
}
