// Which scene the page works on: opening, copying and storing scenes, and what to do when the server has lost one.

import * as api from "./api.js";
import { freshName } from "./document.js";

const POLL_MS = 2000;
const EXISTS = 412;
const NAME_MOST = 64;

/** An id that begins with a name: `street-thin` gives `street-thin-3f9a2c`. */
export function freshId(name) {
  const tail = `-${freshName().slice(0, 6)}`;
  const stem = name.toLowerCase().replaceAll(/[^a-z0-9-]+/g, "-").replace(/^-+|-+$/g, "");
  return (stem || "scene").slice(0, NAME_MOST - tail.length) + tail;
}

/** Connects a document with the server. */
export class Session {
  #document;
  #live;
  #keeper;
  #events;
  #isPreset;
  /** The timer of requests that stand in for the socket; 0 where there is one. */
  #polls = 0;
  #kept = { pending: [] };
  /** Whether the scene that comes is another one than that before. */
  #isNew = false;

  /**
   * `isPreset(id)` tells presets from stored scenes. Events: `opened()` when another scene has come, `missing(id)` when there
   * is none and none can be made, `gone()` when a request finds none, `moved(id)` when the page works on another scene from now on.
   */
  constructor(document, live, keeper, isPreset, events) {
    this.#document = document;
    this.#live = live;
    this.#keeper = keeper;
    this.#isPreset = isPreset;
    this.#events = events;
  }

  /** Whether the scene stays as it is: a change makes a copy. */
  get isPreset() {
    return this.#document.revision === 0 || (this.#document.revision === null && this.#isPreset(this.#document.id));
  }

  /** Opens a stored scene, or a preset. */
  async open(id) {
    const kept = await this.#keeper.kept(id);
    this.#kept = kept;
    await this.#begin(id, kept.pending);
  }

  /** A scene of this page, of which a preset is the beginning: the first change makes it. */
  async own() {
    if (!this.isPreset) return;
    const [from, id, key] = [this.#document.id, freshId(this.#document.id), freshName()];
    const { revision } = await api.copy(from, id, key);
    // Another scene was opened meanwhile: the copy stays as it is.
    if (this.#document.id !== from) return;
    this.#document.moved(id, revision);
    await this.#keeper.moved(from);
    this.#events.moved(id);
    this.#live.open(id);
  }

  /** Stores the scene under another id and goes on with that. */
  async saveAs(id) {
    await api.copy(this.#document.id, id, freshName());
    await this.open(id);
  }

  /** Puts a whole scene in the place of this one; a preset stays, and the scene becomes a new one. */
  async replace(scene) {
    if (this.isPreset) return this.create(scene);
    const { id } = this.#document;
    await api.store(id, scene, false);
    await this.#begin(id);
  }

  /** Stores a new scene and goes on with that. */
  async create(scene) {
    const id = freshId(this.#isPreset(this.#document.id) ? this.#document.id : "scene");
    await api.store(id, scene, true);
    await this.#begin(id);
  }

  async #begin(id, pending = []) {
    this.#isNew = true;
    this.#document.begin(id, pending);
    this.#events.moved(id);
    // A request brings the scene compressed, or from what the browser keeps; the socket then need not.
    if ((await this.poll()) && id === this.#document.id) this.#live.open(id);
  }

  /** The server does not know the scene any more: it gets what this page has of it. Answers whether it has it now. */
  async restore() {
    const { id, revision, scene } = this.#document;
    const kept = this.#kept;
    const known = revision === null ? kept.scene : scene;
    if (!known || this.#isPreset(id)) {
      this.#events.missing(id);
      return false;
    }
    const inside = (change) => kept.keys?.includes(change.key);
    const sealed = revision === null ? this.#document.pending.filter(inside) : this.#document.seal();
    try {
      const stored = await api.store(id, known, true);
      this.#document.stored(sealed, stored.revision);
    } catch (error) {
      // Another page was faster: the scene is there.
      if (error.status !== EXISTS) throw error;
    }
    if (id !== this.#document.id) return false;
    this.#live.open(id);
    if (this.isPolling) await this.poll();
    return true;
  }

  /** The socket's first word, or what a request brought. */
  hello({ id, revision, scene }) {
    if (id !== this.#document.id) return;
    // What it thinks is known here is not.
    if (!scene && revision !== this.#document.known) return this.#live.reopen();
    this.#document.hear({ revision, scene });
    if (!this.#isNew || this.#document.revision === null) return;
    this.#isNew = false;
    this.#events.opened();
  }

  /** Requests stand in for the socket from now on, or no longer. */
  usePolls(isOn) {
    clearInterval(this.#polls);
    this.#polls = isOn ? setInterval(() => this.poll(), POLL_MS) : 0;
    if (isOn) this.poll();
  }

  get isPolling() {
    return this.#polls !== 0;
  }

  /** Asks whether the scene has changed. Answers false where there is none. */
  async poll() {
    const { id, known } = this.#document;
    try {
      const told = await api.scene(id, known ?? undefined);
      if (told && id === this.#document.id && known === this.#document.known) this.hello(told);
    } catch (error) {
      if (error.status !== 404) return true;
      if (id === this.#document.id) this.#events.gone();
      return false;
    }
    return true;
  }
}
