"use strict";
// A click on a figure shows it alone; wheel, keys, buttons and two fingers zoom, dragging and arrow keys move.
(() => {
  const MOST = 40; // times enlarged
  const STEP = 1.25, MOVE = 0.1;
  const dialog = document.createElement("dialog");
  dialog.className = "zoom";
  document.body.append(dialog);
  dialog.addEventListener("close", () => dialog.replaceChildren());

  const made = (name, text, act) => {
    const node = document.createElement(name);
    node.textContent = text;
    if (act) node.addEventListener("click", act);
    return node;
  };

  // The svg with its view, moved and zoomed within the whole of it.
  const viewer = (svg) => {
    const { x, y, width, height } = svg.viewBox.baseVal;
    const whole = { x, y, width, height };
    let view = { ...whole };
    const set = (next) => {
      view = next;
      svg.setAttribute("viewBox", `${view.x} ${view.y} ${view.width} ${view.height}`);
    };
    const all = () => set({ ...whole });
    const move = (right, down) => set({ ...view, x: view.x + right, y: view.y + down });
    const zoom = (factor, place) => {
      const wanted = view.width * factor;
      if (wanted > 1.02 * whole.width) { all(); return; }
      const least = Math.max(factor, whole.width / MOST / view.width);
      const about = place || { x: view.x + view.width / 2, y: view.y + view.height / 2 };
      set({
        x: about.x - (about.x - view.x) * least, y: about.y - (about.y - view.y) * least,
        width: view.width * least, height: view.height * least,
      });
    };
    const step = (right, down) => move(right * MOVE * view.width, down * MOVE * view.height);
    return { all, move, zoom, step };
  };

  const pointers = (svg, view) => {
    const held = new Map();
    const at = ({ clientX, clientY }) =>
      new DOMPoint(clientX, clientY).matrixTransform(svg.getScreenCTM().inverse());
    const spread = () => {
      const [a, b] = [...held.values()];
      return Math.hypot(a.clientX - b.clientX, a.clientY - b.clientY);
    };
    const middle = () => {
      const all = [...held.values()];
      return {
        clientX: all.reduce((sum, one) => sum + one.clientX, 0) / all.length,
        clientY: all.reduce((sum, one) => sum + one.clientY, 0) / all.length,
      };
    };
    svg.addEventListener("wheel", (event) => {
      event.preventDefault();
      view.zoom(Math.exp(0.002 * event.deltaY), at(event));
    }, { passive: false });
    svg.addEventListener("pointerdown", (event) => {
      held.set(event.pointerId, event);
      svg.setPointerCapture(event.pointerId);
    });
    svg.addEventListener("pointermove", (event) => {
      if (!held.has(event.pointerId)) return;
      const from = at(middle()), wide = held.size === 2 ? spread() : 0;
      held.set(event.pointerId, event);
      const to = at(middle());
      view.move(from.x - to.x, from.y - to.y);
      if (wide) view.zoom(wide / Math.max(spread(), 1), at(middle()));
    });
    for (const end of ["pointerup", "pointercancel"])
      svg.addEventListener(end, (event) => held.delete(event.pointerId));
    svg.addEventListener("dblclick", view.all);
  };

  const keys = (view) => ({
    "+": () => view.zoom(1 / STEP), "=": () => view.zoom(1 / STEP), "-": () => view.zoom(STEP), "0": view.all,
    ArrowLeft: () => view.step(-1, 0), ArrowRight: () => view.step(1, 0),
    ArrowUp: () => view.step(0, -1), ArrowDown: () => view.step(0, 1),
  });

  const show = (figure) => {
    const svg = figure.cloneNode(true);
    svg.removeAttribute("tabindex");
    const view = viewer(svg);
    pointers(svg, view);
    const acts = keys(view);
    dialog.onkeydown = (event) => {
      const act = acts[event.key];
      if (act && !event.ctrlKey && !event.metaKey) { event.preventDefault(); act(); }
    };
    dialog.setAttribute("aria-label", svg.getAttribute("aria-label"));
    // A legend that several figures share stands outside of them.
    const group = figure.closest(".pair, .triple");
    const legend = group && group.previousElementSibling;
    const words = made("p", "Wheel or + and −: zoom. Drag or arrow keys: move. 0: all of it. Esc: close.");
    const bar = document.createElement("div");
    bar.append(
      made("button", "+", acts["+"]), made("button", "−", acts["-"]), made("button", "All", view.all),
      made("button", "Close", () => dialog.close()),
    );
    const under = document.createElement("div");
    if (legend && legend.classList.contains("legend")) under.append(legend.cloneNode(true));
    under.append(words);
    dialog.replaceChildren(svg, under, bar);
    dialog.showModal();
    bar.lastChild.focus();
  };

  for (const svg of document.querySelectorAll("figure svg")) {
    svg.setAttribute("tabindex", "0");
    svg.addEventListener("click", () => show(svg));
    svg.addEventListener("keydown", (event) => {
      if (event.key !== "Enter" && event.key !== " ") return;
      event.preventDefault(); // or the same key presses the button that gets the focus
      show(svg);
    });
  }
})();
