// Scenes that live on the server, as a person works on them: node scenes.js PROGRAM ADDRESS DIRECTORY [SHOTS]
// PROGRAM is run on ADDRESS, killed and run again; DIRECTORY takes its data, SHOTS the screenshots.
// Prints a line for each thing that holds, and ends with status 1 at the first one that does not.

import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import { once } from "node:events";
import { readFile } from "node:fs/promises";
import { complaints, dragOver, holds, load, onPicture, open, openIn, page, phase, pixels, pointAt, posted, run, saved, said, scene, shot, state, toFull, traffic, turnTo, until } from "./driver.js";

const [program, address, directory, shots] = process.argv.slice(2);

let server;

/** Runs the program, with its scenes in a directory or in memory. */
async function start(dataDirectory) {
  const kept = dataDirectory ? ["--data-dir", dataDirectory] : [];
  server = spawn(program, ["serve", "--listen", address, ...kept], { stdio: ["ignore", "ignore", "pipe"] });
  server.stderr.resume();
  for (const end = Date.now() + 60_000; ;) {
    if (await fetch(`http://${address}/healthz`).then((answer) => answer.ok, () => false)) return;
    assert.ok(Date.now() < end, "the server does not start");
    await new Promise((resolve) => setTimeout(resolve, 50));
  }
}

async function kill() {
  server.kill("SIGKILL");
  await once(server, "exit");
}

const STAGE = {
  camera: { position: [0, 2, 8], target: [0, 1, 0] },
  surfaces: [{ id: "wall", shape: { kind: "box", min: [-8, 0, -3], max: [8, 6, -2] } }, { id: "floor" },
    { id: "ball", shape: { kind: "sphere", center: [-3, 0.6, 1], radius: 0.6 } }],
  lights: [{ id: "lamp", kind: "point", position: [2, 3, 1], intensity: [80, 70, 50] }],
  fog: { ambient: [0.05, 0.05, 0.06], terms: [{ id: "paint", kind: "gaussians", blobs: [] }] },
};

const blobs = async () => (await scene()).fog.terms.find(({ kind }) => kind === "gaussians")?.blobs ?? [];
const camera = () => page.evaluate(() => window.fogbank.camera);
const chosen = () => page.evaluate(() => window.fogbank.chosen);
const stored = async (id) => (await fetch(`http://${address}/v1/scenes/${id}`)).json();
const idOf = () => page.evaluate(() => window.fogbank.id);
const press = (key) => page.locator("#picture").press(key);
const tool = (name) => page.locator(`#tools input[value=${name}]`).check({ force: true });
const gap = (a, b) => Math.hypot(...a.map((x, i) => x - b[i]));
/** Where in the picture a point is that the stage's own camera sees, from [0, 2, 8] to [0, 1, 0] with 45° of height. */
async function seenAt([px, py, pz]) {
  const box = await page.locator("#picture").boundingBox();
  const size = Math.hypot(1, 8);
  const depth = ((py - 2) * -1 + (pz - 8) * -8) / size;
  const up = ((py - 2) * 8 + (pz - 8) * -1) / size;
  const half = Math.tan(Math.PI / 8) * depth;
  return [(px / ((half * box.width) / box.height) + 1) / 2, (1 - up / half) / 2];
}
/** What the probe reads at a point, once it does. */
async function probeAt(x, y) {
  const before = await page.evaluate(() => window.fogbank.counts.probes);
  await pointAt(x, y);
  await until((count) => window.fogbank.counts.probes > count && window.fogbank.lastReading, before);
  await page.waitForTimeout(150);
  return page.evaluate(() => window.fogbank.lastReading);
}
/** Undoes or redoes, and waits until the picture shows it. */
const turn = (key) => toFull(() => press(key));

