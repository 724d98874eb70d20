// The frame loop where there is no socket: drafts while things move, one full frame when they rest, nothing when nothing changed.

import { BACKOFF_MS, Problem, ServerLost } from "./api.js";

const REST_MS = 150;
// A draft of an older view still shows movement, so it is let finish; unless it takes this long.
const STALE_DRAFT_MS = 2000;
const DRAFT_AREA_PX = 800 * 600;
const DRAFT_SCALE_LEAST = 0.4;
const DRAFT_TARGET_MS = 80;

/**
 * Shows the latest view on a canvas. There is never more than one request on its way, so an older picture cannot
 * arrive after a newer one.
 */
export class Requests {
  #screen;
  #render;
  #events;
  #version = 0;
  #changedAt_ms = 0;
  /** The versions that were last shown as a draft and in full, and the one that the server refused. */
  #drafted = 0;
  #finished = 0;
  #refused = 0;
  #flight = null;
  #timer = 0;
  #notBefore_ms = 0;
  #backoff_ms = BACKOFF_MS.first;
  #draftScale = 1;

  /**
   * `render({quality, width, height, signal})` answers what `api.frame` does. Events: `frame(info)` after each picture;
   * `problem(error, retryIn_ms)`.
   */
  constructor(screen, render, events) {
    this.#screen = screen;
    this.#render = render;
    this.#events = events;
  }

  /** Says that the view is no longer what was asked for. */
  change() {
    this.#version += 1;
    this.#changedAt_ms = performance.now();
    this.#pump();
  }

  /** Gives up the picture on its way; the next one is made when something changes, or on `resume()`. */
  stop() {
    this.#refused = this.#version;
    this.#flight?.controller.abort();
    clearTimeout(this.#timer);
  }

  /** Starts what is due now, or waits for what is due later. */
  #pump() {
    clearTimeout(this.#timer);
    const now_ms = performance.now();
    if (this.#flight) return this.#overtake(now_ms);
    if (this.#finished === this.#version || this.#refused === this.#version) return;
    if (now_ms < this.#notBefore_ms) return this.#wait(this.#notBefore_ms - now_ms);
    if (this.#drafted < this.#version) return void this.#fly("draft");
    const rest_ms = this.#changedAt_ms + REST_MS - now_ms;
    if (rest_ms > 0) this.#wait(rest_ms);
    else this.#fly("full");
  }

  #wait(delay_ms) {
    this.#timer = setTimeout(() => this.#pump(), delay_ms);
  }

  /** Gives up the request on its way if a newer view should not wait for it. */
  #overtake(now_ms) {
    const { quality, version, startedAt_ms, controller } = this.#flight;
    if (version === this.#version) return;
    const patience_ms = quality === "draft" ? startedAt_ms + STALE_DRAFT_MS - now_ms : 0;
    if (patience_ms > 0) this.#wait(patience_ms);
    else controller.abort();
  }

  async #fly(quality) {
    const controller = new AbortController();
    const flight = { quality, version: this.#version, startedAt_ms: performance.now(), controller };
    this.#flight = flight;
    try {
      const answer = await this.#render({ quality, ...this.#size(quality), signal: controller.signal });
      if (!controller.signal.aborted) await this.#show(answer, flight);
    } catch (error) {
      if (!controller.signal.aborted) this.#fail(error, flight);
    } finally {
      this.#flight = null;
      this.#pump();
    }
  }

  /** The picture's size in pixels; drafts have the same shape and fewer pixels. */
  #size(quality) {
    const { width, height } = this.#screen.size;
    const draftScale = Math.min(1, Math.sqrt(DRAFT_AREA_PX / (width * height))) * this.#draftScale;
    const scale = quality === "draft" ? draftScale : 1;
    return { width: Math.max(Math.round(width * scale), 1), height: Math.max(Math.round(height * scale), 1) };
  }

  async #show({ blob, ...rest }, { quality, version, startedAt_ms }) {
    const shown = await this.#screen.show(blob);
    this.#drafted = version;
    if (quality === "full") this.#finished = version;
    else this.#adaptDrafts(performance.now() - startedAt_ms);
    this.#backoff_ms = BACKOFF_MS.first;
    this.#events.frame({ ...shown, quality, ...rest });
  }

  /** Shrinks drafts on a slow machine until the hand is followed, and lets them grow back. */
  #adaptDrafts(took_ms) {
    const wanted = this.#draftScale * Math.sqrt(DRAFT_TARGET_MS / Math.max(took_ms, 1));
    const eased = (this.#draftScale + Math.min(wanted, 1)) / 2;
    this.#draftScale = Math.min(Math.max(eased, DRAFT_SCALE_LEAST), 1);
  }

  #fail(error, { version }) {
    let retryIn_ms;
    if (error instanceof ServerLost) {
      retryIn_ms = this.#backoff_ms;
      this.#backoff_ms = Math.min(this.#backoff_ms * 2, BACKOFF_MS.most);
    } else if (error instanceof Problem && error.isBusy) {
      retryIn_ms = error.retryAfter_s * 1000;
    }
    if (retryIn_ms === undefined) this.#refused = version;
    else this.#notBefore_ms = performance.now() + retryIn_ms;
    if (version !== this.#version && retryIn_ms === undefined) return;
    this.#events.problem(error, retryIn_ms);
  }
}
