// The page: scenes, controls and curves around the simulation in the worker.

import { FIELDS, colours, gradient, packed } from "lab/colours";
import { Picture } from "lab/draw";
import { History, measure, plot } from "lab/plot";
import { SCENES, fieldsOf, fromHash, isInSpace, ownValues, sceneWith, toHash } from "lab/scenes";

const BUDGET = 20; // Time for the steps of a frame, ms: with painting it leaves 30 frames a second
const MOST_STEPS = 400; // In a frame
const WINDOW = 4000; // Steps that the curves show
const CYLINDER = 0.08; // Radius of a placed cylinder, by the height of the picture
const GRAB = 28; // Distance from a rod within which it can be pulled, pixels
const TURN = 0.008; // Angle by which a pixel turns the view of space, rad
const KEY_TURN = 0.12; // Angle by which a key turns it, rad
const STEEPEST = 1.4; // Largest angle of the camera above or below the horizon, rad

const of = (id) => document.getElementById(id);
const [flow, picture] = [of("flow"), new Picture(of("flow"))];
const darkness = matchMedia("(prefers-color-scheme: dark)");

// The worker, which answers requests in their order.

const source = new Blob([of("worker").textContent], { type: "text/javascript" });
const worker = new Worker(URL.createObjectURL(source));
const waiting = new Map();
let requests = 0;

worker.onmessage = ({ data: { id, answer, error } }) => {
  const { resolve, reject } = waiting.get(id);
  waiting.delete(id);
  if (error === undefined) resolve(answer);
  else reject(new Error(error));
};

function ask(type, content = {}) {
  return new Promise((resolve, reject) => {
    waiting.set(++requests, { resolve, reject });
    worker.postMessage({ id: requests, type, ...content });
  });
}

// What is simulated.

let state = fromHash(location.hash);
let about = null; // Facts, columns and numbers of the running scene
let history = new History(3, WINDOW);
let json = null; // The running scene
let running = !matchMedia("(prefers-reduced-motion: reduce)").matches;
let failed = false;
let pull = null; // {rod, station, to}: what the mouse or a key holds
let placing = null; // {to, radius}: a cylinder that is being drawn
let camera = null; // Angles from which space is seen, rad; null in a plane
let viewed = null; // The scene that the camera belongs to
let turning = null; // {x, y, camera}: where the mouse began to turn it
let speed = { frames: 0, since: 0, fps: 0, steps: 0, seconds: 0, ms: 0 };

const U = () => about?.facts?.dimensionless?.velocity || 1;
const L = () => about?.facts?.dimensionless?.length || 1;
const isReference = () => Boolean(json?.reference) && !json.name.endsWith("-lab");

function fail(error) {
  failed = true;
  of("failure").textContent = `The simulation stopped: ${error.message}. Change a value back, or restart.`;
  of("failure").hidden = false;
}

function tell(text) {
  of("status").textContent = text;
}

/** The scene for the worker, and the one whose numbers are shown: placed cylinders give no lengths. */
function texts() {
  const [scene, known] = [json, sceneWith(state.scene, state.values, [])].map((value) => JSON.stringify(value));
  return { scene, known };
}

async function load() {
  runs += 1;
  failed = false;
  pull = turning = null;
  if (viewed !== state.scene) [viewed, camera] = [state.scene, state.scene.camera ?? null];
  ready?.bitmap?.close();
  ready = null; // Of the scene before
  json = sceneWith(state.scene, state.values, state.placed);
  try {
    about = await ask("load", texts());
    of("failure").hidden = true;
  } catch (error) {
    return fail(error);
  }
  history = new History(about.columns, WINDOW);
  [shown, places] = [null, null];
  showScene();
  await look();
  await next(true);
}

/** Go on from the present flow with other values; start again where that cannot be. */
async function change(restart) {
  remember();
  if (restart || failed) return load();
  json = sceneWith(state.scene, state.values, state.placed);
  try {
    about = { ...about, ...(await ask("change", texts())) };
  } catch (error) {
    return fail(error);
  }
  showNumbers();
  return look();
}

function remember() {
  window.history.replaceState(null, "", toHash(state));
  of("clear").hidden = state.placed.length === 0;
}

// Frames.

let ready = null; // The last answer, not drawn yet
let isAsked = false;
let runs = 0; // Scenes loaded: a frame of an earlier one is not shown

