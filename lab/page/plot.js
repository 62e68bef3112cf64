// Curves over time with bands of published values, and what is measured of a curve.

const POINTS = 700; // Of a curve on the screen
const SKIPPED = 50; // Steps after the start, in which the flow meets the bodies with a blow
const ROUNDING = 1e-10; // Amplitude, by the values of the column and its partner, below which a signal is rounding
const PEAK = 0.05; // Part of a curve that the blow of a new cylinder may last

/** Rows of samples in the order of time; the oldest ones are forgotten. */
export class History {
  constructor(columns, capacity) {
    Object.assign(this, { columns, capacity, rows: new Float64Array(2 * capacity * columns), length: 0, skipped: 0 });
  }

  add(rows) {
    const { columns, capacity } = this;
    rows = rows.subarray(Math.max(0, rows.length - capacity * columns)); // More would be forgotten at once
    const skipped = Math.min(SKIPPED - this.skipped, rows.length / columns);
    this.skipped += skipped;
    rows = rows.subarray(skipped * columns);
    const count = rows.length / columns;
    if (this.length + count > 2 * capacity) {
      this.rows.copyWithin(0, (this.length - capacity) * columns, this.length * columns);
      this.length = capacity;
    }
    this.rows.set(rows, this.length * columns);
    this.length += count;
  }

  at(row, column) {
    return this.rows[row * this.columns + column];
  }

  /** Return the rows of the last `count` samples, at most the capacity. */
  last(count) {
    return [Math.max(0, this.length - Math.min(count, this.capacity)), this.length];
  }
}

/** Return mean, amplitude and frequency of a column in the last part of its curve; without a whole period, and of
 * rounding, there is no frequency. A period begins where the curve rises through the middle, after it was well below
 * it. */
export function measure(history, column) {
  const [first, end] = history.last(history.capacity);
  if (end - first < 20) return null;
  const begin = end - Math.floor(0.6 * (end - first));
  const [low, high] = range(Array.from({ length: end - begin }, (_, i) => history.at(begin + i, column)));
  const [mean, amplitude] = [(low + high) / 2, (high - low) / 2];
  if (amplitude <= ROUNDING * largest(history, column, begin, end)) return { mean, amplitude, frequency: null };
  const rises = [];
  let wasBelow = false;
  for (let row = begin; row < end; row++) {
    const value = history.at(row, column) - mean;
    if (value < -0.3 * amplitude) wasBelow = true;
    if (!wasBelow || value < 0) continue;
    const before = history.at(row - 1, column) - mean;
    const [t0, t1] = [history.at(row - 1, 0), history.at(row, 0)];
    rises.push(t0 + (t1 - t0) * (before / (before - value)));
    wasBelow = false;
  }
  const frequency = rises.length > 1 ? (rises.length - 1) / (rises.at(-1) - rises[0]) : null;
  return { mean, amplitude, frequency };
}

/** Return the largest size of a column and of its partner, as drag and lift, along and across. */
function largest(history, column, begin, end) {
  let found = 0;
  for (const one of [column, column % 2 ? column + 1 : column - 1].filter((one) => one < history.columns)) {
    for (let row = begin; row < end; row++) found = Math.max(found, Math.abs(history.at(row, one)));
  }
  return found;
}

/** Return the ends of an axis for values: a peak that lasts less than `PEAK` of them, and exceeds the range of the rest
 * by more than this range, is cut off once it is over. */
export function range(values) {
  const sorted = Float64Array.from(values).sort();
  const cut = Math.floor(PEAK * sorted.length);
  const [least, most, latest] = [sorted[0], sorted.at(-1), values.slice(values.length - Math.max(cut, 1))];
  const [low, high] = [Math.min(sorted[cut], ...latest), Math.max(sorted[sorted.length - 1 - cut], ...latest)];
  const span = high - low;
  return [low - least > span ? low : least, most - high > span ? high : most];
}

/** Round to a number that is easy to read, upward. */
function nice(value) {
  const power = 10 ** Math.floor(Math.log10(value));
  return [1, 2, 2.5, 5, 10].find((factor) => factor * power >= value * 0.999) * power;
}

/** Draw curves [{column, scale, colour, dash}] of a history, and bands [low, high] of published values. */
export function plot(canvas, history, curves, bands, unit) {
  const ratio = Math.min(window.devicePixelRatio || 1, 2);
  const [width, height] = [canvas.clientWidth, canvas.clientHeight];
  if (!width) return;
  if (canvas.width !== Math.round(width * ratio)) {
    [canvas.width, canvas.height] = [Math.round(width * ratio), Math.round(height * ratio)];
  }
  const context = canvas.getContext("2d");
  const style = getComputedStyle(canvas);
  const colour = (name) => style.getPropertyValue(name).trim();
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.clearRect(0, 0, width, height);
  const [begin, end] = history.last(history.capacity);
  if (end - begin < 2) return;
  let [low, high] = [Infinity, -Infinity];
  const stride = Math.max(1, Math.ceil((end - begin) / POINTS));
  const first = Math.ceil(begin / stride) * stride;
  for (const { column, scale } of curves) {
    const values = [];
    for (let row = first; row < end; row += stride) values.push(history.at(row, column) * scale);
    const [least, most] = range(values);
    [low, high] = [Math.min(low, least), Math.max(high, most)];
  }
  for (const band of bands) [low, high] = [Math.min(low, ...band), Math.max(high, ...band)];
  const step = nice(Math.max(high - low, 1e-12) / 4);
  [low, high] = [Math.floor(low / step) * step, Math.ceil(high / step) * step];
  const [x0, y0, x1, y1] = [52, 8, width - 8, height - 24];
  const [from, to] = [history.at(begin, 0), history.at(end - 1, 0)];
  const px = (t) => x0 + ((t - from) / (to - from)) * (x1 - x0);
  const py = (value) => y1 - ((value - low) / (high - low || 1)) * (y1 - y0);
  context.font = "12px system-ui, sans-serif";
  context.fillStyle = colour("--band");
  for (const [a, b] of bands) context.fillRect(x0, py(b), x1 - x0, Math.max(py(a) - py(b), 2));
  [context.strokeStyle, context.fillStyle, context.lineWidth] = [colour("--line"), colour("--soft"), 1];
  context.textAlign = "right";
  context.textBaseline = "middle";
  for (let value = low; value <= high + step / 2; value += step) {
    context.beginPath();
    context.moveTo(x0, py(value));
    context.lineTo(x1, py(value));
    context.stroke();
    const rounded = Number((Math.round(value / step) * step).toPrecision(6));
    context.fillText(String(rounded).replace("-", "−"), x0 - 6, py(value));
  }
  context.textAlign = "center";
  context.textBaseline = "top";
  const tick = nice((to - from) / 5);
  for (let t = Math.ceil(from / tick) * tick; t <= to; t += tick) {
    context.fillText(`${Number(t.toPrecision(6))} ${unit}`, Math.min(Math.max(px(t), x0 + 12), x1 - 18), y1 + 7);
  }
  context.lineWidth = 2;
  context.lineJoin = "round";
  context.save();
  context.beginPath();
  context.rect(x0, y0, x1 - x0, y1 - y0);
  context.clip();
  for (const { column, scale, name, dash } of curves) {
    context.strokeStyle = colour(name);
    context.setLineDash(dash ?? []);
    context.beginPath();
    for (let row = first; row < end; row += stride) {
      context.lineTo(px(history.at(row, 0)), py(history.at(row, column) * scale));
    }
    context.lineTo(px(to), py(history.at(end - 1, column) * scale));
    context.stroke();
  }
  context.restore();
}
