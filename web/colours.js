// Controls of linear colours: a swatch and the three numbers, and a slider of how strong a light is.

import { element } from "./dom.js";
import { numberInput, numberInputs, sliderInput } from "./numbers.js";
import { usual } from "./schema.js";

const AXES = ["r", "g", "b"];
const DIGITS = 6;

const encodeSrgb = (x) => (x <= 0.0031308 ? 12.92 * x : 1.055 * x ** (1 / 2.4) - 0.055);
const decodeSrgb = (x) => (x <= 0.04045 ? x / 12.92 : ((x + 0.055) / 1.055) ** 2.4);

/** How strong a colour is: its largest channel. */
const strengthOf = (rgb) => Math.max(...rgb.map((x) => x ?? 0), 0);
const scaled = (rgb, gain) => rgb.map((x) => Number(((x ?? 0) * gain).toPrecision(DIGITS)));

/** Linear RGB in [0, 1] as the text of a colour input, and back. */
const toHex = (rgb) => `#${rgb.map((x) => Math.round(255 * encodeSrgb(x)).toString(16).padStart(2, "0")).join("")}`;
const fromHex = (text) => [1, 3, 5].map((at) => decodeSrgb(parseInt(text.slice(at, at + 2), 16) / 255));

/** A colour: of light, whose strength has no end, where the schema tells what strengths are usual; else a share. */
export function colourControl(schemas, schema, names, onInput) {
  const make = usual(schema) ? lightControl : shareControl;
  return make(schemas, schema, names, onInput);
}

function swatchInput(names, onPick) {
  const input = element("input", { type: "color", "aria-label": `${names["aria-label"]} colour`, title: "colour" });
  input.addEventListener("input", () => onPick(fromHex(input.value)));
  return input;
}

/** A swatch that shows the colour as it is, up to white, and the numbers. */
function shareControl(schemas, schema, names, onInput) {
  let rgb = [0, 0, 0];
  const put = (next) => { show(next); onInput(next); };
  // What is brighter than any swatch keeps its strength when a hue is picked.
  const swatch = swatchInput(names, (picked) => put(scaled(picked, strengthOf(rgb) > 1 ? strengthOf(rgb) / (strengthOf(picked) || 1) : 1)));
  const numbers = numberInputs(schemas.elements(schema), AXES, names, put);
  const show = (next) => {
    rgb = AXES.map((_, i) => next?.[i] ?? 0);
    numbers.show(next);
    swatch.value = toHex(rgb.map((x) => Math.max(x, 0) / Math.max(strengthOf(rgb), 1)));
  };
  return { nodes: [swatch, ...numbers.inputs], show };
}

/** A swatch of the hue alone, a slider and a number of the strength that keep it, and the three exact numbers. */
function lightControl(schemas, schema, names, onInput) {
  const { min, max } = usual(schema);
  let strength = 0;
  // Kept where the light is off, for when it is turned on again.
  let hue = [1, 1, 1];
  const put = (next) => { show(next); onInput(next); };
  const putStrength = (next) => put(scaled(hue, next));
  const channel = { ...schemas.elements(schema)[0], "x-usual": usual(schema) };
  const label = `${names["aria-label"]}, strength`;
  // Whoever gives a dark light a colour wants to see it: the middle of what is usual.
  const swatch = swatchInput(names, (picked) =>
    put(scaled(strengthOf(picked) ? scaled(picked, 1 / strengthOf(picked)) : [1, 1, 1], strength || Math.sqrt(min * max))));
  const slider = sliderInput(channel, `${label}, slider`, putStrength);
  const field = numberInput(channel, { "aria-label": label, "aria-describedby": names["aria-describedby"], title: "strength: the largest of r, g, b" }, putStrength);
  const numbers = numberInputs(schemas.elements(schema), AXES, names, put);
  const show = (next) => {
    strength = strengthOf(next ?? []);
    if (strength > 0) hue = next.map((x) => Math.max(x ?? 0, 0) / strength);
    numbers.show(next);
    field.show(strength);
    slider.show(strength);
    swatch.value = toHex(strength > 0 ? hue : [0, 0, 0]);
  };
  const exact = element("div", { className: "exact" }, ...numbers.inputs);
  return { nodes: [swatch, slider.input, field.input, exact], show };
}
