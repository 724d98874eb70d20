// Changes of a scene as JSON patches (RFC 6902), each with the patch that takes it back.

import { applyOperation, applyPatch, getValueByPointer } from "./vendor/fast-json-patch/core.mjs";
import { compare } from "./vendor/fast-json-patch/duplex.mjs";
import { unescapePathComponent } from "./vendor/fast-json-patch/helpers.mjs";
import { pointerOf, valueAt } from "./pointer.js";

// What a blob is is known by all of it: it has no id.
const WITHOUT_ID = "blobs";

const isBranch = (value) => typeof value === "object" && value !== null;
// A position or a colour is one value: three operations for three numbers would say no more.
const isRow = (value) => Array.isArray(value) && value.length <= 4 && value.every((item) => !isBranch(item));

/** What leads from `before` to `after`, both at `path`. */
function difference(path, before, after) {
  if (!isBranch(before) || !isBranch(after) || Array.isArray(before) !== Array.isArray(after) || isRow(after)) {
    return [{ op: "replace", path, value: after }];
  }
  return compare(before, after).map((operation) => ({ ...operation, path: path + operation.path }));
}

/** Sets the value at `path` of a scene; `undefined` takes it out. */
export function setting(scene, path, value) {
  const before = valueAt(scene, path);
  const pointer = pointerOf(path);
  if (value === undefined) return before === undefined ? { guards: [], patch: [] } : removing(scene, path);
  const guards = guardsOf(scene, path);
  if (before === undefined) return { guards, patch: [{ op: "add", path: pointer, value }] };
  return { guards, patch: difference(pointer, before, value) };
}

/** Puts `value` into the list at `path`, in front of the entry at `index`. */
export function inserting(scene, path, index, value) {
  return { guards: guardsOf(scene, path), patch: [{ op: "add", path: pointerOf([...path, index]), value }] };
}

/** Takes out what is at `path`. */
export function removing(scene, path) {
  return { guards: guardsOf(scene, path), patch: [{ op: "remove", path: pointerOf(path) }] };
}

/** Entries of lists that the path leads through must still be what they are: somebody else may have moved them. */
function guardsOf(scene, path) {
  return path.flatMap((key, depth) => {
    if (typeof key !== "number") return [];
    const at = path.slice(0, depth + 1);
    const entry = valueAt(scene, at);
    if (path[depth - 1] === WITHOUT_ID) return [{ op: "test", path: pointerOf(at), value: structuredClone(entry) }];
    return entry?.id === undefined ? [] : [{ op: "test", path: pointerOf([...at, "id"]), value: entry.id }];
  });
}

/** What takes an operation back, to be asked before it is made; throws where it does not fit. */
function inverseOf(scene, { op, path }) {
  const at = path.lastIndexOf("/");
  const parent = getValueByPointer(scene, path.slice(0, at));
  const key = unescapePathComponent(path.slice(at + 1));
  const isInsert = op === "add" && Array.isArray(parent);
  const value = isInsert ? undefined : parent[key];
  if (op === "add") return value === undefined ? { op: "remove", path } : { op: "replace", path, value };
  if (value === undefined) throw new Error(`there is nothing at ${path}`);
  return op === "remove" ? { op: "add", path, value } : { op: "replace", path, value };
}

/**
 * Makes a patch and answers the one that takes it back; `null` where it does not fit, and then nothing has changed. Patches
 * are of operations `add`, `remove`, `replace` and `test`.
 */
export function make(scene, patch) {
  const back = [];
  try {
    for (const operation of structuredClone(patch)) {
      const inverse = operation.op === "test" ? [] : [inverseOf(scene, operation)];
      applyOperation(scene, operation);
      back.unshift(...inverse);
    }
    return back;
  } catch {
    takeBack(scene, back);
    return null;
  }
}

/** Takes a patch back by what `make` answered. */
export function takeBack(scene, back) {
  applyPatch(scene, structuredClone(back));
}

const isReplace = ({ op }) => op === "replace";

/** Adds a later patch to an earlier one. Of a value that is replaced again and again only the last one counts. */
export function join(earlier, later) {
  const known = (operation) => earlier.find((other) => other.path === operation.path);
  if (later.every(isReplace) && earlier.every(isReplace) && later.every(known)) {
    for (const operation of later) known(operation).value = structuredClone(operation.value);
  } else {
    earlier.push(...structuredClone(later));
  }
}
