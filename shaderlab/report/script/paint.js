// Colours of a check's pictures: direct or false colour for values, the place in the band.
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
 * Draws "measured", "reference" or "distance" into an image of one pixel a value.
 * look: {channel (−1 for all), gain}.
 */
function paint(values, what, look) {
  const { columns, rows, components } = values;
  const image = new ImageData(columns, rows);
  const size = rows * columns;
  const single = components === 1 ? 0 : look.channel;
  const range = single >= 0 ? rangeOf(values, single) : null;
  for (let row = 0; row < rows; row += 1) {
    for (let column = 0; column < columns; column += 1) {
      const i = row * columns + column;
      // Images have their top row first.
      const at = ((rows - 1 - row) * columns + column) * 4;
      image.data.set(colourAt(values, what, i, size, single, range, look.gain), at);
      image.data[at + 3] = 255;
    }
  }
  return image;
}

function colourAt(values, what, i, size, single, range, gain) {
  if (!(values.flags[i] & 1)) return colours.uncovered;
  if (what === "distance") return distanceColour(values, i, size, single);
  const array = values[what];
  if (single >= 0) {
    const value = array[single * size + i];
    if (!Number.isFinite(value)) return colours.broken;
    const span = range[1] - range[0] || 1;
    const t = Math.max(0, Math.min(1, (value * gain - range[0]) / span));
    return ramp[Math.round(t * (ramp.length - 1))];
  }
  const scale = values.unit ? gain : gain * 255;
  const rgb = [0, 0, 0];
  for (let c = 0; c < Math.min(3, values.components); c += 1) {
    const value = array[c * size + i];
    if (!Number.isFinite(value)) return colours.broken;
    rgb[c] = Math.round(value * scale);
  }
  return rgb;
}

function distanceColour(values, i, size, single) {
  let furthest = 0;
  for (let c = 0; c < values.components; c += 1) {
    if (single >= 0 && c !== single) continue;
    const place = placeOf(values, c * size + i);
    if (Math.abs(place) > Math.abs(furthest)) furthest = place;
  }
  if (!Number.isFinite(furthest)) return colours.outside[0];
  const end = furthest < 0 ? colours.low : colours.high;
  return colours.middle.map((m, c) => Math.round(m + (end[c] - m) * Math.abs(furthest)));
}

/** Where the values outside are, as [x, y] in the picture. */
function outsidePixels(values, single) {
  const size = values.rows * values.columns;
  const found = [];
  for (let i = 0; i < size; i += 1) {
    for (let c = 0; c < values.components; c += 1) {
      if ((single < 0 || c === single) && values.flags[c * size + i] & 2) {
        const x = values.origin[0] + (i % values.columns);
        found.push([x, values.origin[1] + Math.floor(i / values.columns)]);
        break;
      }
    }
  }
  return found;
}
