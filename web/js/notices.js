/** Short messages that come and go; errors stay until they are closed. */

import { byId, make } from "./dom.js";

const STAY_MS = 6000;
const MOST = 4;

/**
 * @param {string} text
 * @param {"info" | "error"} [level]
 */
export function notify(text, level = "info") {
  withdraw(text);
  const list = byId("notice", HTMLElement);
  const close = make("button", { type: "button", "aria-label": "Close this notice", title: "Close" }, "×");
  const notice = make("div", { class: `notice ${level}` }, make("p", { class: "grow" }, text), close);
  if (level === "error") notice.setAttribute("role", "alert");
  close.addEventListener("click", () => notice.remove());
  list.append(notice);
  while (list.children.length > MOST) list.firstElementChild?.remove();
  if (level === "info") setTimeout(() => notice.remove(), STAY_MS);
}

/**
 * Take a notice back: what it says is over.
 * @param {string} text
 */
export function withdraw(text) {
  for (const old of [...byId("notice", HTMLElement).children]) {
    if (old.querySelector("p")?.textContent === text) old.remove();
  }
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
