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

  constructor(document) {
    this.#document = document;
  }

  /** Keeps what is on its way, now; and the scene, when it rests. A browser that keeps nothing is no reason to stop. */
  async keep() {
    const { id, pending } = this.#document;
    clearTimeout(this.#timer);
    this.#timer = setTimeout(() => this.#keepScene(), REST_MS);
    const changes = structuredClone(pending.filter(({ revision }) => revision === undefined));
    const store = await table("pending", "readwrite").catch(() => null);
    if (changes.length > 0) store?.put(changes, id);
    else store?.delete(id);
  }

  async #keepScene() {
    const { id, scene, revision } = this.#document;
    // Before the server has told the scene there is nothing to keep.
    if (revision === null) return;
    const store = await table("scenes", "readwrite").catch(() => null);
    if (!store) return;
    store.put({ scene: structuredClone(scene), revision, at_ms: Date.now() }, id);
    const keys = await done(store.getAllKeys());
    if (keys.length <= SCENES_MOST) return;
    const all = await Promise.all(keys.map(async (key) => [key, (await done(store.get(key))).at_ms]));
    for (const [key] of all.sort(([, a], [, b]) => b - a).slice(SCENES_MOST)) store.delete(key);
  }

  /** `{pending, scene}` of what was kept under an id. */
  async kept(id) {
    try {
      const pending = await done((await table("pending", "readonly")).get(id));
      const kept = await done((await table("scenes", "readonly")).get(id));
      return { pending: pending ?? [], scene: kept?.scene };
    } catch {
      return { pending: [] };
    }
  }
}
