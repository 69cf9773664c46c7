// Opens whatever is folded around a link's goal, shows it if a filter hid it, and unfolds
// everything for paper.
function reveal() {
  // Anchors of this page are plain letters, digits and hyphens.
  const goal = document.getElementById(location.hash.slice(1));
  if (!goal) return;
  for (let node = goal; node; node = node.parentElement) {
    if (node.tagName === "DETAILS") node.open = true;
    if (node.matches("[data-case], [data-shelf]")) node.hidden = false;
  }
  goal.scrollIntoView();
  if (goal.matches(".check")) inspectWorst(goal);
}
addEventListener("hashchange", reveal);
if (location.hash) reveal();

let folded = [];
addEventListener("beforeprint", () => {
  folded = [...document.querySelectorAll("details:not([open])")];
  for (const item of folded) item.open = true;
});
addEventListener("afterprint", () => {
  for (const item of folded) item.open = false;
});
