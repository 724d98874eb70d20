// Two properties that say the same quantity, such as an extinction and a visibility: one is given, and
// choosing the other converts the value. The schema says which, and what their product is.

import { element, nameAndUnit } from "./dom.js";
import { bounds, mean } from "./schema.js";

// A number that a person can read, and that keeps every pixel when it is converted back.
const DIGITS = 12;

const isGiven = (value) => value !== undefined && value !== null;

/** The one of the two keys that an object's value is given by. */
function givenKey(object, [first, second]) {
  return isGiven(object?.[second]) ? second : first;
}

/** What a property is called in the select: its name and unit. */
function textOf(key, { description }) {
  const { name, unit } = nameAndUnit(key, description);
  return unit ? `${name} ${unit}` : name;
}

/**
 * Answers the `key` of the property that is given, a `title` to choose by, `write(value)`, which leaves the other
 * property out, and `onSwitch(node, rebuild)`, which has the field built anew once the other one is given.
 */
export function bindAlternatives(form, path, schema, { keys, product, fallback }) {
  const { store, schemas } = form;
  const key = givenKey(store.get(path), keys);
  // One change instead of two: no picture is asked for in between.
  const give = (wanted, number) => {
    const others = Object.entries(store.get(path) ?? {}).filter(([name]) => !keys.includes(name));
    store.set(path, { ...Object.fromEntries(others), [wanted]: number });
  };
  const property = (name) => schemas.resolve(schema.properties[name]);
  const options = keys.map((name) => element("option", { value: name, textContent: textOf(name, property(name)) }));
  const label = options.map((option) => option.textContent).join(" or ");
  const title = element("select", { className: "alternatives", "aria-label": label }, ...options);
  title.value = key;
  title.addEventListener("change", () => {
    const [low, high] = bounds(property(title.value));
    const converted = product / mean(store.get([...path, key]) ?? fallback);
    give(title.value, Number(Math.min(Math.max(converted, low), high).toPrecision(DIGITS)));
  });
  const onSwitch = (node, rebuild) => form.bind(node, () => {
    if (givenKey(store.get(path), keys) !== key) rebuild();
  });
  return { key, title, write: (number) => give(key, number), onSwitch };
}
