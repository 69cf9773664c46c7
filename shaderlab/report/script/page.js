// Reads a chart's points: the nearest one under the pointer, or with the arrow keys.
for (const chart of document.querySelectorAll("figure.chart")) {
  const svg = chart.querySelector("svg");
  const rows = [...chart.querySelectorAll("tbody tr[data-at]")];
  if (svg && rows.length) readChart(chart, svg, rows);
}

function readChart(chart, svg, rows) {
  // Of each row its x and one or two heights, from left to right.
  const points = rows.map((row) => ({ row, at: row.dataset.at.split(" ").map(Number) }))
    .sort((one, other) => one.at[0] - other.at[0]);
  const names = [...chart.querySelectorAll("thead th")].map((cell) => cell.textContent);
  const said = chart.querySelector(".chart-point");
  const marks = svg.querySelector(".cursor");
  let rank = -1;

  function show(next) {
    rank = Math.max(0, Math.min(points.length - 1, next));
    const { row, at: [x, ...heights] } = points[rank];
    marks.removeAttribute("hidden");
    marks.querySelector("path").setAttribute("d", `M${x} ${svg.dataset.top}V${svg.dataset.bottom}`);
    marks.querySelectorAll("circle").forEach((dot, n) => {
      dot.setAttribute("cx", x);
      dot.setAttribute("cy", heights[n] ?? -99);
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
    // Of several points at one x, the one at the pointer's height.
    const far = points.map(({ at }) => Math.abs(at[0] - x) + Math.abs(at[1] - y) / 1000);
    show(far.indexOf(Math.min(...far)));
  });
  svg.tabIndex = 0;
  svg.addEventListener("keydown", (event) => {
    const step = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
    if (!step) return;
    event.preventDefault();
    show(rank < 0 ? 0 : rank + step * (event.shiftKey ? 8 : 1));
  });
}
// Shows the cases whose text holds every word of the box and whose status is switched on: their
// titles, lessons, checks and shaders.

/** Each case's words by its anchor: in the page, or in a script of the site. */
const searchWords = (() => {
  let words = null;
  return () => {
    const inside = document.getElementById("search");
    words ??= inside
      ? Promise.resolve(Object.fromEntries([...inside.content.children]
        .map((item) => [item.dataset.case, item.textContent])))
      // Titles are found without it.
      : loadScript("page/search.js").then(() => globalThis.shaderlabWords, () => ({}));
    return words;
  };
})();

const filterForm = document.querySelector(".controls");
if (filterForm) watchFilter(filterForm);

document.addEventListener("keydown", (event) => {
  const typing = event.target.closest && event.target.closest("input, textarea, select");
  if (event.key !== "/" || typing || event.ctrlKey || event.metaKey || event.altKey) return;
  event.preventDefault();
  if (filterForm) filterForm.querySelector("#find").focus();
  else location.assign(`${document.documentElement.dataset.root}index.html#find`);
});

function watchFilter(form) {
  const box = form.querySelector("#find");
  const found = form.querySelector("#found");
  const switches = [...form.querySelectorAll("button[data-status]")];
  const cases = [...document.querySelectorAll("[data-case]")];
  const shelves = [...document.querySelectorAll("[data-shelf]")];
  const cards = cases.filter((item) => item.tagName === "LI");

  let updates = 0;

  async function update() {
    updates += 1;
    const own = updates;
    const words = box.value.toLowerCase().split(/\s+/).filter(Boolean);
    const texts = words.length ? await searchWords() : {};
    if (own !== updates) return;  // something else was typed meanwhile
    const textOf = (item) => texts[item.dataset.case] ?? item.textContent.toLowerCase();
    const off = new Set(switches.filter((b) => b.getAttribute("aria-pressed") === "false")
      .map((b) => b.dataset.status));
    for (const item of cases) {
      item.hidden = off.has(item.dataset.status)
        || !words.every((word) => textOf(item).includes(word));
    }
    for (const shelf of shelves) shelf.hidden = !shelf.querySelector("[data-case]:not([hidden])");
    const shown = cards.filter((card) => !card.hidden).length;
    found.value = shown === cards.length ? "" : `${shown} of ${cards.length} shown`;
  }

  form.hidden = false;
  box.addEventListener("focus", searchWords, { once: true });
  form.addEventListener("submit", (event) => event.preventDefault());
  box.addEventListener("input", update);
  for (const button of switches) {
    button.addEventListener("click", () => {
      button.setAttribute("aria-pressed", button.getAttribute("aria-pressed") === "false");
      update();
    });
  }
  box.addEventListener("keydown", (event) => {
    if (event.key !== "Escape") return;
    box.value = "";
    update();
  });
  // Browsers keep a box's text over a reload.
  update();
}
// Links to anchors open what is folded around their target.

/** The page of the case that an anchor begins with; null where no card of this page leads there. */
function pageOf(anchor) {
  const cards = [...document.querySelectorAll("a.card")]
    .map((card) => ({ card, name: card.closest("[data-case]").dataset.case }))
    .filter(({ name }) => anchor === name || anchor.startsWith(`${name}-`))
    .sort((one, other) => one.name.length - other.name.length);
  return cards.at(-1)?.card.getAttribute("href");
}

async function reveal() {
  // Anchors of this page are plain letters, digits and hyphens.
  const name = location.hash.slice(1);
  // A case's id alone will do, in a link from elsewhere.
  const goal = document.getElementById(name) ?? document.getElementById(`case-${name}`);
  if (!goal) {
    const page = pageOf(name) ?? pageOf(`case-${name}`);
    if (page) location.replace(`${page}#${name}`);
    return;
  }
  if (goal.matches("input")) {
    goal.focus();
    return;
  }
  for (let node = goal; node; node = node.parentElement) {
    if (node.tagName === "DETAILS") node.open = true;
    if (node.matches("[data-case], [data-shelf]")) node.hidden = false;
  }
  if (goal.matches(".check")) {
    goal.querySelector("details").open = true;
    await inspectWorst(goal);
  }
  goal.scrollIntoView({ behavior: "instant" });
}
addEventListener("hashchange", reveal);
if (location.hash) reveal();
// Chinese names beside the English ones, or none; a browser may forbid to keep which.
const chinese = document.getElementById("zh");
if (chinese) {
  const show = (on) => {
    chinese.setAttribute("aria-pressed", on);
    document.documentElement.classList.toggle("no-zh", !on);
  };
  try { show(localStorage.zh !== "false"); } catch { show(true); }
  chinese.hidden = false;
  chinese.onclick = () => {
    show(document.documentElement.matches(".no-zh"));
    try { localStorage.zh = chinese.getAttribute("aria-pressed"); } catch { /* this page, then */ }
  };
}
// On a case's own page its chapter is marked in the line of chapters, which may be longer than wide.
const marked = document.querySelector(".way [aria-current]");
if (marked) marked.closest("ol").scrollLeft = marked.offsetLeft - marked.closest("ol").offsetLeft;
// A case's live picture: what plays it, and its recording, are loaded when it is asked for.

function loadScript(name) {
  return new Promise((resolve, reject) => {
    const script = document.createElement("script");
    script.src = `${document.documentElement.dataset.root}${name}`;
    script.onload = resolve;
    script.onerror = () => reject(new Error(`${name} can't be loaded`));
    document.head.append(script);
  });
}

for (const tool of document.querySelectorAll(".live-button")) {
  const open = async (file) => {
    if (!globalThis.shaderlabLive) await loadScript("page/live.js");
    await loadScript(file);
    return inflated(globalThis.shaderlabRecording);
  };
  const box = document.querySelector("[data-live]");
  tool.querySelector("button").onclick = async () => {
    try {
      const files = JSON.parse(box.dataset.live);
      const first = await open(files[0][1]);
      globalThis.shaderlabLive(box, files, first, { open, general, ramp, colours });
      tool.remove();
      box.scrollIntoView();
    } catch (error) {
      tool.querySelector("output").textContent = `No live picture: ${error.message}`;
    }
  };
  tool.hidden = !("DecompressionStream" in window);
}
