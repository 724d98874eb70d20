// Foldable groups and lists. What is folded is not built: a scene may hold hundreds of thousands of values.

import { button, docNodes, element, freshId, nameAndUnit, plainDoc } from "./dom.js";
import { buildInfo, kindOptions } from "./frame.js";
import { pointerOf } from "./pointer.js";

// A longer list shows one entry at a time.
const UNFOLDED_MOST = 8;
const bodies = new WeakMap();

/** Builds what a folded group holds, if that has not happened yet. */
export function ensureBuilt(details) {
  const build = bodies.get(details);
  bodies.delete(details);
  build?.();
}

/** A `<details>` whose content is made by `fill(body)` when it first opens. */
export function buildFold(form, key, { className, title, isOpen, fill }) {
  const summary = element("summary", {}, title);
  const body = element("div", { className: "body" });
  const details = element("details", { className }, summary, body);
  bodies.set(details, () => fill(body));
  details.addEventListener("toggle", () => {
    form.open.set(key, details.open);
    if (details.open) ensureBuilt(details);
  });
  if (form.open.get(key) ?? isOpen) {
    ensureBuilt(details);
    details.open = true;
  }
  return details;
}

/** The line of a doc comment above a group's fields, and the place of the group's own errors. */
export function buildAbout(description) {
  const error = element("p", { className: "field-error", hidden: true });
  if (!description) return [error];
  return [element("p", { className: "group-about" }, ...docNodes(description)), error];
}

/** An object as a group of its fields, made by `fill(body)`. An entry of a list is folded by its list. */
export function buildGroup({ form, path, place, schema }, fill) {
  const { name } = nameAndUnit(String(place.label));
  if (place.isItem) {
    const node = element("div", { className: "item-body" }, ...buildAbout(schema.description));
    fill(node);
    return node;
  }
  return buildFold(form, pointerOf(path), {
    className: "group",
    title: element("span", { title: plainDoc(schema.description), textContent: name }),
    isOpen: false,
    fill: (body) => { body.append(...buildAbout(schema.description)); fill(body); },
  });
}

/** What an entry calls itself: its id, its kind, its number. */
function itemTitle(item, index) {
  const kind = item?.kind?.replaceAll("_", " ");
  return [item?.id, kind, ...(kind || item?.id ? [] : [`#${index + 1}`])].filter(Boolean).join(" · ");
}

/** A list with its length, its entries, and a row to add one. */
export function buildList(spot) {
  const { form, path } = spot;
  const items = form.store.get(path) ?? [];
  const isLong = items.length > UNFOLDED_MOST;
  const entries = isLong ? [buildPager(spot, items.length)] : items.map((_, i) => buildItem(spot, i));
  return element("div", { className: "list" }, ...buildListHead(spot, items.length), ...entries, buildAdd(spot));
}

/** A list's name, length and doc comment. A panel's title already says the name. */
function buildListHead({ schema, place }, length) {
  if (place.isPanel) return buildAbout(schema.description);
  const { name } = nameAndUnit(String(place.label));
  const tooltip = plainDoc(schema.description);
  const hidden = { className: "about", id: freshId("about"), hidden: true };
  const about = element("p", hidden, ...docNodes(schema.description ?? ""));
  const count = element("span", { className: "count", textContent: String(length) });
  const title = element("span", { className: "list-name", title: tooltip }, name, " ", count);
  const row = element("div", { className: "label-row" }, title, ...(tooltip ? [buildInfo(name, about, tooltip)] : []));
  return [row, about, element("p", { className: "field-error", hidden: true })];
}

function buildItem(spot, index) {
  const { form, path } = spot;
  const itemPath = [...path, index];
  const title = element("span");
  const details = buildFold(form, pointerOf(itemPath), {
    className: "item",
    title,
    isOpen: (form.store.get(path) ?? []).length === 1,
    fill: (body) => body.append(...buildItemBody(spot, index)),
  });
  form.bind(details, () => { title.textContent = itemTitle(form.store.get(itemPath), index); });
  details.dataset.pointer = pointerOf(itemPath);
  return details;
}

