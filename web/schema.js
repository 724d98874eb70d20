// Reads the JSON schemas of the OpenAPI document: references, nullable types, tagged unions, defaults.

// Deeper chains of references than this are a loop.
const MAX_REFERENCES = 16;

/** Joins two schemas of the same value; where both speak, `b` wins. */
function merge(a, b) {
  const joined = { ...a, ...b };
  if (a.properties || b.properties) joined.properties = { ...a.properties, ...b.properties };
  if (a.required || b.required) joined.required = [...new Set([...(a.required ?? []), ...(b.required ?? [])])];
  return joined;
}

/** The fixed value of a schema (`const`, or an `enum` of one), or `undefined`. */
function fixedValue(schema) {
  if (schema.const !== undefined) return schema.const;
  return schema.enum?.length === 1 ? schema.enum[0] : undefined;
}

export class Schemas {
  #document;
  #resolved = new WeakMap();

  constructor(openapi) {
    this.#document = openapi;
  }

  /** The schema of the JSON body of `POST path`. */
  body(path) {
    return this.resolve(this.#document.paths?.[path]?.post?.requestBody?.content?.["application/json"]?.schema);
  }

  /** The sentence that describes `POST path`. */
  summary(path) {
    return this.#document.paths?.[path]?.post?.summary;
  }

  /** A named schema of the document. */
  component(name) {
    return this.resolve(this.#document.components?.schemas?.[name]);
  }

  /** A schema without `$ref`, `allOf` and null at its root: `nullable` and `refName` tell what was there. */
  resolve(schema, depth = 0) {
    if (!schema || typeof schema !== "object" || depth > MAX_REFERENCES) return {};
    if (!this.#resolved.has(schema)) this.#resolved.set(schema, this.#flatten(schema, depth + 1));
    return this.#resolved.get(schema);
  }

  #flatten(schema, depth) {
    const { $ref, allOf, ...own } = schema;
    let flat = own;
    if (allOf) flat = merge(allOf.map((part) => this.resolve(part, depth)).reduce(merge, {}), flat);
    if ($ref) flat = merge({ ...this.#lookUp($ref, depth), refName: $ref.split("/").at(-1) }, flat);
    return this.#withoutNull(flat, depth);
  }

  #lookUp(reference, depth) {
    const keys = reference.replace(/^#\//, "").split("/").map((key) => key.replaceAll("~1", "/").replaceAll("~0", "~"));
    const target = keys.reduce((node, key) => node?.[key], this.#document);
    return this.resolve(target ?? this.#document.components?.schemas?.[keys.at(-1)], depth);
  }

  #withoutNull(schema, depth) {
    if (Array.isArray(schema.type)) {
      const types = schema.type.filter((type) => type !== "null");
      const nullable = schema.nullable || types.length < schema.type.length;
      return { ...schema, type: types.length === 1 ? types[0] : types, nullable };
    }
    const list = schema.oneOf ? "oneOf" : "anyOf";
    if (!schema[list]) return schema;
    const variants = schema[list].filter((variant) => variant.type !== "null");
    const nullable = schema.nullable || variants.length < schema[list].length;
    const { [list]: _, ...rest } = schema;
    // A union of one kind stays a union: its control is the same as when more kinds come.
    const isUnion = this.tag({ oneOf: variants }) !== undefined;
    if (variants.length === 1 && !isUnion) return { ...merge(this.resolve(variants[0], depth), rest), nullable };
    return { ...rest, oneOf: variants, nullable };
  }

  /**
   * What kind of control a resolved schema asks for: `enum`, `tagged`, `choice`, `boolean`, `string`, `number`,
   * `integer`, `tuple` (a few numbers), `map` (rows of numbers), `list`, `object`, or `json` for what has no control of its own.
   */
  shape(schema) {
    if (schema["x-map"] !== undefined) return "map";
    if (this.options(schema)) return "enum";
    if (schema.oneOf) return this.tag(schema) ? "tagged" : "choice";
    if (schema.type === "array" || schema.prefixItems) return this.#arrayShape(schema);
    if (schema.type === "object" || schema.properties) return schema.properties ? "object" : "json";
    return ["boolean", "string", "number", "integer"].includes(schema.type) ? schema.type : "json";
  }

  #arrayShape(schema) {
    if (this.elements(schema)) return "tuple";
    const items = this.resolve(schema.items);
    // Rows of numbers, such as a fogmap's coefficients, are edited as text.
    return ["list", "json", "number", "integer"].includes(this.shape(items)) ? "json" : "list";
  }

  /** `[{value, description}]` of a closed list of strings, or `undefined`. */
  options(schema) {
    if (schema.enum) return schema.enum.map((value) => ({ value }));
    if (schema.const !== undefined) return [{ value: schema.const }];
    const variants = schema.oneOf?.map((variant) => this.resolve(variant));
    if (!variants?.every((variant) => typeof fixedValue(variant) === "string")) return undefined;
    return variants.map((variant) => ({ value: fixedValue(variant), description: variant.description }));
  }

  /** The element schemas of two to four numbers, or `undefined`. */
  elements(schema) {
    const size = schema.prefixItems?.length ?? (schema.minItems === schema.maxItems ? schema.maxItems : undefined);
    if (!(size >= 2 && size <= 4)) return undefined;
    const items = schema.prefixItems ?? Array(size).fill(schema.items);
    const elements = items.map((item) => this.resolve(item));
    return elements.every((item) => ["number", "integer"].includes(item.type)) ? elements : undefined;
  }

  /** The key whose fixed value tells a union's variants apart (`kind`), or `undefined`. */
  tag(schema) {
    const variants = schema.oneOf?.map((variant) => this.resolve(variant)) ?? [];
    const tags = Object.keys(variants[0]?.properties ?? {}).filter((key) =>
      variants.every((variant) => fixedValue(this.resolve(variant.properties?.[key])) !== undefined),
    );
    return tags.includes("kind") ? "kind" : tags[0];
  }

  /** The variants of a tagged union: `[{value, schema}]`, the tag taken out of each schema. */
  variants(schema) {
    const tag = this.tag(schema);
    return schema.oneOf.map((raw) => {
      const variant = this.resolve(raw);
      const { [tag]: fixed, ...properties } = variant.properties;
      const required = (variant.required ?? []).filter((key) => key !== tag);
      return { value: fixedValue(this.resolve(fixed)), schema: { ...variant, properties, required } };
    });
  }

  /** The variant of an untagged union that a value belongs to, by its JSON type; the first if none does. */
  choiceIndex(schema, value) {
    const typeOf = (json) => (Array.isArray(json) ? "array" : typeof json);
    const index = schema.oneOf.findIndex((raw) => {
      const variant = this.resolve(raw);
      const type = variant.type === "integer" ? "number" : variant.type ?? typeof fixedValue(variant);
      return type === typeOf(value);
    });
    return Math.max(index, 0);
  }

  /** A value of another variant of an untagged union: the same quantity, where both are numbers or rows of them. */
  asVariant(raw, value) {
    const variant = this.resolve(raw);
    const row = this.elements(variant);
    if (row && typeof value === "number") return row.map(() => value);
    if (variant.type === "number" && Array.isArray(value)) return mean(value);
    return this.initial(variant);
  }

  /**
   * Pairs of an object's properties that say the same quantity, each the `product` divided by the other (the keyword
   * `x-reciprocal-of`): `[{keys, product, fallback}]`, where `fallback` is the first one's value if neither is given.
   */
  reciprocals(schema) {
    return Object.keys(schema.properties ?? {}).flatMap((key) => {
      const { property, product, default: fallback } = this.resolve(schema.properties[key])["x-reciprocal-of"] ?? {};
      return schema.properties[property] ? [{ keys: [property, key], product, fallback }] : [];
    });
  }

  /** A value to begin with: the default, an example, or the plainest that the schema allows. */
  initial(raw, depth = 0) {
    const schema = this.resolve(raw);
    const given = schema.default ?? schema.examples?.[0] ?? schema.example;
    if (given !== undefined && given !== null) return structuredClone(given);
    if (depth > MAX_REFERENCES) return null;
    switch (this.shape(schema)) {
      case "enum": return this.options(schema)[0].value;
      case "tagged": return this.initialVariant(schema, this.variants(schema)[0], {}, depth);
      case "choice": return this.initial(schema.oneOf[0], depth + 1);
      case "boolean": return false;
      case "string": return "";
      case "number": case "integer": return initialNumber(schema);
      case "tuple": return this.#initialTuple(schema);
      case "object": return this.#initialObject(schema, depth);
      default: return schema.type === "object" ? {} : [];
    }
  }

  /** A value of one variant that keeps what it shares with the `previous` value. */
  initialVariant(union, { value, schema }, previous = {}, depth = 0) {
    const kept = Object.keys(schema.properties).filter((key) => key in previous);
    const shared = Object.fromEntries(kept.map((key) => [key, previous[key]]));
    return { [this.tag(union)]: value, ...this.#initialObject(schema, depth), ...shared };
  }

  #initialObject(schema, depth) {
    const required = (schema.required ?? []).filter((key) => schema.properties[key]);
    return Object.fromEntries(required.map((key) => [key, this.initial(schema.properties[key], depth + 1)]));
  }

  #initialTuple(schema) {
    const elements = this.elements(schema);
    // A direction may not be zero and a position may be anywhere: up serves both.
    if (elements.length === 3 && !this.isColour(schema) && bounds(elements[0])[0] < 0) return [0, 1, 0];
    return elements.map(initialNumber);
  }

  isColour(schema) {
    return /rgb|colou?r|albedo/i.test(`${schema.refName ?? ""} ${schema.format ?? ""}`) && this.elements(schema)?.length === 3;
  }
}

/** Where a quantity usually lies and how a slider moves there (the keyword `x-usual`): `{min, max, scale}` or `undefined`. */
export const usual = (schema) => schema["x-usual"];

// A third of three times a number is not always the number.
const MEAN_DIGITS = 12;

/** What a number, or a row of them that says the same quantity channel by channel, comes to. */
export const mean = (value) =>
  Array.isArray(value) ? Number((value.reduce((a, b) => a + b, 0) / value.length).toPrecision(MEAN_DIGITS)) : value;

/** The least and greatest value of a number; infinite where the schema names none. */
export function bounds(schema) {
  const low = schema.minimum ?? schema.exclusiveMinimum ?? -Infinity;
  const high = schema.maximum ?? schema.exclusiveMaximum ?? Infinity;
  return [low, high];
}

function initialNumber(schema) {
  if (schema.nullable) return null;
  const [low, high] = bounds(schema);
  return Math.min(Math.max(1, low), high);
}
