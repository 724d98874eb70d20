// The switch of layers.

import { element, plainDoc } from "./dom.js";

const LAYERS = ["beauty", "airlight", "optical_depth", "transmittance", "depth"];
// What the errors are errors of.
const COMPARED_LAYER = "airlight";

/** Fills `box` with the layers that the schema lists, and the errors; `errors` is their layer. */
export function buildLayers(box, schemas, { store, errors }) {
  const schema = schemas.resolve(schemas.body("/v1/render").properties?.layer);
  const options = schemas.options(schema) ?? LAYERS.map((value) => ({ value }));
  const choice = (value, description, layer) => {
    const radio = element("input", { type: "radio", name: "layer", value, checked: value === store.view.layer });
    radio.addEventListener("change", () => {
      errors.isOn = value !== layer;
      store.set(["layer"], layer);
    });
    return element("label", { title: plainDoc(description) }, radio, element("span", {}, value.replaceAll("_", " ")));
  };
  errors.describe(schemas.component("Comparison").properties);
  box.append(
    ...options.map(({ value, description }) => choice(value, description, value)),
    choice("error", schemas.summary("/v1/compare"), COMPARED_LAYER));
}
