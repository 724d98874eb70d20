// Drives a page as a person would, and tells what it complains of.

import assert from "node:assert/strict";
import { chromium } from "playwright-core";

export const PATIENCE_MS = Number(process.env.PATIENCE_MS ?? 120_000);
const FLAGS = ["--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
  "--disable-background-networking", "--disable-component-update", "--disable-sync"];

/** What pages complained of since it was emptied. */
export const complaints = [];
/** What pages posted: for each request its path and a promise of its headers. */
export const posted = [];
/** What pages sent over sockets, parsed; and bytes of all that they sent and got. */
export const said = [];
export const traffic = { up: 0, down: 0 };
/** The page that is driven. */
export let page;
let address;
let shots;

/** Runs `tests(browser)` with the address of a server and a directory for screenshots. */
export async function run(server, directory, tests) {
  [address, shots] = [server, directory];
  const browser = await chromium.launch({ executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium", args: FLAGS, timeout: PATIENCE_MS });
  try {
    await tests(browser);
  } catch (error) {
    await shot("failed");
    console.error(error);
    console.error(`complaints: ${JSON.stringify(complaints)}`);
    process.exitCode = 1;
  } finally {
    await browser.close();
  }
}

/** Opens the page in a window of its own and collects everything that it complains of. */
export async function open(browser, options, query = "") {
  const context = await browser.newContext({ acceptDownloads: true, ...options, permissions: ["clipboard-read", "clipboard-write"] });
  return openIn(context, query);
}

/** Opens another page in the window of one. */
export async function openIn(context, query = "") {
  page = await context.newPage();
  page.setDefaultTimeout(PATIENCE_MS);
  page.on("console", (message) => {
    // A job that ended while it was asked for is unknown, which the browser itself notes.
    if (message.location().url.includes("/v1/progress/")) return;
    if (["error", "warning"].includes(message.type())) complaints.push(`${message.text()} ${message.location().url}`);
  });
  page.on("request", (request) => {
    traffic.up += request.postDataBuffer()?.length ?? 0;
    if (request.method() === "POST") posted.push({ path: new URL(request.url()).pathname, headers: request.allHeaders() });
  });
  page.on("response", async (response) => {
    const sizes = await response.request().sizes().catch(() => ({ responseBodySize: 0 }));
    traffic.down += sizes.responseBodySize;
  });
  page.on("websocket", (socket) => {
    socket.on("framesent", ({ payload }) => {
      traffic.up += payload.length;
      said.push(JSON.parse(payload));
    });
    socket.on("framereceived", ({ payload }) => { traffic.down += payload.length; });
  });
  page.on("pageerror", (error) => complaints.push(String(error.stack)));
  page.on("requestfailed", (request) => {
    // A newer view overtakes an older one: the page gives that request up itself.
    if (request.failure().errorText !== "net::ERR_ABORTED") complaints.push(`${request.url()} ${request.failure().errorText}`);
  });
  await page.goto(`http://${address}/${query}`);
  return page;
}

/** Drives another page that is open. */
export function turnTo(other) {
  page = other;
}

export const until = (predicate, argument) => page.waitForFunction(predicate, argument, { timeout: PATIENCE_MS });
export const phase = (name) => until((wanted) => document.documentElement.dataset.frame === wanted, name);
export const state = (name) => page.evaluate((key) => document.documentElement.dataset[key], name);
export const count = (name) => page.evaluate((key) => window.fogbank.counts[key], name);
export const camera = () => page.evaluate(() => window.fogbank.camera);
export const scene = () => page.evaluate(() => window.fogbank.request.scene);
export const pixels = () => page.evaluate(() => document.getElementById("picture").toDataURL());
/** Waits until the server has confirmed everything. */
export const saved = () => until(() => document.documentElement.dataset.saved === "saved");

/** Does something and waits for the full frame that it must lead to. */
export async function toFull(act) {
  const before = await page.evaluate(() => window.fogbank.lastFrame?.seq ?? 0);
  await act();
  await until((seq) => {
    const { lastFrame } = window.fogbank;
    return lastFrame?.seq > seq && lastFrame.quality === "full" && document.documentElement.dataset.frame === "full";
  }, before);
}

export const load = (next) => toFull(() => page.evaluate((scene) => window.fogbank.load(scene), next));

export async function shot(name) {
  if (shots) await page.screenshot({ path: `${shots}/page-${name}.png` });
}

export async function holds(name, check) {
  await check();
  assert.deepEqual(complaints, [], "the page complains");
  console.log(`ok ${name}`);
}

/** Where a point of the picture is in the window, in pixels. */
export async function onPicture(x, y) {
  const box = await page.locator("#picture").boundingBox();
  return [box.x + box.width * x, box.y + box.height * y];
}

export async function pointAt(x, y) {
  await page.mouse.move(...(await onPicture(x, y)));
}

/** Drags over the picture through some points. */
export async function dragOver(points, options) {
  const [first, ...rest] = points;
  await pointAt(...first);
  await page.mouse.down(options);
  for (const point of rest) {
    await pointAt(...point);
    await page.waitForTimeout(30);
  }
  await page.mouse.up(options);
}
