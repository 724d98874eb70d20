// What is shown of the scene: the socket's frames, or where there is no socket those of requests.

import { freshName } from "./document.js";

// What comes before all passes, and what after them.
const PLACES = { queue: -1, encode: 1 };
const placeOf = ({ name }) => PLACES[name] ?? 0;

/**
 * Asks for the newest view and says what is on the screen: `loading` while a newer picture is due, then `draft` or `full`;
 * `error` or `stopped` otherwise.
 */
export class Preview {
  #screen;
  #live;
  #requests;
  #getView;
  #events;
  #usesRequests = false;
  #seq = 0;
  #sentAt_ms = 0;
  #isDue = false;
  #isStopped = false;
  /** The header of the frame that is shown. */
  #shown = null;
  #count = 0;

  /**
   * `getView()` answers what a view of the socket holds, without size. Events: `phase(name)`, `frame(info)` after each
   * picture, `asked(job)` with the name of the pictures that come, `isNewest(revision)` answers whether the scene has no
   * newer revision.
   */
  constructor(screen, live, requests, getView, events) {
    this.#screen = screen;
    this.#live = live;
    this.#requests = requests;
    this.#getView = getView;
    this.#events = events;
  }

  /** The view is another one. */
  change() {
    this.#isStopped = false;
    this.expect();
    if (this.#usesRequests) this.#requests.change();
    else if (!this.#isDue) {
      this.#isDue = true;
      queueMicrotask(() => this.#send());
    }
  }

  /** The scene is another one: frames of it come by themselves over the socket. */
  sceneChanged() {
    if (this.#usesRequests) return this.change();
    this.#sentAt_ms = performance.now();
    this.expect();
  }

  /** Says that a newer picture is due. */
  expect() {
    if (!this.#isStopped) this.#events.phase("loading");
  }

  /** Gives up the picture on its way; the next one is made when something changes, or on `resume()`. */
  stop() {
    this.#isStopped = true;
    this.#live.say({ type: "stop" });
    this.#requests.stop();
    this.#events.phase("stopped");
  }

  /** Makes the picture that was stopped after all. */
  resume() {
    this.change();
  }

  /** Uses requests, or the socket. */
  useRequests(isOn) {
    this.#usesRequests = isOn;
    this.#requests.stop();
    this.change();
  }

  #send() {
    this.#isDue = false;
    this.#seq += 1;
    this.#sentAt_ms = performance.now();
    const job = freshName();
    this.#live.say({ type: "view", seq: this.#seq, ...this.#getView(), ...this.#screen.size, job });
    this.#events.asked(job);
  }

  /** A frame of the socket. */
  async take(header, blob) {
    if (this.#usesRequests) return;
    const shown = await this.#screen.show(blob);
    this.#shown = header;
    const passes = Object.entries(header.timing_ms).map(([name, duration_ms]) =>
      ({ name, duration_ms, is_reused: header.reused.includes(name) })).sort((a, b) => placeOf(a) - placeOf(b));
    const roundTrip_ms = performance.now() - this.#sentAt_ms;
    this.#tell({ ...shown, quality: header.tier, backend: header.backend, passes, roundTrip_ms, revision: header.revision, depthRange: header.depth_range });
    this.look();
  }

  /** A picture of the requests. */
  took(info) {
    this.#tell(info);
    this.#events.phase(info.quality);
  }

  #tell(info) {
    this.#count += 1;
    this.#events.frame({ seq: this.#count, ...info });
  }

  /** Another scene is shown from now on: what is on the screen is not of it. */
  forget() {
    this.#shown = null;
  }

  /** Says what is on the screen, if it is what was asked for last. */
  look() {
    if (!this.#shown || this.#usesRequests || this.#isStopped) return;
    if (this.#shown.seq === this.#seq && this.#events.isNewest(this.#shown.revision)) this.#events.phase(this.#shown.tier);
  }

  /** The server refused the view of that number. */
  refused(seq) {
    return seq === undefined || seq === this.#seq;
  }
}
