// What is drawn over the pictures: the pixel that is read, the worst one, values outside.

/** A frame around the pixel that is read, light and dark so that it shows on any colour. */
function cross(context, view, [x, y], ratio) {
  const [left, top, side] = view.square(x, y, context.canvas);
  const size = Math.max(side, 7 * ratio);
  const shift = (size - side) / 2;
  for (const [colour, width] of [["#000", 3], ["#fff", 1.2]]) {
    context.strokeStyle = colour;
    context.lineWidth = width * ratio;
    context.strokeRect(left - shift, top - shift, size, size);
  }
}

/** A ring around the worst pixel. */
function ring(context, view, [x, y], ratio) {
  const [left, top, side] = view.square(x, y, context.canvas);
  const radius = Math.max(side, 9 * ratio);
  for (const [colour, width] of [["#fff", 4.5], ["#c01010", 2.2]]) {
    context.strokeStyle = colour;
    context.lineWidth = width * ratio;
    context.beginPath();
    context.arc(left + side / 2, top + side / 2, radius, 0, 2 * Math.PI);
    context.stroke();
  }
}

/** The second colour of the check over values outside, where their squares are large enough. */
function checkOutside(context, view, pixels) {
  if (context.canvas.width / view.span[0] < 3) return;
  context.fillStyle = `rgb(${colours.outside[1].join(" ")})`;
  for (const [x, y] of pixels) {
    const [left, top, side] = view.square(x, y, context.canvas);
    context.fillRect(left, top, side / 2, side / 2);
    context.fillRect(left + side / 2, top + side / 2, side / 2, side / 2);
  }
}
