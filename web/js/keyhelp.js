/** The strip that tells which keys do what, and shows which of them are held. */

import { byId, make } from "./dom.js";
import { keyOf, thrown } from "./shortcuts.js";
import { keyName } from "./words.js";

/** @typedef {import("./types.js").State} State */

/** @param {string} code */
const key = (code) => make("kbd", { "data-code": code }, keyName(code));

/** What can be done by a key or a click: [use, command, words]. */
const DOES = [
  ["pause", "pause", "pause"],
  ["resume", "resume", "go on"],
  ["over", "take-over", "take over"],
  ["back", "hand-back", "hand back"],
  ["again", "restart", "start again"],
  ["same", "restart-same", "same world again"],
  ["there", "restart-same", "try again from there"],
  ["keep", "keep-last", "keep the last"],
  ["discard", "discard", "throw away"],
  ["series", "automatic", "take after take"],
  ["look", "look-back", "look back"],
  ["stop", "stop", "stop"],
];
/** Seconds that can be kept of a take's end. */
const ENDS = [2, 3, 5, 10, 20];
const ENDS_WITH = "evastudio.keep";

/** How much of a take's end is kept. */
export const keptSeconds = () => Number(localStorage.getItem(ENDS_WITH) ?? 5);

/**
 * Which hints make sense at the moment.
 * @param {State} state
 * @returns {Record<string, boolean>}
 */
function useful(state) {
  const { status } = state;
  const { phase = "ready", mode = null } = status ?? {};
  const demonstrating = mode === "demonstrate";
  const correcting = mode === "correct" && phase !== "ended";
  const on = mode !== null && mode !== "review";
  const still = phase === "paused" || phase === "ended";
  return {
    steer: demonstrating || correcting || mode === null,
    over: mode === "play" && ["playing", "paused"].includes(phase),
    back: correcting,
    pause: ["countdown", "recording", "playing"].includes(phase),
    resume: phase === "paused",
    again: on || thrown(state),
    same: on && still && !status?.forked,
    there: on && still && !!status?.forked,
    keep: demonstrating && phase !== "countdown" && !!status?.pairs,
    discard: demonstrating || correcting,
    series: demonstrating && !status?.automatic,
    look: on && still,
    stop: on,
  };
}

/**
 * @param {import("./store.js").Store} store
 * @param {(name: string) => void} command
 */
export function keyHelp(store, command) {
  const list = byId("keys", HTMLElement);
  let built = "";
  store.watch((state) => {
    const { scene } = state;
    if (scene === null) return;
    if (built !== scene.name) {
      built = scene.name;
      list.replaceChildren(
        ...scene.controls.map(({ label, negative, positive }) => {
          const keys = positive.flatMap((code, i) => [code, negative[i]].filter(Boolean).map(key));
          return make("li", { "data-use": "steer" }, ...keys, ` ${label}`);
        }),
        ...DOES.map(([use, name, words]) => {
          const cap = make("kbd", {}, keyName(keyOf(name)));
          const button = make("button", { type: "button", "data-does": name }, cap, words);
          button.addEventListener("click", () => command(name));
          return make("li", { "data-use": use }, button, ...(use === "keep" ? [ends()] : []));
        }),
      );
    }
    const now = useful(state);
    for (const item of list.children) {
      if (item instanceof HTMLElement) item.classList.toggle("idle", !now[item.dataset.use ?? ""]);
    }
  });
}

/** Of how many seconds a take's end is kept. */
function ends() {
  const words = "How much of the end is kept";
  const select = make("select", { "aria-label": words, title: words });
  for (const seconds of ENDS) {
    const option = make("option", { value: String(seconds) }, `${seconds} s`);
    option.selected = seconds === keptSeconds();
    select.append(option);
  }
  select.addEventListener("change", () => localStorage.setItem(ENDS_WITH, select.value));
  return select;
}

/** @param {string[]} held */
export function showHeld(held) {
  for (const cap of document.querySelectorAll("kbd[data-code]")) {
    cap.classList.toggle("held", held.includes(/** @type {HTMLElement} */ (cap).dataset.code ?? ""));
  }
}
