// How many judged values lie where in their bands, as bars; what is outside stands apart.
const BINS = 20;

/** Counts: [outside below, BINS from lower to upper edge, outside above]. */
function histogramOf(values, channel) {
  const size = values.rows * values.columns;
  const counts = new Array(BINS + 2).fill(0);
  for (let i = 0; i < values.flags.length; i += 1) {
    if (!(values.flags[i] & 1)) continue;
    if (channel >= 0 && Math.floor(i / size) !== channel) continue;
    const place = placeOf(values, i);
    if (place === -Infinity) counts[0] += 1;
    else if (place === Infinity) counts[BINS + 1] += 1;
    else counts[1 + Math.min(BINS - 1, Math.floor((place + 1) / 2 * BINS))] += 1;
  }
  return counts;
}

/** Draws the counts into an SVG of 240 × 64; each bar's height is a logarithm. */
function drawHistogram(svg, values, channel) {
  const counts = histogramOf(values, channel);
  const most = Math.log1p(Math.max(...counts));
  svg.querySelectorAll(".bar").forEach((bar) => bar.remove());
  counts.forEach((count, n) => {
    if (!count) return;
    const height = Math.max(1.5, Math.log1p(count) / most * 46);
    const apart = n === 0 ? -6 : n === BINS + 1 ? 6 : 0;
    const bar = document.createElementNS(svg.namespaceURI, "rect");
    bar.setAttribute("class", apart ? "bar is-outside" : "bar");
    bar.setAttribute("x", 10 + n * 10 + apart);
    bar.setAttribute("y", 48 - height);
    bar.setAttribute("width", 9);
    bar.setAttribute("height", height);
    svg.append(bar);
  });
  const outside = counts[0] + counts[BINS + 1];
  const all = counts.reduce((a, b) => a + b, 0);
  svg.setAttribute("aria-label",
    `${all - outside} values by their place in the band, ${outside} outside it`);
}
