// Drives the page as a person would: node page.js ADDRESS [DIRECTORY for screenshots]
// Prints a line for each thing that holds, and ends with status 1 at the first one that does not.

import assert from "node:assert/strict";
import { PATIENCE_MS, camera, complaints, count, holds, load, open, page, phase, pixels, pointAt, posted, run, said, scene, shot, state, toFull, until } from "./driver.js";

const [address, shots] = process.argv.slice(2);

const SIMPLE = {
  camera: { position: [0, 1.5, 6], target: [0, 1, 0] },
  surfaces: [{ id: "ball", shape: { kind: "sphere", center: [0, 1, 0], radius: 1 } }, { id: "floor" }],
  lights: [{ id: "lamp", kind: "point", position: [2, 3, 2], intensity: [80, 70, 50] }],
  fog: { ambient: [0.02, 0.02, 0.03], terms: [{ id: "mist", kind: "homogeneous", extinction: 0.05 }] },
};
const PATCHY = { ...SIMPLE, fog: { terms: [{ kind: "gaussians", blobs: [
  { center: [-1, 1, 1], radius: 1.5, extinction: 0.4 }, { center: [1.5, 2, 1], radius: 0.8, extinction: 1 },
] }] } };
const SMOKING = { ...SIMPLE, fog: { wind: { velocity: [0.3, 0, 0] }, terms: [
  { kind: "emitter", rate_hz: 8, lifetime_s: 3, radius: 0.3, extinction: 1 },
] } };
const MAPPED = { ...SIMPLE, fog: { ambient: [0.3, 0.3, 0.4], terms: [
  { kind: "fogmap", cell_m: 2, origin: [-3, -3], coefficients: [[0.2, 0.1], [0.9, 0.4]] },
] } };
// Minutes of work.
const SLOW = { ...SIMPLE, fog: { airlight: "reference", terms: [{ kind: "gaussians", blobs: Array.from({ length: 16 }, (_, i) =>
  ({ center: [i % 7 - 3, i % 3, i % 5 - 2], radius: 0.7, extinction: 0.5 })) }] } };
const at = (pointer, rest = "") => page.locator(`[data-pointer="${pointer}"]:not(details) ${rest}`).last();
const errorState = () => page.evaluate(() => document.documentElement.dataset.errors);

/** Puts a value into a control, which must lead to a full picture, and answers the scene. */
async function put(control, value) {
  await toFull(async () => { await control.fill(String(value)); await control.blur(); });
  return scene();
}

const isNear = (a, b, share = 1e-6) => assert.ok(Math.abs(a - b) <= share * Math.abs(b), `${a} is not ${b}`);

async function slowPictures() {
  await holds("a slow picture says how far it is, and can be stopped and made after all", async () => {
    // The bar's value once it is more than that; false while no bar is shown.
    const moreThan = (from) => until((least) => {
      const { hidden, innerText } = document.getElementById("progress");
      const { value } = document.querySelector("#progress progress");
      return !hidden && /: \d+ %/.test(innerText) && value > least && value;
    }, from).then((value) => value.jsonValue());
    await page.evaluate((slow) => window.fogbank.load(slow), SLOW);
    await moreThan(await moreThan(0));
    await shot("progress");
    await page.locator("#progress button", { hasText: "Stop" }).click();
    assert.equal(await page.evaluate(() => document.documentElement.dataset.frame), "stopped");
    assert.match(await page.locator("#progress").innerText(), /Stopped/);
    const { job } = said.findLast(({ type }) => type === "view");
    const views = said.length;
    const forgotten = async () => (await fetch(`http://${address}/v1/progress/${job}`)).status === 404;
    for (const end = Date.now() + PATIENCE_MS; !(await forgotten());) assert.ok(Date.now() < end, "the server goes on");
    assert.deepEqual(said.slice(views), [], "nothing is asked for after a stop");
    await page.locator("#progress button", { hasText: "Render" }).click();
    await moreThan(0);
    await load(SIMPLE);
    assert.equal(await page.locator("#progress").isVisible(), false);
  });
}

