/** How steering feels: sensitivity, ramp, the view as a stick, and whether a gamepad is there. */

import { byId, say } from "./dom.js";

const KEPT = "evastudio.feel";
const USUAL = { sensitivity: 1, ramp: 1, drag: false };

/** @returns {typeof USUAL} */
function kept() {
  try {
    return { ...USUAL, ...JSON.parse(localStorage.getItem(KEPT) ?? "{}") };
  } catch {
    return { ...USUAL };
  }
}

/**
 * @param {{changed: (feel: typeof USUAL) => void}} act
 */
export function feel({ changed }) {
  const now = kept();
  const drag = byId("drag", HTMLInputElement);

  function tell() {
    localStorage.setItem(KEPT, JSON.stringify(now));
    show();
    changed(now);
  }
  function show() {
    drag.checked = now.drag;
    for (const name of /** @type {const} */ (["sensitivity", "ramp"])) {
      byId(name, HTMLInputElement).valueAsNumber = Math.round(100 * now[name]);
      say(byId(`${name}-is`, HTMLElement), `${Math.round(100 * now[name])} %`);
    }
  }
  for (const name of /** @type {const} */ (["sensitivity", "ramp"])) {
    const slider = byId(name, HTMLInputElement);
    slider.addEventListener("input", () => {
      now[name] = slider.valueAsNumber / 100;
      tell();
    });
  }
  drag.addEventListener("change", () => {
    now.drag = drag.checked;
    tell();
  });
  show();
  return {
    now,
    /** Let drags in the view steer, or turn the camera. */
    toggle() {
      now.drag = !now.drag;
      tell();
      return now.drag;
    },
    /** @param {string | null} name of the gamepad */
    gamepad(name) {
      const known = name?.replace(/\s*\(.*/, "") ?? "";
      say(byId("gamepad", HTMLElement), known ? `Gamepad: ${known}` : "No gamepad. Connect one and press a button on it.");
    },
  };
}
