// Starts an inspector where pictures with numbers come into sight, or when a link leads there.
const inspectors = new WeakMap();

/** The inspector of a group of pictures, made now if there is none; null without its numbers. */
function inspectorOf(group) {
  if (!inspectors.has(group)) {
    inspectors.set(group, (async () => {
      try {
        const values = await unpackValues(group.querySelector("template").content.textContent);
        return new Inspector(group, values);
      } catch (error) {
        // The pictures stay as they are.
        console.warn("no inspector here:", error);
        return null;
      }
    })());
  }
  return inspectors.get(group);
}

if ("DecompressionStream" in window) {
  const seen = new IntersectionObserver((entries) => {
    for (const entry of entries) {
      if (!entry.isIntersecting) continue;
      seen.unobserve(entry.target);
      inspectorOf(entry.target);
    }
  }, { rootMargin: "300px" });
  for (const group of document.querySelectorAll("[data-inspect]")) seen.observe(group);
}

/** Shows the worst pixel of the first pictures inside an element. */
async function inspectWorst(element) {
  const group = element.querySelector("[data-inspect]");
  const inspector = group && await inspectorOf(group);
  inspector?.showWorst();
}
