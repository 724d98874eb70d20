// Changes of a scene as JSON patches (RFC 6902), each with the patch that takes it back.

import { compare } from "./vendor/fast-json-patch/duplex.mjs";
import { pointerOf, valueAt } from "./pointer.js";

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
  if (value === undefined) return before === undefined ? nothing() : removing(scene, path);
  const guards = guardsOf(scene, path);
  if (before === undefined) {
    return { guards, patch: [{ op: "add", path: pointer, value }], inverse: [{ op: "remove", path: pointer }] };
  }
  return { guards, patch: difference(pointer, before, value), inverse: difference(pointer, value, before) };
}

/** Puts `value` into the list at `path`, in front of the entry at `index`. */
export function inserting(scene, path, index, value) {
  const pointer = pointerOf([...path, index]);
  return { guards: guardsOf(scene, path), patch: [{ op: "add", path: pointer, value }], inverse: [{ op: "remove", path: pointer }] };
}

/** Takes out what is at `path`. */
export function removing(scene, path) {
  const pointer = pointerOf(path);
  const value = structuredClone(valueAt(scene, path));
  return { guards: guardsOf(scene, path), patch: [{ op: "remove", path: pointer }], inverse: [{ op: "add", path: pointer, value }] };
}

const nothing = () => ({ guards: [], patch: [], inverse: [] });

/** Entries of lists that the path leads through must still be who they are: somebody else may have moved them. */
function guardsOf(scene, path) {
  return path.flatMap((key, depth) => {
    const id = typeof key === "number" ? valueAt(scene, path.slice(0, depth + 1))?.id : undefined;
    return id === undefined ? [] : [{ op: "test", path: pointerOf([...path.slice(0, depth + 1), "id"]), value: id }];
  });
}

const isReplace = ({ op }) => op === "replace";

/** Adds a later change to an earlier one. Of a value that is replaced again and again only the last one counts. */
export function join(earlier, later) {
  const known = (operation) => earlier.patch.find((other) => other.path === operation.path);
  if (later.patch.every(isReplace) && earlier.patch.every(isReplace) && later.patch.every(known)) {
    for (const operation of later.patch) known(operation).value = operation.value;
    return;
  }
  earlier.patch.push(...later.patch);
  earlier.inverse.unshift(...later.inverse);
}
