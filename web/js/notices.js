/** Short messages that come and go; errors stay until they are closed. */

import { byId, make } from "./dom.js";

const STAY_MS = 6000;
const MOST = 4;

/**
 * @param {string} text
 * @param {"info" | "error"} [level]
 */
export function notify(text, level = "info") {
  const list = byId("notice", HTMLElement);
  for (const old of [...list.children]) {
    if (old.querySelector("p")?.textContent === text) old.remove();
  }
  const close = make("button", { type: "button", "aria-label": "Close this notice" }, "×");
  const notice = make("div", { class: `notice ${level}` }, make("p", { class: "grow" }, text), close);
  if (level === "error") notice.setAttribute("role", "alert");
  close.addEventListener("click", () => notice.remove());
  list.append(notice);
  while (list.children.length > MOST) list.firstElementChild?.remove();
  if (level === "info") setTimeout(() => notice.remove(), STAY_MS);
}

/**
 * Run `work`; what goes wrong becomes a notice.
 * @param {() => Promise<void> | void} work
 */
export async function attempt(work) {
  try {
    await work();
  } catch (error) {
    notify(error instanceof Error ? error.message : String(error), "error");
  }
}