function buildItemBody(spot, index) {
  const { form: { schemas }, schema, path, place } = spot;
  const isTagged = schemas.shape(schemas.resolve(schema.items)) === "tagged";
  const label = isTagged ? "kind" : `${place.label} ${index + 1}`;
  const field = spot.child(schema.items, [...path, index], { label, isRequired: true, isItem: true });
  return [field, buildItemActions(spot, index)];
}

/** Changes the list's entries and shows them; which entries are open is no longer known by their index. */
function changeItems({ form, path, rebuild }, change) {
  const prefix = `${pointerOf(path)}/`;
  for (const pointer of form.open.keys()) if (pointer.startsWith(prefix)) form.open.delete(pointer);
  change(form.store);
  rebuild();
}

// Where a thing is, by the names that such properties have.
const PLACES = ["position", "center"];

/** A new value of that schema where the view looks, if it is somewhere and was nowhere `before`. */
export async function placed(form, schema, value, before = {}) {
  const place = PLACES.find((name) => schema.properties?.[name]);
  const isBox = schema.properties?.min && schema.properties?.max;
  if ((!place && !isBox) || place in before || (isBox && before.min)) return value;
  const focus = await form.getFocus();
  if (isBox) return { ...value, min: focus.map((x) => x - 0.5), max: focus.map((x) => x + 0.5) };
  return { ...value, [place]: focus };
}

function buildItemActions(spot, index) {
  const items = () => spot.form.store.get(spot.path);
  const duplicate = () => {
    const copy = structuredClone(items()[index]);
    // Ids are unique within their list.
    if (copy && typeof copy === "object") delete copy.id;
    changeItems(spot, (store) => store.insert(spot.path, index + 1, copy));
  };
  const remove = () => changeItems(spot, (store) => store.remove([...spot.path, index]));
  return element("div", { className: "actions" },
    button("Duplicate", duplicate, { className: "small" }), button("Remove", remove, { className: "small danger" }));
}

/** The row that adds an entry, of a chosen kind where there are kinds. */
function buildAdd(spot) {
  const { form, schema, path, place } = spot;
  const { schemas } = form;
  const item = schemas.resolve(schema.items);
  const variants = schemas.shape(item) === "tagged" ? schemas.variants(item) : [];
  const what = nameAndUnit(String(place.label)).name;
  const select = element("select", { "aria-label": `Kind to add to ${what}` }, ...kindOptions(variants));
  const add = async () => {
    const variant = variants[select.selectedIndex];
    const value = variant ? schemas.initialVariant(item, variant) : schemas.initial(schema.items);
    const stands = await placed(form, variant?.schema ?? item, value);
    changeItems(spot, (store) => store.insert(path, (store.get(path) ?? []).length, stands));
  };
  const addButton = button("Add", add, { className: "small", "aria-label": `Add to ${what}` });
  return element("div", { className: "add" }, ...(variants.length > 1 ? [select] : []), addButton);
}

/** One entry of a long list, and the way to the others. */
function buildPager(spot, length) {
  const { form, path, place } = spot;
  const shownKey = `${pointerOf(path)}#shown`;
  const what = nameAndUnit(String(place.label)).name;
  const label = `Entry of ${what}, 1 to ${length}`;
  const at = element("input", { type: "number", min: 1, max: length, step: 1, "aria-label": label });
  const body = element("div", { className: "body" });
  const show = (index) => {
    const shown = Math.min(Math.max(Math.round(index) || 0, 0), length - 1);
    form.open.set(shownKey, shown);
    at.value = shown + 1;
    body.replaceChildren(...buildItemBody(spot, shown));
    body.dataset.pointer = pointerOf([...path, shown]);
  };
  at.addEventListener("change", () => show(at.valueAsNumber - 1));
  const turn = (step) => () => show(form.open.get(shownKey) + step);
  const bar = element("div", { className: "pager-bar" },
    button("‹", turn(-1), { className: "icon", "aria-label": `Previous of ${what}` }), at,
    element("span", { textContent: `of ${length}` }),
    button("›", turn(1), { className: "icon", "aria-label": `Next of ${what}` }));
  const pager = element("div", { className: "pager" }, bar, body);
  pager.showIndex = show;
  show(form.open.get(shownKey) ?? 0);
  return pager;
}
