/** The evaluations kept, to open again. */

import { byId, make, say } from "./dom.js";
import { plural } from "./words.js";

/** @param {import("./store.js").Store<import("./types.js").Comparing>} store */
export function earlier(store) {
  const list = byId("earlier", HTMLElement);
  store.watch((state, before) => {
    const { evaluation, evaluations } = state;
    if (evaluations !== before.evaluations || evaluations.length === 0) {
      say(byId("earlier-says", HTMLElement), evaluations.length ? "" : "Evaluations are kept here.");
      list.replaceChildren(...evaluations.map((one) => entry(one, state.scene)));
    }
    for (const link of list.querySelectorAll("a")) {
      link.setAttribute("aria-current", String(link.hash === `#${evaluation?.id}`));
    }
  });
}

/**
 * @param {import("./types.js").EvaluationFound} evaluation
 * @param {import("./types.js").Scene | null} scene
 */
function entry({ id, created_at, asked, result }, scene) {
  const when = new Date(created_at * 1000).toLocaleString("en-GB", { dateStyle: "medium", timeStyle: "short" });
  const rates = Object.values(result.pilots).map((one) => `${Math.round(100 * one.success_rate)} %`);
  const unusual = (scene?.options ?? [])
    .filter(({ name, default: usual }) => (asked.options[name] ?? usual) !== usual)
    .map(({ name, label }) => `${label.toLowerCase()} ${asked.options[name]}`);
  const says = [plural(asked.worlds, "world"), ...unusual, rates.join(" / "), when].join(", ");
  return make(
    "li",
    {},
    make("a", { href: `#${id}`, title: "Open it again" }, Object.keys(result.pilots).join(", "), make("small", {}, says)),
  );
}
