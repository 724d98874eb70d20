// Which scene the page works on: opening, copying and storing scenes, and what to do when the server has lost one.

import * as api from "./api.js";
import { freshName } from "./document.js";

const POLL_MS = 2000;
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
  #presets;
  /** Whether requests stand in for the socket. */
  #polls = 0;
  #kept = { pending: [] };

  /**
   * `isPreset(id)` tells presets from stored scenes. Events: `opened()` when another scene has come, `missing(id)` when there
   * is none, `moved(id)` when the page works on another scene from now on, `failed(error)`.
   */
  constructor(document, live, keeper, isPreset, events) {
    this.#document = document;
    this.#live = live;
    this.#keeper = keeper;
    this.#presets = isPreset;
    this.#events = events;
  }

  /** Whether the scene stays as it is: a change makes a copy. */
  get isPreset() {
    return this.#document.revision === 0 || (this.#document.revision === null && this.#presets(this.#document.id));
  }

  /** Opens a stored scene, or a preset. */
  async open(id) {
    this.#kept = await this.#keeper.kept(id);
    this.#document.begin(id, this.#kept.pending);
    this.#events.moved(id);
    this.#live.open(id);
    if (this.#polls) await this.poll();
  }

  /** A scene of this page, of which a preset is the beginning: the first change makes it. */
  async own() {
    if (!this.isPreset) return;
    const [from, id, key] = [this.#document.id, freshId(this.#document.id), freshName()];
    const { revision } = await api.copy(from, id, key);
    this.#document.moved(id, revision);
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
    await api.store(this.#document.id, scene, false, freshName());
    await this.#begin(this.#document.id);
  }

  /** Stores a new scene and goes on with that. */
  async create(scene) {
    const id = freshId(this.#presets(this.#document.id) ? this.#document.id : "scene");
    await api.store(id, scene, true, freshName());
    await this.#begin(id);
  }

  async #begin(id) {
    this.#document.begin(id);
    this.#events.moved(id);
    this.#live.open(id);
    if (this.#polls) await this.poll();
  }

  /** The server does not know the scene any more: it gets what this page has of it. */
  async restore() {
    const { id, revision, scene } = this.#document;
    const known = revision === null ? this.#kept.scene : scene;
    if (!known || this.#presets(id)) return this.#events.missing(id);
    try {
      await api.store(id, known, true);
      this.#document.stored();
    } catch (error) {
      // Another page was faster.
      if (error.status !== 412) return this.#events.failed(error);
    }
    this.#live.open(id);
    if (this.#polls) await this.poll();
  }

  /** The socket's first word, or what a request brought. */
  hello({ id, revision, scene }) {
    if (id !== this.#document.id) return;
    const isFirst = this.#document.revision === null;
    this.#document.hear({ revision, scene });
    if (isFirst) this.#events.opened();
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

  /** Asks whether the scene has changed. */
  async poll() {
    const { id, revision } = this.#document;
    try {
      const told = await api.scene(id, revision ?? undefined);
      if (told && id === this.#document.id) this.hello(told);
    } catch (error) {
      if (error.status === 404) await this.restore();
    }
  }
}