async function moving() {
  await holds("time runs and rests, and the smoke moves", async () => {
    await load(SMOKING);
    const before = await pixels();
    await page.locator("#play").click();
    await until(() => (window.fogbank.request.time_s ?? 0) > 0.5);
    assert.equal(await page.locator("#play").innerText(), "Pause");
    await toFull(() => page.locator("#play").click());
    assert.notEqual(await pixels(), before);
    const time = await page.evaluate(() => window.fogbank.request.time_s);
    assert.equal(await page.locator("#time").innerText(), `${time.toFixed(2)} s`);
    await shot("smoke");
  });
  await holds("a map's cells are dragged, and chosen by keys", async () => {
    await load(MAPPED);
    await reveal("/scene/fog/terms/0/coefficients");
    const map = at("/scene/fog/terms/0/coefficients", "canvas.map");
    const box = await map.boundingBox();
    const cell = () => page.evaluate(() => window.fogbank.request.scene.fog.terms[0].coefficients[0][1]);
    await toFull(async () => {
      await page.mouse.move(box.x + box.width * 0.75, box.y + box.height * 0.25);
      await page.mouse.down();
      await page.mouse.move(box.x + box.width * 0.75, box.y + box.height * 0.25 - 80, { steps: 4 });
      await page.mouse.up();
    });
    isNear(await cell(), 0.6);
    await map.focus();
    await toFull(() => map.press("-"));
    isNear(await cell(), 0.55);
    await shot("map");
  });
}

