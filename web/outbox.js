// Sends what a document has not sent yet, one request at a time, until the server has confirmed it.

import * as api from "./api.js";
import { BACKOFF_MS, Problem } from "./api.js";

const MISSING = 404;
// The disk is full, or the deadline passed: it may be better later.
const LATER = [504, 507];

/** The edits of a change, as the server reads them. */
function editsOf({ edits, guards, patch, stroke }) {
  if (patch.length === 0) return edits;
  return [{ op: "patch", patch: [...guards, ...patch], ...(stroke && { stroke }) }];
}

/**
 * Every change has a name, under which the server makes it once, however often it is sent. So nothing is lost when an
 * answer is, and nothing is done twice.
 */
export class Outbox {
  #document;
  #events;
  #isBusy = false;
  #isMissing = false;
  #timer = 0;
  #backoff_ms = BACKOFF_MS.first;

  /**
   * Events: `prepare()` is waited for before a change is sent; `refused(error)`, `waits(error, retryIn_ms)`, `sent()` when the
   * server answers again; `restore()` is waited for when the server does not know the scene, and answers whether it does now;
   * `isLive()` says whether a socket tells what changes.
   */
  constructor(document, events) {
    this.#document = document;
    this.#events = events;
  }

  /** Says that the server has lost the scene: it is given back before anything else is sent. */
  missing() {
    this.#isMissing = true;
    this.pump();
  }

  /** Forgets that, for another scene is open now. */
  forget() {
    this.#isMissing = false;
  }

  /** Sends what there is, if nothing is on its way. */
  async pump() {
    if (this.#isBusy) return;
    this.#isBusy = true;
    clearTimeout(this.#timer);
    try {
      for (;;) {
        if (this.#isMissing) {
          this.#isMissing = false;
          if (!(await this.#events.restore())) break;
        }
        const change = this.#document.next;
        if (!change) break;
        await this.#events.prepare();
        // Another scene may have been opened meanwhile.
        if (change === this.#document.next) await this.#send(change);
      }
    } catch (error) {
      this.#later(error);
    } finally {
      this.#isBusy = false;
    }
  }

  async #send(change) {
    const document = this.#document;
    const { id } = document;
    change.isSent = true;
    const body = change.route === "edits" ? { edits: editsOf(change) } : undefined;
    try {
      const { revision, patch } = await api.write(id, change.route, body, change.key);
      this.#backoff_ms = BACKOFF_MS.first;
      this.#events.sent();
      document.answered(change, revision, this.#events.isLive() ? undefined : patch);
    } catch (error) {
      if (id !== document.id) return;
      if (!(error instanceof Problem) || error.isBusy || LATER.includes(error.status)) throw error;
      if (error.status === MISSING) {
        this.#isMissing = true;
        return;
      }
      document.refused(change);
      this.#events.refused(error);
    }
  }

  #later(error) {
    const retryIn_ms = error instanceof Problem && error.isBusy ? error.retryAfter_s * 1000 : this.#backoff_ms;
    this.#backoff_ms = Math.min(this.#backoff_ms * 2, BACKOFF_MS.most);
    this.#events.waits(error, retryIn_ms);
    this.#timer = setTimeout(() => this.pump(), retryIn_ms);
  }
}