async function opening(browser) {
  await open(browser, { viewport: { width: 1280, height: 800 } });
  await holds("a preset is shown without all the others, and nothing is stored for it", async () => {
    await phase("full");
    assert.equal(await state("saved"), "preset");
    assert.equal(await state("link"), "socket");
    assert.ok(!posted.some(({ path }) => path === "/v1/render"));
    const { scenes } = await (await fetch(`http://${address}/v1/scenes`)).json();
    assert.deepEqual(scenes, []);
    assert.match(page.url(), /\?preset=street-thin$/);
  });
  await holds("a view is sent in less than a kilobyte, and no scene", async () => {
    const [views, bytes] = [said.length, traffic.up];
    await toFull(() => dragOver([[0.5, 0.5], [0.55, 0.5], [0.6, 0.52]]));
    const sent = said.slice(views).filter(({ type }) => type === "view");
    assert.ok(sent.length >= 2);
    assert.ok(sent.every((view) => JSON.stringify(view).length < 1000));
    assert.ok(traffic.up - bytes < 20_000, `${traffic.up - bytes} bytes`);
  });
  await holds("the first change of a preset makes a scene of one's own", async () => {
    await toFull(() => page.evaluate(() => window.fogbank.set(["scene", "fog", "terms", 0, "extinction"], 0.05)));
    await saved();
    const id = await idOf();
    assert.match(id, /^street-thin-[0-9a-f]{6}$/);
    assert.match(page.url(), new RegExp(`\\?scene=${id}$`));
    assert.equal((await stored(id)).scene.fog.terms[0].extinction, 0.05);
    assert.equal((await stored("street-thin")).revision, 0);
    await turn("Control+z");
    assert.equal((await stored(id)).scene.fog.terms[0].extinction, (await stored("street-thin")).scene.fog.terms[0].extinction);
  });
  await holds("a preset is as it was, whatever was made of it", async () => {
    const { scenes: before } = await (await fetch(`http://${address}/v1/scenes`)).json();
    await toFull(() => page.selectOption("#preset", "street-thin"));
    await page.waitForTimeout(700);
    assert.equal(await state("saved"), "preset");
    assert.deepEqual(await scene(), (await stored("street-thin")).scene);
    assert.deepEqual((await (await fetch(`http://${address}/v1/scenes`)).json()).scenes, before);
  });
}

async function painting() {
  await holds("a brush paints fog on surfaces, its radius by wheel", async () => {
    await load(STAGE);
    const before = await pixels();
    await tool("brush");
    await pointAt(0.4, 0.4);
    const radius = page.locator("input[aria-label='Brush radius in m']");
    const small = Number(await radius.inputValue());
    await page.mouse.wheel(0, -120);
    assert.ok(Number(await radius.inputValue()) > small);
    await page.waitForTimeout(200);
    await toFull(() => dragOver([[0.35, 0.4], [0.42, 0.38], [0.5, 0.42], [0.58, 0.4]]));
    await saved();
    const painted = await blobs();
    assert.ok(painted.length >= 4, `${painted.length} blobs`);
    // Of the wall's front, within a radius.
    for (const { center, radius } of painted) assert.ok(Math.abs(center[2] + 2) <= radius + 1e-3, `${center}`);
    assert.notEqual(await pixels(), before);
    await shot("painted");
    assert.deepEqual((await stored(await idOf())).scene.fog.terms[0].blobs, painted);
  });
  await holds("a stroke is one step of undo, and of redo", async () => {
    const painted = await blobs();
    await turn("Control+z");
    assert.deepEqual(await blobs(), []);
    await turn("Control+Shift+Z");
    assert.deepEqual(await blobs(), painted);
    await toFull(() => page.locator("#undo").click());
    await toFull(() => page.locator("#redo").click());
    assert.deepEqual(await blobs(), painted);
  });
  await holds("an eraser takes fog away where it is seen", async () => {
    const before = await blobs();
    const [x, y] = await seenAt(before.at(-1).center);
    await tool("eraser");
    await pointAt(x, y);
    await page.waitForTimeout(200);
    await toFull(() => dragOver([[x, y], [x + 0.01, y], [x + 0.02, y]]));
    await saved();
    const after = await blobs();
    assert.ok(after.length < before.length && after.length > 0, `${before.length} then ${after.length}`);
    await turn("Control+z");
    assert.deepEqual(await blobs(), before);
  });
  await holds("a brush on a plane paints in the air, as deep as what is looked at", async () => {
    const before = (await blobs()).length;
    await tool("brush");
    await page.locator("select[aria-label='Paint on']").selectOption("plane");
    await toFull(() => dragOver([[0.5, 0.2], [0.6, 0.2], [0.7, 0.22]]));
    await saved();
    const fresh = (await blobs()).slice(before);
    assert.ok(fresh.length >= 2);
    const { position, target } = await camera();
    const forward = target.map((x, i) => (x - position[i]) / gap(target, position));
    for (const { center, radius } of fresh) {
      const depth = center.reduce((sum, x, i) => sum + (x - target[i]) * forward[i], 0);
      assert.ok(Math.abs(depth) <= radius + 1e-3, `${depth}`);
    }
    await page.locator("select[aria-label='Paint on']").selectOption("surfaces");
    await tool("select");
  });
}

