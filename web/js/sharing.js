/** What is looked at made into one file: a page that plays it in 3D anywhere, or a video. */

import { api } from "./api.js";
import { byId } from "./dom.js";
import { jobOf } from "./needs.js";
import { attempt, notify } from "./notices.js";
import { hand } from "./screenshot.js";

/** @typedef {import("./types.js").Job} Job */

/**
 * @param {import("./store.js").Store} store
 * @param {{stage: () => string | null, job: (job: Job) => void}} act
 * @returns {{made: (job: Job) => void}}
 */
export function sharing(store, act) {
  const box = byId("share", HTMLDetailsElement);
  /** @type {Set<number>} The jobs that this page began; others' films are not handed to it. */
  const own = new Set();
  for (const button of box.querySelectorAll("button[data-form]")) {
    button.addEventListener("click", () =>
      attempt(async () => {
        const stage = act.stage();
        if (stage === null || jobOf(store.state, "film")) return;
        const job = await api.film(stage, /** @type {HTMLElement} */ (button).dataset.form ?? "");
        own.add(job.id);
        act.job(job);
      }),
    );
  }
  /** Fold the menu up, which would lie over the notice; the focus stays at hand. */
  const close = () => {
    if (box.open && box.contains(document.activeElement)) box.querySelector("summary")?.focus();
    box.open = false;
  };
  store.watch((state, before) => {
    const busy = jobOf(state, "film") !== null;
    for (const button of box.querySelectorAll("button[data-form]")) {
      button.setAttribute("aria-disabled", String(busy));
    }
    // It is about what is looked at: nobody finds it open at something else.
    const moved = state.status?.phase !== before.status?.phase;
    if (moved || state.status?.take !== before.status?.take) box.open = false;
  });
  return {
    made: ({ id, result }) => {
      if (!own.delete(id)) return;
      const name = String(result?.film);
      close();
      hand(name, api.filmFile(name));
      notify(`“${name}” is made, and handed to your browser.`);
    },
  };
}
