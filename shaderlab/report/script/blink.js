// Two runs' pictures of one variant in one place, one after the other, while a button is on.
const BLINK_MS = 500;

for (const figure of document.querySelectorAll(".blink")) blinkable(figure);

function blinkable(figure) {
  const images = [...figure.querySelectorAll("img")];
  const which = figure.querySelector(".which");
  const button = document.createElement("button");
  let timer = 0;
  let shown = 1;
  if (images.length < 2) return;
  button.type = "button";
  button.textContent = "blink";
  button.setAttribute("aria-pressed", "false");
  figure.querySelector("figcaption").append(button);

  function turn() {
    shown = 1 - shown;
    images.forEach((image, n) => image.classList.toggle("is-off", n !== shown));
    which.textContent = shown ? "now" : "before";
  }

  button.addEventListener("click", () => {
    const on = !timer;
    clearInterval(timer);
    timer = on ? setInterval(turn, BLINK_MS) : 0;
    button.setAttribute("aria-pressed", String(on));
    figure.classList.toggle("is-stacked", on);
    if (on) turn();
    else which.textContent = "before and now";
  });
}
