// Mouse, pen and fingers on a picture: read, pin, zoom, pan.

/** A press that moves further than this pans; one that does not pins the pixel. */
const STILL = 4;

function watchPointer(inspector, canvas) {
  const { view } = inspector;
  const fingers = new Map();
  let start = null;
  let panned = false;
  canvas.addEventListener("pointerdown", (event) => {
    if (event.button) return;
    fingers.set(event.pointerId, event);
    start = { x: event.clientX, y: event.clientY, centre: view.centre };
    // A pinch ends without pinning anything.
    panned = fingers.size > 1;
  });
  canvas.addEventListener("pointermove", (event) => {
    if (fingers.size === 2 && fingers.has(event.pointerId)) {
      pinch(event);
      return;
    }
    if (!start || view.zoom === 1) {
      if (!panned) inspector.hover(...view.under(event, canvas));
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

  /** Two fingers: what lies between them stays there, and grows as they part. */
  function pinch(event) {
    const apart = () => {
      const [a, b] = [...fingers.values()];
      return [Math.hypot(a.clientX - b.clientX, a.clientY - b.clientY),
        { clientX: (a.clientX + b.clientX) / 2, clientY: (a.clientY + b.clientY) / 2 }];
    };
    const [before, middle] = apart();
    const held = view.under(middle, canvas);
    fingers.set(event.pointerId, event);
    const [now, moved] = apart();
    view.zoomBy(now / Math.max(before, 1), held);
    const under = view.under(moved, canvas);
    view.moveTo(view.centre.map((c, n) => c + held[n] - under[n]));
    inspector.redraw();
  }

  canvas.addEventListener("pointerup", (event) => {
    if (start && !panned) inspector.pin(...view.under(event, canvas));
    lift(event);
  });
  canvas.addEventListener("pointercancel", lift);
  function lift(event) {
    fingers.delete(event.pointerId);
    const [left] = fingers.values();
    start = left ? { x: left.clientX, y: left.clientY, centre: view.centre } : null;
    if (!left) panned = false;
  }
  // The page scrolls with one finger, and neither scrolls nor zooms with two.
  for (const name of ["touchstart", "touchmove"]) {
    canvas.addEventListener(name, (event) => {
      if (event.touches.length > 1) event.preventDefault();
    }, { passive: false });
  }
  canvas.addEventListener("pointerleave", (event) => {
    fingers.delete(event.pointerId);
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