async function choosing() {
  await holds("a click chooses a lamp and shows its panel, and a drag moves it in one step of undo", async () => {
    await load(STAGE);
    const [x, y] = await seenAt([2, 3, 1]);
    await page.mouse.click(...(await onPicture(x, y)));
    await until(() => window.fogbank.chosen === "/scene/lights/0");
    assert.equal(await page.locator('#panels details[data-pointer="/scene/lights/0"]').getAttribute("open"), "");
    assert.equal(await page.locator("#chosen").isVisible(), true);
    await shot("chosen");
    const before = await pixels();
    await toFull(() => dragOver([[x, y], [x - 0.05, y], [x - 0.1, y], [x - 0.2, y + 0.05]]));
    await saved();
    const [moved] = (await scene()).lights;
    assert.ok(moved.position[0] < 1 && moved.position[1] < 3, `${moved.position}`);
    assert.notEqual(await pixels(), before);
    await turn("Control+z");
    assert.deepEqual((await scene()).lights[0].position, [2, 3, 1]);
    assert.equal(await pixels(), before);
  });
  await holds("a click chooses a surface or a blob, and Delete deletes it", async () => {
    const air = { ...STAGE, fog: { terms: [{ id: "paint", kind: "gaussians", blobs: [{ center: [0, 1, 0], radius: 0.8, extinction: 1 }] }] } };
    await load(air);
    const [x, y] = [0.5, 0.5];
    await page.mouse.click(...(await onPicture(x, y)));
    await until(() => window.fogbank.chosen === "/scene/fog/terms/0/blobs/0");
    // The click itself has given the picture the keys.
    await toFull(() => page.keyboard.press("Delete"));
    assert.deepEqual(await blobs(), []);
    assert.equal(await chosen(), null);
    await page.mouse.click(...(await onPicture(x, y)));
    await until(() => window.fogbank.chosen === "/scene/surfaces/0");
    await toFull(() => page.locator("#chosen-delete").click());
    assert.deepEqual((await scene()).surfaces.map(({ id }) => id), ["floor", "ball"]);
    await turn("Control+z");
    await turn("Control+z");
    assert.equal((await blobs()).length, 1);
    assert.equal((await scene()).surfaces.length, 3);
  });
  await holds("what is added stands where the view looks", async () => {
    // Choosing the lamp opened its panel.
    await toFull(() => page.locator("button[aria-label='Add to lights']").click());
    const { lights } = await scene();
    assert.equal(lights.length, 2);
    const { position, target } = await camera();
    const at = lights[1].position;
    const far = gap(at, position);
    const onRay = position.map((p, i) => p + ((target[i] - p) / gap(target, position)) * far);
    assert.ok(gap(at, onRay) < 0.05 * far, `${at}`);
    assert.ok(at[2] > -2, "in front of the wall");
    await turn("Control+z");
  });
}

