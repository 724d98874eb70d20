// The layer "error": where and by how much the scene's airlight differs from the reference, in growing resolution.

import { Problem } from "./api.js";
import { button, element, numberText, plainDoc } from "./dom.js";
import { progressText } from "./progress.js";

const SCALES = [1 / 16, 1 / 8, 1 / 4, 1 / 2, 1];
// More pixels no comparison has.
const PIXELS_MOST = 2e6;
const FIGURES = ["median", "p95", "max"];

const percent = (share) => `${numberText(100 * share, 3)} %`;
const scaleText = (scale) => (scale === 1 ? "full size" : `1/${1 / scale} of the size`);
const wait = (delay_ms, signal) => new Promise((resolve, reject) => {
  const timer = setTimeout(resolve, delay_ms);
  signal.addEventListener("abort", () => { clearTimeout(timer); reject(signal.reason); });
});

/** Covers the picture with the errors of each size as they come, until something changes. */
export class ErrorLayer {
  #canvas;
  #note;
  #ask;
  #onState;
  #docs = {};
  #isOn = false;
  #controller = null;

  /**
   * `ask({width, height, signal, show})` answers `{blob, numbers}` and tells `show({state, fraction})` how far it is;
   * `onState(name, comparison)` is told `off`, `waiting`, `working`, `done`, `failed` or `stopped`, and the newest
   * comparison where there is one.
   */
  constructor(canvas, note, ask, onState) {
    this.#canvas = canvas;
    this.#note = note;
    this.#ask = ask;
    this.#onState = onState;
  }

  /** Takes the documentation of the figures: the schema of a comparison's properties. */
  describe(properties) {
    this.#docs = properties ?? {};
  }

  /** Switches the layer on or off; the next full frame starts it. */
  set isOn(isOn) {
    this.#isOn = isOn;
    this.cancel();
  }

  /** Gives up what is on its way: the picture is no longer the one that was compared. */
  cancel() {
    this.#controller?.abort();
    this.#controller = null;
    this.#canvas.hidden = true;
    this.#note.hidden = !this.#isOn;
    this.#note.replaceChildren(element("p", { textContent: "The errors come when the picture rests." }));
    this.#onState(this.#isOn ? "waiting" : "off");
  }

  /** Gives up the comparison on its way and keeps what is known; a change of the picture begins anew. */
  stop() {
    this.#controller?.abort();
    this.#say("Stopped.");
    this.#onState("stopped");
  }

  /** Compares a picture of that size, coarsely first. */
  async start({ width, height }) {
    if (!this.#isOn) return;
    this.cancel();
    const controller = new AbortController();
    this.#controller = controller;
    const fit = Math.min(1, Math.sqrt(PIXELS_MOST / (width * height)));
    try {
      await this.#refine(fit * width, fit * height, controller.signal);
    } catch (error) {
      if (controller.signal.aborted) return;
      this.#say(error.message);
      this.#onState("failed");
    }
  }

  async #refine(width, height, signal) {
    let last = null;
    for (const scale of SCALES) {
      const what = `Comparing at ${scaleText(scale)}`;
      this.#say(`${what}…`, last, true);
      this.#onState("working");
      const size = { width: Math.max(Math.round(width * scale), 1), height: Math.max(Math.round(height * scale), 1) };
      const show = (far) => { this.#note.querySelector("p").textContent = progressText(what, far); };
      const { blob, numbers } = await this.#patiently({ ...size, signal, show });
      const bitmap = await createImageBitmap(blob);
      if (signal.aborted) return;
      this.#show(bitmap);
      last = { ...size, scale, numbers };
      this.#onState("working", last);
    }
    this.#say("", last);
    this.#onState("done", last);
  }

  /** Asks again while the server is busy. */
  async #patiently(view) {
    for (;;) {
      try {
        return await this.#ask(view);
      } catch (error) {
        if (!(error instanceof Problem && error.isBusy)) throw error;
        await wait(error.retryAfter_s * 1000, view.signal);
      }
    }
  }

  #show(bitmap) {
    this.#canvas.width = bitmap.width;
    this.#canvas.height = bitmap.height;
    this.#canvas.getContext("2d").drawImage(bitmap, 0, 0);
    this.#canvas.hidden = false;
    bitmap.close();
  }

  /** Writes what goes on, and how to stop what can be stopped; the figures stay where they are known. */
  #say(text, comparison, canStop = false) {
    const stop = canStop ? [button("Stop", () => this.stop(), { className: "small", "aria-label": "Stop comparing" })] : [];
    const progress = element("div", { className: "progress-line", hidden: text === "" }, element("p", { textContent: text, "aria-live": "off" }), ...stop);
    this.#note.hidden = false;
    if (comparison) this.#note.replaceChildren(progress, ...this.#figures(comparison));
    else if (this.#note.querySelector("dl")) this.#note.firstChild.replaceWith(progress);
    else this.#note.replaceChildren(progress);
  }

  #figures({ scale, numbers }) {
    const { a, b } = numbers;
    const rows = FIGURES.map((name) => element("div", { title: plainDoc(this.#docs[name]?.description) },
      element("dt", { textContent: name }), element("dd", { textContent: percent(numbers[name]) })));
    const legend = element("div", { className: "legend", title: "The colours are logarithmic." },
      element("span", { textContent: "0.01 %" }), element("span", { textContent: "1 %" }), element("span", { textContent: "100 %" }));
    return [element("p", { textContent: `${a.airlight} against ${b.airlight}, ${scaleText(scale)}` }),
      element("dl", {}, ...rows), legend];
  }
}
