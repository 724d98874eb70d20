// The page: connects the request, the frame loop, the panels and the probe.

import * as api from "./api.js";
import { bindClock } from "./clock.js";
import { completeCamera, orbit, pan, rayThrough, tidied, zoom } from "./camera.js";
import { element, plainDoc } from "./dom.js";
import { ErrorLayer } from "./errors.js";
import { bindGestures } from "./gestures.js";
import { Panels } from "./panels.js";
import { Probe, showReading } from "./probe.js";
import { bindProgress, followed } from "./progress.js";
import { bindSceneDialog } from "./scene_dialog.js";
import { Schemas } from "./schema.js";
import { bindStatus } from "./status.js";
import { RequestStore } from "./store.js";
import { showFacts, showTimings } from "./timings.js";
import { Viewer } from "./viewer.js";

const CENTRE = { x: 0.5, y: 0.5 };
const LAYERS = ["beauty", "airlight", "optical_depth", "transmittance", "depth"];
// What the errors are errors of.
const COMPARED_LAYER = "airlight";
const ACCEPT = { draft: "image/jpeg", full: "image/png" };

const find = (id) => document.getElementById(id);
const picture = find("picture");
const store = new RequestStore(onChange);
const status = bindStatus(find("status"), (pointer) => panels?.reveal(pointer));
const viewer = new Viewer(picture, render, { phase: onPhase, frame: onFrame, problem: onProblem });
const progress = bindProgress(find("progress"), { stop: () => viewer.stop(), resume: () => viewer.resume() });
const probe = new Probe(askProbe, onReading);
const errors = new ErrorLayer(find("errors"), find("errors-note"), askErrors, onErrors);
/** @type {Panels} made once the schema is here */
let panels;
/** The camera that the loaded scene came with. */
let homeCamera;
let refreshIsDue = false;
const clock = bindClock(find("play"), find("time"), {
  getTime: () => store.scene.time_s ?? 0,
  setTime: (time_s) => store.set(["scene", "time_s"], time_s),
});

/**
 * For scripts and browser tests. `document.documentElement.dataset.frame` is `loading` while a newer picture is due, then
 * `draft`, `full`, `error` or `stopped`; `lastFrame` is `{seq, quality, layer, width, height, bytes, backend, serverTiming,
 * roundTrip_ms}`. `dataset.errors` is the state of the layer "error" (`off`, `waiting`, `working`, `done`, `failed` or
 * `stopped`), `lastComparison` `{scale, width, height, numbers}`. `counts` only grow.
 */
window.fogbank = {
  get request() { return store.request; },
  get camera() { return completeCamera(store.scene.camera); },
  set: (path, value) => store.set(path, value),
  load: loadScene,
  lastFrame: null,
  lastReading: null,
  lastComparison: null,
  counts: { changes: 0, renders: 0, frames: 0, probes: 0, comparisons: 0 },
};
const { counts } = window.fogbank;

function onChange() {
  counts.changes += 1;
  errors.cancel();
  viewer.change();
  if (refreshIsDue) return;
  refreshIsDue = true;
  requestAnimationFrame(() => {
    refreshIsDue = false;
    panels?.refresh();
    clock.refresh();
  });
}

function onPhase(name) {
  document.documentElement.dataset.frame = name;
  if (name === "stopped") progress.stopped();
}

async function render({ quality, width, height, signal }) {
  counts.renders += 1;
  const { layer } = store.request;
  const body = store.renderBody({ width, height, quality });
  const ask = (job) => api.render(body, { accept: ACCEPT[quality], signal, job });
  progress.hide();
  const answer = await followed(ask, (far) => progress.show(quality, far)).finally(() => {
    // What was given up shows that it stopped, or a newer picture how far that is.
    if (!signal.aborted) progress.hide();
  });
  return { ...answer, layer };
}

function onFrame(info) {
  counts.frames += 1;
  window.fogbank.lastFrame = info;
  status.clear();
  panels?.showErrors([]);
  showFacts(find("facts"), info);
  showTimings(find("timings"), info);
  clock.tick();
  if (info.quality !== "full") return;
  probe.refresh();
  errors.start(info);
}

function onProblem(error, retryIn_ms) {
  clock.pause();
  status.show(error, retryIn_ms);
  panels?.showErrors(error.errors ?? []);
}

/** The scene's own estimator against the reference; where that is its own, what `auto` would do. */
function askErrors({ width, height, signal, show }) {
  counts.comparisons += 1;
  const own = store.scene.fog?.airlight ?? "auto";
  const a = { airlight: own === "reference" ? "auto" : own };
  const body = store.sceneBody({ width, height, a });
  return followed((job) => api.compare(body, { signal, job }), show);
}

function onErrors(state, comparison) {
  document.documentElement.dataset.errors = state;
  if (comparison) window.fogbank.lastComparison = comparison;
}