async function controls() {
  await holds("exposure slides over eight stops to either side, and takes more as a number", async () => {
    const slider = at("/exposure_ev", "input[type=range]");
    assert.deepEqual([await slider.getAttribute("min"), await slider.getAttribute("max")], ["-8", "8"]);
    const dark = await pixels();
    await put(slider, 3);
    assert.equal(await page.evaluate(() => window.fogbank.request.exposure_ev), 3);
    assert.notEqual(await pixels(), dark);
    await put(at("/exposure_ev", "input[type=number]"), 12);
    assert.equal(Number(await slider.inputValue()), 12);
    await put(at("/exposure_ev", "input[type=number]"), 0);
    assert.equal(await slider.getAttribute("max"), "8");
  });
  await holds("extinction slides through powers of ten", async () => {
    await reveal("/scene/fog/terms/0/extinction");
    const slider = at("/scene/fog/terms/0/extinction", "input[type=range]");
    const field = at("/scene/fog/terms/0/extinction", "input[type=number]");
    assert.deepEqual([await slider.getAttribute("min"), await slider.getAttribute("max")], ["-4", "1"]);
    assert.equal((await put(slider, -1)).fog.terms[0].extinction, 0.1);
    assert.equal(await field.inputValue(), "0.1");
    assert.equal((await put(field, 0.001)).fog.terms[0].extinction, 0.001);
    assert.equal(Number(await slider.inputValue()), -3);
    await put(field, 0);
    assert.equal(Number(await slider.inputValue()), -4);
    await put(field, 0.1);
  });
  await holds("extinction and visibility convert into each other, and only one is sent", async () => {
    const before = await pixels();
    const choose = (from, to) => toFull(() => at(`/scene/fog/terms/0/${from}`, "select.alternatives").selectOption(to));
    const term = async () => (await scene()).fog.terms[0];
    await choose("extinction", "visibility_m");
    assert.equal((await term()).extinction, undefined);
    isNear((await term()).visibility_m, -Math.log(0.05) / 0.1);
    assert.equal(await pixels(), before, "the fog stays what it was");
    await put(at("/scene/fog/terms/0/visibility_m", "input[type=number]"), 60);
    const { visibility_m, extinction } = await term();
    assert.deepEqual([visibility_m, extinction], [60, undefined]);
    await shot("visibility");
    await choose("visibility_m", "extinction");
    isNear((await term()).extinction, -Math.log(0.05) / 60);
    assert.equal((await term()).visibility_m, undefined);
  });
  await holds("a term that gives neither shows its own extinction, and a script's change is followed", async () => {
    await load({ ...SIMPLE, fog: { terms: [{ kind: "homogeneous" }] } });
    await reveal("/scene/fog/terms/0/extinction");
    assert.equal(await at("/scene/fog/terms/0/extinction", "input[type=number]").inputValue(), "0.02");
    await toFull(() => at("/scene/fog/terms/0/extinction", "select.alternatives").selectOption("visibility_m"));
    isNear((await scene()).fog.terms[0].visibility_m, -Math.log(0.05) / 0.02);
    await toFull(() => page.evaluate(() => window.fogbank.set(["scene", "fog", "terms", 0], { kind: "homogeneous", extinction: 0.3 })));
    assert.equal(await at("/scene/fog/terms/0/extinction", "input[type=number]").inputValue(), "0.3");
  });
  await holds("an extinction takes a colour, keeps its strength, and gives the colour back", async () => {
    await load(SIMPLE);
    await reveal("/scene/fog/terms/0/extinction");
    const field = (rest) => at("/scene/fog/terms/0/extinction", rest);
    const before = await pixels();
    const extinction = async () => (await scene()).fog.terms[0].extinction;
    const grey = await extinction();
    const choose = (kind) => toFull(() => field("select:not(.alternatives)").selectOption(kind));
    await choose("colour");
    assert.deepEqual(await extinction(), [grey, grey, grey]);
    assert.equal(await pixels(), before, "three equal numbers are one");
    assert.deepEqual((await put(field("input[title=b]"), 2 * grey)).fog.terms[0].extinction, [grey, grey, 2 * grey]);
    assert.notEqual(await pixels(), before);
    await put(field("input[title=b]"), grey);
    await choose("grey");
    assert.equal(await extinction(), grey);
  });
  await holds("a lamp has a strength and a colour, and exact numbers", async () => {
    await load(SIMPLE);
    await page.locator('[data-pointer="/scene/lights"] > summary').click();
    const lamp = (rest) => at("/scene/lights/0/intensity", rest);
    const strength = lamp("input[aria-label='intensity in W/sr, strength']");
    assert.equal(await strength.inputValue(), "80");
    assert.deepEqual((await put(strength, 160)).lights[0].intensity, [160, 140, 100]);
    assert.deepEqual((await put(lamp("input[type=range]"), 1)).lights[0].intensity, [10, 8.75, 6.25]);
    assert.deepEqual((await put(lamp("input[type=color]"), "#0000ff")).lights[0].intensity, [0, 0, 10]);
    assert.deepEqual((await put(lamp("input[title=g]"), 4.5)).lights[0].intensity, [0, 4.5, 10]);
    await put(strength, 0);
    assert.deepEqual((await put(strength, 20)).lights[0].intensity, [0, 9, 20], "a lamp that is turned on again has its colour");
    await shot("lamp");
  });
  await holds("whatever else the server says of a problem, the page shows what and where", async () => {
    const errors = [{ pointer: "/scene/far_m", detail: "no such distance", code: "out_of_range", more: { min: 1 } }];
    const body = JSON.stringify({ type: "about:blank", title: "x", status: 422, detail: "wrong", errors, trace: ["y"] });
    await page.route("**/edits", (route) => route.fulfill({ status: 422, contentType: "application/problem+json", body }));
    await page.evaluate(() => window.fogbank.set(["scene", "far_m"], 100));
    await phase("error");
    assert.match(await page.locator("#status").innerText(), /wrong[^]*\/scene\/far_m no such distance/);
    await page.unroute("**/edits");
    await toFull(() => page.evaluate(() => window.fogbank.set(["scene", "far_m"], 1000)));
    assert.ok(complaints.splice(0).every((text) => text.includes("422")));
  });
  await holds("every wrong number of a colour is told of, once", async () => {
    await page.evaluate(() => window.fogbank.set(["scene", "lights", 0, "intensity"], [-1, 2, -3]));
    await phase("error");
    assert.match(await at("/scene/lights/0/intensity").innerText(), /-1 is not[^]*; -3 is not/);
    assert.equal((await page.locator("#status").innerText()).match(/-1 is not/g).length, 1);
    await toFull(() => page.evaluate(() => window.fogbank.set(["scene", "lights", 0, "intensity"], [80, 70, 50])));
    assert.ok(complaints.splice(0).every((text) => text.includes("422")));
  });
  await holds("every control has a name", async () => {
    await unfoldAll();
    const nameless = await page.evaluate(() => [...document.querySelectorAll("button, input, select, textarea")]
      .filter((node) => !node.getAttribute("aria-label") && !node.labels?.length && !(node.tagName === "BUTTON" && node.textContent.trim()))
      .map((node) => node.outerHTML));
    assert.deepEqual(nameless, []);
  });
}

