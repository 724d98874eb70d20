// The probe: asks the server what a ray meets, and shows the numbers.

import { element, numberText } from "./dom.js";

const PAUSE_MS = 60;
const pause = () => new Promise((resolve) => setTimeout(resolve, PAUSE_MS));

/** Asks for the newest point only, one request at a time. */
export class Probe {
  #ask;
  #show;
  #point = null;
  #isDue = false;
  #isBusy = false;

  /** `ask(point)` answers a reading; `show(reading, point)` is given `null` where there is none. */
  constructor(ask, show) {
    this.#ask = ask;
    this.#show = show;
  }

  /** Remembers where to probe next, without probing. */
  aim(point) {
    if (this.#point) this.#point = point;
  }

  at(point) {
    this.#point = point;
    this.refresh();
  }

  clear() {
    this.#point = null;
    this.#show(null, null);
  }

  /** Probes the same point again, because the scene changed. */
  async refresh() {
    if (!this.#point) return;
    this.#isDue = true;
    if (this.#isBusy) return;
    this.#isBusy = true;
    while (this.#isDue && this.#point) {
      this.#isDue = false;
      const point = this.#point;
      // The frame's own request tells what is wrong; a reading that failed is merely absent.
      const reading = await this.#ask(point).catch(() => null);
      if (this.#point) this.#show(reading, point);
      await pause();
    }
    this.#isBusy = false;
  }
}

const numbersText = (value) => (Array.isArray(value) ? value.map((x) => numberText(x, 3)).join("  ") : numberText(value, 4));
const isPresent = (value) => value !== undefined && value !== null;

/** The reading as `[name, text, unit]`, in the order in which they are shown. */
function rowsOf(reading, lightNames) {
  const { hit, airlight_by_light: byLight = [] } = reading;
  const rows = [
    ["optical depth", reading.optical_depth, ""],
    ["transmittance", reading.transmittance, ""],
    ["airlight", reading.airlight, "W/(m² sr)"],
    ["ambient", reading.ambient, "W/(m² sr)"],
    ["radiance", reading.radiance, "W/(m² sr)"],
    ...(byLight.length > 1 ? byLight.map((rgb, i) => [`airlight of ${lightNames[i] ?? i}`, rgb, "W/(m² sr)"]) : []),
  ].filter(([, value]) => isPresent(value)).map(([name, value, unit]) => [name, numbersText(value), unit]);
  const surface = isPresent(hit?.surface) ? ` · ${hit.surface}` : "";
  return [["hit", hit ? `${numberText(hit.distance_m)} m${surface}` : "nothing", ""], ...rows];
}

/** Writes a reading into a `<dl>`. */
export function showReading(list, reading, lightNames) {
  const rows = reading ? rowsOf(reading, lightNames) : [];
  list.replaceChildren(...rows.map(([name, text, unit]) => element("div", { title: unit },
    element("dt", { textContent: name }), element("dd", { textContent: text }))));
}
