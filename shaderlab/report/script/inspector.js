// Mouse, pen and finger on a picture: read, pin, zoom, pan.

/** A press that moves further than this pans; one that does not pins the pixel. */
const STILL = 4;

function watchPointer(inspector, canvas) {
  const { view } = inspector;
  let start = null;
  let panned = false;
  canvas.addEventListener("pointerdown", (event) => {
    if (event.button) return;
    start = { x: event.clientX, y: event.clientY, centre: view.centre };
    panned = false;
  });
  canvas.addEventListener("pointermove", (event) => {
    if (!start || view.zoom === 1) {
      inspector.hover(...view.under(event, canvas));
      return;
    }
    const [dx, dy] = [event.clientX - start.x, event.clientY - start.y];
    if (!panned && Math.hypot(dx, dy) < STILL) return;
    if (!panned) canvas.setPointerCapture(event.pointerId);
    panned = true;
    const scale = view.span[0] / canvas.clientWidth;
    view.moveTo([start.centre[0] - dx * scale, start.centre[1] + dy * scale]);
    inspector.redraw();
  });
  canvas.addEventListener("pointerup", (event) => {
    if (start && !panned) inspector.pin(...view.under(event, canvas));
    start = null;
  });
  canvas.addEventListener("pointercancel", () => { start = null; });
  canvas.addEventListener("pointerleave", () => { if (!start) inspector.hover(null); });
  canvas.addEventListener("dblclick", (event) => {
    inspector.zoom(event.shiftKey ? 0.5 : 2, view.under(event, canvas));
  });
  // Without Ctrl the wheel scrolls the page; a trackpad's pinch comes with Ctrl.
  canvas.addEventListener("wheel", (event) => {
    if (!event.ctrlKey && !event.metaKey) return;
    event.preventDefault();
    inspector.zoom(2 ** (-event.deltaY / 120), view.under(event, canvas));
  }, { passive: false });
}

// The pixel inspector: a check's three pictures as canvases that share a window and a cursor.
class Inspector {
  constructor(group, values) {
    this.group = group;
    this.values = values;
    this.view = new View(values);
    this.look = { channel: -1, gain: 1 };
    this.worst = group.dataset.worst ? group.dataset.worst.split(" ").map(Number) : null;
    this.pinned = this.worst ?? this.firstJudged();
    this.hovered = null;
    this.panel = document.getElementById("inspector").content.cloneNode(true).firstElementChild;
    this.pictures = [...group.querySelectorAll("[data-picture]")]
      .map((figure) => this.canvasIn(figure));
    group.after(this.panel);
    this.wire();
    this.repaint();
  }

  firstJudged() {
    const at = this.values.flags.findIndex((flag) => flag & 1);
    const n = at % (this.values.columns * this.values.rows);
    const column = Math.max(0, n) % this.values.columns;
    const row = Math.floor(Math.max(0, n) / this.values.columns);
    return [this.values.origin[0] + column, this.values.origin[1] + row];
  }

  canvasIn(figure) {
    const image = figure.querySelector("img, .scripted");
    const canvas = document.createElement("canvas");
    canvas.setAttribute("role", "img");
    canvas.setAttribute("aria-label", image.alt ?? image.dataset.alt);
    canvas.style.aspectRatio = `${this.view.width} / ${this.view.height}`;
    image.hidden = true;
    image.after(canvas);
    return { what: figure.dataset.picture, canvas, image: null };
  }

  part(name) {
    return this.panel.querySelector(`[data-part="${name}"]`);
  }

  wire() {
    const { group } = this;
    group.tabIndex = 0;
    group.setAttribute("role", "application");
    group.setAttribute("aria-label", "Pixel inspector: arrow keys move by a pixel, with Shift by "
      + "eight; plus and minus zoom; 0 shows all; W goes to the worst pixel");
    group.addEventListener("keydown", (event) => this.key(event));
    for (const { canvas } of this.pictures) watchPointer(this, canvas);
    new ResizeObserver(() => this.redraw()).observe(group);
    const gain = this.part("exposure");
    gain.addEventListener("input", () => {
      this.look.gain = 2 ** Number(gain.value);
      this.part("stops").value = `${gain.value > 0 ? "+" : ""}${gain.value} EV`.replace("-", "−");
      this.repaint();
    });
    const act = {
      in: () => this.zoom(2),
      out: () => this.zoom(0.5),
      all: () => this.showAll(),
      worst: () => this.showWorst(),
    };
    for (const button of this.panel.querySelectorAll("button[data-do]")) {
      button.addEventListener("click", () => act[button.dataset.do]());
    }
    this.panel.querySelector('[data-do="worst"]').hidden = !this.worst;
    this.part("partial").hidden = this.values.whole;
    this.channels();
  }

