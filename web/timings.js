// How long the last frame took, pass by pass.

import { element, numberText } from "./dom.js";

/** Reads a `Server-Timing` header: `[{name, duration_ms, is_reused}]`. */
export function parseServerTiming(header) {
  // Commas inside a quoted description do not separate.
  const entries = header.match(/(?:[^,"]|"(?:\\.|[^"\\])*")+/g) ?? [];
  return entries.map((entry) => ({
    name: entry.split(";")[0].trim(),
    duration_ms: Number.parseFloat(/;\s*dur\s*=\s*"?([\d.eE+-]+)/.exec(entry)?.[1]),
    is_reused: /;\s*desc\s*=\s*"?reused/.test(entry),
  })).filter(({ name, duration_ms }) => name && Number.isFinite(duration_ms));
}

const millis = (duration_ms) => `${numberText(duration_ms, duration_ms < 10 ? 2 : 3)} ms`;

/** Writes a frame's figures in one line. */
export function showFacts(line, { quality, width, height, backend, roundTrip_ms }) {
  const facts = [quality, `${width} × ${height}`, backend, millis(roundTrip_ms)].filter(Boolean);
  line.textContent = facts.join(" · ");
}

/** Writes a frame's passes into a `<dl>`, each with a bar of its share. */
export function showTimings(list, { passes, roundTrip_ms, bytes }) {
  const longest_ms = Math.max(...passes.map((pass) => pass.duration_ms), 1e-3);
  const rows = passes.map(({ name, duration_ms, is_reused }) => {
    const bar = element("span", { className: "bar" });
    bar.style.width = `${(100 * duration_ms) / longest_ms}%`;
    return element("div", {}, element("dt", {}, name.replaceAll(/[_-]/g, " ")), element("dd", {}, is_reused ? "kept" : millis(duration_ms)), bar);
  });
  const extra = [["round trip", millis(roundTrip_ms)], ["picture", `${numberText(bytes / 1e3, 3)} kB`]];
  list.replaceChildren(...rows, ...extra.map(([name, text]) =>
    element("div", {}, element("dt", { textContent: name }), element("dd", { textContent: text }))));
}
