// Controls of single values: numbers, colours and other small tuples, words, switches, pieces of JSON.
//
// Each maker takes (schemas, schema, names, onInput), where `names` are the attributes that name the control for
// assistive technology, and answers {nodes, show}: `show(value)` writes a value without disturbing who types.

import { element, freshId, numberText } from "./dom.js";
import { bounds } from "./schema.js";

// A range no wider than this gets a slider over all of it.
const SLIDER_SPAN_MOST = 1000;
const JSON_TEXT_MOST = 20_000;
const AXES = ["x", "y", "z", "w"];
const COLOUR_AXES = ["r", "g", "b"];

const isFocused = (node) => document.activeElement === node;

/** The slider's ends: the whole range where it is narrow, else a neighbourhood of the value. */
function sliderRange(schema, value) {
  const [low, high] = bounds(schema);
  if (high - low <= SLIDER_SPAN_MOST) return [low, high];
  if (low >= 0) return [low, Math.min(Math.max(value > 0 ? value * 4 : 1, low * 2), high)];
  const reach = Math.max(Math.abs(value), 1) * 2;
  return [Math.max(value - reach, low), Math.min(value + reach, high)];
}

/** A number field alone. The arrow keys step by a tenth of the number's own size, with shift by all of it. */
function numberInput(schema, names, onInput) {
  const input = element("input", { type: "number", step: "any", inputMode: "decimal", ...names });
  const isInteger = schema.type === "integer";
  let shown = null;
  const show = (value) => {
    shown = value;
    if (!isFocused(input)) input.value = typeof value === "number" ? String(value) : "";
  };
  const read = () => {
    if (input.value === "" && schema.nullable) return null;
    return isInteger ? Math.round(input.valueAsNumber) : input.valueAsNumber;
  };
  const commit = () => {
    const value = read();
    if (value !== null && !Number.isFinite(value)) return;
    shown = value;
    onInput(value);
  };
  input.addEventListener("input", commit);
  input.addEventListener("blur", () => { input.value = shown ?? ""; });
  input.addEventListener("keydown", (event) => {
    const sign = { ArrowUp: 1, ArrowDown: -1 }[event.key];
    if (!sign) return;
    event.preventDefault();
    const size = 10 ** (Math.floor(Math.log10(Math.abs(shown) || 1)) - (event.shiftKey ? 0 : 1));
    const [low, high] = bounds(schema);
    const stepped = (shown ?? 0) + sign * (isInteger ? Math.max(Math.round(size), 1) : size);
    input.value = String(Number(Math.min(Math.max(stepped, low), high).toPrecision(12)));
    commit();
  });
  return { input, show };
}

export function numberControl(_, schema, names, onInput) {
  const [low, high] = bounds(schema);
  // Seeds and other wide integers have no order worth sliding along.
  if (schema.nullable || (schema.type === "integer" && high - low > SLIDER_SPAN_MOST)) {
    const { input, show } = numberInput(schema, names, onInput);
    return { nodes: [input], show };
  }
  const slider = element("input", { type: "range", "aria-label": `${names["aria-label"]}, slider` });
  const placeThumb = (value) => {
    const [least, most] = sliderRange(schema, value);
    slider.min = least;
    slider.max = most;
    slider.step = schema.type === "integer" ? 1 : (most - least) / 400;
    slider.value = value;
  };
  const field = numberInput(schema, names, (value) => { placeThumb(value); onInput(value); });
  slider.addEventListener("input", () => {
    const value = Math.min(Math.max(Number(slider.valueAsNumber.toPrecision(4)), low), high);
    field.show(value);
    onInput(value);
  });
  const show = (value) => {
    field.show(value);
    // The slider's neighbourhood must not move under the hand that slides it.
    if (!isFocused(slider)) placeThumb(value ?? low);
  };
  slider.addEventListener("blur", () => placeThumb(slider.valueAsNumber));
  return { nodes: [slider, field.input], show };
}

export function tupleControl(schemas, schema, names, onInput) {
  const elements = schemas.elements(schema);
  const isColour = schemas.isColour(schema);
  const axes = isColour ? COLOUR_AXES : AXES;
  let values = [];
  const put = (next) => { values = next; onInput(next); };
  const fields = elements.map((item, i) => {
    const label = `${names["aria-label"]} ${axes[i]}`;
    const own = { ...names, "aria-label": label, id: undefined, title: axes[i] };
    return numberInput(item, own, (value) => put(values.map((old, k) => (k === i ? value : old))));
  });
  const swatch = isColour ? swatchControl(names, () => values, (next) => { put(next); show(next); }) : null;
  const show = (next) => {
    values = elements.map((_, i) => next?.[i] ?? null);
    fields.forEach((field, i) => field.show(values[i]));
    swatch?.show(values);
  };
  fields[0].input.id = names.id;
  return { nodes: [...(swatch ? [swatch.input] : []), ...fields.map((field) => field.input)], show };
}

const encodeSrgb = (x) => (x <= 0.0031308 ? 12.92 * x : 1.055 * x ** (1 / 2.4) - 0.055);
const decodeSrgb = (x) => (x <= 0.04045 ? x / 12.92 : ((x + 0.055) / 1.055) ** 2.4);

/** Shows the hue of a linear colour. Lights are brighter than any swatch, so picking a hue keeps the largest part. */
function swatchControl(names, values, onPick) {
  const input = element("input", { type: "color", "aria-label": `${names["aria-label"]} hue` });
  const peakOf = (rgb) => Math.max(...rgb.map((x) => x ?? 0), 0);
  input.addEventListener("input", () => {
    const picked = [1, 3, 5].map((at) => decodeSrgb(parseInt(input.value.slice(at, at + 2), 16) / 255));
    const wanted = peakOf(values()) || 1;
    const gain = wanted > 1 ? wanted / (peakOf(picked) || 1) : 1;
    onPick(picked.map((x) => Number((x * gain).toPrecision(4))));
  });
  const show = (rgb) => {
    const gain = 1 / Math.max(peakOf(rgb), 1);
    const bytes = rgb.map((x) => Math.round(255 * encodeSrgb(Math.max(x ?? 0, 0) * gain)));
    input.value = `#${bytes.map((byte) => byte.toString(16).padStart(2, "0")).join("")}`;
  };
  return { input, show };
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
};
