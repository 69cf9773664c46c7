// A source that an earlier case shows too stands in the page once; here it is copied when opened.
for (const details of document.querySelectorAll("details[data-copy]")) {
  details.addEventListener("toggle", () => {
    const shown = document.getElementById(details.dataset.copy);
    if (!details.open || !shown || details.querySelector("pre")) return;
    const copy = shown.querySelector("pre").cloneNode(true);
    // Its lines' anchors are the first one's.
    for (const row of copy.querySelectorAll("[id]")) row.removeAttribute("id");
    details.querySelector("p").replaceWith(copy);
  });
}
