// What the colours of a layer mean: its unit and, where it is a map, a bar of its values.

import { element, numberText } from "./dom.js";

const RADIANCE = "W/(m² sr)";
// Pictures of radiance are shown by exposure and tone map; what is no light, by a colour map.
const LAYERS = {
  beauty: { unit: RADIANCE, note: "radiance" },
  airlight: { unit: RADIANCE, note: "radiance of the fog" },
  surface: { unit: RADIANCE, note: "radiance of the surfaces" },
  // Drawn as what it takes away: 1 − exp(−τ).
  optical_depth: { unit: "no unit", note: "optical depth", ticks: [0, 0.2, 0.5, 1, 2, 4], place: (value) => -Math.expm1(-value) },
  transmittance: { unit: "no unit", note: "transmittance", ticks: [0, 0.25, 0.5, 0.75, 1], place: (value) => value },
  depth: { unit: "m", note: "depth" },
  normal: { unit: "no unit", note: "x, y, z of the normal as red, green, blue" },
};

/** Ticks of a logarithmic scale from the nearest to the farthest. */
function depthTicks([nearest, farthest]) {
  const span = Math.log(farthest / nearest) || 1;
  const shares = [0, 0.25, 0.5, 0.75, 1];
  return shares.map((share) => [share, nearest * Math.exp(share * span)]);
}

/** Shows the legend of a frame's layer in `box`. */
export function showLegend(box, { layer, depthRange }) {
  const legend = LAYERS[layer];
  box.hidden = !legend;
  if (!legend) return;
  const { unit, note, ticks, place } = legend;
  const marks = layer === "depth" && depthRange ? depthTicks(depthRange) : (ticks ?? []).map((value) => [place(value), value]);
  const key = JSON.stringify([layer, marks]);
  if (box.dataset.key === key) return;
  box.dataset.key = key;
  const name = element("p", {}, `${note} `, element("span", { className: "unit", textContent: `[${unit}]` }));
  const tick = ([share, value]) => {
    const node = element("span", { textContent: numberText(value, 3) });
    node.style.left = `${100 * share}%`;
    return node;
  };
  const bar = marks.length > 0 ? [element("div", { className: "colour-bar" }), element("div", { className: "ticks" }, ...marks.map(tick))] : [];
  box.classList.toggle("has-bar", marks.length > 0);
  box.replaceChildren(name, ...bar);
}
