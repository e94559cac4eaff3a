/** The coach's one line: whether what one does can be learned from. */

import { byId, say } from "./dom.js";

/** @type {Record<string, string>} */
const SAYS = {
  seen: "Your decisions show. Go on like that.",
  nothing: "You have hardly steered. Go where something has to be decided.",
  faint: "You correct so early and so little that it hardly shows: wait a moment longer, then steer firmly.",
  hidden: "What you do cannot be told from what the character sees: answer what is near, each time alike.",
};

/** @param {import("./store.js").Store} store */
export function coach(store) {
  const line = byId("coach", HTMLElement);
  store.watch(({ status }) => {
    const advice = status?.mode === "demonstrate" ? status.coach : null;
    line.dataset.advice = advice ?? "";
    say(line, SAYS[advice ?? ""] ?? "");
  });
}
