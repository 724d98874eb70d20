// The page's address: which scene, and in a shared link from where it is looked at.

const VIEW = "view";

/** `{id, view}` that the address asks for; `id` is undefined where it asks for none. */
export function readLink() {
  const query = new URLSearchParams(location.search);
  const id = query.get("scene") ?? query.get("preset") ?? undefined;
  let view = {};
  try {
    view = JSON.parse(new URLSearchParams(location.hash.slice(1)).get(VIEW)) ?? {};
  } catch {
    // Somebody else's anchor.
  }
  return { id, view };
}

/** The address of a scene, and of a view of it. */
export function linkOf(id, isPreset, view) {
  const query = new URLSearchParams({ [isPreset ? "preset" : "scene"]: id });
  const hash = view ? `#${new URLSearchParams({ [VIEW]: JSON.stringify(view) })}` : "";
  return `${location.pathname}?${query}${hash}`;
}