async function next(still = false) {
  if (isAsked || failed) return;
  isAsked = true;
  const [run, share] = [runs, of("pace").value / 100];
  const steps = still ? 0 : share === 1 ? MOST_STEPS : Math.round(60 ** share);
  let frame = null;
  try {
    frame = await ask("frame", { steps, budget: BUDGET });
  } catch (error) {
    if (run === runs) fail(error);
  }
  isAsked = false;
  if (run === runs) {
    ready = frame;
    requestAnimationFrame(show);
  } else {
    frame?.bitmap.close();
    next(!running);
  }
}

function show(now) {
  if (!ready) return;
  const frame = ready;
  ready = null;
  if (running) next();
  history.add(frame.rows);
  shown?.bitmap.close();
  const { x, y, z } = json.fluid.box;
  const directions = z && frame.directions; // The worker may still have the camera of a scene before
  shown = { ...frame, directions, circles: circlesOf(frame.rows), mesh: about.facts?.wing, ends: [x, y, z] };
  shapes = frame.shapes;
  draw();
  count(now, frame);
}

let shown = null; // The frame on the canvas
let shapes = [];

function draw() {
  if (!shown) return;
  picture.draw({ ...shown, thicknesses: thicknesses(), marks: marksOf(shown.shapes), dark: darkness.matches });
}

function count(now, { made, seconds }) {
  speed.frames += 1;
  [speed.steps, speed.seconds] = [speed.steps + made, speed.seconds + seconds];
  if (now - speed.since > 500) {
    speed.fps = (1000 * speed.frames) / (now - speed.since);
    speed.ms = speed.steps ? (1000 * speed.seconds) / speed.steps : 0;
    speed.rate = (speed.steps * json.time.communication_step * 1000) / (now - speed.since);
    speed = { ...speed, frames: 0, steps: 0, seconds: 0, since: now };
    showCurves();
    showNumbers();
  }
  const t = history.length ? history.at(history.length - 1, 0) : 0;
  of("clock").textContent = `t = ${t.toFixed(2)} ${unitOfTime()}`;
}

const unitOfTime = () => (isMetric() ? "s" : json.display?.time ?? "");
const isMetric = () => Boolean(json.fluid.channel);

let places = null; // Of the bodies, after the last step

function circlesOf(rows) {
  if (isInSpace(state.scene)) return [];
  const bodies = json.fluid.bodies ?? [];
  const last = rows.length && bodies.length ? rows.subarray(-2 * bodies.length) : places;
  places = last;
  const moving = bodies.map(({ shape, position }, k) => {
    const [x, y] = last ? last.subarray(2 * k, 2 * k + 2) : position;
    return [x, y, shape.circle.radius];
  });
  return [...(json.fluid.cylinders ?? []).map(({ center, radius }) => [...center, radius]), ...moving];
}

const beams = () => (json.rods ? json.rods.map(({ beam }) => beam) : json.beam ? [json.beam] : []);
const thicknesses = () => beams().map(({ thickness }) => (typeof thickness === "number" ? thickness : 0.02));

function marksOf(frameShapes) {
  const marks = [];
  if (pull && frameShapes[pull.rod]) {
    const [xs, ys] = frameShapes[pull.rod];
    marks.push({ from: [xs[pull.station], ys[pull.station]], to: pull.to, radius: 0 });
  }
  if (placing) marks.push(placing);
  return marks;
}

/** Tell the worker what to paint: ranges grow with the speed of the flow. */
function look() {
  const isSpace = isInSpace(state.scene);
  picture.fit(state.scene.part, isSpace);
  draw(); // A canvas of another size is empty
  const list = colours(isSpace && state.field === "vorticity" ? "swirl" : state.field, darkness.matches);
  const { density } = json.fluid;
  const [low, high, unit] = {
    vorticity: isSpace ? [0, 4 * (U() / L()), "1/s"] : [-8 * (U() / L()), 8 * (U() / L()), "1/s"],
    speed: [0, 1.8 * U(), "m/s"],
    pressure: [-0.8 * density * U() ** 2, 0.8 * density * U() ** 2, "Pa"],
  }[state.field];
  of("colours").style.background = gradient(list);
  of("low").textContent = number(low);
  of("high").textContent = `${number(high)}${isMetric() ? ` ${unit}` : ""}`;
  const pixels = picture.pixels(isSpace);
  const view = { field: FIELDS.indexOf(state.field), range: [low, high], part: picture.part, pixels };
  const sent = ask("view", { view: { ...view, camera, colours: packed(list) } });
  if (!running) sent.then(() => next(true));
  return sent;
}

