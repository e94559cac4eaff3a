/** How fast time goes on the stage: slow motion, in which one steers with more time to think. */

import { byId, say } from "./dom.js";

const KEPT = "evastudio.pace";
/** Shares of real time. */
const PACES = [0.25, 0.5, 0.75, 1];

/**
 * @param {import("./store.js").Store} store
 * @param {(pace: number) => void} choose
 */
export function pace(store, choose) {
  const figure = byId("pace-is", HTMLElement);
  const box = byId("pace", HTMLElement);
  const slower = byId("slower", HTMLButtonElement);
  const faster = byId("faster", HTMLButtonElement);
  const chosen = () => Number(localStorage.getItem(KEPT) ?? 1);
  const now = () => store.state.status?.pace ?? chosen();

  /** @param {number} way 1 faster, -1 slower */
  function step(way) {
    const found = way > 0 ? PACES.find((one) => one > now()) : PACES.findLast((one) => one < now());
    if (found === undefined) return;
    localStorage.setItem(KEPT, String(found));
    choose(found);
  }
  slower.addEventListener("click", () => step(-1));
  faster.addEventListener("click", () => step(1));
  store.watch(() => {
    say(figure, `${Math.round(100 * now())} %`);
    box.classList.toggle("slowed", now() < 1);
    slower.setAttribute("aria-disabled", String(now() <= PACES[0]));
    faster.setAttribute("aria-disabled", String(now() >= 1));
  });
  return { step, chosen };
}
