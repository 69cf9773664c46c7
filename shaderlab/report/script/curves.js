// Reads a chart's points: the nearest one under the pointer, or with the arrow keys.
for (const chart of document.querySelectorAll("figure.chart")) {
  const svg = chart.querySelector("svg");
  const rows = [...chart.querySelectorAll("tbody tr[data-x]")];
  if (svg && rows.length) readChart(chart, svg, rows);
}

function readChart(chart, svg, rows) {
  const places = rows.map((row) => Number(row.dataset.x));
  const order = places.map((_, n) => n).sort((a, b) => places[a] - places[b]);
  const names = [...chart.querySelectorAll("thead th")].map((cell) => cell.textContent);
  const said = chart.querySelector(".chart-point");
  const marks = svg.querySelector(".cursor");
  let rank = -1;

  function show(next) {
    rank = Math.max(0, Math.min(order.length - 1, next));
    const row = rows[order[rank]];
    const [x, y, strip] = [row.dataset.x, row.dataset.y, row.dataset.strip];
    marks.removeAttribute("hidden");
    marks.querySelector("path").setAttribute("d", `M${x} ${svg.dataset.top}V${svg.dataset.bottom}`);
    [y, strip].forEach((height, n) => {
      const dot = marks.querySelectorAll("circle")[n];
      dot.setAttribute("cx", x);
      dot.setAttribute("cy", height || -99);
    });
    said.textContent = [...row.cells]
      .map((cell, n) => `${names[n]} ${cell.textContent}`).join(" · ");
    said.hidden = false;
  }

  svg.addEventListener("pointermove", (event) => {
    const box = svg.getBoundingClientRect();
    const scale = svg.viewBox.baseVal.width / box.width;
    const x = (event.clientX - box.left) * scale;
    const y = (event.clientY - box.top) * scale;
    // Of several curves' points at one x, the one at the pointer's height.
    const far = (at) => Math.abs(places[at] - x) + Math.abs((rows[at].dataset.y || y) - y) / 1000;
    let best = 0;
    order.forEach((at, n) => {
      if (far(at) < far(order[best])) best = n;
    });
    show(best);
  });
  svg.tabIndex = 0;
  svg.addEventListener("keydown", (event) => {
    const step = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
    if (!step) return;
    event.preventDefault();
    show(rank < 0 ? 0 : rank + step * (event.shiftKey ? 8 : 1));
  });
}
