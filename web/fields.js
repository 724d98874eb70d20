// From a schema to a form: fields with labels and tooltips, groups, unions, lists.

import { LEAVES } from "./controls.js";
import { button, docNodes, element, freshId, nameAndUnit, plainDoc } from "./dom.js";
import { buildGroup, buildList } from "./groups.js";
import { pointerOf } from "./store.js";

/** What the fields of one form share. */
export class Form {
  /** `{node, refresh}` of each control that is on the page. */
  #bindings = [];

  constructor(schemas, store) {
    this.schemas = schemas;
    this.store = store;
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
 * `isItem` for an entry of a list, whose own list removes it, `isPanel` where a panel's title names it.
 */
export function buildField(form, rawSchema, path, place) {
  const schema = form.schemas.resolve(rawSchema);
  const shape = form.schemas.shape(schema);
  const stored = form.store.get(path);
  const value = stored ?? schema.default ?? (isContainer(shape) ? emptyOf(shape) : undefined);
  const spot = { form, rawSchema, schema, path, place, value };
  spot.rebuild = () => rebuild(spot);
  if (stored === undefined && value !== undefined) form.store.seed(path, value);
  spot.node = value === undefined || value === null ? buildUnset(spot) : buildShape(spot, shape);
  spot.node.dataset.pointer = pointerOf(path);
  return spot.node;
}

const isContainer = (shape) => shape === "object" || shape === "list";
const emptyOf = (shape) => (shape === "list" ? [] : {});

function buildShape(spot, shape) {
  if (shape === "object") return buildGroup(spot, (body) => body.append(...buildProperties(spot, spot.schema)));
  if (shape === "list") return buildList(spot);
  if (shape === "tagged") return buildTagged(spot);
  if (shape === "choice") return buildChoice(spot);
  return buildLeaf(spot, LEAVES[shape]);
}

/** The fields of an object's properties. */
export function buildProperties({ form, path }, schema) {
  const required = schema.required ?? [];
  return Object.entries(schema.properties).map(([key, property]) =>
    buildField(form, property, [...path, key], { label: key, isRequired: required.includes(key) }));
}

/** Builds the field anew, after a change of what it consists of. */
function rebuild({ form, rawSchema, path, place, node }) {
  const hadFocus = node.contains(document.activeElement);
  const next = buildField(form, rawSchema, path, place);
  node.replaceWith(next);
  if (hadFocus) next.querySelector("input, select, textarea, button, summary")?.focus();
}

/**
 * A field's frame: label, the ⓘ that unfolds the doc comment, the control's place, and the place of an error.
 * `names` are the attributes that tie a control to them.
 */
function buildFrame(spot, description = spot.schema.description) {
  const { name, unit } = nameAndUnit(String(spot.place.label));
  const id = freshId("field");
  const tooltip = plainDoc(description);
  const label = element("label", { htmlFor: id, title: tooltip }, name);
  if (unit) label.append(" ", element("span", { className: "unit", textContent: unit }));
  const about = element("p", { className: "about", id: `${id}-about`, hidden: true }, ...docNodes(description ?? ""));
  const error = element("p", { className: "field-error", id: `${id}-error`, hidden: true });
  const row = element("div", { className: "label-row" }, label);
  if (description) row.append(buildInfo(name, about, tooltip));
  const control = element("div", { className: "control" });
  const described = `${description ? `${about.id} ` : ""}${error.id}`;
  const names = { id, "aria-label": unit ? `${name} in ${unit}` : name, "aria-describedby": described };
  const node = element("div", { className: "field" }, row, control, about, error);
  return { node, row, control, names };
}

/** The ⓘ button: a tooltip for the mouse, and text that unfolds for touch and keyboard. */
export function buildInfo(name, about, tooltip) {
  const names = { "aria-label": `About ${name}`, "aria-expanded": "false", "aria-controls": about.id };
  const info = button("", () => {
    about.hidden = !about.hidden;
    info.setAttribute("aria-expanded", String(!about.hidden));
  }, { className: "info", title: tooltip, ...names });
  info.append(element("span", { textContent: "i" }));
  return info;
}

/** The button that takes an optional value out again. */
function clearButton({ form, path, place, schema, rebuild }) {
  const isOptional = !place.isRequired && !place.isItem && (schema.default === undefined || schema.default === null);
  if (!isOptional) return [];
  const clear = () => { form.store.set(path, undefined); rebuild(); };
  return [button("×", clear, { className: "icon", "aria-label": `Leave out ${place.label}`, title: "Leave out" })];
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
  const { form, schema, path } = spot;
  const { node, row, control, names } = buildFrame(spot);
  const { nodes, show } = make(form.schemas, schema, names, (value) => form.store.set(path, value));
  control.append(...nodes);
  row.append(...clearButton(spot));
  if (nodes[0].type === "select-one") node.classList.add("inline");
  if (nodes[0].type === "checkbox") node.classList.add("inline", "tight");
  form.bind(node, () => show(form.store.get(path) ?? schema.default));
  return node;
}

/** The kinds of a tagged union, for a select. */
export function kindOptions(variants) {
  return variants.map(({ value, schema }) =>
    element("option", { value, textContent: String(value).replaceAll("_", " "), title: plainDoc(schema.description) }));
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
  select.addEventListener("change", () => {
    store.set(path, schemas.initialVariant(schema, variants[select.selectedIndex], store.get(path) ?? value));
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
    store.set(path, schemas.initial(variants[select.selectedIndex]));
    rebuild();
  });
  control.append(select);
  row.append(...clearButton(spot));
  node.classList.add("inline", "choice");
  const inner = buildField(form, variants[index], path, { label: place.label, isRequired: true });
  node.append(element("div", { className: "nested" }, inner));
  return node;
}