// Texts, numbers and curves.

function number(value, digits = 3) {
  if (value !== 0 && Math.abs(value) < 1e-3) {
    const [digitsOf, power] = value.toExponential(digits - 1).split("e");
    const raised = [...power].map((letter) => "⁰¹²³⁴⁵⁶⁷⁸⁹"[letter] ?? "⁻").join("");
    return `${Number(digitsOf)} × 10${raised}`.replace("-", "−");
  }
  return String(Number(value.toPrecision(digits))).replace("-", "−");
}

function showScene() {
  of("about-title").textContent = state.scene.title;
  of("about").textContent = state.scene.about;
  of("scene").value = state.scene.id;
  const places = "Choose “Place a cylinder” and click, or drag for its size; arrow keys and Enter do the same.";
  const pulls = beams().length ? "Drag the rod to pull it, or focus the picture and hold an arrow key. " : "";
  const isSpace = isInSpace(state.scene);
  of("hint").textContent = isSpace
    ? "Drag the picture to see it from another side, or focus it and press the arrow keys." : `${pulls}${places}`;
  of("tools").hidden = isSpace;
  flow.classList.toggle("place", !isSpace && tool() === "place");
  const hasMotion = state.scene.quantity !== "lift";
  for (const part of ["motion", "motion-title", "motion-text"]) of(part).hidden = !hasMotion;
  for (const input of document.querySelectorAll("[name=field]")) {
    input.checked = input.value === state.field;
    input.parentElement.hidden = !fieldsOf(state.scene).includes(input.value);
  }
  showSliders();
  remember();
}

function showSliders() {
  of("sliders").replaceChildren(...state.scene.sliders.map((slider) => {
    const { id, label, unit, help, min, max, log, restart } = slider;
    const [place, value] = log
      ? [(v) => Math.log(v / min) / Math.log(max / min), (p) => min * (max / min) ** p]
      : [(v) => (v - min) / (max - min), (p) => min + (max - min) * p];
    const box = document.createElement("div");
    box.className = "slider";
    box.innerHTML = `<label for="s-${id}"><span></span><output for="s-${id}"></output></label>
      <input id="s-${id}" type="range" min="0" max="1000" aria-describedby="h-${id}"><small id="h-${id}"></small>`;
    const [input, output] = [box.querySelector("input"), box.querySelector("output")];
    box.querySelector("span").textContent = label;
    box.querySelector("small").textContent = help;
    const write = () => {
      output.textContent = `${number(state.values[id])} ${unit}`.trim();
      input.setAttribute("aria-valuetext", output.textContent);
    };
    input.value = 1000 * place(state.values[id]);
    write();
    input.addEventListener("input", () => {
      state.values[id] = Number(value(input.value / 1000).toPrecision(3));
      write();
      later(restart);
    });
    return box;
  }));
}

let timer = 0;
function later(restart) {
  clearTimeout(timer);
  timer = setTimeout(() => change(restart), 120);
}

/** Curves of the motion: their columns, and the factor in which they are shown. */
function motions() {
  const { quantity } = state.scene;
  if (quantity === "twist") return [{ column: history.columns - 1, scale: 180 / Math.PI, name: "--curve" }];
  const [first, count] = quantity === "body_y" ? [history.columns - 1, 1] : [4, about.count];
  const scale = isMetric() ? 1000 : 1;
  const names = ["--curve", "--second"];
  return Array.from({ length: count }, (_, i) => ({ column: first + 2 * i, scale, name: names[i % 2] }));
}

const lengthUnit = () => (isMetric() ? "mm" : state.scene.length ?? "lengths");

/** What moves, the title of its curve, and its unit. */
function motionTexts() {
  const { quantity } = state.scene;
  if (quantity === "twist") return ["Twist", "Twist at three quarters of the span (degrees)", "degrees"];
  const what = quantity === "body_y" ? "Cylinder" : "Tip";
  return [what, `${what}, displacement across the stream (${lengthUnit()})`, lengthUnit()];
}

