// The page: connects the scene, the socket, the picture, the tools and the panels.

import * as api from "./api.js";
import { Brush } from "./brush.js";
import { bindClock } from "./clock.js";
import { completeCamera } from "./camera.js";
import { SceneDocument } from "./document.js";
import { element } from "./dom.js";
import { ErrorLayer } from "./errors.js";
import { Keeper } from "./keeper.js";
import { buildLayers } from "./layers.js";
import { showLegend } from "./legend.js";
import { bindLibrary } from "./library.js";
import { linkOf, readLink, shareLink } from "./link.js";
import { Live } from "./live.js";
import { Panels } from "./panels.js";
import { bindPicture } from "./picture.js";
import { Preview } from "./preview.js";
import { Probe, showReading } from "./probe.js";
import { bindProgress, followed, watch } from "./progress.js";
import { Requests } from "./requests.js";
import { bindSave } from "./save.js";
import { bindSceneDialog } from "./scene_dialog.js";
import { Schemas } from "./schema.js";
import { Screen } from "./screen.js";
import { Session } from "./session.js";
import { Selection } from "./selection.js";
import { bindStatus } from "./status.js";
import { Store } from "./store.js";
import { parseServerTiming, showFacts, showTimings } from "./timings.js";
import { Tools } from "./tools.js";
import { Outbox } from "./outbox.js";

const ACCEPT = { draft: "image/jpeg", full: "image/png" };
const HISTORY_REST_MS = 150;
const SAVED = { preset: "preset", saved: "saved", saving: "saving…", waiting: "not saved yet" };
// From 0 to 255: a picture that is nowhere brighter shows nothing.
const DARK = 2;

const find = (id) => document.getElementById(id);
const picture = find("picture");
const root = document.documentElement;

let presets = [];
/** @type {Panels} made once the schema is here */
let panels;
let historyTimer = 0;
let frameWatch = new AbortController();
let refreshIsDue = false;
/** The scene and the view that the page's address asked for, until it has come. */
let linked = null;

const scene = new SceneDocument({ changed: onScene, pending: onPending, lost: () => live.reopen() });
const store = new Store(scene, onView);
const keeper = new Keeper(scene);
const status = bindStatus(find("status"), (pointer) => panels?.reveal(pointer));
const live = new Live({
  hello: onHello, scene: (told) => scene.hear(told), frame: (header, blob) => preview.take(header, blob), viewers: onViewers,
  refused: (seq, problem) => { if (preview.refused(seq)) onProblem(problem); },
  revision: () => scene.known, gone: () => outbox.missing(), deleted: () => onMissing(scene.id), lost: onLost,
  unavailable: () => useRequests(true),
});
const session = new Session(scene, live, keeper, (id) => presetOf(id) !== undefined,
  { opened: onOpened, missing: onMissing, gone: () => outbox.missing(), moved: onMoved });
const outbox = new Outbox(scene, {
  prepare: () => session.own(), refused: (error) => onProblem(error), waits: onWaits, sent: () => { isWaiting = false; },
  restore: () => session.restore(), isLive: () => !session.isPolling,
});
let isWaiting = false;
const screen = new Screen(picture, () => preview.change());
const requests = new Requests(screen, renderByRequest, { frame: (info) => preview.took(info), problem: onProblem });
const preview = new Preview(screen, live, requests, viewOfSocket, { phase: onPhase, frame: onFrame, asked: onAsked, isNewest });
const progress = bindProgress(find("progress"), { stop: () => preview.stop(), resume: () => preview.resume() });
const brush = new Brush(scene, frameOf);
const tools = new Tools(find("tools"), brush, (name) => { root.dataset.tool = name; });
const selection = new Selection(store, find("chosen"), frameOf, onChosen);
const probe = new Probe(askProbe, onReading);
const errors = new ErrorLayer(find("errors"), find("errors-note"), askErrors, onErrors);
const hand = bindPicture(picture, { store, probe, brush, tools, selection, frameOf, cursor: find("cursor"), marker: find("marker") });
const clock = bindClock(find("play"), find("time"), {
  getTime: () => store.view.time_s ?? store.scene.time_s ?? 0,
  setTime: (time_s) => store.set(["time_s"], time_s),
});

/**
 * For scripts and browser tests. `document.documentElement.dataset.frame` is `loading` while a newer picture is due, then
 * `draft`, `full`, `error` or `stopped`; `lastFrame` is `{seq, quality, layer, width, height, bytes, backend, passes,
 * roundTrip_ms, revision}`. `dataset.errors` is the state of the layer "error" (`off`, `waiting`, `working`, `done`, `failed` or
 * `stopped`), `lastComparison` `{scale, width, height, numbers}`. `dataset.saved` is `preset`, `saved`, `saving` or `waiting`;
 * `dataset.link` is `socket`, `requests` or `lost`. `counts` only grow.
 */
