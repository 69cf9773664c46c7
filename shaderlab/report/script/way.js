// Marks the chapter that is being read in the line of chapters at the top; on a case's own page the
// chapter is marked already.
const way = document.querySelector(".way");
if (way && !document.documentElement.dataset.root) followChapters(way);
const marked = way?.querySelector("[aria-current]");
if (marked) marked.closest("ol").scrollLeft = marked.offsetLeft - marked.closest("ol").offsetLeft;

function followChapters(nav) {
  const links = [...nav.querySelectorAll("ol a")];
  const heads = links.map((link) => document.getElementById(link.hash.slice(1)));
  let current = null;
  let waiting = false;

  function mark() {
    waiting = false;
    const line = nav.getBoundingClientRect().bottom + 90;
    // A hidden chapter's heading has no place.
    const passed = heads.filter((head) => head.offsetParent
      && head.getBoundingClientRect().top < line);
    const next = passed.length ? links[heads.indexOf(passed.at(-1))] : null;
    if (next === current) return;
    current?.removeAttribute("aria-current");
    current = next;
    if (!current) return;
    current.setAttribute("aria-current", "true");
    // Only the line itself is scrolled, never the page.
    const list = current.closest("ol");
    list.scrollLeft = current.offsetLeft - list.offsetLeft - list.clientWidth / 3;
  }

  addEventListener("scroll", () => {
    if (!waiting) requestAnimationFrame(mark);
    waiting = true;
  }, { passive: true });
  mark();
}