/** Published mean, amplitude, frequency and range of the amplitude of a quantity; null for other values. */
function published(name) {
  if (!isReference()) return null;
  const { quantities, spread } = json.reference;
  return quantities?.[name] && { ...quantities[name], range: spread?.quantities?.[name]?.amplitude };
}

function bandsOf(name, scale) {
  const known = published(name);
  if (!known?.range) return [];
  const [low, high] = known.range;
  const band = (sign) => [low, high].map((a) => (known.mean + sign * a) * scale).sort((a, b) => a - b);
  return [band(1), band(-1)];
}

function spoken({ mean, amplitude, frequency, frequency_hz: f = frequency }, scale, unit) {
  const size = `${number(mean * scale)} ± ${number(amplitude * scale)} ${unit}`.trim();
  return f ? `${size} at ${number(f)} ${isMetric() ? "Hz" : "per unit of time"}` : size;
}

function sentence(what, column, name, scale, unit) {
  const found = measure(history, column);
  if (!found) return "";
  const known = published(name);
  const here = `${what}: ${spoken(found, scale, unit)}${found.frequency ? "" : ", not periodic yet"}.`;
  return known ? `${here} Published: ${spoken(known, scale, unit)}.` : here;
}

function showCurves() {
  const unit = unitOfTime();
  const forceUnit = isMetric() ? "N/m" : "";
  if (state.scene.quantity !== "lift" && about.columns > 3) {
    const curves = motions();
    plot(of("motion"), history, curves, bandsOf("tip_uy", curves[0].scale), unit);
    const [what, title, motionUnit] = motionTexts();
    of("motion-title").textContent = title;
    of("motion-text").textContent = sentence(what, curves[0].column, "tip_uy", curves[0].scale, motionUnit);
    of("motion").setAttribute("aria-label", of("motion-text").textContent || what);
  }
  const isSpace = isInSpace(state.scene);
  const across = isSpace ? 3 : 1; // In hovering the wing is dragged to and fro along z
  const dashed = { column: across, scale: 1, name: "--second", dash: [6, 4] };
  const forces = [{ column: 2, scale: 1, name: "--curve" }, dashed];
  plot(of("force"), history, forces, bandsOf("lift", 1), unit);
  const drag = isSpace ? "force along the stroke" : "drag";
  of("force-title").textContent = `Lift, and ${drag} dashed${forceUnit ? ` (${forceUnit})` : ""}`;
  of("force-text").textContent = sentence("Lift", 2, "lift", 1, forceUnit);
  of("force").setAttribute("aria-label", of("force-text").textContent || `Lift and ${drag}`);
}

function showNumbers() {
  const { dimensionless: facts } = about.facts ?? {};
  if (!facts) return;
  const isSpace = isInSpace(state.scene);
  const column = state.scene.quantity === "lift" ? 2 : motions()[0]?.column ?? 2;
  const found = history.length > 20 ? measure(history, column) : null;
  const f = found?.frequency;
  const rows = [
    ["Reynolds number", facts.reynolds],
    ["Reduced frequency πfL/U", isSpace ? facts.reduced_frequency : null],
    ["Mass ratio μ/(ρL)", facts.mass_ratio],
    ["Mass by displaced fluid", facts.density_ratio],
    [isSpace ? "Stiffness D/(ρU²L³)" : "Stiffness EI/(ρU²L³)", facts.stiffness],
    ["Strouhal number fL/U", f && !isSpace ? (f * L()) / U() : null],
    ["of the motion, 2Af/U", f && !isSpace && state.scene.quantity !== "lift" ? (2 * found.amplitude * f) / U() : null],
    ["Cells", about.cells.join(" × ")],
    ["Time step", json.time.communication_step],
    ["A step takes", speed.ms ? `${number(speed.ms, 2)} ms` : null],
    ["Frames a second", speed.fps ? Math.round(speed.fps) : null],
  ];
  const shown = rows.filter(([, value]) => value !== null && value !== undefined);
  of("numbers").replaceChildren(...shown.map(([name, value]) => {
    const [row, dt, dd] = ["div", "dt", "dd"].map((tag) => document.createElement(tag));
    dt.textContent = name;
    dd.textContent = typeof value === "number" ? number(value) : value;
    row.append(dt, dd);
    return row;
  }));
}

