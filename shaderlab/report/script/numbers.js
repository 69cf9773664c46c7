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
