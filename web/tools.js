// The tools of the hand: which one is chosen, and its settings.

import { element, numberText } from "./dom.js";
import { numberInput } from "./numbers.js";

const TOOLS = [
  { name: "select", text: "Select", key: "v", title: "Choose lamps, blobs and surfaces, and drag them (V)" },
  { name: "brush", text: "Brush", key: "b", title: "Paint fog (B)" },
  { name: "eraser", text: "Eraser", key: "e", title: "Take fog away (E)" },
];
const ONTO = [{ value: "surfaces", text: "on surfaces" }, { value: "plane", text: "on a plane" }];

/** Builds the tool bar. `onChange(name)` is called when another tool is chosen. */
export class Tools {
  current = "select";
  #brush;
  #radios = new Map();
  #settings;
  #radius;
  #extinction;
  #onChange;

  constructor(bar, brush, onChange) {
    this.#brush = brush;
    this.#onChange = onChange;
    const choice = ({ name, text, title }) => {
      const radio = element("input", { type: "radio", name: "tool", value: name, checked: name === this.current });
      radio.addEventListener("change", () => this.choose(name));
      this.#radios.set(name, radio);
      return element("label", { title }, radio, element("span", { textContent: text }));
    };
    this.#radius = this.#number("radius", "m", 1e-3, 1e4, (value) => { brush.radius_m = value; });
    this.#extinction = this.#number("extinction", "1/m", 1e-6, 1e3, (value) => { brush.extinction = value; });
    const onto = element("select", { "aria-label": "Paint on", title: "Where the fog is laid" },
      ...ONTO.map(({ value, text }) => element("option", { value, textContent: text })));
    onto.addEventListener("change", () => { brush.onto = onto.value; });
    this.#settings = element("div", { className: "settings" }, this.#radius.node, this.#extinction.node, onto);
    bar.append(element("fieldset", { className: "switch" }, element("legend", { className: "unseen", textContent: "Tool" }), ...TOOLS.map(choice)), this.#settings);
    this.refresh();
  }

  #number(name, unit, minimum, maximum, write) {
    const names = { "aria-label": `Brush ${name} in ${unit}` };
    const { input, show } = numberInput({ type: "number", minimum, maximum }, names, write);
    const node = element("label", { className: "setting" }, element("span", { textContent: name }), input, element("span", { className: "unit", textContent: unit }));
    return { node, show };
  }

  choose(name) {
    this.current = name;
    this.#radios.get(name).checked = true;
    this.refresh();
    this.#onChange(name);
  }

  /** The tool of a key, if it is one's. */
  choosesBy(key) {
    const tool = TOOLS.find((tool) => tool.key === key.toLowerCase());
    if (tool) this.choose(tool.name);
    return tool !== undefined;
  }

  get paints() {
    return this.current !== "select";
  }

  /** Shows what the settings are now. */
  refresh() {
    this.#settings.hidden = !this.paints;
    this.#extinction.node.hidden = this.current === "eraser";
    this.#radius.show(Number(numberText(this.#brush.radius_m, 3)));
    this.#extinction.show(this.#brush.extinction);
  }
}