// Mouse and keys on the picture.

const tool = () => document.querySelector("[name=tool]:checked").value;

function nearest([x, y]) {
  let best = { distance: Infinity };
  shapes.forEach(([xs, ys], rod) => xs.forEach((px, station) => {
    const distance = Math.hypot(px - x, ys[station] - y);
    if (distance < best.distance) best = { rod, station, distance };
  }));
  return best;
}

/** Stiffness of the spring with which the mouse pulls: stiffer than the rod, and strong beside the flow. */
function springStiffness() {
  const { density } = json.fluid;
  return density * U() ** 2 * Math.max(1, 3 * (about.facts.dimensionless.stiffness ?? 0));
}

function setPull(to) {
  pull = to;
  const { rod = 0, station = 0, to: [x, y] = [0, 0] } = to ?? {};
  ask("pull", { rod, station, x, y, stiffness: to ? springStiffness() : 0 });
}

function place(to, radius) {
  const clear = nearest(to).distance > radius + 0.02 * L();
  if (!clear) return tell("A cylinder cannot cover a rod.");
  state.placed.push([...to, radius].map((value) => Number(value.toPrecision(3))));
  tell("A cylinder was placed.");
  return change(false);
}

let isTurned = false; // Whether the next frame will be seen from another side

/** See space from other angles (rad) from the next frame on. */
function turn([around, above]) {
  camera = [around, Math.min(Math.max(above, -STEEPEST), STEEPEST)];
  if (isTurned) return;
  isTurned = true;
  requestAnimationFrame(() => {
    isTurned = false;
    if (camera) look();
  });
}

const standard = () => CYLINDER * (picture.part[3] - picture.part[2]);

flow.addEventListener("pointerdown", (event) => {
  const to = picture.toMetres(event);
  flow.setPointerCapture(event.pointerId);
  if (camera) {
    turning = { x: event.clientX, y: event.clientY, camera };
  } else if (tool() === "place") {
    placing = { to, radius: standard() };
  } else {
    const { rod, station, distance } = nearest(to);
    if (distance * (flow.clientWidth / (picture.part[1] - picture.part[0])) < GRAB) setPull({ rod, station, to });
  }
});
flow.addEventListener("pointermove", (event) => {
  const to = picture.toMetres(event);
  if (pull) setPull({ ...pull, to });
  if (turning) {
    const [x, y] = [event.clientX - turning.x, event.clientY - turning.y];
    turn([turning.camera[0] - TURN * x, turning.camera[1] + TURN * y]);
  }
  if (placing && event.buttons) {
    const radius = Math.hypot(to[0] - placing.to[0], to[1] - placing.to[1]);
    if (radius > 0.3 * standard()) placing.radius = Math.min(radius, 4 * standard());
  }
});
for (const end of ["pointerup", "pointercancel"]) {
  flow.addEventListener(end, () => {
    if (pull) setPull(null);
    if (placing && end === "pointerup") place(placing.to, placing.radius);
    placing = turning = null;
  });
}

const ARROWS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
let cursor = null;

flow.addEventListener("keydown", (event) => {
  const arrow = ARROWS[event.key];
  const [left, right, bottom, top] = picture.part;
  if (camera && arrow) {
    turn(camera.map((angle, i) => angle + KEY_TURN * arrow[i]));
  } else if (!camera && tool() === "place" && (arrow || event.key === "Enter")) {
    cursor ??= [(left + right) / 2, (bottom + top) / 2];
    if (arrow) cursor = cursor.map((at, axis) => at + 0.04 * (top - bottom) * arrow[axis]);
    placing = event.key === "Enter" ? null : { to: cursor, radius: standard() };
    if (event.key === "Enter") place(cursor, standard());
  } else if (arrow && !camera && shapes.length) {
    const [xs, ys] = shapes[0];
    const station = xs.length - 1;
    const to = [xs, ys].map((list, axis) => list[station] + 0.25 * (top - bottom) * arrow[axis]);
    setPull({ rod: 0, station, to });
  } else if (event.key === " ") {
    of("run").click();
  } else {
    return;
  }
  event.preventDefault();
});
flow.addEventListener("keyup", (event) => {
  if (pull && ARROWS[event.key]) setPull(null);
});
flow.addEventListener("blur", () => {
  if (pull) setPull(null);
  placing = null;
});

