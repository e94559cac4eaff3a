/** Which policy plays, and how the next one is fitted. */

import { byId, fill, say } from "./dom.js";

/** @typedef {import("./types.js").Policy} Policy */

/** @param {Policy} policy */
function text({ name, shipped, made_before, problem }) {
  const marks = [];
  if (problem) marks.push("cannot play");
  else if (made_before) marks.push(made_before);
  if (shipped) marks.push("comes with the studio");
  return marks.length ? `${name} (${marks.join(", ")})` : name;
}

/** @param {import("./store.js").Store} store */
export function policies(store) {
  const choice = byId("policy", HTMLSelectElement);
  choice.addEventListener("change", () => store.set({ policy: choice.value }));
  for (const radio of document.querySelectorAll('input[name="learner"]')) {
    radio.addEventListener("change", () => {
      const { value } = /** @type {HTMLInputElement} */ (radio);
      store.set({ learner: value });
    });
  }
  const sees = byId("sees", HTMLSelectElement);
  sees.addEventListener("change", () => store.set({ perception: sees.value }));
  store.watch((state, before) => {
    if (state.scene?.name !== before.scene?.name && state.perception !== null) {
      return store.set({ perception: null });
    }
    const perceptions = state.scene?.perceptions ?? [];
    byId("sees-box", HTMLElement).hidden = perceptions.length < 2;
    const seen = perceptions.find(({ name }) => name === state.perception) ?? perceptions[0];
    fill(sees, perceptions.map(({ name }) => ({ value: name, text: name })), seen?.name ?? "");
    say(byId("sees-says", HTMLElement), seen?.summary ?? "");
    byId("learner", HTMLFieldSetElement).hidden = !!state.scene?.symbols.length;
    if (state.policies === before.policies && state.policy === before.policy && choice.length) return;
    const known = state.policies.map((one) => ({ value: one.name, text: text(one) }));
    const none = [{ value: "", text: "No policy yet", disabled: true }];
    fill(choice, known.length ? known : none, state.policy ?? "");
  });
}

/**
 * The one to play when nobody has chosen: the newest of one's own, else one that comes along.
 * @param {Policy[]} all
 * @param {string | null} chosen
 */
export function defaultPolicy(all, chosen) {
  if (all.some((one) => one.name === chosen)) return chosen;
  const able = all.filter((one) => !one.problem);
  const own = able.filter((one) => !one.shipped);
  own.sort((a, b) => String(b.created).localeCompare(String(a.created)));
  return (own[0] ?? able[0] ?? all[0])?.name ?? null;
}
