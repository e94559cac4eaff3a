/** The gauge: how much what plays has come to is like what was demonstrated, as it plays. */

import { byId, say } from "./dom.js";
import { familiarColor, familiarWords } from "./strip.js";

/** @typedef {import("./types.js").Status} Status */

/** How long the bar is where all is as familiar as can be, and at least, in its own units. */
const LONG = 120;
const SHORT = 8;

/** @param {Status | null} status */
const shown = (status) =>
  status !== null &&
  ["play", "correct"].includes(status.mode ?? "") &&
  ["playing", "paused", "recording", "ended"].includes(status.phase);

/** @param {Status} status */
function words({ mode, phase, familiarity, silent }) {
  if (mode === "correct" && phase !== "ended") return "You steer, and it is recorded";
  if (silent !== null) return "Cannot tell how like your takes";
  const known = familiarWords(familiarity);
  return known ? known.charAt(0).toUpperCase() + known.slice(1) : "";
}

/**
 * @param {import("./store.js").Store} store
 * @param {() => void} ask why it does that
 */
export function gauge(store, ask) {
  const button = byId("gauge", HTMLButtonElement);
  const says = byId("gauge-says", HTMLElement);
  const fill = byId("gauge-fill", SVGRectElement);
  const hint = byId("gauge-why", HTMLElement);
  button.addEventListener("click", ask);

  store.watch(({ status }) => {
    button.hidden = !shown(status);
    if (status === null || button.hidden) return;
    say(says, words(status));
    const known = status.mode === "play" ? status.familiarity : null;
    fill.classList.toggle("idle", known === null);
    fill.setAttribute("width", String(Math.max(SHORT, Math.round((known ?? 0) * LONG))));
    fill.setAttribute("fill", familiarColor(known ?? 0));
    hint.classList.toggle("idle", status.mode !== "play");
  });
}
