// The picture of the flow with rods, cylinders and marks over it.

const MARK = "#d9702a"; // What the mouse holds

/** A part [left, right, bottom, top] of the plane (m) on a canvas. */
export class Picture {
  constructor(canvas) {
    this.canvas = canvas;
    this.context = canvas.getContext("2d");
  }

  /** Fit the canvas to its width on the page: a part that is too wide for it is cut at its right end. */
  fit(part) {
    const [left, right, bottom, top] = part;
    const width = this.canvas.clientWidth || 800;
    const narrowest = width < 760 ? 1.7 : 2.1;
    const aspect = Math.min((right - left) / (top - bottom), Math.max(narrowest, (width / 900) * 4.2));
    const height = Math.round(width / aspect);
    this.part = [left, left + (top - bottom) * aspect, bottom, top];
    const scale = Math.min(window.devicePixelRatio || 1, 2);
    this.pixel = scale; // Of the page, in those of the canvas
    [this.canvas.width, this.canvas.height] = [Math.round(width * scale), Math.round(height * scale)];
    this.canvas.style.height = `${height}px`;
    this.scale = this.canvas.width / (this.part[1] - left); // Pixels in a metre
  }

  /** Size of the painted field, at most about as fine as a screen shows at 30 frames a second. */
  get pixels() {
    const factor = Math.min(1, 1280 / this.canvas.width);
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

  draw({ bitmap, shapes, circles, thicknesses, marks, dark }) {
    const { context, canvas } = this;
    context.imageSmoothingQuality = "high";
    context.drawImage(bitmap, 0, 0, canvas.width, canvas.height);
    const [body, edge] = dark ? ["#d3dde6", "#0b1016"] : ["#16222e", "#ffffff"];
    context.lineJoin = context.lineCap = "round";
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
