/** The next decision, where decisions are symbols: what it would be as of now, and when it falls. */

import { byId, make } from "./dom.js";

/** @param {import("./store.js").Store} store */
export function decisions(store) {
  const box = byId("deciding", HTMLElement);
  const list = byId("decisions", HTMLElement);
  const bar = byId("until", HTMLProgressElement);
  let built = "";
  let falls = 0;
  let step = 1;
  let filling = false;

  const fill = () => {
    bar.value = 1 - Math.min(1, Math.max(0, (falls - performance.now()) / 1000 / step));
    filling = !box.hidden;
    if (filling) requestAnimationFrame(fill);
  };

  store.watch(({ scene, status }, before) => {
    if (scene !== null && built !== scene.name) {
      built = scene.name;
      const chip = (/** @type {string} */ name) => make("li", { "data-symbol": name }, name);
      list.replaceChildren(...scene.symbols.map(chip));
    }
    const decision = status?.decision ?? null;
    box.hidden = decision === null;
    if (status === null || status === before.status || decision === null) return;
    box.dataset.mode = status.mode ?? "";
    for (const chip of list.children) {
      chip.classList.toggle("coming", chip.getAttribute("data-symbol") === decision);
    }
    falls = performance.now() + 1000 * (status.decides_s ?? 0);
    step = scene?.dt_s ?? 1;
    if (!filling) fill();
  });
}
