// The parts of controls for numbers: fields to type into, and sliders.

import { element, numberText } from "./dom.js";
import { bounds, usual } from "./schema.js";

// A range no wider than this gets a slider over all of it.
const SLIDER_SPAN_MOST = 1000;
const SLIDER_STEPS = 400;
// Steps of about 3 %, and powers of ten are among them where an end is one.
const LOG_STEP = 1 / 80;

export const isFocused = (node) => document.activeElement === node;

/** A number field alone. The arrow keys step by a tenth of the number's own size, with shift by all of it. */
export function numberInput(schema, names, onInput) {
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

/** One number field for each element of a tuple, named by `axes`; `onInput` is given all the numbers. */
export function numberInputs(elements, axes, names, onInput) {
  let values = [];
  const fields = elements.map((item, i) => {
    const own = { ...names, "aria-label": `${names["aria-label"]} ${axes[i]}`, id: undefined, title: axes[i] };
    return numberInput(item, own, (value) => {
      values = values.map((old, k) => (k === i ? value : old));
      onInput(values);
    });
  });
  fields[0].input.id = names.id;
  const show = (next) => {
    values = elements.map((_, i) => next?.[i] ?? null);
    fields.forEach((field, i) => field.show(values[i]));
  };
  return { inputs: fields.map(({ input }) => input), show };
}

/** Whether a number has an order worth sliding along: seeds and other wide integers have none. */
export function hasSlider(schema) {
  const [low, high] = bounds(schema);
  const isWideInteger = schema.type === "integer" && high - low > SLIDER_SPAN_MOST;
  return usual(schema) !== undefined || !(schema.nullable || isWideInteger);
}

/** The slider's ends: what is usual and the value, else the whole range where it is narrow, else around the value. */
function sliderRange(schema, value) {
  const [low, high] = bounds(schema);
  const { min, max } = usual(schema) ?? {};
  if (min !== undefined) return [isLog(schema) && !(value > 0) ? min : Math.min(min, value), Math.max(max, value)];
  if (high - low <= SLIDER_SPAN_MOST) return [low, high];
  if (low >= 0) return [low, Math.min(Math.max(value > 0 ? value * 4 : 1, low * 2), high)];
  const reach = Math.max(Math.abs(value), 1) * 2;
  return [Math.max(value - reach, low), Math.min(value + reach, high)];
}

const isLog = (schema) => usual(schema)?.scale === "log";

/**
 * A slider alone. `show(value)` moves its thumb unless a hand is on it, for what lies under a hand must not move;
 * `place(value)` always does.
 */
export function sliderInput(schema, label, onSlide) {
  const input = element("input", { type: "range", "aria-label": label });
  const [low, high] = bounds(schema);
  // The track is the quantity's logarithm where equal steps multiply. Zero lies beyond its end.
  const [onTrack, offTrack] = isLog(schema) ? [Math.log10, (x) => 10 ** x] : [Number, Number];
  const place = (value) => {
    const number = value ?? low;
    const [least, most] = sliderRange(schema, number).map(onTrack);
    input.min = least;
    input.max = most;
    const fine = isLog(schema) ? LOG_STEP : (most - least) / SLIDER_STEPS;
    input.step = schema.type === "integer" ? 1 : fine;
    input.value = Math.max(onTrack(number), least);
    input.setAttribute("aria-valuetext", numberText(number));
  };
  const read = () => Math.min(Math.max(Number(offTrack(input.valueAsNumber).toPrecision(isLog(schema) ? 3 : 4)), low), high);
  input.addEventListener("input", () => {
    input.setAttribute("aria-valuetext", numberText(read()));
    onSlide(read());
  });
  input.addEventListener("blur", () => place(read()));
  return { input, place, show: (value) => { if (!isFocused(input)) place(value); } };
}
