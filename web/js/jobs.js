/** Cleaning and fitting while they run: how far they are, and a way to end them. */

import { api } from "./api.js";
import { make, say } from "./dom.js";
import { jobOf } from "./needs.js";
import { attempt } from "./notices.js";

/** @typedef {import("./types.js").Job} Job */

/** @param {Job} job */
export const isOpen = (job) => job.state === "queued" || job.state === "running";

/** @param {import("./store.js").Store} store */
export function jobs(store) {
  for (const element of document.querySelectorAll(".job")) {
    const box = /** @type {HTMLElement} */ (element);
    const kind = box.dataset.kind ?? "";
    const message = make("span", { role: "status" });
    const cancel = make("button", { type: "button", class: "quiet", title: "End this work" }, "Cancel");
    const bar = make("progress", { max: "1", "aria-label": "Progress" });
    box.append(message, cancel, bar);
    cancel.addEventListener("click", () =>
      attempt(async () => {
        const job = jobOf(store.state, kind);
        if (job) await api.cancel(job.id);
      }),
    );
    store.watch((state) => {
      const job = jobOf(state, kind);
      box.hidden = job === null;
      if (job === null) return;
      const waiting = job.state === "queued" ? "Waiting for its turn" : "Working";
      say(message, job.message || waiting);
      bar.value = job.progress;
    });
  }
}
