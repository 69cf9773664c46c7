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
    const place = placeOf(values, i);
    rows.push({
      bad,
      cells: [
        channelName(values, c),
        figure(values.measured[i]),
        general(values.reference[i], values.fine ? 9 : 8),
        figure(values.low[i]),
        figure(values.high[i]),
        short(ulpDistance(values, i)),
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
