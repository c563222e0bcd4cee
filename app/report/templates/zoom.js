"use strict";
// A click on a figure shows it alone; the wheel zooms, dragging moves, a double click shows all of it.
(() => {
  const dialog = document.createElement("dialog");
  dialog.className = "zoom";
  document.body.append(dialog);
  const close = () => dialog.close();
  const show = (figure) => {
    const svg = figure.cloneNode(true);
    svg.removeAttribute("tabindex");
    const whole = { ...box(svg) };
    let view = { ...whole };
    let grip = null;
    const set = (next) => {
      view = next;
      svg.setAttribute("viewBox", `${view.x} ${view.y} ${view.width} ${view.height}`);
    };
    const at = (event) => {
      const place = new DOMPoint(event.clientX, event.clientY);
      return place.matrixTransform(svg.getScreenCTM().inverse());
    };
    svg.addEventListener("wheel", (event) => {
      event.preventDefault();
      const factor = Math.exp(0.002 * event.deltaY);
      if (view.width * factor > 1.02 * whole.width) { set({ ...whole }); return; }
      const { x, y } = at(event);
      set({
        x: x - (x - view.x) * factor, y: y - (y - view.y) * factor,
        width: view.width * factor, height: view.height * factor,
      });
    }, { passive: false });
    svg.addEventListener("pointerdown", (event) => { grip = at(event); svg.setPointerCapture(event.pointerId); });
    svg.addEventListener("pointermove", (event) => {
      if (grip === null) return;
      const { x, y } = at(event);
      set({ ...view, x: view.x + grip.x - x, y: view.y + grip.y - y });
    });
    svg.addEventListener("pointerup", () => { grip = null; });
    svg.addEventListener("dblclick", () => set({ ...whole }));
    const button = document.createElement("button");
    button.textContent = "Close";
    button.addEventListener("click", close);
    const words = document.createElement("p");
    words.textContent = "Wheel: zoom. Drag: move. Double click: all.";
    dialog.replaceChildren(svg, words, button);
    dialog.showModal();
  };
  const box = (svg) => {
    const { x, y, width, height } = svg.viewBox.baseVal;
    return { x, y, width, height };
  };
  for (const svg of document.querySelectorAll("figure svg")) {
    svg.setAttribute("tabindex", "0");
    svg.addEventListener("click", () => show(svg));
    svg.addEventListener("keydown", (event) => { if (event.key === "Enter") show(svg); });
  }
})();
