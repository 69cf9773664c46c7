// Shows the cases whose text holds every word of the box and whose status is switched on.
const filterForm = document.querySelector(".controls");
if (filterForm) watchFilter(filterForm);

function watchFilter(form) {
  const box = form.querySelector("#find");
  const found = form.querySelector("#found");
  const switches = [...form.querySelectorAll("button[data-status]")];
  const cases = [...document.querySelectorAll("[data-case]")];
  const shelves = [...document.querySelectorAll("[data-shelf]")];
  const cards = cases.filter((item) => item.tagName === "LI");

  function update() {
    const words = box.value.toLowerCase().split(/\s+/).filter(Boolean);
    const off = new Set(switches.filter((b) => b.getAttribute("aria-pressed") === "false")
      .map((b) => b.dataset.status));
    for (const item of cases) {
      item.hidden = off.has(item.dataset.status)
        || !words.every((word) => item.dataset.search.includes(word));
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
