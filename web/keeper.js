// What must outlive a reload: changes that the server has not confirmed, and the scene for a server that forgets.

const NAME = "fogbank";
const TABLES = ["pending", "scenes"];
// Scenes of this page that are kept; whoever comes back to an older one has only what the server has.
const SCENES_MOST = 8;
const REST_MS = 500;

const done = (request) => new Promise((resolve, reject) => {
  request.onsuccess = () => resolve(request.result);
  request.onerror = () => reject(request.error);
});

let opened;

/** The browser's database; rejected where the browser has none for this page. */
function database() {
  opened ??= (() => {
    const request = indexedDB.open(NAME, 1);
    request.onupgradeneeded = () => TABLES.forEach((table) => request.result.createObjectStore(table));
    return done(request);
  })();
  return opened;
}

async function table(name, mode) {
  return (await database()).transaction(name, mode).objectStore(name);
}

/** Keeps a document's changes, and its scene, in the browser. */
export class Keeper {
  #document;
  #timer = 0;
  /** Names of the changes that this page keeps. */
  #mine = [];
  #count = Date.now();

  constructor(document) {
    this.#document = document;
  }

  /** Keeps what is on its way, now; and the scene, when it rests. A browser that keeps nothing is no reason to stop. */
  async keep() {
    const { id, pending } = this.#document;
    clearTimeout(this.#timer);
    this.#timer = setTimeout(() => this.#keepScene(), REST_MS);
    const changes = structuredClone(pending.filter(({ revision }) => revision === undefined));
    const keys = changes.map(({ key }) => [id, key]);
    const store = await table("pending", "readwrite").catch(() => null);
    // Another page may keep changes of the same scene: each goes by its own name.
    changes.forEach((change, i) => store?.put({ at: this.#count + i, change }, keys[i]));
    this.#count += changes.length;
    const kept = this.#mine;
    this.#mine = keys;
    // Those of a scene that was left stay: they are sent when it is opened again.
    const isOver = (key) => key[0] === id && !keys.some((other) => other[1] === key[1]);
    for (const key of kept.filter(isOver)) store?.delete(key);
  }

  /** Goes on under another id: what was kept under the one before is not to be made again there. */
  async moved(from) {
    const old = this.#mine.filter(([id]) => id === from);
    await this.keep();
    const store = await table("pending", "readwrite").catch(() => null);
    for (const key of old) store?.delete(key);
  }

  async #keepScene() {
    const { id, scene, revision, pending } = this.#document;
    // Before the server has told the scene there is nothing to keep, and a preset is always there.
    if (!revision) return;
    const store = await table("scenes", "readwrite").catch(() => null);
    if (!store) return;
    const keys = pending.filter(({ isUnseen, patch }) => !isUnseen && patch.length > 0).map(({ key }) => key);
    store.put({ scene: structuredClone(scene), keys, at_ms: Date.now() }, id);
    const ids = await done(store.getAllKeys());
    if (ids.length <= SCENES_MOST) return;
    const all = await Promise.all(ids.map(async (key) => [key, (await done(store.get(key))).at_ms]));
    for (const [key] of all.sort(([, a], [, b]) => b - a).slice(SCENES_MOST)) store.delete(key);
  }

  /** `{pending, scene, keys}` of what was kept under an id: `keys` are those of the changes that the scene holds. */
  async kept(id) {
    try {
      const range = IDBKeyRange.bound([id], [id, []]);
      const pending = await done((await table("pending", "readonly")).getAll(range));
      const kept = await done((await table("scenes", "readonly")).get(id));
      const changes = pending.sort((a, b) => a.at - b.at).map(({ change }) => change);
      this.#mine = changes.map(({ key }) => [id, key]);
      return { pending: changes, scene: kept?.scene, keys: kept?.keys };
    } catch {
      return { pending: [] };
    }
  }
}