async function looking() {
  await holds("the view turns about what is under the pointer, and zooms there", async () => {
    await load(STAGE);
    const before = await probeAt(0.75, 0.4);
    await toFull(async () => { for (let i = 0; i < 3; i += 1) await page.mouse.wheel(0, -200); });
    const after = await probeAt(0.75, 0.4);
    assert.equal(after.hit.surface, before.hit.surface);
    assert.ok(after.hit.distance_m < 0.7 * before.hit.distance_m, `${after.hit.distance_m}`);
    assert.ok(gap(after.hit.point, before.hit.point) < 0.01 * before.hit.distance_m, "the wheel goes to where the pointer is");
    const pivot = after.hit.distance_m;
    await toFull(() => dragOver([[0.75, 0.4], [0.72, 0.4], [0.68, 0.4], [0.65, 0.4]]));
    const turned = await probeAt(0.75, 0.4);
    assert.ok(Math.abs(turned.hit.distance_m - pivot) < 0.02 * pivot, "the pivot stays where it is");
    // However often the wheel turns, nobody ends behind a wall.
    await toFull(async () => { for (let i = 0; i < 30; i += 1) await page.mouse.wheel(0, -200); });
    assert.ok((await camera()).position[2] > -2, `${(await camera()).position}`);
  });
  await holds("no view ends below the floor, and F looks at what is chosen", async () => {
    await toFull(() => press("Home"));
    await toFull(() => dragOver([[0.5, 0.3], [0.5, 0.2], [0.5, 0.05]]));
    await toFull(() => dragOver([[0.5, 0.9], [0.5, 0.5], [0.5, 0.05]]));
    assert.ok((await camera()).position[1] > 0, `${(await camera()).position}`);
    await toFull(() => press("Home"));
    const box = await onPicture(0.5, 0.5);
    await page.mouse.click(...box);
    await until(() => window.fogbank.chosen === "/scene/surfaces/0");
    await toFull(() => press("f"));
    assert.deepEqual((await camera()).target, [0, 3, -2.5]);
    await toFull(() => page.locator("#reset-view").click());
    assert.deepEqual((await camera()).position, STAGE.camera.position);
  });
  await holds("from where nothing is seen there is a way back", async () => {
    await toFull(() => page.evaluate(() => window.fogbank.set(["camera", "position"], [0, 3, -2.5])));
    await page.locator("#dark").waitFor({ state: "visible" });
    await shot("dark");
    await toFull(() => page.locator("#dark-reset").click());
    assert.deepEqual((await camera()).position, STAGE.camera.position);
    assert.equal(await page.locator("#dark").isVisible(), false);
  });
  await holds("layers show their units, and a bar of their values", async () => {
    const layer = (name) => toFull(() => page.locator(`#layers input[value=${name}]`).check({ force: true }));
    await layer("depth");
    assert.match(await page.locator("#legend").innerText(), /depth \[m\]/);
    const ticks = (await page.locator(".ticks span").allInnerTexts()).map(Number);
    assert.ok(ticks.length === 5 && ticks.every((tick, i) => i === 0 || tick > ticks[i - 1]), `${ticks}`);
    const { distance_m } = (await probeAt(0.5, 0.5)).hit;
    assert.ok(ticks[0] <= distance_m && distance_m <= ticks[4], `${distance_m} is not within ${ticks}`);
    await shot("legend");
    await layer("optical_depth");
    assert.match(await page.locator("#legend").innerText(), /optical depth/);
    await layer("beauty");
    const scrolls = await page.evaluate(() => [...document.querySelectorAll("#layers, .tool-bar, header")]
      .filter((node) => node.scrollWidth > node.clientWidth + 1).length);
    assert.equal(scrolls, 0, "a switch that scrolls");
  });
}

