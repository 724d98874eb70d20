// A map of numbers, seen from above: grey cells that are dragged up and down.

import { element, freshId, numberText } from "./dom.js";
import { isFocused } from "./numbers.js";

const SIDE_PX = 240;
// A drag of so many pixels takes a cell from nothing to the most.
const WHOLE_DRAG_PX = 160;
const STEP = 1 / 20;

/** Rows of numbers from 0 to the schema's `x-map`, of which larger ones count as that bright. */
export function mapControl(schemas, schema, names, onInput) {
  const most = schema["x-map"];
  const canvas = element("canvas", { className: "map", tabIndex: 0, role: "application", ...names });
  const note = element("p", { className: "note", id: freshId("note") });
  canvas.setAttribute("aria-describedby", note.id);
  let rows = [];
  let chosen = { column: 0, row: 0 };
  let drag = null;

  const at = ({ column, row }) => rows[row]?.[column] ?? 0;
  const draw = () => {
    const [columns, height] = [rows[0]?.length ?? 1, Math.max(rows.length, 1)];
    canvas.width = columns;
    canvas.height = height;
    canvas.style.aspectRatio = `${columns} / ${height}`;
    canvas.style.width = `${Math.min(SIDE_PX, (SIDE_PX * columns) / height)}px`;
    const context = canvas.getContext("2d");
    const image = context.createImageData(columns, height);
    rows.forEach((row, j) => row.forEach((value, i) => {
      const grey = 255 * Math.sqrt(Math.min(value / most, 1));
      image.data.set([grey, grey, grey, 255], 4 * (j * columns + i));
    }));
    context.putImageData(image, 0, 0);
    note.textContent = `${columns} × ${height}; column ${chosen.column + 1}, row ${chosen.row + 1}: ${numberText(at(chosen), 3)}. `
      + "Drag a cell up or down; arrow keys choose one, + and − change it.";
  };
  const put = (cell, value) => {
    const kept = Math.min(Math.max(value, 0), Math.max(most, at(cell)));
    rows = rows.map((row, j) => (j === cell.row ? row.with(cell.column, Number(kept.toFixed(4))) : row));
    draw();
    onInput(rows);
  };
  const cellUnder = (event) => {
    const box = canvas.getBoundingClientRect();
    const index = (share, count) => Math.min(Math.max(Math.floor(share * count), 0), count - 1);
    return {
      column: index((event.clientX - box.left) / box.width, rows[0]?.length ?? 1),
      row: index((event.clientY - box.top) / box.height, rows.length),
    };
  };
  canvas.addEventListener("pointerdown", (event) => {
    chosen = cellUnder(event);
    drag = { y: event.clientY, value: at(chosen) };
    canvas.setPointerCapture(event.pointerId);
    draw();
  });
  canvas.addEventListener("pointermove", (event) => {
    if (drag) put(chosen, drag.value + (most * (drag.y - event.clientY)) / WHOLE_DRAG_PX);
  });
  const drop = () => { drag = null; };
  canvas.addEventListener("pointerup", drop);
  canvas.addEventListener("pointercancel", drop);
  canvas.addEventListener("keydown", (event) => {
    const [x, y] = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[event.key] ?? [0, 0];
    const change = { "+": STEP, "=": STEP, "-": -STEP }[event.key] ?? 0;
    if (!x && !y && !change) return;
    event.preventDefault();
    const within = (place, count) => Math.min(Math.max(place, 0), count - 1);
    chosen = { column: within(chosen.column + x, rows[0]?.length ?? 1), row: within(chosen.row + y, rows.length) };
    if (change) put(chosen, at(chosen) + most * change);
    else draw();
  });
  const show = (value) => {
    if (value === rows || drag || (isFocused(canvas) && value?.length === rows.length)) return;
    rows = value ?? [];
    draw();
  };
  return { nodes: [canvas, note], show };
}
