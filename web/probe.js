// The probe: asks the server what a ray meets, and shows the numbers.

import { element, numberText } from "./dom.js";

const PAUSE_MS = 60;
const pause = () => new Promise((resolve) => setTimeout(resolve, PAUSE_MS));

/** Asks for the newest point only, one request at a time. */
export class Probe {
  #ask;
  #show;
  #rayAt;
  #newest = { point: null, reading: null };
  #point = null;
  #isDue = false;
  #running = null;

  /** `ask(rays)` answers a reading for each; `show(reading, point)` is given `null` where there is none. */
  constructor(ask, show) {
    this.#ask = ask;
    this.#show = show;
  }

  /** `rayAt(point)` answers the ray through a point of the picture. */
  bind(rayAt) {
    this.#rayAt = rayAt;
  }

  /** Readings of some rays, once. */
  ask(rays) {
    return this.#ask(rays);
  }

  /** The newest reading and the point that it is of. */
  get newest() {
    return this.#newest;
  }

  /** Remembers where to probe next, without probing. */
  aim(point) {
    if (this.#point) this.#point = point;
  }

  /** Probes a point; answers when there is a reading, of this point or a newer one. */
  at(point) {
    this.#point = point;
    return this.refresh();
  }

  clear() {
    this.#point = null;
    this.#newest = { point: null, reading: null };
    this.#show(null, null);
  }

  /** Probes the same point again, because the scene changed. */
  async refresh() {
    if (!this.#point) return;
    this.#isDue = true;
    this.#running ??= this.#run();
    await this.#running;
  }

  async #run() {
    while (this.#isDue && this.#point) {
      this.#isDue = false;
      const point = this.#point;
      // The frame's own request tells what is wrong; a reading that failed is merely absent.
      const [reading = null] = await this.#ask([this.#rayAt(point)]).catch(() => []);
      if (this.#point) {
        this.#newest = { point, reading };
        this.#show(reading, point);
      }
      await pause();
    }
    this.#running = null;
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
