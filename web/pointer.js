// JSON pointers (RFC 6901), and the values that they lead to.

/** The pointer of a list of keys. */
export function pointerOf(path) {
  return path.map((key) => `/${String(key).replaceAll("~", "~0").replaceAll("/", "~1")}`).join("");
}

/** The value behind a list of keys, or `undefined`. */
export function valueAt(root, path) {
  return path.reduce((node, key) => node?.[key], root);
}
