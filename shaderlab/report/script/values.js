// Numbers as the page's own tables write them, and float32's unit in the last place.
const cell32 = new DataView(new ArrayBuffer(4));

/** C's %.{digits}g with a real minus sign. */
function general(value, digits) {
  if (Number.isNaN(value)) return "NaN";
  if (!Number.isFinite(value)) return value > 0 ? "∞" : "−∞";
  if (value === 0) return Object.is(value, -0) ? "−0" : "0";
  const [mantissa, exponent] = value.toExponential(digits - 1).split("e");
  const power = Number(exponent);
  const trim = (text) => (text.includes(".") ? text.replace(/\.?0+$/, "") : text);
  const text = power < -4 || power >= digits
    ? `${trim(mantissa)}e${power < 0 ? "-" : "+"}${String(Math.abs(power)).padStart(2, "0")}`
    : trim(value.toFixed(Math.max(0, digits - 1 - power)));
  return text.replaceAll("-", "−");
}

/** A float in nine digits, enough to tell any two 32-bit floats apart. */
const figure = (value) => general(value, 9);

/** A distance or share in three digits. */
function short(value) {
  const size = Math.abs(value);
  if (Number.isFinite(value) && size >= 100 && size < 1e6) {
    return general(Number(value.toPrecision(3)), 9);
  }
  return general(value, 3);
}

/** The distance from |value|, rounded to float32, to the next larger float32. */
function ulpOf(value) {
  cell32.setFloat32(0, Math.abs(value));
  const near = cell32.getFloat32(0);
  cell32.setUint32(0, cell32.getUint32(0) + 1);
  return cell32.getFloat32(0) - near;
}
// Unpacks a check's numbers; shaderlab/model/pictures/values.py says how they were packed.

/** The bytes that base64 text holds deflated; rejects in a browser without DecompressionStream. */
async function inflated(text) {
  const packed = Uint8Array.from(atob(text.trim()), (c) => c.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/** The numbers in such text. */
async function unpackValues(text) {
  const bytes = await inflated(text);
  const end = bytes.indexOf(10);
  const head = JSON.parse(new TextDecoder().decode(bytes.subarray(0, end)));
  const { rows, columns, components } = head;
  const count = rows * columns * components;
  const body = bytes.subarray(end + 1);

  const byte = (start, i, b) => body[start + b * count + i] << (8 * b);
  const folded = (start, i) => {
    const n = byte(start, i, 0) | byte(start, i, 1) | byte(start, i, 2) | byte(start, i, 3);
    return (n >>> 1) ^ -(n & 1);
  };
  const measured = new Int32Array(count);
  const nearest = new Int32Array(count);
  const low = new Int32Array(count);
  const high = new Int32Array(count);
  for (let i = 0; i < count; i += 1) {
    const column = i % columns;
    const row = Math.floor(i / columns) % rows;
    const before = column ? measured[i - 1] : row ? measured[i - columns] : 0;
    measured[i] = before + folded(count, i);
    nearest[i] = measured[i] + folded(5 * count, i);
    low[i] = nearest[i] + folded(9 * count, i);
    high[i] = nearest[i] - folded(9 * count, i) - folded(13 * count, i);
  }
  return {
    ...head,
    flags: body.subarray(0, count),
    measured: floatsOf(measured),
    reference: floatsOf(nearest),
    low: floatsOf(low),
    high: floatsOf(high),
  };
}

/** Floats whose bits, ordered as the floats are, stand in an Int32Array; changes it. */
function floatsOf(ordered) {
  for (let i = 0; i < ordered.length; i += 1) if (ordered[i] < 0) ordered[i] ^= 0x7fffffff;
  return new Float32Array(ordered.buffer);
}

/** Where component c of pixel (x, y) stands in the arrays, or −1 if it was not judged. */
function indexOf(values, x, y, c) {
  const column = x - values.origin[0];
  const row = y - values.origin[1];
  if (column < 0 || row < 0 || column >= values.columns || row >= values.rows) return -1;
  const index = (c * values.rows + row) * values.columns + column;
  return values.flags[index] & 1 ? index : -1;
}

/** Signed distance from the band's middle in half widths; beyond ±1 outside, ±Infinity if the
 * band is one value. */
function placeOf(values, i) {
  const middle = values.low[i] / 2 + values.high[i] / 2;
  const half = values.high[i] / 2 - values.low[i] / 2;
  const value = values.measured[i];
  if (values.flags[i] & 2) {
    const place = half > 0 ? (value - middle) / half : NaN;
    if (Math.abs(place) > 1) return place;
    return value < middle ? -Infinity : Infinity;
  }
  if (!(half > 0) || !Number.isFinite(half) || Number.isNaN(value)) return 0;
  return Math.max(-1, Math.min(1, (value - middle) / half));
}

/** Distance to the reference in ULP, or in codes of a fixed-point format. */
function ulpDistance(values, i) {
  if (!Number.isFinite(values.reference[i])) return NaN;
  const unit = values.unit || ulpOf(values.reference[i]);
  return Math.abs(values.measured[i] - values.reference[i]) / unit;
}
