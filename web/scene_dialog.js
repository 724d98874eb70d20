// The scene's JSON: to read, copy, paste, load and save.

import { element } from "./dom.js";

/** JSON with rows of numbers on one line, for people. */
export function prettyJson(value) {
  const spread = JSON.stringify(value, null, 2) ?? "";
  // A line break directly after a bracket cannot be inside a string.
  return spread.replace(/\[\n[^[\]{}"]*\]/g, (row) => row.replace(/\s+/g, " ").replace("[ ", "[").replace(" ]", "]"));
}

/** Reads a scene's text; throws an error that says what is wrong. */
export function parseScene(text) {
  const scene = JSON.parse(text);
  if (scene === null || typeof scene !== "object" || Array.isArray(scene)) throw new Error("A scene is a JSON object.");
  return scene;
}

async function copyText(field) {
  try {
    await navigator.clipboard.writeText(field.value);
  } catch {
    // Away from localhost the clipboard needs https; a selection can still be copied by hand or by the browser.
    field.select();
    if (!document.execCommand("copy")) throw new Error("The clipboard is closed to this page. The text is selected.");
  }
}

function saveText(text, name) {
  const url = URL.createObjectURL(new Blob([text], { type: "application/json" }));
  element("a", { href: url, download: name }).click();
  setTimeout(() => URL.revokeObjectURL(url), 1000);
}

/** Binds the dialog; `getScene()` and `loadScene(scene)` connect it to the page. Answers `open()`. */
export function bindSceneDialog(dialog, { getScene, loadScene }) {
  const find = (id) => dialog.querySelector(`#${id}`);
  const text = find("scene-text");
  const message = find("scene-message");
  /** Runs a step of the dialog and says how it went. */
  const act = (step, done) => async () => {
    try {
      await step();
      message.textContent = done;
    } catch (error) {
      message.textContent = error.message;
    }
  };
  const onClick = (id, step, done) => find(id).addEventListener("click", act(step, done));
  const apply = () => { loadScene(parseScene(text.value)); dialog.close(); };
  const loadFile = async () => {
    const [file] = find("scene-file").files;
    if (!file) return;
    text.value = await file.text();
    find("scene-file").value = "";
    apply();
  };
  onClick("scene-copy", () => copyText(text), "Copied.");
  onClick("scene-apply", apply, "");
  onClick("scene-save", () => saveText(text.value, "scene.json"), "Saved.");
  onClick("scene-close", () => dialog.close(), "");
  onClick("scene-load", () => find("scene-file").click(), "");
  find("scene-file").addEventListener("change", act(loadFile, ""));
  return () => {
    text.value = prettyJson(getScene());
    message.textContent = "";
    dialog.showModal();
    text.focus();
    text.setSelectionRange(0, 0);
    text.scrollTop = 0;
  };
}
