// The scene as this page knows it: what the server has told, and on top of it what is on its way there.

import { applyPatch } from "./vendor/fast-json-patch/core.mjs";
import { inserting, join, removing, setting } from "./changes.js";

// Edits of one request, well below what a request may hold.
const TOGETHER_MOST = 100;

/** A name that no other request has. `crypto.randomUUID` is missing where a page came without https. */
export function freshName() {
  const bytes = crypto.getRandomValues(new Uint8Array(16));
  return Array.from(bytes, (byte) => byte.toString(16).padStart(2, "0")).join("");
}

const apply = (scene, patch) => applyPatch(scene, structuredClone(patch), false, true);

/**
 * A scene and the changes that the server has not confirmed yet. A change is seen here at once; when somebody else's
 * change comes meanwhile, ours are taken back, theirs is made, and ours are made again.
 */
export class SceneDocument {
  id = null;
  /** The revision that the server told last; `null` before it told anything. */
  revision = null;
  scene = {};
  /** `{key, stroke, route, edits, patch, inverse, guards, needsBase, isSent, revision}`, the oldest first. */
  #pending = [];
  /** What the server told while a request was on its way whose revision is not known yet. */
  #told = [];
  #events;

  /**
   * Events: `changed()` after each change of the scene, `pending()` when there is more or less to send, `lost()` when the
   * scene must be told anew.
   */
  constructor(events) {
    this.#events = events;
  }

  get pending() {
    return this.#pending;
  }

  /** Whether all changes are confirmed and told. */
  get isSettled() {
    return this.#pending.length === 0;
  }

  /** The newest revision that this page knows of. */
  get latest() {
    return Math.max(this.revision ?? 0, ...this.#pending.map(({ revision }) => revision ?? 0));
  }

  /** Begins with another scene, of which nothing is known yet; `pending` are changes that were kept from before. */
  begin(id, pending = []) {
    this.id = id;
    this.revision = null;
    this.#told = [];
    this.#pending = pending.map((change) => ({ ...change, isSent: false }));
    if (pending.length > 0) this.#events.pending();
  }

  /** Goes on as the scene of another id, which is a copy of this one. */
  moved(id, revision) {
    this.id = id;
    this.revision = revision;
    this.#told = [];
  }

  set(path, value, stroke) { this.change(setting(this.scene, path, value), stroke); }
  insert(path, index, value) { this.change(inserting(this.scene, path, index, value)); }
  remove(path) { this.change(removing(this.scene, path)); }

  /** Makes a change here and sends it; those of one stroke are undone together. */
  change({ guards, patch, inverse }, stroke) {
    if (patch.length === 0) return;
    apply(this.scene, patch);
    const last = this.#open(stroke);
    if (last?.patch.length > 0) {
      join(last, { patch, inverse });
      last.guards.push(...guards.filter(({ path }) => !last.guards.some((other) => other.path === path)));
    } else {
      this.#add({ stroke, patch: structuredClone(patch), inverse: structuredClone(inverse), guards });
    }
    this.#events.changed();
    this.#events.pending();
  }

  /** Sends an edit that only the server can make; `needsBase` says that it names blobs by their places. */
  edit(edit, stroke, needsBase = false) {
    const last = this.#open(stroke);
    if (last && last.edits.length > 0 && last.edits.length < TOGETHER_MOST) last.edits.push(edit);
    else this.#add({ stroke, edits: [edit], needsBase });
    this.#events.pending();
  }

  /** Sends an undo or a redo. */
  turn(route) {
    this.#add({ route });
    this.#events.pending();
  }

  #add(change) {
    this.#pending.push({ key: freshName(), route: "edits", edits: [], patch: [], inverse: [], guards: [], ...change });
  }

  /** The last change, if it is of that stroke and not sent yet. */
  #open(stroke) {
    const last = this.#pending.at(-1);
    return stroke !== undefined && last?.stroke === stroke && !last.isSent ? last : undefined;
  }

  /** The server told its scene: all of it, or what changed. */
  hear(told) {
    this.#told.push(told);
    this.#settle();
  }

  /** A change is revision `revision` now. Where nothing else tells what it made, `patch` does. */
  answered(change, revision, patch) {
    change.revision = revision;
    if (patch && revision === this.revision + 1) this.#told.push({ revision, patch });
    this.#settle();
    this.#events.pending();
  }

  /** The server did not take a change: it is taken back here. */
  refused(change) {
    this.#takeBack();
    this.#pending = this.#pending.filter((other) => other !== change);
    this.#makeAgain();
    this.#settle();
    this.#events.changed();
    this.#events.pending();
  }

  /** The whole scene was stored as it is seen here. */
  stored() {
    this.#pending = this.#pending.filter(({ patch }) => patch.length === 0);
    this.#told = [];
    this.revision = null;
    this.#events.pending();
  }

  #settle() {
    // What was told may hold what is on its way: its answer says so.
    if (this.#pending.some(({ isSent, revision }) => isSent && revision === undefined)) return;
    const isKnown = ({ revision }) => revision <= this.revision;
    if (this.#told.length === 0 && !this.#pending.some(isKnown)) return;
    const told = this.#told.splice(0);
    const anew = told.findLastIndex(({ scene }) => scene);
    if (anew === -1) this.#takeBack();
    for (const { revision, patch, scene } of told.slice(Math.max(anew, 0))) {
      if (scene) this.scene = scene;
      else if (patch && revision > this.revision) this.#apply(patch);
      this.revision = revision;
    }
    this.#pending = this.#pending.filter((change) => !isKnown(change));
    this.#makeAgain();
    this.#events.changed();
    this.#events.pending();
  }

  #takeBack() {
    for (const { inverse, isUnseen } of this.#pending.toReversed()) if (!isUnseen) this.#apply(inverse);
  }

  /** What no longer fits is not seen here; the server says what becomes of it. */
  #makeAgain() {
    for (const change of this.#pending) change.isUnseen = !this.#apply(change.patch);
  }

  /** Applies a patch. One that does not fit may have changed half: then the scene is asked for again. */
  #apply(patch) {
    try {
      apply(this.scene, patch);
      return true;
    } catch {
      if (patch.length > 1) this.#events.lost();
      return false;
    }
  }
}
