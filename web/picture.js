// The hand on the picture: it turns the view, probes, chooses, drags and paints.

import { add, completeCamera, framing, heightAt_m, keptBeside, orbit, pan, pointAtDepthOf, rayThrough, scale, tidied, zoom } from "./camera.js";
import { putAt } from "./dom.js";
import { bindGestures } from "./gestures.js";
import { placeOf, planesOf, radiusOf, rounded } from "./places.js";

const CENTRE = { x: 0.5, y: 0.5 };
// A pivot farther away than so many times what is looked at would whirl the view around.
const PIVOT_MOST = 8;
// What is added stands this share of the way to the surface that is looked at.
const BEFORE_SURFACE = 0.85;
// A reading speaks for places as near as this, in picture sizes.
const NEAR = 0.02;
// A lamp has no size of its own: this share of the picture.
const FRAMED_SHARE = 0.15;

/**
 * Binds the hand. `frameOf()` answers `{camera, aspect, width, height}`; `cursor` shows how far the brush reaches, `marker` where
 * a finger probes. Answers `refresh()`, `focus()`, the point that is looked at, `goHome()` and `frameChosen()`.
 */
export function bindPicture(picture, { store, probe, brush, tools, selection, frameOf, cursor, marker }) {
  let pivot = null;
  let pointer = null;

  const move = (step) => {
    const { camera } = frameOf();
    store.set(["camera"], tidied(keptBeside(step(camera), camera, planesOf(store.scene))));
  };
  /** The ray of the pixel that a point lies in, so that a reading agrees with the picture. */
  const rayAt = ({ x, y }) => {
    const { camera, aspect, width, height } = frameOf();
    const centreOf = (at, size) => (Math.min(Math.max(Math.floor(at * size), 0), size - 1) + 0.5) / size;
    return rayThrough(camera, centreOf(x, width), centreOf(y, height), aspect);
  };
  /** What the newest reading met near a point. */
  const hitAt = ({ x, y }) => {
    const { point, reading } = probe.newest;
    return point && reading?.hit && Math.hypot(point.x - x, point.y - y) < NEAR ? reading.hit : null;
  };
  const along = ({ origin, direction }, distance_m) => add(origin, scale(direction, distance_m / Math.hypot(...direction)));
  /** The place in the scene that is seen at a point: on the surface there, or as deep as what is looked at. */
  const under = (point) => {
    const { camera, aspect } = frameOf();
    // Of a reading the place counts: the eye may have moved since.
    const hit = hitAt(point);
    const far_m = (place) => Math.hypot(...camera.position.map((x, i) => x - place[i]));
    if (hit && far_m(hit.point) < PIVOT_MOST * far_m(camera.target)) return hit.point;
    return pointAtDepthOf(camera, point, aspect, camera.target);
  };
  /** The point that is looked at, a little in front of the surface there. */
  const focus = async () => {
    const [reading] = await probe.ask([rayAt(CENTRE)]).catch(() => []);
    const { camera } = frameOf();
    if (!reading?.hit) return rounded(camera.target);
    return rounded(along(rayAt(CENTRE), BEFORE_SURFACE * reading.hit.distance_m));
  };
  /** Looks as the scene's own camera does. */
  const goHome = () => store.set(["camera"], completeCamera(structuredClone(store.scene.camera)));
  const frameChosen = () => {
    const { thing } = selection;
    if (!thing) return goHome();
    const place = placeOf(store.scene, thing) ?? thing.point;
    if (place) move((camera) => framing(camera, place, radiusOf(store.scene, thing) ?? FRAMED_SHARE * heightAt_m(camera, camera.target)));
  };

  function showCursor() {
    const isShown = tools.paints && pointer !== null;
    cursor.hidden = !isShown;
    if (!isShown) return;
    const { camera, height } = frameOf();
    const reach_px = (brush.radius_m / heightAt_m(camera, brush.place(pointer, hitAt(pointer), tools.current === "eraser"))) * height;
    putAt(cursor, pointer);
    cursor.style.width = cursor.style.height = `${2 * reach_px}px`;
  }

  function placeMarker(point) {
    marker.hidden = !point;
    if (point) putAt(marker, point);
  }

  function probeAt(point, isMarked) {
    pointer = point;
    placeMarker(isMarked ? point : null);
    showCursor();
    return probe.at(point);
  }

  /** What a press takes hold of. */
  function grab(point) {
    pointer = point;
    if (tools.paints) {
      brush.begin(point, hitAt(point), tools.current === "eraser");
      return { isInstant: true, move: (to) => { pointer = to; showCursor(); brush.move(to, hitAt(to)); }, end: () => brush.end() };
    }
    const thing = selection.handleAt(point);
    if (!thing?.at) return null;
    let drag = null;
    const moveTo = (to) => {
      if (!drag) {
        selection.choose(thing);
        drag = selection.drag(point);
      }
      drag(to);
    };
    return { isInstant: false, move: moveTo, end: () => {} };
  }

  async function tap(point, isTouch) {
    probeAt(point, isTouch);
    if (tools.paints) return;
    const [reading] = await probe.ask([rayAt(point)]).catch(() => []);
    selection.choose(selection.pick(point, reading?.hit ?? null));
  }

  function key(event) {
    const name = event.key.toLowerCase();
    if (name === "home") goHome();
    else if (name === "p") probeAt(CENTRE, true);
    else if (name === "f") frameChosen();
    else if (name === "delete" || name === "backspace") selection.remove();
    else if (name === "escape") selection.choose(null);
    else if (name === "[" || name === "]") resize(name === "[" ? 150 : -150);
    else return tools.choosesBy(name);
    return true;
  }

  function resize(delta_px) {
    if (!tools.paints) return false;
    brush.resize(delta_px);
    tools.refresh();
    showCursor();
    return true;
  }

  bindGestures(picture, {
    grab, tap, key, resize,
    press: (point) => { pivot = under(point); },
    orbit: (yaw_rad, pitch_rad) => move((camera) => orbit(camera, yaw_rad, pitch_rad, pivot ?? camera.target)),
    pan: (rightwards, upwards) => move((camera) => pan(camera, rightwards, upwards)),
    zoom: (factor, point) => move((camera) => zoom(camera, factor, under(point))),
    hover: (point) => probeAt(point, false),
    aim: (point) => probe.aim(point),
    leave: () => { pointer = null; placeMarker(null); showCursor(); probe.clear(); },
  });
  probe.bind(rayAt);
  return { refresh: showCursor, focus, goHome, frameChosen };
}
