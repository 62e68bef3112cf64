// Scenes of the page: a shipped scene, the changes that make it fit a page, and the values of the sliders.

export const SCENES = JSON.parse(document.getElementById("scenes").textContent);

const keys = (path) => path.replace(/^-/, "").split(".");
const isNumber = (key) => /^\d+$/.test(key);

function get(object, path) {
  return keys(path).reduce((part, key) => part?.[isNumber(key) ? Number(key) : key], object);
}

function set(object, path, value) {
  const list = keys(path);
  const last = list.pop();
  const part = list.reduce((inner, key) => inner[isNumber(key) ? Number(key) : key], object);
  part[isNumber(last) ? Number(last) : last] = path.startsWith("-") ? -value : value;
}

/** Return whether a scene is one of space, which a camera sees. */
export const isInSpace = ({ camera }) => Boolean(camera);

/** Return the fields that a scene offers: in space those that have a largest value along a line of sight. */
export const fieldsOf = (scene) => (isInSpace(scene) ? ["vorticity", "speed"] : ["vorticity", "speed", "pressure"]);

/** Return the scale of each path of a slider. */
const scalesOf = ({ scale = 1, paths }) => paths.map((_, i) => (Array.isArray(scale) ? scale[i] : scale));

/** Return the values that the scene itself gives the sliders, by their names. */
export function ownValues({ json, sliders }) {
  return Object.fromEntries(sliders.map((slider) => [slider.id, get(json, slider.paths[0]) / scalesOf(slider)[0]]));
}

/** Return the JSON of a scene with the values of sliders and placed cylinders [x, y, radius]. */
export function sceneWith(scene, values, placed) {
  const json = structuredClone(scene.json);
  const own = ownValues(scene);
  let changed = placed.length > 0;
  for (const slider of scene.sliders) {
    const value = values[slider.id];
    if (value === own[slider.id]) continue;
    changed = true;
    scalesOf(slider).forEach((scale, i) => set(json, slider.paths[i], value * scale));
  }
  if (placed.length) {
    const more = placed.map(([x, y, radius]) => ({ center: [x, y], radius }));
    json.fluid.cylinders = [...(json.fluid.cylinders ?? []), ...more];
  }
  if (changed) json.name += "-lab";
  return json;
}

/** Return the state of the page as the part of its address behind #. */
export function toHash({ scene, values, placed, field }) {
  const own = ownValues(scene);
  const parts = scene.sliders.filter(({ id }) => values[id] !== own[id]).map(({ id }) => `${id}=${short(values[id])}`);
  parts.push(...placed.map((cylinder) => `cylinder=${cylinder.map(short).join(",")}`));
  if (field !== "vorticity") parts.push(`field=${field}`);
  return `#${[scene.id, ...parts].join("&")}`;
}

const short = (value) => String(Number(value.toPrecision(4)));

/** Decode what is encoded in an address, and keep a percent sign that encodes nothing. */
function decoded(text) {
  return text.replace(/(%[0-9a-f]{2})+/gi, (found) => {
    try {
      return decodeURIComponent(found);
    } catch {
      return found;
    }
  });
}

/** Return the state that an address holds; what is unknown or out of range falls back to the scene. */
export function fromHash(hash) {
  const [id, ...parts] = decoded(hash.slice(1)).split(/[&?]/);
  const scene = SCENES.find((known) => known.id === id) ?? SCENES[0];
  const values = ownValues(scene);
  const placed = [];
  let field = "vorticity";
  for (const [key, value = ""] of parts.map((part) => part.split("="))) {
    const slider = scene.sliders.find((known) => known.id === key);
    const numbers = value.split(",").map(Number);
    if (slider && numbers[0] >= slider.min && numbers[0] <= slider.max) values[key] = numbers[0];
    if (key === "cylinder" && numbers.length === 3 && numbers.every(Number.isFinite) && !isInSpace(scene)) {
      placed.push(numbers);
    }
    if (key === "field" && fieldsOf(scene).includes(value)) field = value;
  }
  return { scene, values, placed, field };
}
