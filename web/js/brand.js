/** What every page has in its head: light or dark, and the sheet of keys. */

import { byId, make } from "./dom.js";
import { turn } from "./scheme.js";

/**
 * Build both buttons, beside what the page has there itself.
 * @param {() => void} showKeys
 */
export function brand(showKeys) {
  const half = make("span", { class: "half", "aria-hidden": "true" });
  const scheme = button("scheme", "Light or dark", "Light or dark", half);
  scheme.addEventListener("click", turn);
  const keys = button("sheet-open", "Keys", "Show the keys", "?");
  keys.setAttribute("aria-haspopup", "dialog");
  keys.addEventListener("click", showKeys);
  byId("brand-does", HTMLElement).append(scheme, keys);
}

/** @param {string} id @param {string} label @param {string} title @param {Node | string} sign */
const button = (id, label, title, sign) =>
  make("button", { id, type: "button", class: "icon", "aria-label": label, title }, sign);
