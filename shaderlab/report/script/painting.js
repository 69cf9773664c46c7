// Colours of a check's pictures: direct or false colour for values, the position in the band.
const colours = JSON.parse(document.getElementById("colours").content.textContent);
const ramp = colours.palette.match(/.{6}/g)
  .map((hex) => [0, 2, 4].map((start) => parseInt(hex.substr(start, 2), 16)));

/** One channel's finite range over measured and reference values together. */
function rangeOf(values, channel) {
  const size = values.rows * values.columns;
  let [low, high] = [Infinity, -Infinity];
  for (let i = channel * size; i < (channel + 1) * size; i += 1) {
    if (!(values.flags[i] & 1)) continue;
    for (const v of [values.measured[i], values.reference[i]]) {
      if (Number.isFinite(v)) [low, high] = [Math.min(low, v), Math.max(high, v)];
    }
  }
  return low <= high ? [low, high] : [0, 0];
}

/**
 * Draws "measured", "reference" or "distance" into an image of 2 × 2 pixels a value.
 * look: {channel (−1 for all), gain}.
 */
function paint(values, what, look) {
  const { columns, rows, components } = values;
  const image = new ImageData(2 * columns, 2 * rows);
  const single = components === 1 ? 0 : look.channel;
  const range = single >= 0 ? rangeOf(values, single) : null;
  for (let i = 0; i < rows * columns; i += 1) {
    const [x, y] = [i % columns, rows - 1 - Math.floor(i / columns)];  // the top row comes first
    const [even, odd] = colourAt(values, what, i, single, range, look.gain);
    for (const [dx, dy] of [[0, 0], [1, 0], [0, 1], [1, 1]]) {
      const colour = dx === dy ? even : odd;
      image.data.set([...colour, 255], ((2 * y + dy) * 2 * columns + 2 * x + dx) * 4);
    }
  }
  return image;
}

/** Two colours, of which a check is made: other than one another where a value is outside. */
function colourAt(values, what, i, single, range, gain) {
  const both = (colour) => [colour, colour];
  if (!(values.flags[i] & 1)) return both(colours.uncovered);
  const size = values.rows * values.columns;
  if (what === "distance") {
    const place = furthestOf(values, i, single);
    if (Math.abs(place) > 1) {
      const rank = colours.magnitudes.findIndex((most) => Math.abs(place) <= most);
      return [colours.outside.at(rank), colours.check];  // the last one beyond all of them
    }
    const end = place < 0 ? colours.low : colours.high;
    return both(colours.middle.map((m, c) => Math.round(m + (end[c] - m) * Math.abs(place))));
  }
  const channels = single >= 0 ? [single] : [0, 1, 2].slice(0, values.components);
  const numbers = channels.map((c) => values[what][c * size + i]);
  if (!numbers.every(Number.isFinite)) return both(colours.broken);
  if (single >= 0) {
    const t = (numbers[0] * gain - range[0]) / (range[1] - range[0] || 1);
    return both(ramp[Math.round(Math.max(0, Math.min(1, t)) * (ramp.length - 1))]);
  }
  const scale = values.unit ? gain : gain * 255;
  return both([0, 1, 2].map((c) => Math.round((numbers[c] ?? 0) * scale)));
}

/** The place in its band of the component that is furthest from the middle. */
function furthestOf(values, i, single) {
  let furthest = 0;
  for (let c = 0; c < values.components; c += 1) {
    if (single >= 0 && c !== single) continue;
    const place = placeOf(values, c * values.rows * values.columns + i);
    if (Math.abs(place) > Math.abs(furthest)) furthest = place;
  }
  return furthest;
}
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
// What is drawn over the pictures: the pixel that is read, the worst one, values outside.

/** Strokes around a pixel, light and dark so that they show on any colour. */
function around(context, view, [x, y], least, strokes, path) {
  const [left, top, side] = view.square(x, y, context.canvas);
  const size = Math.max(side, least);
  for (const [colour, width] of strokes) {
    [context.strokeStyle, context.lineWidth] = [colour, width];
    context.beginPath();
    path(left + side / 2, top + side / 2, size);
    context.stroke();
  }
}

/** A frame around the pixel that is read. */
const cross = (context, view, place, ratio) => around(context, view, place, 7 * ratio,
  [["#000", 3 * ratio], ["#fff", 1.2 * ratio]],
  (x, y, size) => context.rect(x - size / 2, y - size / 2, size, size));

/** A ring around the worst pixel. */
const ring = (context, view, place, ratio) => around(context, view, place, 9 * ratio,
  [["#fff", 4.5 * ratio], ["#c01010", 2.2 * ratio]],
  (x, y, size) => context.arc(x, y, size, 0, 2 * Math.PI));

// The table under the pictures: one pixel's numbers, channel by channel.

/** Fills a table's body for pixel (x, y); says in words what is there. */
function readPixel(body, values, x, y) {
  const rows = [];
  let outside = 0;
  for (let c = 0; c < values.components; c += 1) {
    const i = indexOf(values, x, y, c);
    if (i < 0) break;
    const bad = Boolean(values.flags[i] & 2);
    outside += bad;
    const [place, ulp] = [placeOf(values, i), ulpDistance(values, i)];
    rows.push({
      bad,
      cells: [
        channelName(values, c),
        figure(values.measured[i]),
        figure(values.reference[i]),
        figure(values.low[i]),
        figure(values.high[i]),
        values.unit || ulp ? short(ulp) : "< 1", // the reference is rounded to float32
        bad ? "outside" : `${place > 0 ? "+" : ""}${general(place, 2)}`,
      ],
    });
  }
  body.replaceChildren(...rows.map(({ bad, cells }) => {
    const row = document.createElement("tr");
    row.classList.toggle("is-bad", bad);
    row.append(...cells.map((text, n) => {
      const cell = document.createElement(n ? "td" : "th");
      if (n) cell.className = "num";
      else cell.scope = "row";
      cell.textContent = text;
      return cell;
    }));
    return row;
  }));
  if (!rows.length) return "not drawn, so not judged";
  return outside ? "outside its band" : "inside its band";
}

const channelName = (values, c) => (values.components === 1 ? "value" : `${c} ${"rgba"[c]}`);
