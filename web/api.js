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

/** `[{name, title, description, scene}]` */
export const presets = async () => (await request("v1/presets", {}, asJson)).presets;

/** Probes rays; `body` is the JSON of `{scene, rays}`. */
export const probe = async (body) => (await post("v1/probe", body, {}, asJson)).rays;

/** `{state, fraction}` of a job that is on its way: `waiting` or `running`, and how much of it is done. */
export const progress = (job, signal) => request(`v1/progress/${job}`, { signal, cache: "no-store" }, asJson);

/**
 * Compares two airlight estimators; `body` is the JSON of the comparison. Answers the error image and the numbers.
 * Here and in `render`, `signal` gives the job up, and `job` is its name for `progress`.
 */
export function compare(body, { signal, job }) {
  return post("v1/compare", body, { accept: "image/png", signal, job }, async (response) => ({
    blob: await response.blob(),
    numbers: JSON.parse(response.headers.get("Fog-Comparison")),
  }));
}

/** Renders a picture; `body` is the JSON of the render request. */
export function render(body, { accept, signal, job }) {
  const sentAt_ms = performance.now();
  return post("v1/render", body, { accept, signal, job }, async (response) => {
    const blob = await response.blob();
    return {
      blob,
      backend: response.headers.get("Fog-Backend") ?? "",
      serverTiming: response.headers.get("Server-Timing") ?? "",
      roundTrip_ms: performance.now() - sentAt_ms,
    };
  });
}
