/** The sheet of keys, and what the page says of keys at each control. */

import { brand } from "./brand.js";
import { make } from "./dom.js";
import { Keys } from "./keys.js";
import { meaningOf } from "./meaning.js";
import { WITHOUT } from "./shortcuts.js";
import { keyName } from "./words.js";

/** @typedef {import("./shortcuts.js").Group} Group */
/** @typedef {import("./shortcuts.js").Shortcut} Shortcut */
/** @typedef {import("./types.js").Scene} Scene */

/** @param {string} words */
const begun = (words) => words.charAt(0).toUpperCase() + words.slice(1);

/** @param {string} key */
const cap = (key) => make("kbd", {}, keyName(key));

/** As `aria-keyshortcuts` wants it. @param {string} key */
const told = (key) => key.replace("Ctrl", "Control").replace(/Key(?=\w$)|Digit/, "");

/**
 * Say at a control what it does and by which key; where it says why it does not, leave that.
 * @param {HTMLElement} control
 * @param {Shortcut} shortcut
 */
function mark(control, { keys, words }) {
  if (control.dataset.tip !== undefined) return;
  const barred = control.getAttribute("aria-disabled") === "true";
  const says = (!barred && control.title) || begun(words);
  control.dataset.tip = `${says} (${keyName(keys[0])})`;
  control.setAttribute("aria-keyshortcuts", keys.map(told).join(" "));
  if (!barred) control.title = control.dataset.tip;
}

/**
 * Say so at every control that does what the table says, also at those that come later.
 * @param {Group[]} groups
 */
function tips(groups) {
  const rows = groups.flatMap(({ shortcuts }) => shortcuts);
  const all = () => {
    for (const row of rows) {
      const selectors = [row.on, `[data-does="${row.does}"]`].filter(Boolean).join();
      for (const control of document.querySelectorAll(selectors)) {
        mark(/** @type {HTMLElement} */ (control), row);
      }
    }
  };
  new MutationObserver((changes) => {
    const made = changes.some(({ addedNodes }) => [...addedNodes].some((one) => one.nodeType === 1));
    if (made) all();
  }).observe(document.body, { childList: true, subtree: true });
  all();
}

/** @typedef {import("./shortcuts.js").State} State */

/** @type {State} */
const STILL = { status: null, scene: null, conflict: null };
const nothing = () => {};

/**
 * How a page stands on which nothing is steered, with a timeline to go through or without.
 * @param {boolean} there
 * @returns {State}
 */
export const throughTime = (there) =>
  there ? /** @type {State} */ ({ ...STILL, status: { mode: "review" } }) : STILL;

/**
 * Keys of a page on which nothing is steered: each presses its control, or is given to `command`.
 * @param {Group[]} groups
 * @param {(name: string) => void} [command]
 * @param {() => State} [state]
 */
export function pageKeys(groups, command = nothing, state = () => STILL) {
  return new Keys(
    (event, onControl) => meaningOf(groups, state(), event, onControl),
    nothing,
    command,
    nothing,
    nothing,
  );
}

/** @param {string} title @param {[string[], string][]} rows */
function part(title, rows) {
  const lines = rows.map(([keys, words]) =>
    make("div", {}, make("dt", {}, ...keys.map(cap)), make("dd", {}, begun(words))),
  );
  return make("section", {}, make("h3", {}, title), make("dl", {}, ...lines));
}

/** What the scene itself makes of keys. @param {Scene} scene */
function ofScene({ title, controls, signals }) {
  /** @type {[string[], string][]} */
  const rows = controls.map(({ label, negative, positive }) => [
    positive.flatMap((code, i) => [code, negative[i]].filter(Boolean)),
    label,
  ]);
  for (const { key, label } of signals) rows.push([[key], label]);
  return part(title, rows);
}

/**
 * The sheet of `groups`, opened by its button; the switch between light and dark beside it.
 * @param {Group[]} groups
 * @param {() => Scene | null} [scene] whose keys come first
 */
export function sheet(groups, scene = () => null) {
  const close = make("button", { type: "button", class: "quiet", title: "Close (Esc)" }, "Close");
  const parts = make("div", { class: "sheet-parts" });
  const dialog = make(
    "dialog",
    { id: "sheet", class: "sheet", "aria-labelledby": "sheet-title" },
    make("header", {}, make("h2", { id: "sheet-title" }, "Keys"), close),
    parts,
  );
  document.body.append(dialog);
  close.addEventListener("click", () => dialog.close());
  // A click beside it: the dialog itself is all padding's edge.
  dialog.addEventListener("click", ({ target }) => target === dialog && dialog.close());

  brand(() => {
    const now = scene();
    parts.replaceChildren(
      ...(now ? [ofScene(now)] : []),
      ...groups.map(({ title, shortcuts }) =>
        part(title, shortcuts.map(({ keys, words }) => [keys, words])),
      ),
      rest(),
    );
    dialog.showModal();
  });
  tips(groups);
}

/** What has no key of its own, and why. */
function rest() {
  const lines = WITHOUT.map(([, what, why]) =>
    make("div", {}, make("dt", {}, what), make("dd", {}, why)),
  );
  return make("section", { class: "rest" }, make("h3", {}, "Without a key"), make("dl", {}, ...lines));
}