async function saving() {
  await holds("the picture is saved as PNG, EXR and NPY", async () => {
    const { width, height } = await page.evaluate(() => window.fogbank.lastFrame);
    for (const [ending, magic] of [["png", "89504e47"], ["exr", "762f3101"], ["npy", "934e554d5059"]]) {
      await page.locator("#save > summary").click();
      const coming = page.waitForEvent("download");
      await page.locator(`#save button[value=${ending}]`).click();
      const file = await (await coming).path();
      const bytes = await readFile(file);
      assert.equal(bytes.subarray(0, magic.length / 2).toString("hex"), magic, ending);
      if (ending === "png") assert.deepEqual([bytes.readUInt32BE(16), bytes.readUInt32BE(20)], [width, height]);
      if (ending === "npy") assert.match(bytes.subarray(0, 128).toString("latin1"), new RegExp(`\\(${height}, ${width}`));
    }
  });
  await holds("scenes are listed, saved under a name, opened and deleted", async () => {
    const first = await idOf();
    await page.locator("#open-library").click();
    await page.fill("#library-name", "evening");
    await toFull(() => page.locator("#library-save button").click());
    assert.equal(await idOf(), "evening");
    await page.locator("#open-library").click();
    await page.locator("#library-list li").first().waitFor();
    await shot("library");
    const names = await page.locator("#library-list .scene-name").allInnerTexts();
    assert.ok(names.includes("evening") && names.includes(first), `${names}`);
    await toFull(() => page.locator(`button[aria-label="Open ${first}"]`).click());
    await page.locator("#open-library").click();
    const remove = page.locator('button[aria-label="Delete evening"]');
    await remove.click();
    await remove.click();
    await until(() => !document.getElementById("library-list").innerText.includes("evening"));
    await page.locator("#library-close").click();
    assert.equal((await fetch(`http://${address}/v1/scenes/evening`)).status, 404);
  });
  await holds("a link shows the same scene from the same place", async () => {
    await toFull(() => press("ArrowLeft"));
    await page.locator("#share").click();
    await until(() => document.getElementById("share").innerText === "Copied");
    const link = await page.evaluate(() => navigator.clipboard.readText());
    const [id, here, sight] = [await idOf(), await camera(), await pixels()];
    const first = page;
    const other = await openIn(page.context(), link.slice(link.indexOf("?")));
    await phase("full");
    assert.deepEqual([await idOf(), await camera()], [id, here]);
    assert.equal(await pixels(), sight);
    await other.close();
    turnTo(first);
  });
}

