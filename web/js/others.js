/** What everybody else does while one leads: stand still, or follow a policy. */

import { byId, fill } from "./dom.js";

/** @param {import("./store.js").Store} store */
export function others(store) {
  const box = byId("others-choice", HTMLElement);
  const choice = byId("others", HTMLSelectElement);
  choice.addEventListener("change", () => store.set({ others: choice.value || null }));
  store.watch((state, before) => {
    box.hidden = !state.scene?.many;
    if (state.policies === before.policies && state.others === before.others && choice.length) return;
    const able = state.policies.filter((one) => !one.problem).map(({ name }) => name);
    const known = able.map((name) => ({ value: name, text: `follow ${name}` }));
    const chosen = able.includes(state.others ?? "") ? state.others : null;
    fill(choice, [{ value: "", text: "stand still" }, ...known], chosen ?? "");
  });
}
