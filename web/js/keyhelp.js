/** The strip that tells which keys do what, and shows which of them are held. */

import { byId, make } from "./dom.js";
import { keyName } from "./words.js";

/** @typedef {import("./types.js").State} State */

/** @param {string} code */
const key = (code) => make("kbd", { "data-code": code }, keyName(code));

/**
 * Which hints make sense at the moment.
 * @param {State} state
 * @returns {Record<string, boolean>}
 */
function useful({ status }) {
  const acting = ["countdown", "recording", "paused", "playing"].includes(status?.phase ?? "");
  const demonstrating = status?.mode === "demonstrate";
  return {
    steer: demonstrating || (status?.mode ?? null) === null,
    pause: acting,
    again: (status?.mode ?? null) !== null,
    discard: demonstrating,
    stop: (status?.mode ?? null) !== null,
  };
}

/** @param {import("./store.js").Store} store */
export function keyHelp(store) {
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
        make("li", { "data-use": "pause" }, key("Space"), " pause"),
        make("li", { "data-use": "again" }, key("KeyR"), " start again"),
        make("li", { "data-use": "discard" }, key("Backspace"), " throw away"),
        make("li", { "data-use": "stop" }, make("kbd", {}, "Esc"), " stop"),
      );
    }
    const now = useful(state);
    for (const item of list.children) {
      if (item instanceof HTMLElement) item.classList.toggle("idle", !now[item.dataset.use ?? ""]);
    }
  });
}

/** @param {string[]} held */
export function showHeld(held) {
  for (const cap of document.querySelectorAll("kbd[data-code]")) {
    cap.classList.toggle("held", held.includes(/** @type {HTMLElement} */ (cap).dataset.code ?? ""));
  }
}
