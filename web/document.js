// The scene as this page knows it: what the server has told, and on top of it what is on its way there.

import { applyPatch } from "./vendor/fast-json-patch/core.mjs";
import { inserting, join, make, removing, setting, takeBack } from "./changes.js";

// Edits of one request, well below what a request may hold.
const TOGETHER_MOST = 100;

/** A name that no other request has. `crypto.randomUUID` is missing where a page came without https. */
export function freshName() {
  const bytes = crypto.getRandomValues(new Uint8Array(16));
  return Array.from(bytes, (byte) => byte.toString(16).padStart(2, "0")).join("");
}

/**
 * A scene and the changes that the server has not confirmed yet. A change is seen here at once; when somebody else's
 * change comes meanwhile, ours are taken back, theirs is made, and ours are made again.
 */
export class SceneDocument {
  id = null;
  /** The revision that the server told last; `null` before it told anything. */
  revision = null;
  scene = {};
  /**
   * `{key, stroke, route, edits, patch, guards, inverse, isUnseen, isSent, isSealed, revision}`, the oldest first: `inverse` takes
   * the patch back, unless it does not fit and is not seen; what is sealed is not added to.
   */
  #pending = [];
  /** What the server told while a request was on its way whose revision is not known yet. */
  #told = [];
  /** Whether the scene here is surely what the server told. */
  #isWhole = true;
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

  /** The revision that need not be told again, or `null`. */
  get known() {
    return this.#isWhole ? this.revision : null;
  }

  /** Begins with another scene, of which nothing is known yet; `pending` are changes that were kept from before. */
  begin(id, pending = []) {
    this.id = id;
    this.revision = null;
    this.#told = [];
    this.#pending = pending.map((change) => ({ ...change, isSent: false, isSealed: true, isUnseen: true }));
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
  change({ guards, patch }, stroke) {
    if (this.revision === null || patch.length === 0) return;
    const inverse = make(this.scene, patch);
    if (!inverse) return;
    const last = this.#open(stroke);
    if (last?.patch.length > 0) {
      join(last.patch, patch);
      last.inverse = [...inverse, ...last.inverse];
      last.guards.push(...guards.filter(({ path }) => !last.guards.some((other) => other.path === path)));
    } else {
      this.#add({ stroke, patch: structuredClone(patch), inverse, guards });
    }
    this.#events.changed();
    this.#events.pending();
  }

  /** Sends an edit that only the server can make. */
  edit(edit, stroke) {
    if (this.revision === null) return;
    const last = this.#open(stroke);
    if (last && last.edits.length > 0 && last.edits.length < TOGETHER_MOST) last.edits.push(edit);
    else this.#add({ stroke, edits: [edit] });
    this.#events.pending();
  }

  /** Sends an undo or a redo. */
  turn(route) {
    if (this.revision === null) return;
    this.#add({ route });
    this.#events.pending();
  }

  #add(change) {
    this.#pending.push({ key: freshName(), route: "edits", edits: [], patch: [], inverse: [], guards: [], ...change });
  }

  /** The last change, if it is of that stroke and may be added to. */
  #open(stroke) {
    const last = this.#pending.at(-1);
    return stroke !== undefined && last?.stroke === stroke && !last.isSent && !last.isSealed ? last : undefined;
  }

  /** The change that is to be sent next; none before the scene is known. */
  get next() {
    return this.revision === null ? undefined : this.#pending.find(({ revision }) => revision === undefined);
  }

  /** The server told its scene: all of it, or what changed. */
  hear(told) {
    this.#told.push(told);
    this.#settle();
  }

  /** A change is revision `revision` now. Where nothing else tells what it made, `patch` does. */
  answered(change, revision, patch) {
    if (!this.#pending.includes(change)) return;
    change.revision = revision;
    if (patch && revision === this.revision + 1) this.#told.push({ revision, patch });
    this.#settle();
    this.#events.pending();
  }

  /** The server did not take a change: it is taken back here. */
  refused(change) {
    if (!this.#pending.includes(change)) return;
    this.#takeBack();
    this.#pending = this.#pending.filter((other) => other !== change);
    this.#makeAgain();
    this.#settle();
    this.#events.changed();
    this.#events.pending();
  }

  /** Names the changes that are seen in the scene as it is now: it is about to be stored as a whole. */
  seal() {
    const seen = this.#pending.filter(({ patch, isUnseen }) => patch.length > 0 && !isUnseen);
    for (const change of seen) change.isSealed = true;
    return seen;
  }

  /** A scene with those changes was stored for a server that had lost it; all others are to be sent again. */
  stored(sealed, revision) {
    this.#pending = this.#pending.filter((change) => !sealed.includes(change));
    for (const change of this.#pending) forgetSending(change);
    this.#told = [];
    this.#isWhole = false;
    this.revision = revision;
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
    for (const one of told.slice(Math.max(anew, 0))) this.#take(one);
    this.#pending = this.#pending.filter((change) => !isKnown(change));
    this.#makeAgain();
    this.#events.changed();
    this.#events.pending();
  }

  #take({ revision, patch, scene }) {
    if (scene) {
      this.scene = scene;
      this.#isWhole = true;
      // A server that has lost revisions has lost what they made.
      for (const change of this.#pending) if (change.revision > revision) forgetSending(change);
    } else if (!(revision > this.revision)) {
      return;
    } else if (patch) {
      this.#apply(patch);
    }
    this.revision = revision;
  }

  /** What the server told fits what it told before; if not, this page has lost its way. */
  #apply(patch) {
    try {
      applyPatch(this.scene, structuredClone(patch), false, true);
    } catch {
      this.#isWhole = false;
      this.#events.lost();
    }
  }

  #takeBack() {
    for (const { inverse, isUnseen } of this.#pending.toReversed()) if (!isUnseen) takeBack(this.scene, inverse);
  }

  /** What no longer fits is not seen here; the server says what becomes of it. */
  #makeAgain() {
    for (const change of this.#pending) {
      const inverse = make(this.scene, [...change.guards, ...change.patch]);
      change.isUnseen = inverse === null;
      change.inverse = inverse ?? [];
    }
  }
}

function forgetSending(change) {
  change.isSent = false;
  change.revision = undefined;
}