/** Probes the ray of the pixel that a point of the picture lies in, so that it agrees with the picture. */
async function askProbe({ x, y }) {
  const { width, height } = window.fogbank.lastFrame ?? { width: picture.clientWidth, height: picture.clientHeight };
  const centreOf = (at, size) => (Math.min(Math.floor(at * size), size - 1) + 0.5) / size;
  const ray = rayThrough(window.fogbank.camera, centreOf(x, width), centreOf(y, height), width / height);
  counts.probes += 1;
  const [reading] = await api.probe(store.sceneBody({ rays: [ray] }));
  return reading;
}

function onReading(reading) {
  window.fogbank.lastReading = reading;
  const lights = store.scene.lights ?? [];
  find("probe-hint").hidden = reading !== null;
  showReading(find("probe"), reading, lights.map((light, i) => light?.id ?? `light ${i + 1}`));
}

/** Shows where the probe is when no mouse cursor shows it. */
function placeMarker(point) {
  const marker = find("marker");
  marker.hidden = !point;
  if (!point) return;
  marker.style.left = `${100 * point.x}%`;
  marker.style.top = `${100 * point.y}%`;
}

function probeAt(point, isMarked) {
  placeMarker(isMarked ? point : null);
  probe.at(point);
}

function moveCamera(move) {
  store.set(["scene", "camera"], tidied(move(window.fogbank.camera)));
}

function resetView() {
  const kindBefore = window.fogbank.camera.projection.kind;
  store.set(["scene", "camera"], structuredClone(homeCamera));
  if (window.fogbank.camera.projection.kind !== kindBefore) panels.rebuild();
}

function loadScene(scene) {
  clock.pause();
  homeCamera = structuredClone(scene.camera);
  store.load(scene);
  panels.rebuild();
}

function bindPicture() {
  bindGestures(picture, {
    orbit: (yaw_rad, pitch_rad) => moveCamera((camera) => orbit(camera, yaw_rad, pitch_rad)),
    pan: (rightwards, upwards) => moveCamera((camera) => pan(camera, rightwards, upwards)),
    zoom: (factor) => moveCamera((camera) => zoom(camera, factor)),
    hover: (point) => probeAt(point, false),
    aim: (point) => probe.aim(point),
    leave: () => { placeMarker(null); probe.clear(); },
    tap: (point) => probeAt(point, true),
    probeCentre: () => probeAt(CENTRE, true),
    home: resetView,
  });
}

/** The layer switch, from the schema's own list, and the errors. */
function buildLayers(schemas) {
  const schema = schemas.resolve(schemas.body("/v1/render").properties?.layer);
  const options = schemas.options(schema) ?? LAYERS.map((value) => ({ value }));
  const choice = (value, description, layer) => {
    const radio = element("input", { type: "radio", name: "layer", value, checked: value === store.request.layer });
    radio.addEventListener("change", () => {
      errors.isOn = value !== layer;
      store.set(["layer"], layer);
    });
    return element("label", { title: plainDoc(description) }, radio, element("span", {}, value.replaceAll("_", " ")));
  };
  errors.describe(schemas.component("Comparison").properties);
  find("layers").append(
    ...options.map(({ value, description }) => choice(value, description, value)),
    choice("error", schemas.summary("/v1/compare"), COMPARED_LAYER));
}

function bindPresets(presets) {
  const select = find("preset");
  select.append(...presets.map(({ name, title }) => element("option", { value: name, textContent: title ?? name })));
  const load = () => {
    const preset = presets[select.selectedIndex];
    find("preset-about").textContent = preset?.description ?? "";
    loadScene(structuredClone(preset?.scene ?? {}));
  };
  select.addEventListener("change", load);
  find("reload-preset").addEventListener("click", load);
  const wanted = new URLSearchParams(location.search).get("preset");
  if (presets.some(({ name }) => name === wanted)) select.value = wanted;
  load();
}

function bindTools() {
  find("reset-view").addEventListener("click", resetView);
  find("open-keys").addEventListener("click", () => find("keys-dialog").showModal());
  const openScene = bindSceneDialog(find("scene-dialog"), { getScene: () => store.scene, loadScene });
  find("open-scene").addEventListener("click", openScene);
  find("toggle-panels").addEventListener("click", (event) => {
    const isOpen = document.body.classList.toggle("no-panels") === false;
    event.currentTarget.setAttribute("aria-expanded", String(isOpen));
  });
}

async function start() {
  const [document, presets] = await status.untilAnswered(() => Promise.all([api.openapi(), api.presets()]));
  const schemas = new Schemas(document);
  panels = new Panels(find("panels"), schemas, store);
  buildLayers(schemas);
  bindPicture();
  bindTools();
  bindPresets(presets);
}

start().catch((error) => {
  onPhase("error");
  status.show(error);
});