async function together() {
  await holds("two pages on one scene see each other's changes, each from its own place", async () => {
    const first = page;
    const id = await idOf();
    await openIn(page.context(), `?scene=${id}`);
    await phase("full");
    const second = page;
    await until(() => document.getElementById("viewers").innerText === "2 viewers");
    const [before, place] = [await pixels(), await camera()];
    turnTo(first);
    await tool("brush");
    await pointAt(0.5, 0.4);
    await page.waitForTimeout(200);
    await toFull(() => dragOver([[0.45, 0.4], [0.5, 0.4], [0.55, 0.4]]));
    await toFull(() => press("ArrowRight"));
    await saved();
    const painted = await blobs();
    turnTo(second);
    await until((count) => window.fogbank.request.scene.fog.terms[0].blobs.length === count, painted.length);
    await phase("full");
    assert.notEqual(await pixels(), before);
    assert.deepEqual(await camera(), place);
    // Both at once, at different places of the scene.
    await Promise.all([
      first.evaluate(() => window.fogbank.set(["scene", "lights", 0, "intensity"], [10, 20, 30])),
      second.evaluate(() => window.fogbank.set(["scene", "fog", "ambient"], [0.1, 0.2, 0.3])),
    ]);
    for (const other of [first, second]) {
      turnTo(other);
      await until(() => {
        const { lights, fog } = window.fogbank.request.scene;
        return lights[0].intensity[2] === 30 && fog.ambient[2] === 0.3 && document.documentElement.dataset.saved === "saved";
      });
    }
    await second.close();
    turnTo(first);
    await tool("select");
  });
  await holds("who has chosen a lamp keeps it when another lamp goes, and a change that no longer fits is taken back", async () => {
    const lamp = (id, x) => ({ id, kind: "point", position: [x, 3, 1], intensity: [20, 20, 20] });
    await load({ ...STAGE, lights: [lamp("left", -2), lamp("middle", 0), lamp("right", 2)] });
    await page.mouse.click(...(await onPicture(...(await seenAt([2, 3, 1])))));
    await until(() => window.fogbank.chosen === "/scene/lights/2");
    const body = JSON.stringify([{ op: "remove", path: "/lights/0" }]);
    const headers = { "Content-Type": "application/json-patch+json" };
    const id = await idOf();
    await toFull(() => fetch(`http://${address}/v1/scenes/${id}`, { method: "PATCH", body, headers }));
    await until(() => window.fogbank.chosen === "/scene/lights/1");
    // While one cannot send, the other takes the lamp away.
    await page.route("**/edits", (route) => setTimeout(() => route.continue(), 800));
    const light = (await scene()).lights[1];
    assert.equal(light.id, "right");
    await page.evaluate(() => window.fogbank.set(["scene", "lights", 1, "intensity"], [1, 2, 3]));
    await fetch(`http://${address}/v1/scenes/${id}`, { method: "PATCH", body: JSON.stringify([{ op: "remove", path: "/lights/1" }]), headers });
    await until(() => document.getElementById("status").checkVisibility());
    await page.unroute("**/edits");
    await saved();
    assert.deepEqual((await scene()).lights.map((other) => other.id), ["middle"]);
    assert.deepEqual(await scene(), (await stored(id)).scene);
    assert.equal(await chosen(), null);
    forgive();
  });
  await holds("a scene that somebody deletes stays deleted", async () => {
    const id = await idOf();
    await fetch(`http://${address}/v1/scenes/${id}`, { method: "DELETE" });
    await until(() => /There is no scene/.test(document.getElementById("status").innerText));
    await page.waitForTimeout(500);
    assert.equal((await fetch(`http://${address}/v1/scenes/${id}`)).status, 404);
    forgive();
    await toFull(() => page.selectOption("#preset", "in-scatter"));
    await load(STAGE);
  });
}

/** The browser notes every request that a dead server does not answer. */
const forgive = () => { complaints.length = 0; };

async function losing(dataDirectory) {
  await holds("a reload keeps everything", async () => {
    const before = await scene();
    await page.reload();
    await phase("full");
    assert.deepEqual(await scene(), before);
  });
  await holds("a server that is killed and comes again has what was done meanwhile", async () => {
    await kill();
    await until(() => document.documentElement.dataset.link === "lost");
    await page.evaluate(() => window.fogbank.set(["scene", "fog", "ambient"], [0.3, 0.3, 0.3]));
    await until(() => document.documentElement.dataset.saved === "waiting");
    assert.match(await page.locator("#status").innerText(), /cannot be reached/);
    assert.deepEqual((await scene()).fog.ambient, [0.3, 0.3, 0.3]);
    await start(dataDirectory);
    await saved();
    await phase("full");
    assert.deepEqual((await stored(await idOf())).scene.fog.ambient, [0.3, 0.3, 0.3]);
    assert.equal(await page.locator("#status").isVisible(), false);
    forgive();
  });
  await holds("a change that was not sent outlives a reload", async () => {
    await page.route("**/edits", (route) => route.abort("connectionrefused"));
    await page.evaluate(() => window.fogbank.set(["scene", "fog", "ambient"], [0.4, 0.4, 0.4]));
    await until(() => document.documentElement.dataset.saved === "waiting");
    await page.waitForTimeout(300);
    await page.unroute("**/edits");
    await page.reload();
    await saved();
    await phase("full");
    assert.deepEqual((await stored(await idOf())).scene.fog.ambient, [0.4, 0.4, 0.4]);
    assert.deepEqual((await scene()).fog.ambient, [0.4, 0.4, 0.4]);
    forgive();
  });
  await holds("a server that has forgotten a scene gets it back", async () => {
    const before = await scene();
    // The page keeps the scene when it rests.
    await page.waitForTimeout(1500);
    await kill();
    await start();
    await page.reload();
    await phase("full");
    assert.deepEqual(await scene(), before);
    assert.deepEqual((await stored(await idOf())).scene, before);
    forgive();
  });
}

