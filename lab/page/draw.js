// The picture of the flow with rods, wings, cylinders and marks over it.

const MARK = "#d9702a"; // What the mouse holds
const LIGHT = [0.25, 0.55, 0.8]; // Direction to the light, by the directions of the camera
const AMBIENT = 0.45; // Part of the light that comes from everywhere

const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const minus = (a, b) => a.map((x, d) => x - b[d]);
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const unit = (a) => a.map((x) => x / (Math.hypot(...a) || 1));

/** Return corners that are farther from their middle: else the background shines through between triangles. */
function larger(corners, way) {
  const [x, y] = [0, 1].map((d) => corners.reduce((sum, corner) => sum + corner[d], 0) / corners.length);
  return corners.map(([px, py]) => {
    const by = 1 + way / (Math.hypot(px - x, py - y) || 1);
    return [x + (px - x) * by, y + (py - y) * by];
  });
}

/** Return the edges of triangles that belong to one triangle alone. */
function outline(triangles) {
  const seen = new Map();
  for (const triangle of triangles) {
    triangle.forEach((a, i) => {
      const edge = [a, triangle[(i + 1) % 3]];
      const key = edge.toSorted((m, n) => m - n).join();
      seen.set(key, seen.has(key) ? null : edge);
    });
  }
  return [...seen.values()].filter(Boolean);
}

/** A part [left, right, bottom, top] of the plane, or of what a camera sees of space (m), on a canvas. */
export class Picture {
  constructor(canvas) {
    this.canvas = canvas;
    this.context = canvas.getContext("2d");
  }

  /** Fit the canvas to its width on the page: a part that is too wide for it is cut at its right end, or at both. */
  fit(part, atBoth = false) {
    const [left, right, bottom, top] = part;
    const width = this.canvas.clientWidth || 800;
    const narrowest = width < 760 ? 1.7 : 2.1;
    const aspect = Math.min((right - left) / (top - bottom), Math.max(narrowest, (width / 900) * 4.2));
    const height = Math.round(width / aspect);
    const cut = right - left - (top - bottom) * aspect;
    const begin = left + (atBoth ? cut / 2 : 0);
    this.part = [begin, begin + (top - bottom) * aspect, bottom, top];
    const scale = Math.min(window.devicePixelRatio || 1, 2);
    this.pixel = scale; // Of the page, in those of the canvas
    [this.canvas.width, this.canvas.height] = [Math.round(width * scale), Math.round(height * scale)];
    this.canvas.style.height = `${height}px`;
    this.scale = this.canvas.width / (this.part[1] - begin); // Pixels in a metre
  }

  /** Size of the painted field, at most about as fine as a screen shows at 30 frames a second. */
  pixels(isSpace) {
    const factor = Math.min(1, (isSpace ? 640 : 1280) / this.canvas.width);
    return [Math.round(this.canvas.width * factor), Math.round(this.canvas.height * factor)];
  }

  toPixels([x, y]) {
    return [(x - this.part[0]) * this.scale, this.canvas.height - (y - this.part[2]) * this.scale];
  }

  toMetres(event) {
    const box = this.canvas.getBoundingClientRect();
    const scale = box.width / (this.part[1] - this.part[0]);
    return [this.part[0] + (event.clientX - box.left) / scale, this.part[3] - (event.clientY - box.top) / scale];
  }

  /** Draw a frame; in space with the `directions` of its camera, the `mesh` of the wing and the `ends` of the field. */
  draw({ bitmap, shapes, circles, thicknesses, marks, dark, directions, mesh, ends }) {
    const { context, canvas } = this;
    context.imageSmoothingQuality = directions ? "low" : "high"; // The smooth picture of space is enlarged more
    context.drawImage(bitmap, 0, 0, canvas.width, canvas.height);
    const [body, edge] = dark ? ["#d3dde6", "#0b1016"] : ["#16222e", "#ffffff"];
    context.lineJoin = context.lineCap = "round";
    if (directions) {
      this.frame(directions, ends, body);
      if (mesh) shapes.forEach((nodes) => this.wing(directions, nodes, mesh, dark));
      return;
    }
    // Edges below all bodies: a rod grows out of its cylinder without a seam.
    for (const [style, more] of [[edge, 1.5 * this.pixel], [body, 0]]) {
      for (const [x, y, radius] of circles) this.disc([x, y], radius * this.scale + more, style);
      shapes.forEach(([xs, ys], rod) => {
        const width = Math.max(thicknesses[rod] * this.scale, 2.5 * this.pixel);
        context.beginPath();
        xs.forEach((x, i) => context.lineTo(...this.toPixels([x, ys[i]])));
        this.stroke(style, width + 2 * more);
      });
    }
    for (const { from, to, radius } of marks) {
      if (radius) this.ring(to, radius * this.scale, MARK);
      if (!from) continue;
      context.beginPath();
      context.moveTo(...this.toPixels(from));
      context.lineTo(...this.toPixels(to));
      context.setLineDash([5 * this.pixel, 4 * this.pixel]);
      this.stroke(MARK, 2 * this.pixel);
      context.setLineDash([]);
    }
  }

