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

const SAID_MS = 1500;

/** Copies a link, and says so on the button. */
export async function shareLink(button, link) {
  const { href } = new URL(link, document.baseURI);
  try {
    await navigator.clipboard.writeText(href);
    button.textContent = "Copied";
    setTimeout(() => { button.textContent = "Share"; }, SAID_MS);
  } catch {
    // Away from localhost the clipboard needs https.
    window.prompt("The link to this view", href);
  }
}
