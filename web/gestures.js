// Mouse, touch and keyboard on the picture, told as orbit, pan, zoom, hover and tap.

const ORBIT_RAD_PER_HEIGHT = Math.PI;
const KEY_ORBIT_RAD = (5 * Math.PI) / 180;
const KEY_PAN = 0.05;
const KEY_ZOOM = 1.15;
const TAP_SLOP_PX = 6;
const WHEEL_LINE_PX = 16;

/**
 * Binds the gestures of `surface` to `actions`: `orbit(yaw_rad, pitch_rad)`, `pan(rightwards, upwards)` in
 * picture heights, `zoom(factor)`, `hover(point)`, `aim(point)` while dragging, `leave()`, `tap(point)`, `home()`,
 * `probeCentre()`; a point is `{x, y}` from 0 to 1.
 */
export function bindGestures(surface, actions) {
  bindPointers(surface, actions);
  surface.addEventListener("wheel", (event) => onWheel(event, actions), { passive: false });
  surface.addEventListener("keydown", (event) => onKey(event, actions));
  surface.addEventListener("contextmenu", (event) => event.preventDefault());
}

function pointOf(event, surface) {
  const box = surface.getBoundingClientRect();
  return { x: (event.clientX - box.left) / box.width, y: (event.clientY - box.top) / box.height };
}

function bindPointers(surface, actions) {
  /** Pointers that are down, by id: where each was last seen, in pixels. */
  const down = new Map();
  let travelled_px = 0;

  surface.addEventListener("pointerdown", (event) => {
    surface.setPointerCapture(event.pointerId);
    if (down.size === 0) travelled_px = 0;
    down.set(event.pointerId, { x: event.clientX, y: event.clientY });
  });
  surface.addEventListener("pointermove", (event) => {
    if (!down.has(event.pointerId)) {
      if (event.pointerType !== "touch") actions.hover(pointOf(event, surface));
      return;
    }
    const before = [...down.values()];
    const last = down.get(event.pointerId);
    actions.aim(pointOf(event, surface));
    travelled_px += Math.hypot(event.clientX - last.x, event.clientY - last.y);
    down.set(event.pointerId, { x: event.clientX, y: event.clientY });
    if (travelled_px > TAP_SLOP_PX) drag(before, [...down.values()], event, surface, actions);
  });
  const release = (event) => {
    const wasTap = event.type === "pointerup" && down.size === 1 && travelled_px <= TAP_SLOP_PX;
    if (down.delete(event.pointerId) && wasTap) actions.tap(pointOf(event, surface));
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
    if (spread(before) > 0 && spread(after) > 0) actions.zoom(spread(before) / spread(after));
  } else if (after.length === 1) {
    const pans = event.shiftKey || (event.buttons & 6) !== 0;
    if (pans) actions.pan(-across, down);
    else actions.orbit(-across * ORBIT_RAD_PER_HEIGHT, down * ORBIT_RAD_PER_HEIGHT);
  }
}

function onWheel(event, actions) {
  event.preventDefault();
  const delta_px = event.deltaMode === WheelEvent.DOM_DELTA_PIXEL ? event.deltaY : event.deltaY * WHEEL_LINE_PX;
  // A pinch on a touchpad arrives as small wheel steps with the control key.
  actions.zoom(Math.exp(delta_px * (event.ctrlKey ? 0.01 : 0.001)));
}

const ARROWS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
const ZOOM_KEYS = { "+": 1 / KEY_ZOOM, "=": 1 / KEY_ZOOM, "-": KEY_ZOOM, _: KEY_ZOOM };

function onKey(event, actions) {
  if (event.ctrlKey || event.metaKey || event.altKey) return;
  const arrow = ARROWS[event.key];
  if (arrow && event.shiftKey) actions.pan(arrow[0] * KEY_PAN, arrow[1] * KEY_PAN);
  else if (arrow) actions.orbit(arrow[0] * KEY_ORBIT_RAD, arrow[1] * KEY_ORBIT_RAD);
  else if (ZOOM_KEYS[event.key]) actions.zoom(ZOOM_KEYS[event.key]);
  else if (event.key === "Home") actions.home();
  else if (event.key.toLowerCase() === "p") actions.probeCentre();
  else return;
  event.preventDefault();
}
