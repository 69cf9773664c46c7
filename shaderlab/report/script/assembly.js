// Shows a program's SPIR-V when it is unfolded; until then it lies in the page deflated.
for (const details of document.querySelectorAll("details[data-assembly]")) {
  details.addEventListener("toggle", async () => {
    const packed = document.getElementById(details.dataset.assembly);
    if (!details.open || !packed || details.querySelector("pre")) return;
    const code = document.createElement("pre");
    code.className = "code";
    code.tabIndex = 0;
    code.setAttribute("aria-label", details.querySelector("summary").textContent.trim());
    details.append(code);
    try {
      code.textContent = new TextDecoder().decode(await inflated(packed.content.textContent));
    } catch (error) {
      code.remove();
      console.warn("no assembly here:", error);
    }
  });
}
