// What stands around a control: label, unit, doc comment, the place of an error, the button that leaves a value out.

import { button, docNodes, element, freshId, nameAndUnit, plainDoc } from "./dom.js";

/**
 * A field's frame: label, the ⓘ that unfolds the doc comment, the control's place, and the place of an error.
 * `names` are the attributes that tie a control to them. A place may bring a `title` of its own instead of the label.
 */
export function buildFrame(spot, description = spot.schema.description) {
  const { name, unit } = nameAndUnit(String(spot.place.label), description);
  const id = freshId("field");
  const tooltip = plainDoc(description);
  const label = element("label", { htmlFor: id, title: tooltip }, name);
  if (unit) label.append(" ", element("span", { className: "unit", textContent: unit }));
  const about = element("p", { className: "about", id: `${id}-about`, hidden: true }, ...docNodes(description ?? ""));
  const error = element("p", { className: "field-error", id: `${id}-error`, hidden: true });
  const row = element("div", { className: "label-row" }, spot.place.title ?? label);
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
export function clearButton({ form, path, place, schema, rebuild }) {
  const isOptional = !place.isRequired && !place.isItem && (schema.default === undefined || schema.default === null);
  if (!isOptional) return [];
  const clear = () => { form.store.set(path, undefined); rebuild(); };
  return [button("×", clear, { className: "icon", "aria-label": `Leave out ${place.label}`, title: "Leave out" })];
}

/** The kinds of a tagged union, for a select. */
export function kindOptions(variants) {
  return variants.map(({ value, schema }) =>
    element("option", { value, textContent: String(value).replaceAll("_", " "), title: plainDoc(schema.description) }));
}
