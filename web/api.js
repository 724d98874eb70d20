// What the page asks of the server, and how the server's refusals arrive.
// Addresses are relative to the page, so that it also works below a proxy's path.

/** An answer of the server that is not a success (RFC 9457 problem details). */
export class Problem extends Error {
  constructor(status, body, retryAfter_s) {
    super(body.detail || body.title || `The server answered ${status}.`);
    this.name = "Problem";
    this.status = status;
    /** `[{pointer, detail}]`, pointers into the request's body; the server may say more about each. */
    this.errors = (Array.isArray(body.errors) ? body.errors : []).filter((error) => error && typeof error === "object");
    this.retryAfter_s = retryAfter_s;
  }

  /** Busy servers answer 429 or 503; the same request may be sent again later. */
  get isBusy() {
    return this.status === 429 || this.status === 503;
  }
}

/** How long to wait before asking a lost server again; twice as long each time. */
export const BACKOFF_MS = { first: 500, most: 10_000 };

/** No answer came at all. */
export class ServerLost extends Error {
  constructor() {
    super("The server cannot be reached.");
    this.name = "ServerLost";
  }
}

async function problemOf(response) {
  const text = await response.text();
  let body = {};
  try {
    body = JSON.parse(text) ?? {};
  } catch {
    body = { detail: text.slice(0, 300) };
  }
  // Retry-After may also be a date; one second is then as good a guess as any.
  const retryAfter_s = Number.parseFloat(response.headers.get("Retry-After")) || 1;
  return new Problem(response.status, body, retryAfter_s);
}

/** Runs a network step. Where the network fails, as opposed to what it brought, browsers throw a TypeError. */
async function reach(step, signal) {
  try {
    return await step();
  } catch (error) {
    if (signal?.aborted) throw new DOMException("Superseded.", "AbortError");
    throw error instanceof TypeError ? new ServerLost() : error;
  }
}

async function request(path, { signal, ...options } = {}, read) {
  return reach(async () => {
    const response = await fetch(path, { signal, ...options });
    if (!response.ok) throw await problemOf(response);
    return read(response);
  }, signal);
}

function post(path, body, { accept = "application/json", signal, job }, read) {
  const headers = { "Content-Type": "application/json", Accept: accept, ...(job && { "Fog-Job": job }) };
  return request(path, { method: "POST", body, headers, signal }, read);
}

const asJson = (response) => response.json();

/** The OpenAPI document. */
export const openapi = () => request("v1/openapi.json", {}, asJson);

/** `[{name, title, description}]`: the scene of each is the one of that id. */
export const presets = async () => (await request("v1/presets?scenes=false", {}, asJson)).presets;

const sceneAt = (id, rest = "") => `v1/scenes/${encodeURIComponent(id)}${rest}`;

/** `[{id, revision, at_ms}]` */
export const scenes = async () => (await request("v1/scenes", { cache: "no-store" }, asJson)).scenes;

/** `{id, revision, scene}` of a stored scene or a preset; `undefined` where it is still at that revision. */
export async function scene(id, revision) {
  const headers = revision === undefined ? {} : { "If-None-Match": `"${revision}"` };
  return reach(async () => {
    // Asked for again and again, the browser would answer all of it from what it keeps.
    const response = await fetch(sceneAt(id), { headers, cache: revision === undefined ? "no-cache" : "no-store" });
    if (response.status === 304) return undefined;
    if (!response.ok) throw await problemOf(response);
    return response.json();
  });
}

const NEW = { "If-None-Match": "*" };

/** Stores a scene; with `isNew` there must be none of that id. Answers `{revision}`. */
export const store = (id, scene, isNew, key) => request(sceneAt(id), {
  method: "PUT", body: JSON.stringify(scene),
  headers: { "Content-Type": "application/json", ...(isNew && NEW), ...(key && { "Idempotency-Key": key }) },
}, asJson);

/** Copies a scene or a preset to a new id. Answers `{revision}`. */
export const copy = (from, id, key) =>
  request(sceneAt(id, `?from=${encodeURIComponent(from)}`), { method: "PUT", headers: { ...NEW, "Idempotency-Key": key } }, asJson);

/** Deletes a scene. */
export const remove = (id) => request(sceneAt(id), { method: "DELETE" }, () => undefined);

/** Makes a change by `route` (`edits`, `undo`, `redo`) under a name of its own. Answers `{revision, patch}`. */
export function write(id, route, body, key) {
  const headers = { "Idempotency-Key": key, ...(body && { "Content-Type": "application/json" }) };
  return request(sceneAt(id, `/${route}`), { method: "POST", body: body && JSON.stringify(body), headers }, asJson);
}

/** `{can_undo, can_redo}` and the newest revision of a scene. */
export const history = (id) => request(sceneAt(id, "/history?limit=1"), { cache: "no-store" }, asJson);

/** Probes rays of a scene; `body` is `{rays, time_s?}`. */
export const probe = async (id, body) => (await post(sceneAt(id, "/probe"), JSON.stringify(body), {}, asJson)).rays;

/** `{state, fraction}` of a job that is on its way: `waiting` or `running`, and how much of it is done. */
export const progress = (job, signal) => request(`v1/progress/${job}`, { signal, cache: "no-store" }, asJson);

/** The address of a scene's socket; with `revision` its first word need not bring that again. */
export function liveAddress(id, revision) {
  const address = new URL(sceneAt(id, `/live${revision === null ? "" : `?revision=${revision}`}`), document.baseURI);
  address.protocol = address.protocol.replace("http", "ws");
  return address.href;
}

/**
 * Compares two airlight estimators on a scene; `body` is `{width, height, camera, a}`. Answers the error image and the
 * numbers. Here and in `frame`, `signal` gives the job up, and `job` is its name for `progress`.
 */
export function compare(id, body, { signal, job }) {
  return post(sceneAt(id, "/compare"), JSON.stringify(body), { accept: "image/png", signal, job }, async (response) => ({
    blob: await response.blob(),
    numbers: JSON.parse(response.headers.get("Fog-Comparison")),
  }));
}

/** Renders a picture of a scene, or with `route` `optical-depth` its map; `view` are the parameters of the address. */
export function frame(id, view, { route = "frame", accept, signal, job }) {
  const sentAt_ms = performance.now();
  const given = Object.entries(view).filter(([, value]) => value !== undefined && value !== null);
  const text = (value) => (typeof value === "object" ? JSON.stringify(value) : value);
  const query = new URLSearchParams(given.map(([name, value]) => [name, text(value)]));
  const headers = { Accept: accept, ...(job && { "Fog-Job": job }) };
  return request(sceneAt(id, `/${route}?${query}`), { headers, signal, cache: "no-store" }, async (response) => {
    const blob = await response.blob();
    return {
      blob,
      revision: Number(response.headers.get("Fog-Revision")),
      backend: response.headers.get("Fog-Backend") ?? "",
      serverTiming: response.headers.get("Server-Timing") ?? "",
      depthRange: response.headers.get("Fog-Depth-Range")?.split(" ").map(Number),
      roundTrip_ms: performance.now() - sentAt_ms,
    };
  });
}