async function withoutSockets(browser) {
  await open(browser, { viewport: { width: 1000, height: 700 } }, "?preset=in-scatter");
  await page.addInitScript(() => {
    window.WebSocket = class {
      constructor() { setTimeout(() => this.onclose?.({ code: 1006 })); }
      close() {}
    };
  });
  await page.reload();
  await holds("without sockets requests do", async () => {
    await phase("full");
    assert.equal(await state("link"), "requests");
    await load(STAGE);
    const before = await pixels();
    await tool("brush");
    await pointAt(0.5, 0.4);
    await page.waitForTimeout(200);
    await toFull(() => dragOver([[0.45, 0.4], [0.5, 0.4], [0.55, 0.4]]));
    await saved();
    assert.ok((await blobs()).length >= 2);
    assert.notEqual(await pixels(), before);
    await turn("Control+z");
    assert.deepEqual(await blobs(), []);
    // Somebody else's change is seen after a while.
    const body = JSON.stringify({ fog: { ambient: [1, 0, 0] } });
    await toFull(() => fetch(`http://${address}/v1/scenes/${page.url().split("=")[1]}`, { method: "PATCH", body, headers: { "Content-Type": "application/merge-patch+json" } }));
    assert.deepEqual((await scene()).fog.ambient, [1, 0, 0]);
  });
}

async function onScreens(browser) {
  await open(browser, { viewport: { width: 900, height: 700 }, deviceScaleFactor: 2 }, "?preset=in-scatter");
  await holds("a picture at rest has the screen's own pixels", async () => {
    await phase("full");
    const { width, height } = await page.evaluate(() => window.fogbank.lastFrame);
    const box = await page.locator("#picture").boundingBox();
    assert.deepEqual([width, height], [Math.round(2 * box.width), Math.round(2 * box.height)]);
  });
  await open(browser, { viewport: { width: 320, height: 640 }, hasTouch: true, isMobile: true }, "?preset=in-scatter");
  await holds("a phone of 320 pixels shows everything, and a finger paints", async () => {
    await phase("full");
    const widths = await page.evaluate(() => [document.documentElement.scrollWidth, window.innerWidth]);
    assert.deepEqual(widths, [320, 320]);
    const beyond = await page.evaluate(() => [...document.querySelectorAll("button, input, select, summary")]
      .filter((node) => node.checkVisibility() && node.getBoundingClientRect().right > window.innerWidth + 0.5).map((node) => node.outerHTML));
    assert.deepEqual(beyond, []);
    await shot("phone-320");
    await load(STAGE);
    await page.locator("#tools label", { hasText: "Brush" }).tap();
    await page.locator("#picture").scrollIntoViewIfNeeded();
    const [x, y] = await onPicture(0.5, 0.6);
    await toFull(() => page.touchscreen.tap(x, y));
    await saved();
    assert.ok((await blobs()).length >= 1);
    await shot("phone-painted");
  });
}

const dataDirectory = `${directory}/page-scenes`;
await start(dataDirectory);
try {
  await run(address, shots, async (browser) => {
    await opening(browser);
    await painting();
    await choosing();
    await looking();
    await saving();
    await together();
    await losing(dataDirectory);
    await withoutSockets(browser);
    await onScreens(browser);
  });
} finally {
  server.kill("SIGKILL");
}
