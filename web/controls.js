// Controls of single values: numbers, colours and other small tuples, words, switches, pieces of JSON.
//
// Each maker takes (schemas, schema, names, onInput), where `names` are the attributes that name the control for
// assistive technology, and answers {nodes, show}: `show(value)` writes a value without disturbing who types.

import { colourControl } from "./colours.js";
import { element, freshId, numberText } from "./dom.js";
import { mapControl } from "./map.js";
import { hasSlider, isFocused, numberInput, numberInputs, sliderInput } from "./numbers.js";

const JSON_TEXT_MOST = 20_000;
const AXES = ["x", "y", "z", "w"];
export function numberControl(_, schema, names, onInput) {
  if (!hasSlider(schema)) {
    const { input, show } = numberInput(schema, names, onInput);
    return { nodes: [input], show };
  }
  const slider = sliderInput(schema, `${names["aria-label"]}, slider`, (value) => { field.show(value); onInput(value); });
  const field = numberInput(schema, names, (value) => { slider.place(value); onInput(value); });
  const show = (value) => {
    field.show(value);
    slider.show(value);
  };
  return { nodes: [slider.input, field.input], show };
}

/** A few numbers side by side. */
export function tupleControl(schemas, schema, names, onInput) {
  if (schemas.isColour(schema)) return colourControl(schemas, schema, names, onInput);
  const { inputs, show } = numberInputs(schemas.elements(schema), AXES, names, onInput);
  return { nodes: inputs, show };
}

export function enumControl(schemas, schema, names, onInput) {
  const options = schemas.options(schema);
  const texts = options.map(({ value, description }) =>
    element("option", { value, textContent: String(value).replaceAll("_", " "), title: description }));
  const select = element("select", names, ...texts);
  select.addEventListener("change", () => onInput(options[select.selectedIndex].value));
  return { nodes: [select], show: (value) => { select.value = value; } };
}

export function booleanControl(_, __, names, onInput) {
  const box = element("input", { type: "checkbox", ...names });
  box.addEventListener("change", () => onInput(box.checked));
  return { nodes: [box], show: (value) => { box.checked = value === true; } };
}

export function stringControl(_, __, names, onInput) {
  const input = element("input", { type: "text", spellcheck: false, autocomplete: "off", ...names });
  input.addEventListener("change", () => onInput(input.value));
  return { nodes: [input], show: (value) => { if (!isFocused(input)) input.value = value ?? ""; } };
}

/** What has no control of its own, as JSON text; too large for that, only how large it is. */
export function jsonControl(_, __, names, onInput) {
  const text = element("textarea", { rows: 3, spellcheck: false, ...names });
  const note = element("p", { className: "note", id: freshId("note") });
  let shown;
  text.addEventListener("change", () => {
    try {
      onInput(JSON.parse(text.value));
      note.textContent = "";
    } catch (error) {
      note.textContent = error.message;
    }
  });
  const show = (value) => {
    if (value === shown || isFocused(text)) return;
    shown = value;
    const json = JSON.stringify(value) ?? "";
    text.hidden = json.length > JSON_TEXT_MOST;
    text.value = text.hidden ? "" : json;
    const size = Array.isArray(value) ? `${value.length} rows, ` : "";
    note.textContent = text.hidden ? `${size}${numberText(json.length / 1e3, 3)} kB: edit it in the scene's JSON.` : "";
  };
  return { nodes: [text, note], show };
}

/** The maker for each shape of `Schemas.shape` that is a single value. */
export const LEAVES = {
  number: numberControl,
  integer: numberControl,
  tuple: tupleControl,
  enum: enumControl,
  boolean: booleanControl,
  string: stringControl,
  json: jsonControl,
  map: mapControl,
};
