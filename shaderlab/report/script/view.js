// One window onto a picture that several canvases share: zoom, pan, and pixels on the screen.
class View {
  constructor(values) {
    [this.width, this.height] = values.size;
    this.reset();
  }

  reset() {
    this.zoom = 1;
    this.centre = [this.width / 2, this.height / 2];
  }

  /** How many picture pixels a canvas shows across: the canvas has the picture's shape. */
  get span() {
    return [this.width / this.zoom, this.height / this.zoom];
  }

  get most() {
    return Math.max(1, Math.min(this.width, this.height) / 4);
  }

  /** Zooms by a factor about a point of the picture, which stays where it is. */
  zoomBy(factor, about = this.centre) {
    const before = this.zoom;
    this.zoom = Math.max(1, Math.min(this.most, this.zoom * factor));
    const kept = before / this.zoom;
    this.moveTo(about.map((a, n) => a + (this.centre[n] - a) * kept));
  }

  /** Puts a point into the middle, as far as the picture's edges let it. */
  moveTo(centre) {
    const limit = [this.width, this.height];
    this.centre = centre.map((c, n) => {
      const half = this.span[n] / 2;
      return Math.max(half, Math.min(limit[n] - half, c));
    });
  }

  /** Brings a pixel into sight if it is not. */
  show(x, y) {
    const [w, h] = this.span;
    const [cx, cy] = this.centre;
    const out = Math.abs(x + 0.5 - cx) > w / 2 - 0.5 || Math.abs(y + 0.5 - cy) > h / 2 - 0.5;
    if (out) this.moveTo([x + 0.5, y + 0.5]);
  }

  /** The place in the picture (fractions of pixels, from the lower left) under the pointer. */
  under(event, canvas) {
    const box = canvas.getBoundingClientRect();
    const [w, h] = this.span;
    return [
      this.centre[0] + ((event.clientX - box.left) / box.width - 0.5) * w,
      this.centre[1] - ((event.clientY - box.top) / box.height - 0.5) * h,
    ];
  }

  /** A pixel's square on a canvas: [left, top, side]. */
  square(x, y, canvas) {
    const scale = canvas.width / this.span[0];
    return [
      (x - this.centre[0] + this.span[0] / 2) * scale,
      (this.centre[1] + this.span[1] / 2 - y - 1) * scale,
      scale,
    ];
  }

  /** Draws an image of the judged part, crisp, where it belongs. */
  draw(canvas, image, values) {
    const context = canvas.getContext("2d");
    context.fillStyle = `rgb(${colours.uncovered.join(" ")})`;
    context.fillRect(0, 0, canvas.width, canvas.height);
    const top = values.origin[1] + values.rows - 1;
    const [left, above, side] = this.square(values.origin[0], top, canvas);
    context.imageSmoothingEnabled = false;
    context.drawImage(image, left, above, values.columns * side, values.rows * side);
    return context;
  }
}