// Buttons.

function download(blob, name) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}

function showRunning() {
  of("run").textContent = running ? "Pause" : "Run";
}

of("run").addEventListener("click", () => {
  running = !running;
  showRunning();
  if (running) next();
});
of("restart").addEventListener("click", load);
of("reset").addEventListener("click", () => {
  state.values = ownValues(state.scene);
  showSliders();
  change(state.scene.sliders.some(({ restart }) => restart));
});
of("clear").addEventListener("click", () => {
  state.placed = [];
  change(false);
});
of("png").addEventListener("click", () => flow.toBlob((blob) => download(blob, `${json.name}.png`)));
of("json").addEventListener("click", () => {
  const { $schema, ...scene } = json;
  download(new Blob([JSON.stringify(scene, null, 2)], { type: "application/json" }), `${json.name}.json`);
});
of("link").addEventListener("click", async () => {
  try {
    await navigator.clipboard.writeText(location.href);
    tell("The link was copied.");
    of("link").textContent = "Copied";
  } catch {
    of("link").textContent = "See the address";
  }
  setTimeout(() => { of("link").textContent = "Copy link"; }, 1500);
});

let recorder = null;
of("clip").hidden = !window.MediaRecorder || !flow.captureStream;
of("clip").addEventListener("click", () => {
  if (recorder) return recorder.stop();
  const type = ["video/webm;codecs=vp9", "video/webm", "video/mp4"].find((kind) => MediaRecorder.isTypeSupported(kind));
  const parts = [];
  recorder = new MediaRecorder(flow.captureStream(30), { mimeType: type, videoBitsPerSecond: 6e6 });
  recorder.ondataavailable = ({ data }) => parts.push(data);
  recorder.onstop = () => {
    download(new Blob(parts, { type }), `${json.name}.${type.includes("mp4") ? "mp4" : "webm"}`);
    recorder = null;
    of("clip").textContent = "Record clip";
    of("clip").setAttribute("aria-pressed", "false");
  };
  recorder.start();
  of("clip").textContent = "Stop recording";
  of("clip").setAttribute("aria-pressed", "true");
  return undefined;
});

of("scene").replaceChildren(...SCENES.map(({ id, title }) => new Option(title, id)));
of("scene").addEventListener("change", ({ target }) => {
  const { field } = state;
  state = fromHash(`#${target.value}`);
  if (fieldsOf(state.scene).includes(field)) state.field = field;
  load();
});
of("fields").append(...FIELDS.map((name) => {
  const label = document.createElement("label");
  const shownName = name[0].toUpperCase() + name.slice(1);
  label.innerHTML = `<input type="radio" name="field" value="${name}"><span>${shownName}</span>`;
  label.firstChild.addEventListener("change", () => {
    state.field = name;
    remember();
    look();
  });
  return label;
}));
for (const input of document.querySelectorAll("[name=tool]")) {
  input.addEventListener("change", () => flow.classList.toggle("place", tool() === "place"));
}
of("pace").addEventListener("input", () => running && next());
window.addEventListener("hashchange", () => {
  state = fromHash(location.hash);
  load();
});
let width = 0;
new ResizeObserver(() => {
  if (!json || flow.clientWidth === width) return;
  width = flow.clientWidth;
  look();
}).observe(flow.parentElement);
darkness.addEventListener("change", () => look());

/** For the console and tests: step the running scene, and return the samples of these steps, row after row. */
globalThis.lab = {
  ask,
  place,
  scene: () => about && json,
  step: async (steps) => {
    const run = runs;
    const { rows, bitmap } = await ask("frame", { steps, budget: Infinity });
    bitmap?.close();
    if (run === runs) history.add(rows);
    return rows;
  },
  draw: () => next(true),
  part: () => picture.part,
  camera: () => camera,
  shapes: () => shapes,
  pause: () => running && of("run").click(),
  restart: load,
  speed: () => speed,
};

showRunning();
const packedProgram = Uint8Array.from(atob(of("wasm").textContent), (letter) => letter.charCodeAt(0));
const program = new Blob([packedProgram]).stream().pipeThrough(new DecompressionStream("gzip"));
await ask("start", { bytes: await new Response(program).arrayBuffer() });
await load();
if (running) next();