/** Unfolds whatever can be unfolded, and what is in that. */
async function unfoldAll() {
  const folded = () => page.locator("details:not([open])").count();
  while (await folded()) {
    await page.evaluate(() => document.querySelectorAll("details:not([open])").forEach((fold) => { fold.open = true; }));
    // What a fold holds is built when the browser tells of the toggle.
    await page.evaluate(() => new Promise((resolve) => { requestAnimationFrame(() => setTimeout(resolve)); }));
  }
}

async function onADesk(browser) {
  await open(browser, { viewport: { width: 1280, height: 800 } });
  await holds("the demo scene is shown in full", async () => {
    await phase("full");
    assert.equal(await page.inputValue("#preset"), "street-thin");
    const frame = await page.evaluate(() => window.fogbank.lastFrame);
    assert.equal(frame.quality, "full");
    assert.equal(frame.layer, "beauty");
    const shown = await page.evaluate(() => {
      const { width, height } = document.getElementById("picture");
      const { data } = document.getElementById("picture").getContext("2d").getImageData(0, 0, width, height);
      return { width, height, shades: new Set(data).size };
    });
    assert.deepEqual([shown.width, shown.height], [frame.width, frame.height]);
    assert.ok(shown.shades > 50, `${shown.shades} shades`);
    assert.equal(frame.passes[0].name, "queue");
    assert.equal(frame.passes.at(-1).name, "encode");
    assert.ok(await page.locator("#timings dt").count() >= 4);
  });
  await shot("desk");
  await load(SIMPLE);
  await holds("a drag shows drafts, then the full frame of another camera", async () => {
    const [before, position] = [await count("frames"), (await camera()).position];
    await pointAt(0.5, 0.5);
    await page.mouse.down();
    for (let step = 1; step <= 4; step += 1) {
      await pointAt(0.5 + 0.05 * step, 0.5);
      const drafted = await count("frames");
      await until((frames) => window.fogbank.counts.frames > frames, drafted);
    }
    assert.ok(await count("frames") >= before + 4);
    await toFull(async () => { await pointAt(0.72, 0.55); await page.mouse.up(); });
    const moved = await camera();
    assert.notDeepEqual(moved.position, position);
    const reach = ({ position, target }) => Math.hypot(...position.map((x, i) => x - target[i]));
    assert.ok(Math.abs(reach(moved) - Math.hypot(0.5, 6)) < 1e-3, "an orbit keeps its distance");
  });
  await holds("the wheel zooms and Home goes back", async () => {
    const before = (await camera()).position;
    await toFull(() => page.mouse.wheel(0, 300));
    assert.ok(Math.hypot(...(await camera()).position) > Math.hypot(...before));
    await toFull(() => page.locator("#picture").press("Home"));
    assert.deepEqual((await camera()).position, [0, 1.5, 6]);
  });
  await holds("keys orbit, pan and zoom", async () => {
    for (const key of ["ArrowLeft", "ArrowUp", "Shift+ArrowRight", "+", "-"]) {
      const before = JSON.stringify(await camera());
      await toFull(() => page.locator("#picture").press(key));
      assert.notEqual(JSON.stringify(await camera()), before, key);
    }
    await toFull(() => page.locator("#reset-view").click());
  });
  await holds("every layer can be chosen and shows something else", async () => {
    const all = await page.locator("#layers input").evaluateAll((radios) => radios.map((radio) => radio.value));
    assert.equal(all.at(-1), "error");
    const values = all.slice(0, -1);
    assert.deepEqual(values, ["beauty", "airlight", "surface", "optical_depth", "transmittance", "depth", "normal"]);
    const seen = new Set();
    for (const value of [...values].reverse()) {
      await toFull(() => page.locator(`#layers input[value=${value}]`).check({ force: true }));
      assert.equal(await page.evaluate(() => window.fogbank.lastFrame.layer), value);
      seen.add(await pixels());
    }
    assert.equal(seen.size, values.length);
  });
  await holds("the errors come in growing resolution, with their numbers", async () => {
    const layer = (name) => page.locator(`#layers input[value=${name}]`).check({ force: true });
    await load(PATCHY);
    const before = await count("comparisons");
    await toFull(() => layer("error"));
    assert.equal(await page.evaluate(() => window.fogbank.lastFrame.layer), "airlight");
    await until(() => window.fogbank.lastComparison?.scale >= 1 / 16);
    assert.equal(await errorState(), "working");
    assert.match(await page.locator("#errors-note").innerText(), /Comparing at .*size/);
    await until(() => window.fogbank.lastComparison?.scale >= 1 / 4);
    await shot("errors");
    const { numbers, width, height } = await page.evaluate(() => window.fogbank.lastComparison);
    assert.deepEqual([numbers.a.airlight, numbers.b.airlight], ["auto", "reference"]);
    assert.ok(numbers.median <= numbers.p95 && numbers.p95 <= numbers.max);
    const shown = await page.evaluate(() => {
      const { width, height, hidden } = document.getElementById("errors");
      return { width, height, hidden };
    });
    assert.ok(!shown.hidden && shown.width >= width && shown.height >= height, JSON.stringify(shown));
    const text = await page.locator("#errors-note").innerText();
    for (const word of ["auto against reference", "median", "p95", "max", "%"]) assert.ok(text.includes(word), text);
    const tooltip = await page.locator("#errors-note dl div").first().getAttribute("title");
    assert.match(tooltip, /median/i);
    assert.ok(await count("comparisons") >= before + 3);
  });
  await holds("a comparison says how far it is, and can be stopped", async () => {
    await page.evaluate(() => { window.fogbank.lastComparison = null; });
    await load({ ...SLOW, fog: { ...SLOW.fog, airlight: "auto" } });
    await until(() => window.fogbank.lastComparison?.scale >= 1 / 16 && /: \d+ %/.test(document.getElementById("errors-note").innerText));
    await page.locator("#errors-note button").click();
    assert.equal(await errorState(), "stopped");
    assert.match(await page.locator("#errors-note").innerText(), /Stopped.[^]*median/);
    await load(PATCHY);
    await until(() => document.documentElement.dataset.errors === "working");
  });
  await holds("a move of the camera gives the errors up, and they come again when it rests", async () => {
    const requests = [];
    page.on("requestfailed", (request) => requests.push(request.url()));
    await until(() => document.documentElement.dataset.errors !== "waiting");
    const [wasWorking, done] = [await errorState() === "working", await count("comparisons")];
    await toFull(() => page.locator("#picture").press("ArrowLeft"));
    // A comparison that ended before the key was pressed had nothing left to give up.
    if (wasWorking && await count("comparisons") === done) assert.ok(requests.some((url) => url.endsWith("/compare")), `${requests}`);
    const before = await count("comparisons");
    await page.evaluate(() => { window.fogbank.lastComparison = null; });
    await toFull(() => page.evaluate(() => window.fogbank.set(["scene", "fog", "airlight"], "fogshop2007")));
    await until(() => window.fogbank.lastComparison?.numbers.a.airlight === "fogshop2007");
    assert.ok(await count("comparisons") > before);
    await toFull(() => page.locator("#layers input[value=beauty]").check({ force: true }));
    assert.equal(await errorState(), "off");
    assert.equal(await page.locator("#errors").isVisible(), false);
    assert.equal(await page.locator("#errors-note").isVisible(), false);
    await load(SIMPLE);
  });
  await holds("the probe agrees with the server", async () => {
    await pointAt(0.5, 0.45);
    await until(() => window.fogbank.lastReading?.hit?.surface === "ball");
    const reading = await page.evaluate(() => window.fogbank.lastReading);
    const length = reading.hit.distance_m;
    assert.ok(Math.abs(reading.optical_depth - 0.05 * length) < 1e-9, "optical depth = extinction × distance");
    assert.ok(Math.abs(reading.transmittance - Math.exp(-0.05 * length)) < 1e-9);
    const text = await page.locator("#probe").innerText();
    assert.match(text, /optical depth/i);
    assert.match(text, /ball/);
    await page.mouse.move(2, 2);
    await until(() => window.fogbank.lastReading === null);
  });
  await holds("a fog control changes the picture, and thicker fog is denser", async () => {
    const before = await pixels();
    const group = page.locator('[data-pointer="/scene/fog/terms/0"]').last();
    const field = page.locator('[data-pointer="/scene/fog/terms/0/extinction"] input[type=number], [data-pointer="/scene/fog/terms/0/extinction"] input:not([type=range])').first();
    if (!(await field.isVisible())) await reveal("/scene/fog/terms/0/extinction");
    await group.waitFor({ state: "attached" });
    await toFull(async () => { await field.fill("0.5"); await field.press("Enter"); });
    assert.equal(await page.evaluate(() => window.fogbank.request.scene.fog.terms[0].extinction), 0.5);
    assert.notEqual(await pixels(), before);
  });
  await holds("what the server refuses is said and marked, and gone when it is mended", async () => {
    complaints.length = 0;
    await page.evaluate(() => window.fogbank.set(["scene", "fog", "terms", 0, "extinction"], -1));
    await phase("error");
    await page.locator("#status").waitFor({ state: "visible" });
    assert.match(await page.locator("#status").innerText(), /\/scene\/fog\/terms\/0\/extinction/);
    assert.ok(await page.locator('.has-error[data-pointer^="/scene/fog"]').count() > 0);
    // The browser itself notes the refused requests in its console.
    const refusals = complaints.splice(0);
    assert.ok(refusals.every((text) => text.includes("422")), refusals.join("\n"));
    await shot("error");
    await toFull(() => page.evaluate(() => window.fogbank.set(["scene", "fog", "terms", 0, "extinction"], 0.02)));
    assert.equal(await page.locator("#status").isVisible(), false);
    assert.equal(await page.locator(".has-error").count(), 0);
  });
  await holds("the scene is read, copied and applied as JSON", async () => {
    await page.locator("#open-scene").click();
    const scene = JSON.parse(await page.inputValue("#scene-text"));
    assert.equal(scene.fog.terms[0].extinction, 0.02);
    await shot("scene");
    await page.locator("#scene-copy").click();
    await until(() => document.getElementById("scene-message").textContent === "Copied.");
    assert.deepEqual(JSON.parse(await page.evaluate(() => navigator.clipboard.readText())), scene);
    await page.fill("#scene-text", "{ fog");
    await page.locator("#scene-apply").click();
    await until(() => /JSON/.test(document.getElementById("scene-message").textContent));
    scene.fog.terms[0].extinction = 0.3;
    await page.fill("#scene-text", JSON.stringify(scene));
    await toFull(() => page.locator("#scene-apply").click());
    assert.equal(await page.evaluate(() => window.fogbank.request.scene.fog.terms[0].extinction), 0.3);
    assert.equal(await page.locator("#scene-dialog").isVisible(), false);
  });
  await slowPictures();
  await moving();
  await load(SIMPLE);
  await controls();
  await holds("every preset is shown in full", async () => {
    const names = await page.locator("#preset option").evaluateAll((options) => options.map(({ value }) => value).filter(Boolean));
    assert.ok(names.length >= 7);
    for (const name of names) {
      await toFull(() => page.selectOption("#preset", name));
      await shot(name);
    }
  });
  await holds("nothing is asked when nothing changes", async () => {
    // What was asked how far it is when the picture came.
    await page.waitForTimeout(500);
    const asked = [];
    page.on("request", (request) => asked.push(request.url()));
    const views = said.length;
    await page.waitForTimeout(1500);
    assert.deepEqual(asked, []);
    assert.deepEqual(said.slice(views), []);
  });
  await holds("what is posted says that it is JSON from this very page", async () => {
    for (const path of ["/edits", "/compare", "/probe"]) {
      const all = await Promise.all(posted.filter((post) => post.path.endsWith(path)).map(({ headers }) => headers));
      assert.ok(all.length > 0, path);
      assert.ok(all.every((headers) => headers["content-type"] === "application/json"), path);
      // What was given up before it left has not got all of its headers.
      const sites = new Set(all.map((headers) => headers["sec-fetch-site"]).filter(Boolean));
      assert.deepEqual([...sites], ["same-origin"], path);
    }
  });
}

