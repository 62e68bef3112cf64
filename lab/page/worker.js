// The simulation in a thread of its own. The page asks for a frame, and this thread steps, paints and answers.

let module, wasm, lab = 0, columns = 0;
let view = null; // What to paint: field, range, part of the plane or of the picture, camera, pixels, colours

const text = () => {
  const { memory, lab_message, lab_message_length } = wasm;
  return new TextDecoder().decode(new Uint8Array(memory.buffer, lab_message(), lab_message_length()));
};

/** Call `use` with a text in the memory of the program. */
function withText(value, use) {
  const bytes = new TextEncoder().encode(value);
  const place = wasm.lab_room(bytes.length);
  new Uint8Array(wasm.memory.buffer, place, bytes.length).set(bytes);
  const result = use(place, bytes.length);
  wasm.lab_free_room(place, bytes.length);
  return result;
}

/** Return what a function returns for each axis. */
const axes = (of) => Array.from({ length: wasm.lab_dimensions(lab) }, (_, axis) => of(axis));

/** Return the facts of a scene: Reynolds number and the like. */
function factsOf(scene) {
  withText(scene, wasm.lab_facts);
  return JSON.parse(text());
}

async function load({ scene, known = scene }) {
  wasm ??= (await WebAssembly.instantiate(module, {})).exports;
  if (lab) wasm.lab_free(lab);
  lab = 0;
  lab = withText(scene, wasm.lab_new);
  if (!lab) throw new Error(text());
  columns = wasm.lab_columns(lab);
  const [count, cells] = [wasm.lab_flexible(lab), axes((axis) => wasm.lab_cells(lab, axis))];
  return { facts: factsOf(known), columns, count, cells };
}

function change({ scene, known = scene }) {
  if (!lab) throw new Error("no scene runs");
  if (withText(scene, (place, length) => wasm.lab_change(lab, place, length)) < 0) throw new Error(text());
  columns = wasm.lab_columns(lab);
  return { facts: factsOf(known), columns };
}

/** Step for about `budget` ms, half a step more or less, and at most `steps` steps; return their samples, row after
 * row. */
function step(steps, budget) {
  const samples = [];
  const begin = performance.now();
  let made = 0;
  for (let size = 1; made < steps; made += size) {
    if (wasm.lab_step(lab, size) < 0) throw new Error(text());
    samples.push(new Float64Array(wasm.memory.buffer, wasm.lab_samples(lab), size * columns).slice());
    const spent = performance.now() - begin;
    if (spent + spent / (made + size) / 2 > budget) {
      made += size;
      break;
    }
  }
  const rows = new Float64Array(samples.length * columns);
  samples.forEach((row, i) => rows.set(row, i * columns));
  return { rows, made, seconds: (performance.now() - begin) / 1000 };
}

/** Positions of the stations of each rod, or nodes of each wing, along one axis after the other. */
function shapes() {
  return Array.from({ length: wasm.lab_flexible(lab) }, (_, number) => {
    const n = wasm.lab_stations(lab, number);
    return axes((a) => new Float64Array(wasm.memory.buffer, wasm.lab_positions(lab, number, a), n).slice());
  });
}

/** Paint, and return the picture, and the axes of the camera in space: to the right, to the top, and to the viewer. */
async function picture() {
  const { field, range, part, camera, pixels, colours } = view;
  let directions = null;
  if (camera) {
    const numbers = [...new Float64Array(wasm.memory.buffer, wasm.lab_camera(lab, ...camera), 9)];
    directions = [0, 3, 6].map((first) => numbers.slice(first, first + 3));
  }
  new Uint32Array(wasm.memory.buffer, wasm.lab_colours(lab), 256).set(colours);
  const place = wasm.lab_paint(lab, field, ...range, ...part, ...pixels);
  const bytes = new Uint8ClampedArray(wasm.memory.buffer, place, 4 * pixels[0] * pixels[1]);
  return { bitmap: await createImageBitmap(new ImageData(bytes, ...pixels)), directions };
}

async function frame({ steps, budget }) {
  if (!lab) throw new Error("no scene runs");
  const made = step(steps, budget);
  return { ...made, ...(view && (await picture())), shapes: shapes() };
}

const answers = {
  async start({ bytes }) {
    module = await WebAssembly.compile(bytes);
  },
  load,
  change,
  frame,
  view(wanted) {
    ({ view } = wanted);
  },
  pull({ rod, station, x, y, stiffness }) {
    if (lab) wasm.lab_pull(lab, rod, station, x, y, stiffness);
  },
};

let queue = Promise.resolve(); // One request after the other

self.onmessage = ({ data }) => {
  queue = queue.then(async () => {
    try {
      const answer = (await answers[data.type](data)) ?? {};
      self.postMessage({ id: data.id, answer }, answer.bitmap ? [answer.bitmap] : []);
    } catch (error) {
      // After a panic the program is lost; its text tells why.
      const isPanic = error instanceof WebAssembly.RuntimeError;
      const reason = isPanic && wasm ? text() || error.message : error.message;
      if (isPanic) [wasm, lab] = [undefined, 0];
      self.postMessage({ id: data.id, error: reason });
    }
  });
};
