// Small pieces of the document: elements, labels, numbers as text.

/**
 * Creates an element. A name that the element knows is set as a property, any other as an attribute;
 * `undefined` leaves it out.
 */
export function element(tag, properties = {}, ...children) {
  const node = document.createElement(tag);
  for (const [name, value] of Object.entries(properties)) {
    if (value === undefined) continue;
    if (name in node) node[name] = value;
    else node.setAttribute(name, value);
  }
  node.append(...children);
  return node;
}

export function button(text, onClick, properties = {}) {
  const node = element("button", { type: "button", textContent: text, ...properties });
  node.addEventListener("click", onClick);
  return node;
}

/** Puts an element at a point of the box that it lies in, `{x, y}` from 0 to 1. */
export function putAt(node, { x, y }) {
  node.style.left = `${100 * x}%`;
  node.style.top = `${100 * y}%`;
}

let idsGiven = 0;

/** An element id that nothing else in this document has. */
export function freshId(stem) {
  idsGiven += 1;
  return `${stem}-${idsGiven}`;
}

// The longer suffix first, so that `_per_m` is not read as metres.
const UNITS = [
  ["_per_m", "1/m"], ["_deg", "°"], ["_rad", "rad"], ["_hz", "Hz"], ["_ev", "EV"], ["_m", "m"], ["_s", "s"],
];

/**
 * Splits a JSON key into words and the unit that its suffix names: `far_m` is "far" in "m". Where it names none, the
 * doc comment may, in brackets: "Radiant intensity [W/sr]."
 */
export function nameAndUnit(key, description = "") {
  const [suffix, unit] = UNITS.find(([suffix]) => key.endsWith(suffix) && key !== suffix) ?? ["", ""];
  const stem = key.slice(0, key.length - suffix.length);
  // With a comma it is a list or a range.
  const [, documented = ""] = /\[([^\],`]+)\]/.exec(description) ?? [];
  return { name: stem.replaceAll("_", " "), unit: unit || documented };
}

/** A number for reading: `digits` significant digits, powers of ten where it is very large or small. */
export function numberText(value, digits = 4) {
  if (!Number.isFinite(value)) return "–";
  const size = Math.abs(value);
  if (size !== 0 && (size >= 1e6 || size < 1e-4)) return value.toExponential(digits - 2);
  return String(Number(value.toPrecision(digits)));
}

/** A doc comment as text with its `code` marked. */
export function docNodes(text) {
  return text.split("`").map((part, i) => (i % 2 ? element("code", { textContent: part }) : part));
}

/** A doc comment for a native tooltip, which cannot show markup. */
export function plainDoc(text) {
  return text?.replaceAll("`", "") || undefined;
}