window.fogbank = {
  get request() { return { ...store.view, scene: store.scene }; },
  get camera() { return frameOf().camera; },
  get id() { return scene.id; },
  get revision() { return scene.revision; },
  get chosen() { return selection.pointer; },
  set: (path, value) => store.set(path, value),
  load: loadScene,
  open: (id) => session.open(id),
  lastFrame: null,
  lastReading: null,
  lastComparison: null,
  counts: { changes: 0, frames: 0, probes: 0, comparisons: 0 },
};
const { counts } = window.fogbank;

function presetOf(id) {
  return presets.find(({ name }) => name === id);
}

/** The picture as the hand sees it. */
function frameOf() {
  const [width, height] = [picture.clientWidth || 1, picture.clientHeight || 1];
  return { camera: completeCamera(store.view.camera ?? store.scene.camera), aspect: width / height, width, height };
}

/** What a view of the socket holds, without its size. */
function viewOfSocket() {
  return { ...store.view, camera: frameOf().camera };
}

async function renderByRequest({ quality, width, height, signal }) {
  const ask = (job) => api.frame(scene.id, { ...viewOfSocket(), width, height, quality }, { accept: ACCEPT[quality], signal, job });
  progress.hide();
  const answer = await followed(ask, (far) => progress.show(quality, far)).finally(() => {
    // What was given up shows that it stopped, or a newer picture how far that is.
    if (!signal.aborted) progress.hide();
  });
  const { serverTiming, ...rest } = answer;
  return { ...rest, passes: parseServerTiming(serverTiming) };
}

function isNewest(revision) {
  return scene.isSettled && revision >= scene.latest;
}

function changed() {
  counts.changes += 1;
  errors.cancel();
  find("dark").hidden = true;
  if (refreshIsDue) return;
  refreshIsDue = true;
  requestAnimationFrame(refresh);
}

function refresh() {
  refreshIsDue = false;
  panels?.refresh();
  clock.refresh();
  selection.refresh();
  hand.refresh();
}

function onView() {
  changed();
  preview.change();
}

function onScene() {
  changed();
  preview.sceneChanged();
  preview.look();
}

/** Says whether the server has everything. */
function showSaved() {
  const pending = isWaiting ? "waiting" : "saving";
  const settled = session.isPreset ? "preset" : "saved";
  const state = scene.isSettled ? settled : pending;
  root.dataset.saved = state;
  find("saved").textContent = SAVED[state];
}

function onPending() {
  showSaved();
  keeper.keep();
  outbox.pump();
  preview.look();
  clearTimeout(historyTimer);
  if (scene.isSettled) historyTimer = setTimeout(showHistory, HISTORY_REST_MS);
}

async function showHistory() {
  const { can_undo, can_redo } = await api.history(scene.id).catch(() => ({}));
  find("undo").disabled = !can_undo;
  find("redo").disabled = !can_redo;
}

function onHello(message) {
  useRequests(false);
  root.dataset.link = "socket";
  status.clear();
  session.hello(message);
  preview.change();
  outbox.pump();
}

function onViewers(count) {
  find("viewers").hidden = count < 2;
  find("viewers").textContent = `${count} viewers`;
}

function useRequests(isOn) {
  if (isOn) root.dataset.link = "requests";
  if (session.isPolling === isOn) return;
  session.usePolls(isOn);
  preview.useRequests(isOn);
}

function onLost(retryIn_ms) {
  root.dataset.link = "lost";
  onPhase("error");
  status.show(new api.ServerLost(), retryIn_ms);
}

function onWaits(error, retryIn_ms) {
  isWaiting = true;
  showSaved();
  status.show(error, retryIn_ms);
}

/** Another scene has come: its own camera, its own panels. */
function onOpened() {
  const given = linked?.id === scene.id ? linked.view : {};
  linked = null;
  store.forget();
  store.view = { ...store.view, time_s: undefined, ...given };
  store.view.camera = completeCamera(given.camera ?? store.scene.camera);
  clock.pause();
  selection.choose(null);
  panels?.rebuild();
  onPending();
  preview.change();
}

function onMoved(id) {
  outbox.forget();
  preview.forget();
  const preset = presetOf(id);
  history.replaceState(null, "", linkOf(id, preset !== undefined));
  find("preset").value = preset ? id : "";
  find("preset-about").textContent = preset?.description ?? "";
  find("scene-id").textContent = preset ? "" : id;
}

function onMissing(id) {
  onPhase("error");
  status.show(new Error(`There is no scene ${id}. Choose a preset, or open another one.`));
}

function onPhase(name) {
  root.dataset.frame = name;
  if (name === "stopped" || name === "error") frameWatch.abort();
  if (name === "stopped") progress.stopped();
}

/** Pictures of a new view are on their way: how far they are is asked for until the full one is there. */
function onAsked(job) {
  frameWatch.abort();
  frameWatch = new AbortController();
  progress.hide();
  watch(job, frameWatch.signal, (far) => progress.show("draft", far));
}

