/**
 * Light or dark: the browser's, until the other is chosen on the page, which is remembered.
 *
 * A page loads this before it is drawn, so that it never shows the wrong one first.
 */

/** @typedef {"light" | "dark"} Scheme */

const CHOSEN = "evastudio.scheme";
const prefersDark = matchMedia("(prefers-color-scheme: dark)");
/** @type {Set<(scheme: Scheme) => void>} */
const watchers = new Set();

/** The browser's own. @returns {Scheme} */
const usual = () => (prefersDark.matches ? "dark" : "light");

/** The one that holds. @returns {Scheme} */
export function scheme() {
  const chosen = localStorage.getItem(CHOSEN);
  return chosen === "light" || chosen === "dark" ? chosen : usual();
}

/** Show the other one from now on; where that is the browser's, follow the browser again. */
export function turn() {
  const other = scheme() === "dark" ? "light" : "dark";
  if (other === usual()) localStorage.removeItem(CHOSEN);
  else localStorage.setItem(CHOSEN, other);
  show();
}

/**
 * Call `watcher` now and after every change.
 * @param {(scheme: Scheme) => void} watcher
 */
export function watchScheme(watcher) {
  watchers.add(watcher);
  watcher(scheme());
}

/** The address of a 3D view that suits. @param {string} view */
export const viewed = (view) => `${view}${scheme()}/`;

function show() {
  document.documentElement.dataset.scheme = scheme();
  for (const watcher of watchers) watcher(scheme());
}

prefersDark.addEventListener("change", show);
addEventListener("storage", ({ key }) => key === CHOSEN && show()); // chosen on another page
show();
