/** The takes of the session, kept and trashed. */

import { api } from "./api.js";
import { byId, make, say } from "./dom.js";
import { attempt } from "./notices.js";
import { count, duration, outcomeWords } from "./words.js";

/** @typedef {import("./types.js").Take} Take */
/** @typedef {import("./types.js").Scene} Scene */

/**
 * @param {import("./store.js").Store} store
 * @param {() => Promise<void>} reload
 */
export function takes(store, reload) {
  const list = byId("takes", HTMLElement);
  const box = byId("takes-box", HTMLElement);
  store.watch((state, before) => {
    if (state.takes === before.takes && list.childElementCount === state.takes.length) return;
    const kept = state.takes.filter((take) => !take.trashed).length;
    const trashed = state.takes.length - kept;
    box.hidden = state.takes.length === 0;
    say(
      byId("takes-count", HTMLElement),
      trashed ? `${kept} kept, ${trashed} in the trash` : `${kept} kept`,
    );
    list.replaceChildren(
      ...[...state.takes].reverse().map((take) => row(take, state.scene, reload)),
    );
  });
}

/**
 * @param {Take} take
 * @param {Scene | null} scene
 * @param {() => Promise<void>} reload
 */
function row(take, scene, reload) {
  const good = take.outcome !== null && scene?.successes?.includes(take.outcome);
  const words = take.outcome === null ? "Broken off" : outcomeWords(take.outcome);
  const button = make(
    "button",
    {
      type: "button",
      class: "quiet",
      "aria-label": `${take.trashed ? "Bring back" : "Throw away"} take ${take.number}`,
    },
    take.trashed ? "Bring back" : "Throw away",
  );
  button.addEventListener("click", () =>
    attempt(async () => {
      await (take.trashed ? api.restore(take.id) : api.trash(take.id));
      await reload();
    }),
  );
  return make(
    "li",
    { class: take.trashed ? "trashed" : "", "data-take": String(take.id) },
    make("span", { class: "size" }, `#${take.number}`),
    make("span", { class: `ended ${good ? "good" : ""}` }, words),
    make("span", { class: "size", title: `${count(take.pairs)} pairs` }, duration(take.seconds)),
    button,
  );
}
