// Shows the cases whose text holds every word of the box and whose status is switched on: their
// titles, lessons, checks and shaders.
const filterForm = document.querySelector(".controls");
if (filterForm) watchFilter(filterForm);

function watchFilter(form) {
  const box = form.querySelector("#find");
  const found = form.querySelector("#found");
  const switches = [...form.querySelectorAll("button[data-status]")];
  const cases = [...document.querySelectorAll("[data-case]")];
  const shelves = [...document.querySelectorAll("[data-shelf]")];
  const cards = cases.filter((item) => item.tagName === "LI");
  const texts = new Map();

  /** All that a case or its card can be found by; read from the page when it is first asked for. */
  function textOf(item) {
    const goal = item.querySelector("a.card")?.hash.slice(1);
    const article = goal ? document.getElementById(goal).closest("[data-case]") : item;
    if (!texts.has(article)) {
      // A source that an earlier case shows too stands in the page once.
      const copied = [...article.querySelectorAll("[data-copy]")]
        .map((copy) => document.getElementById(copy.dataset.copy)?.textContent ?? "");
      texts.set(article, [article.dataset.search, article.textContent, ...copied]
        .join(" ").toLowerCase());
    }
    return texts.get(article);
  }

  function update() {
    const words = box.value.toLowerCase().split(/\s+/).filter(Boolean);
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
  form.addEventListener("submit", (event) => event.preventDefault());
  box.addEventListener("input", update);
  for (const button of switches) {
    button.addEventListener("click", () => {
      button.setAttribute("aria-pressed", button.getAttribute("aria-pressed") === "false");
      update();
    });
  }
  document.addEventListener("keydown", (event) => {
    const typing = event.target.closest && event.target.closest("input, textarea, select");
    if (event.key === "/" && !typing && !event.ctrlKey && !event.metaKey && !event.altKey) {
      event.preventDefault();
      box.focus();
    } else if (event.key === "Escape" && event.target === box) {
      box.value = "";
      update();
    }
  });
  // Browsers keep a box's text over a reload.
  update();
}
