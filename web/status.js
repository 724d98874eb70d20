// The line that says what is wrong: the server is away, busy, or refuses the request.

import { BACKOFF_MS, Problem, ServerLost } from "./api.js";
import { button, element } from "./dom.js";

const ERRORS_MOST = 5;

/** Binds the status line; `reveal(pointer)` leads to the control of an error. */
export function bindStatus(line, reveal) {
  let shown = "";

  function show(error, retryIn_ms) {
    const again = retryIn_ms === undefined ? "" : ` Trying again in ${Math.max(Math.round(retryIn_ms / 1000), 1)} s.`;
    const errors = (error.errors ?? []).slice(0, ERRORS_MOST);
    // The server's own sentence may be the first of the errors over again.
    const repeats = errors.length > 0 && error.message.endsWith(errors[0].detail);
    const text = `${repeats ? "This cannot be rendered:" : error.message}${again}`;
    // Written only when it differs: a screen reader reads every change of an alert.
    const key = JSON.stringify([text, errors]);
    if (key === shown) return;
    shown = key;
    const items = errors.map(({ pointer, detail }) => element("li", {},
      button(pointer || "/", () => reveal(pointer ?? ""), { title: "Go to this control" }), ` ${detail}`));
    line.replaceChildren(element("p", { textContent: text }), ...(items.length > 0 ? [element("ul", {}, ...items)] : []));
    line.hidden = false;
  }

  function clear() {
    shown = "";
    line.hidden = true;
    line.replaceChildren();
  }

  /** Asks again and again, ever more slowly, until the server is there and has time. */
  async function untilAnswered(ask) {
    for (let backoff_ms = BACKOFF_MS.first; ; backoff_ms = Math.min(backoff_ms * 2, BACKOFF_MS.most)) {
      try {
        return await ask();
      } catch (error) {
        const isPassing = error instanceof ServerLost || (error instanceof Problem && error.isBusy);
        if (!isPassing) throw error;
        show(error, backoff_ms);
        await new Promise((resolve) => setTimeout(resolve, backoff_ms));
      }
    }
  }

  return { show, clear, untilAnswered };
}
