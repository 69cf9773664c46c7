// Shows the cases whose text holds every word of the box and whose status is switched on: their
// titles, lessons, checks and shaders.

/** Each case's words by its anchor: in the page, or in a script of the site. */
const searchWords = (() => {
  let words = null;
  return () => {
    words ??= new Promise((resolve) => {
      const inside = document.getElementById("search");
      if (inside) {
        resolve(Object.fromEntries([...inside.content.children]
          .map((item) => [item.dataset.case, item.textContent])));
        return;
      }
      const script = document.createElement("script");
      script.src = `${document.documentElement.dataset.root}page/search.js`;
      script.onload = () => resolve(globalThis.shaderlabWords);
      script.onerror = () => resolve({});  // titles are found all the same
      document.head.append(script);
    });
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
