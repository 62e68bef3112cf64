// The picture of the flow with rods, cylinders and marks over it.

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
    const [body, edge] = dark ? ["#e8eef4", "#0b1016"] : ["#16222e", "#ffffff"];
    for (const [x, y, radius] of circles) this.circle(x, y, radius, body, edge);
    context.lineJoin = context.lineCap = "round";
    shapes.forEach(([xs, ys], rod) => {
      const width = Math.max(thicknesses[rod] * this.scale, 3 * (window.devicePixelRatio || 1));
      context.beginPath();
      xs.forEach((x, i) => context.lineTo(...this.toPixels([x, ys[i]])));
      this.stroke(edge, width + 2.5);
      this.stroke(body, width);
    });
    for (const { from, to, radius } of marks) {
      if (radius) this.circle(...to, radius, "transparent", "#d9702a");
      if (!from) continue;
      context.beginPath();
      context.moveTo(...this.toPixels(from));
      context.lineTo(...this.toPixels(to));
      context.setLineDash([6, 6]);
      this.stroke("#d9702a", 3);
      context.setLineDash([]);
    }
  }

  circle(x, y, radius, body, edge) {
    this.context.beginPath();
    this.context.arc(...this.toPixels([x, y]), Math.max(radius * this.scale, 1), 0, 2 * Math.PI);
    this.context.fillStyle = body;
    this.context.fill();
    this.stroke(edge, 2);
  }

  stroke(style, width) {
    this.context.strokeStyle = style;
    this.context.lineWidth = width;
    this.context.stroke();
  }
}