  channels() {
    const box = this.part("channels");
    box.hidden = this.values.components === 1;
    ["all", ..."rgba".slice(0, this.values.components)].forEach((name, n) => {
      const button = document.createElement("button");
      button.type = "button";
      button.textContent = name;
      button.setAttribute("aria-pressed", String(n === 0));
      button.addEventListener("click", () => {
        for (const other of box.children) other.setAttribute("aria-pressed", other === button);
        this.look.channel = n - 1;
        this.repaint();
      });
      box.append(button);
    });
  }

  key(event) {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const step = event.shiftKey ? 8 : 1;
    const moves = {
      ArrowLeft: [-step, 0], ArrowRight: [step, 0], ArrowUp: [0, step], ArrowDown: [0, -step],
    };
    const others = {
      "+": () => this.zoom(2), "=": () => this.zoom(2), "-": () => this.zoom(0.5),
      0: () => this.showAll(), w: () => this.showWorst(), W: () => this.showWorst(),
    };
    if (moves[event.key]) {
      const [x, y] = this.pinned;
      this.pin(x + moves[event.key][0], y + moves[event.key][1], true);
    } else if (others[event.key]) {
      others[event.key]();
    } else {
      return;
    }
    event.preventDefault();
  }

  /** Makes a pixel the one that is read when the pointer is elsewhere. */
  pin(x, y, aloud = false) {
    this.pinned = this.inside(x, y);
    this.hovered = null;
    this.view.show(...this.pinned);
    this.redraw();
    if (aloud) this.part("spoken").textContent = this.part("where").textContent;
  }

  hover(x, y) {
    this.hovered = x === null ? null : this.inside(x, y);
    this.redraw();
  }

  inside(x, y) {
    return [[x, this.view.width], [y, this.view.height]]
      .map(([value, size]) => Math.max(0, Math.min(size - 1, Math.floor(value))));
  }

  zoom(factor, about = this.pinned.map((p) => p + 0.5)) {
    this.view.zoomBy(factor, about);
    this.redraw();
  }

  showAll() {
    this.view.reset();
    this.redraw();
  }

  showWorst() {
    if (!this.worst) return;
    this.view.reset();
    this.view.zoomBy(Math.max(1, Math.min(8, this.view.width / 12)));
    this.view.moveTo(this.worst.map((p) => p + 0.5));
    this.pin(...this.worst, true);
  }

  /** Colours anew, after a change of channel or exposure. */
  repaint() {
    for (const picture of this.pictures) {
      const image = paint(this.values, picture.what, this.look);
      picture.image = new OffscreenCanvas(image.width, image.height);
      picture.image.getContext("2d").putImageData(image, 0, 0);
    }
    this.redraw();
  }

  redraw() {
    const [x, y] = this.hovered ?? this.pinned;
    for (const { canvas, image } of this.pictures) {
      const ratio = devicePixelRatio || 1;
      canvas.width = Math.max(1, Math.round(canvas.clientWidth * ratio));
      canvas.height = Math.max(1, Math.round(canvas.width * this.view.height / this.view.width));
      const context = this.view.draw(canvas, image, this.values);
      if (this.worst) ring(context, this.view, this.worst, ratio);
      cross(context, this.view, [x, y], ratio);
      canvas.classList.toggle("is-near", this.view.zoom > 1);
    }
    const says = readPixel(this.part("numbers"), this.values, x, y);
    const worst = this.worst && x === this.worst[0] && y === this.worst[1] ? ", the worst" : "";
    this.part("where").textContent = `Pixel (${x}, ${y})${worst}: ${says}`;
    this.part("table").hidden = !this.part("numbers").children.length;
    this.part("zoom").value = `${Math.round(this.view.zoom * 10) / 10}×`;
  }
}

// An inspector starts where pictures with numbers come into sight, or when a link leads there.
const inspectors = new WeakMap();

/** The inspector of a group of pictures, made now if there is none; null without its numbers. */
function inspectorOf(group) {
  if (!inspectors.has(group)) {
    inspectors.set(group, (async () => {
      try {
        const values = await unpackValues(group.querySelector("template").content.textContent);
        return new Inspector(group, values);
      } catch (error) {
        // The pictures stay as they are.
        console.warn("no inspector here:", error);
        return null;
      }
    })());
  }
  return inspectors.get(group);
}

if ("DecompressionStream" in window) {
  const seen = new IntersectionObserver((entries) => {
    for (const entry of entries) {
      if (!entry.isIntersecting) continue;
      seen.unobserve(entry.target);
      inspectorOf(entry.target);
    }
  }, { rootMargin: "300px" });
  for (const group of document.querySelectorAll("[data-inspect]")) seen.observe(group);
}

/** Shows the worst pixel of the first pictures inside an element. */
async function inspectWorst(element) {
  const group = element.querySelector("[data-inspect]");
  const inspector = group && await inspectorOf(group);
  inspector?.showWorst();
}
