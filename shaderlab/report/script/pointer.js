// Mouse, pen and finger on a picture: read, pin, zoom, pan.

/** A press that moves further than this pans; one that does not pins the pixel. */
const STILL = 4;

function watchPointer(inspector, canvas) {
  const { view } = inspector;
  let start = null;
  let panned = false;
  canvas.addEventListener("pointerdown", (event) => {
    if (event.button) return;
    start = { x: event.clientX, y: event.clientY, centre: view.centre };
    panned = false;
  });
  canvas.addEventListener("pointermove", (event) => {
    if (!start || view.zoom === 1) {
      inspector.hover(...view.under(event, canvas));
      return;
    }
    const [dx, dy] = [event.clientX - start.x, event.clientY - start.y];
    if (!panned && Math.hypot(dx, dy) < STILL) return;
    if (!panned) canvas.setPointerCapture(event.pointerId);
    panned = true;
    const scale = view.span[0] / canvas.clientWidth;
    view.moveTo([start.centre[0] - dx * scale, start.centre[1] + dy * scale]);
    inspector.redraw();
  });
  canvas.addEventListener("pointerup", (event) => {
    if (start && !panned) inspector.pin(...view.under(event, canvas));
    start = null;
  });
  canvas.addEventListener("pointercancel", () => { start = null; });
  canvas.addEventListener("pointerleave", () => {
    if (!start || !panned) inspector.hover(null);
  });
  canvas.addEventListener("dblclick", (event) => {
    inspector.zoom(event.shiftKey ? 0.5 : 2, view.under(event, canvas));
  });
  // Without Ctrl the wheel scrolls the page; a trackpad's pinch comes with Ctrl.
  canvas.addEventListener("wheel", (event) => {
    if (!event.ctrlKey && !event.metaKey) return;
    event.preventDefault();
    inspector.zoom(2 ** (-event.deltaY / 120), view.under(event, canvas));
  }, { passive: false });
}
