// What is folded away: filled when it is opened, and opened around a link's goal.

/** Calls fill(details) when one is opened whose code is not there yet. */
function fillOnOpening(selector, fill) {
  for (const details of document.querySelectorAll(selector)) {
    details.addEventListener("toggle", () => {
      if (details.open && !details.querySelector("pre")) fill(details);
    });
  }
}

// A program's SPIR-V lies in the page deflated.
fillOnOpening("details[data-assembly]", async (details) => {
  const packed = document.getElementById(details.dataset.assembly);
  if (!packed) return;
  const code = document.createElement("pre");
  code.className = "code";
  code.tabIndex = 0;
  code.setAttribute("role", "group");
  code.setAttribute("aria-label", details.querySelector("summary").textContent.trim());
  details.append(code);
  try {
    code.textContent = new TextDecoder().decode(await inflated(packed.content.textContent));
  } catch (error) {
    code.remove();
    console.warn("no assembly here:", error);
  }
});

// A source that an earlier case shows too stands in the page once.
fillOnOpening("details[data-copy]", (details) => {
  const shown = document.getElementById(details.dataset.copy);
  if (!shown) return;
  const copy = shown.querySelector("pre").cloneNode(true);
  // Its lines' anchors are the first one's.
  for (const row of copy.querySelectorAll("[id]")) row.removeAttribute("id");
  details.querySelector("p").replaceWith(copy);
});

/** The page of the case that has an anchor; null where no card of this page leads there. */
function pageOf(anchor) {
  const cards = [...document.querySelectorAll("a.card[data-source]")];
  const line = /^s(\d+)(-L\d+)?$/.exec(anchor);
  const nameOf = (card) => card.closest("[data-case]").dataset.case;
  const found = line
    // Texts are numbered from the first case to the last.
    ? cards.filter((card) => Number(card.dataset.source) <= Number(line[1])).at(-1)
    : cards.filter((card) => anchor === nameOf(card) || anchor.startsWith(`${nameOf(card)}-`))
      .sort((one, other) => nameOf(one).length - nameOf(other).length).at(-1);
  return found ? found.getAttribute("href") : null;
}

function reveal() {
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
    inspectWorst(goal);
  }
  arriveAt(goal);
}

/** Scrolls to an element, again while what comes before it gets its size, unless someone else
    scrolls. */
function arriveAt(goal) {
  const theirs = new AbortController();
  for (const name of ["wheel", "touchstart", "keydown", "pointerdown"]) {
    addEventListener(name, () => theirs.abort(), { once: true, signal: theirs.signal });
  }
  let frames = 30;
  const again = () => {
    if (theirs.signal.aborted) return;
    goal.scrollIntoView({ behavior: "instant" });
    frames -= 1;
    if (frames) requestAnimationFrame(again);
    else theirs.abort();
  };
  again();
}
addEventListener("hashchange", reveal);
if (location.hash) reveal();
