// Saves the picture, at the size that is shown, as a file.

import * as api from "./api.js";
import { element } from "./dom.js";

const FORMATS = {
  png: { accept: "image/png", text: "PNG, as shown" },
  exr: { accept: "image/x-exr", text: "EXR, scene-linear" },
  npy: { accept: "application/x-npy", text: "NPY, optical depth", route: "optical-depth" },
};

/** Hands a file to the browser's downloads. */
export function download(blob, name) {
  const url = URL.createObjectURL(blob);
  element("a", { href: url, download: name }).click();
  setTimeout(() => URL.revokeObjectURL(url), 10_000);
}

/**
 * Fills the menu; `getView()` answers the parameters of a picture, `getId()` the scene's id, and `say(text)` tells how it
 * goes.
 */
export function bindSave(menu, { getId, getView, failed }) {
  for (const [ending, { accept, text, route }] of Object.entries(FORMATS)) {
    const item = element("button", { type: "button", textContent: text, value: ending });
    item.addEventListener("click", async () => {
      menu.closest("details").open = false;
      try {
        const { layer, exposure_ev, tonemap, ...where } = getView();
        const view = route ? where : { ...where, layer, exposure_ev, tonemap };
        const { blob } = await api.frame(getId(), view, { route, accept });
        download(blob, `${getId()}-${route ?? layer}.${ending}`);
      } catch (error) {
        failed(error);
      }
    });
    menu.append(item);
  }
}