function onFrame(info) {
  counts.frames += 1;
  const shown = { layer: store.view.layer, ...info };
  window.fogbank.lastFrame = shown;
  if (scene.isSettled && root.dataset.link !== "lost") status.clear();
  panels?.showErrors([]);
  showFacts(find("facts"), shown);
  showTimings(find("timings"), shown);
  showLegend(find("legend"), shown);
  clock.tick();
  progress.hide();
  if (info.quality !== "full") return;
  frameWatch.abort();
  probe.refresh();
  errors.start(info);
  find("dark").hidden = store.view.layer !== "beauty" || screen.brightest() > DARK || isHome();
}

const isHome = () => JSON.stringify(frameOf().camera) === JSON.stringify(completeCamera(store.scene.camera));

function onProblem(error, retryIn_ms) {
  clock.pause();
  if (retryIn_ms === undefined) onPhase("error");
  status.show(error, retryIn_ms);
  panels?.showErrors(error.errors ?? []);
}

/** The scene's own estimator against the reference; where that is its own, what `auto` would do. */
function askErrors({ width, height, signal, show }) {
  counts.comparisons += 1;
  const own = store.scene.fog?.airlight ?? "auto";
  const { camera, time_s } = viewOfSocket();
  const body = { width, height, camera, time_s, a: { airlight: own === "reference" ? "auto" : own } };
  return followed((job) => api.compare(scene.id, body, { signal, job }), show);
}

function onErrors(state, comparison) {
  root.dataset.errors = state;
  if (comparison) window.fogbank.lastComparison = comparison;
}

async function askProbe(rays) {
  counts.probes += 1;
  return api.probe(scene.id, { rays, time_s: store.view.time_s });
}

function onReading(reading) {
  window.fogbank.lastReading = reading;
  const lights = store.scene.lights ?? [];
  find("probe-hint").hidden = reading !== null;
  showReading(find("probe"), reading, lights.map((light, i) => light?.id ?? `light ${i + 1}`));
}

function onChosen() {
  const { pointer } = selection;
  find("chosen-name").textContent = selection.thing?.title ?? "";
  find("chosen-tools").hidden = !pointer;
  // The keys go on meaning the picture.
  if (pointer) panels?.reveal(pointer, false);
}

async function loadScene(next) {
  clock.pause();
  onPhase("loading");
  try {
    await session.replace(next);
  } catch (error) {
    onProblem(error);
    throw error;
  }
}

function bindPresets() {
  const select = find("preset");
  select.append(...presets.map(({ name, title }) => element("option", { value: name, textContent: title ?? name })));
  select.addEventListener("change", () => { if (select.value) session.open(select.value); });
}

function bindTools() {
  const onClick = (id, act) => find(id).addEventListener("click", act);
  onClick("reset-view", hand.goHome);
  onClick("dark-reset", hand.goHome);
  onClick("undo", () => turn("undo"));
  onClick("redo", () => turn("redo"));
  onClick("share", () => shareLink(find("share"), linkOf(scene.id, session.isPreset, viewOfSocket())));
  onClick("chosen-delete", () => selection.remove());
  onClick("chosen-frame", hand.frameChosen);
  onClick("open-keys", () => find("keys-dialog").showModal());
  onClick("open-scene", bindSceneDialog(find("scene-dialog"), { getScene: () => store.scene, loadScene }));
  onClick("open-library", bindLibrary(find("library"), {
    getId: () => scene.id,
    open: (id) => session.open(id),
    saveAs: (id) => session.saveAs(id),
    create: () => session.create({}),
  }));
  bindSave(find("save-formats"), { getId: () => scene.id, getView: () => ({ ...viewOfSocket(), ...screen.size }), failed: onProblem });
  onClick("toggle-panels", (event) => {
    const isOpen = document.body.classList.toggle("no-panels") === false;
    event.currentTarget.setAttribute("aria-expanded", String(isOpen));
  });
  document.addEventListener("keydown", onShortcut);
}

/** Undo and redo wherever the focus is, but for text that has an undo of its own. */
function onShortcut(event) {
  if (!(event.ctrlKey || event.metaKey) || event.target.closest?.("textarea, input[type=text], dialog[open]")) return;
  const key = event.key.toLowerCase();
  if (key !== "z" && key !== "y") return;
  event.preventDefault();
  turn(key === "y" || event.shiftKey ? "redo" : "undo");
}

/** Of a preset that nobody changed there is nothing to take back. */
function turn(route) {
  if (!(session.isPreset && scene.isSettled)) scene.turn(route);
}

async function start() {
  root.dataset.tool = tools.current;
  const [document, listed] = await status.untilAnswered(() => Promise.all([api.openapi(), api.presets()]));
  presets = listed;
  const schemas = new Schemas(document);
  const keepCamera = () => store.set(["scene", "camera"], structuredClone(frameOf().camera));
  panels = new Panels(find("panels"), schemas, store, { getFocus: hand.focus, keepCamera });
  const { id, view } = readLink();
  linked = { id: id ?? presets[0].name, view };
  if (view.layer) store.view.layer = view.layer;
  buildLayers(find("layers"), schemas, { store, errors });
  bindPresets();
  bindTools();
  await session.open(linked.id);
}

start().catch((error) => {
  onPhase("error");
  status.show(error);
});
