/** Short messages that come and go. */

import { byId, make } from "./dom.js";

const STAY_MS = 6000;
/** What was refused stays longer: it has to be read. */
const REFUSED_MS = 15000;
const MOST = 4;

/**
 * @param {string} text
 * @param {"info" | "error"} [level]
 * @param {boolean} [lasting] until it is closed or taken back: what holds whatever is done next
 */
export function notify(text, level = "info", lasting = false) {
  withdraw(text);
  const list = byId("notice", HTMLElement);
  const close = make("button", { type: "button", "aria-label": "Close this notice", title: "Close" }, "×");
  const notice = make("div", { class: `notice ${level}` }, make("p", { class: "grow" }, text), close);
  if (level === "error") notice.setAttribute("role", "alert");
  close.addEventListener("click", () => notice.remove());
  list.append(notice);
  while (list.children.length > MOST) list.firstElementChild?.remove();
  if (lasting) return;
  if (level === "error") notice.dataset.refused = "";
  fade(notice, level === "info" ? STAY_MS : REFUSED_MS);
}

/** Let it go after a while, but not from under who points at it. @param {HTMLElement} notice @param {number} ms */
function fade(notice, ms) {
  setTimeout(() => {
    if (notice.matches(":hover, :focus-within")) fade(notice, ms);
    else notice.remove();
  }, ms);
}

/** Take back what was refused: something else was begun since. */
export function goOn() {
  for (const old of [...byId("notice", HTMLElement).children]) {
    if (old instanceof HTMLElement && "refused" in old.dataset) old.remove();
  }
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
