// Mouse, touch and keyboard on the picture, told as grab, orbit, pan, zoom, hover and tap.

const ORBIT_RAD_PER_HEIGHT = Math.PI;
const KEY_ORBIT_RAD = (5 * Math.PI) / 180;
const KEY_PAN = 0.05;
const KEY_ZOOM = 1.15;
const TAP_SLOP_PX = 6;
const WHEEL_LINE_PX = 16;
const PAN_BUTTONS = 2 | 4;
const CENTRE = { x: 0.5, y: 0.5 };

/**
 * Binds the gestures of `surface` to `actions`: `grab(point)` answers `{move(point), end(), isInstant}` where a drag from there
 * moves or paints something, and nothing where it turns the view; `press(point)` before a view is turned; `orbit(yaw_rad,
 * pitch_rad)`, `pan(rightwards, upwards)` in picture heights, `zoom(factor, point)`, `resize(delta_px)` answers whether the wheel
 * means a tool, `hover(point)`, `aim(point)` while dragging, `leave()`, `tap(point)`, and `key(event)`, which answers whether it
 * knew the key; a point is `{x, y}` from 0 to 1.
 */
export function bindGestures(surface, actions) {
  bindPointers(surface, actions);
  surface.addEventListener("wheel", (event) => onWheel(event, surface, actions), { passive: false });
  surface.addEventListener("keydown", (event) => onKey(event, actions));
  surface.addEventListener("contextmenu", (event) => event.preventDefault());
}

function pointOf({ x, y }, surface) {
  const box = surface.getBoundingClientRect();
  return { x: (x - box.left) / box.width, y: (y - box.top) / box.height };
}

const pixelOf = (event) => ({ x: event.clientX, y: event.clientY });
const turnsView = (event) => event.altKey || event.shiftKey || (event.buttons & PAN_BUTTONS) !== 0;

function bindPointers(surface, actions) {
  /** Pointers that are down, by id: where each was last seen, in pixels. */
  const down = new Map();
  let travelled_px = 0;
  /** What is dragged or painted with, if the view is not. */
  let held = null;
  const letGo = () => {
    held?.end();
    held = null;
  };

  surface.addEventListener("pointerdown", (event) => {
    surface.setPointerCapture(event.pointerId);
    const point = pointOf(pixelOf(event), surface);
    if (down.size === 0) travelled_px = 0;
    down.set(event.pointerId, pixelOf(event));
    // A second finger means the view.
    if (down.size > 1) return letGo();
    held = turnsView(event) ? null : actions.grab(point);
    if (!held) actions.press(point);
  });
  surface.addEventListener("pointermove", (event) => {
    const point = pointOf(pixelOf(event), surface);
    if (!down.has(event.pointerId)) {
      if (event.pointerType !== "touch") actions.hover(point);
      return;
    }
    const before = [...down.values()];
    const last = down.get(event.pointerId);
    actions.aim(point);
    travelled_px += Math.hypot(event.clientX - last.x, event.clientY - last.y);
    down.set(event.pointerId, pixelOf(event));
    if (held && (held.isInstant || travelled_px > TAP_SLOP_PX)) held.move(point);
    else if (!held && travelled_px > TAP_SLOP_PX) drag(before, [...down.values()], event, surface, actions);
  });
  const release = (event) => {
    const isTap = event.type === "pointerup" && down.size === 1 && travelled_px <= TAP_SLOP_PX && !held?.isInstant;
    letGo();
    if (down.delete(event.pointerId) && isTap) actions.tap(pointOf(pixelOf(event), surface), event.pointerType === "touch");
  };
  surface.addEventListener("pointerup", release);
  surface.addEventListener("pointercancel", release);
  surface.addEventListener("pointerleave", (event) => {
    // A finger leaves whenever it is lifted; what it tapped stays probed.
    if (event.pointerType !== "touch") actions.leave();
  });
}

const midpoint = ([a, b]) => ({ x: (a.x + b.x) / 2, y: (a.y + b.y) / 2 });
const spread = ([a, b]) => Math.hypot(a.x - b.x, a.y - b.y);

/** One step of a drag: one pointer orbits (or pans), two pan by their midpoint and zoom by their spread. */
function drag(before, after, event, surface, actions) {
  const height_px = surface.clientHeight || 1;
  const twoFingers = after.length === 2;
  const [from, to] = twoFingers ? [midpoint(before), midpoint(after)] : [before[0], after[0]];
  const across = (to.x - from.x) / height_px;
  const down = (to.y - from.y) / height_px;
  if (twoFingers) {
    actions.pan(-across, down);
    if (spread(before) > 0 && spread(after) > 0) actions.zoom(spread(before) / spread(after), pointOf(to, surface));
  } else if (after.length === 1) {
    const pans = event.shiftKey || (event.buttons & PAN_BUTTONS) !== 0;
    if (pans) actions.pan(-across, down);
    else actions.orbit(-across * ORBIT_RAD_PER_HEIGHT, down * ORBIT_RAD_PER_HEIGHT);
  }
}

function onWheel(event, surface, actions) {
  event.preventDefault();
  // With the shift key the wheel turns sideways.
  const delta = event.deltaY || event.deltaX;
  const delta_px = event.deltaMode === WheelEvent.DOM_DELTA_PIXEL ? delta : delta * WHEEL_LINE_PX;
  if (!event.ctrlKey && !event.shiftKey && actions.resize(delta_px)) return;
  // A pinch on a touchpad arrives as small wheel steps with the control key.
  actions.zoom(Math.exp(delta_px * (event.ctrlKey ? 0.01 : 0.001)), pointOf(pixelOf(event), surface));
}

const ARROWS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
const ZOOM_KEYS = { "+": 1 / KEY_ZOOM, "=": 1 / KEY_ZOOM, "-": KEY_ZOOM, _: KEY_ZOOM };

function onKey(event, actions) {
  if (event.ctrlKey || event.metaKey || event.altKey) return;
  const arrow = ARROWS[event.key];
  if (arrow && event.shiftKey) actions.pan(arrow[0] * KEY_PAN, arrow[1] * KEY_PAN);
  else if (arrow) {
    actions.press(CENTRE);
    actions.orbit(arrow[0] * KEY_ORBIT_RAD, arrow[1] * KEY_ORBIT_RAD);
  } else if (ZOOM_KEYS[event.key]) actions.zoom(ZOOM_KEYS[event.key], CENTRE);
  else if (!actions.key(event)) return;
  event.preventDefault();
}
