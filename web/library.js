// Stored scenes and presets: to open, to save under another name, to delete.

import * as api from "./api.js";
import { button, element } from "./dom.js";

const PATTERN = "[a-z0-9\\-]{1,64}";
const when = (at_ms) => new Date(at_ms).toLocaleString(undefined, { dateStyle: "medium", timeStyle: "short" });

/** Binds the dialog; `getId()` answers the scene's id, `open(id)` and `saveAs(id)` do that. Answers `show()`. */
export function bindLibrary(dialog, { getId, open, saveAs, create }) {
  const find = (id) => dialog.querySelector(`#${id}`);
  const list = find("library-list");
  const message = find("library-message");
  const name = find("library-name");
  name.pattern = PATTERN;

  /** Runs a step and says what went wrong. */
  async function act(step) {
    message.textContent = "";
    try {
      await step();
    } catch (error) {
      message.textContent = error.status === 412 ? "There is a scene of that name." : error.message;
    }
  }

  function row({ id, revision, at_ms }) {
    const isOpen = id === getId();
    const openButton = button("Open", () => act(async () => { await open(id); dialog.close(); }), { className: "small", disabled: isOpen, "aria-label": `Open ${id}` });
    const remove = button("Delete", () => act(async () => {
      // Twice, for it cannot be undone.
      if (remove.textContent === "Delete") { remove.textContent = "Really delete"; return; }
      await api.remove(id);
      await refresh();
    }), { className: "small danger", disabled: isOpen, "aria-label": `Delete ${id}` });
    return element("li", {}, element("span", { className: "scene-name", textContent: id }),
      element("span", { className: "note", textContent: `revision ${revision}, ${when(at_ms)}` }), openButton, remove);
  }

  async function refresh() {
    const scenes = await api.scenes();
    const rows = scenes.sort((a, b) => b.at_ms - a.at_ms).map(row);
    list.replaceChildren(...(rows.length > 0 ? rows : [element("li", { className: "note", textContent: "No scene is stored yet. A preset becomes one with your first change." })]));
  }

  find("library-save").addEventListener("submit", (event) => {
    event.preventDefault();
    act(async () => { await saveAs(name.value); dialog.close(); });
  });
  find("library-new").addEventListener("click", () => act(async () => { await create(); dialog.close(); }));
  find("library-close").addEventListener("click", () => dialog.close());
  return () => {
    name.value = "";
    dialog.showModal();
    act(refresh);
  };
}