/** Unfolds the groups on the way to a control, as the error list of the page does. */
async function reveal(pointer) {
  for (let depth = 3; depth <= pointer.split("/").length; depth += 1) {
    const part = pointer.split("/").slice(0, depth).join("/");
    const fold = page.locator(`details[data-pointer="${part}"]:not([open]) > summary`).last();
    if (await fold.count()) await fold.click();
  }
}

async function onAPhone(browser) {
  await open(browser, { viewport: { width: 390, height: 844 }, hasTouch: true, isMobile: true }, "?preset=steaming-vessel");
  await holds("it fits a phone", async () => {
    await phase("full");
    assert.equal(await page.inputValue("#preset"), "steaming-vessel");
    const widths = await page.evaluate(() => [document.documentElement.scrollWidth, window.innerWidth]);
    assert.ok(widths[0] <= 390 && widths[1] <= 390, `${widths}`);
    const box = await page.locator("#picture").boundingBox();
    assert.ok(box.width >= 350 && box.height >= 200, JSON.stringify(box));
  });
  await holds("no control reaches beyond a phone's edge", async () => {
    await load(SIMPLE);
    await unfoldAll();
    const beyond = await page.evaluate(() => [...document.querySelectorAll("#side :is(button, input, select, textarea)")]
      .filter((node) => node.getBoundingClientRect().right > window.innerWidth).map((node) => node.outerHTML));
    assert.deepEqual(beyond, []);
  });
  await holds("a tap probes", async () => {
    const box = await page.locator("#picture").boundingBox();
    await page.touchscreen.tap(box.x + box.width / 2, box.y + box.height / 2);
    await until(() => window.fogbank.lastReading !== null);
    assert.match(await page.locator("#probe").innerText(), /optical depth/i);
  });
  await shot("phone");
}

await run(address, shots, async (browser) => {
  await onADesk(browser);
  await onAPhone(browser);
});