  /** Draw the edges of a box of space with such ends along each axis. */
  frame(directions, ends, style) {
    const { context } = this;
    const corner = (number) => ends.map((pair, axis) => pair[(number >> axis) & 1]);
    context.globalAlpha = 0.25;
    for (let from = 0; from < 8; from++) {
      for (const bit of [1, 2, 4].filter((own) => !(from & own))) {
        this.line([from, from | bit].map((number) => this.seen(directions, corner(number))));
        this.stroke(style, this.pixel);
      }
    }
    context.globalAlpha = 1;
  }

  /** Draw a wing with such positions of its nodes along each axis: far triangles first, shaded by their normals. */
  wing(directions, axes, { triangles, veins }, dark) {
    const { context } = this;
    const nodes = Array.from(axes[0], (_, k) => axes.map((list) => list[k]));
    const seen = nodes.map((node) => this.seen(directions, node));
    const depths = nodes.map((node) => dot(directions[2], node));
    const normals = nodes.map(() => [0, 0, 0]);
    for (const [a, b, c] of triangles) {
      const area = cross(minus(nodes[b], nodes[a]), minus(nodes[c], nodes[a]));
      for (const k of [a, b, c]) normals[k] = normals[k].map((x, d) => x + area[d]);
    }
    const depth = (triangle) => triangle.reduce((sum, k) => sum + depths[k], 0);
    for (const triangle of triangles.toSorted((a, b) => depth(a) - depth(b))) {
      const normal = unit([0, 1, 2].map((d) => triangle.reduce((sum, k) => sum + normals[k][d], 0)));
      const towards = directions.map((direction) => dot(direction, normal));
      const side = Math.sign(towards[2]) || 1;
      const light = AMBIENT + (1 - AMBIENT) * Math.max(0, (side * dot(towards, LIGHT)) / Math.hypot(...LIGHT));
      const [hue, pale] = side > 0 ? [34, 62] : [16, 54];
      context.fillStyle = `hsl(${hue} 72% ${(pale * light + (dark ? 8 : 14)).toFixed(1)}%)`;
      this.line(larger(triangle.map((k) => seen[k]), 0.7 * this.pixel));
      context.fill();
    }
    const ink = "#2b1608";
    for (const vein of veins) {
      this.line(vein.map((k) => seen[k]));
      this.stroke(ink, 1.3 * this.pixel);
    }
    this.edges ??= new WeakMap();
    if (!this.edges.has(triangles)) this.edges.set(triangles, outline(triangles));
    for (const edge of this.edges.get(triangles)) {
      this.line(edge.map((k) => seen[k]));
      this.stroke(ink, 1.8 * this.pixel);
    }
  }

  /** Return the place on the canvas of a point of space. */
  seen([right, up], point) {
    return this.toPixels([dot(right, point), dot(up, point)]);
  }

  /** Begin a path along points of the canvas. */
  line(points) {
    this.context.beginPath();
    points.forEach((point) => this.context.lineTo(...point));
  }

  disc(at, radius, style) {
    this.context.beginPath();
    this.context.arc(...this.toPixels(at), Math.max(radius, 1), 0, 2 * Math.PI);
    this.context.fillStyle = style;
    this.context.fill();
  }

  ring(at, radius, style) {
    this.context.beginPath();
    this.context.arc(...this.toPixels(at), radius, 0, 2 * Math.PI);
    this.stroke(style, 2 * this.pixel);
  }

  stroke(style, width) {
    this.context.strokeStyle = style;
    this.context.lineWidth = width;
    this.context.stroke();
  }
}
