/** Cleaning and fitting while they run: how far they are, and a way to end them. */

import { api } from "./api.js";
import { make, say } from "./dom.js";
import { jobOf } from "./needs.js";
import { attempt } from "./notices.js";

/** @typedef {import("./types.js").Job} Job */

/** What others wait for, by the kind of the job. @type {Record<string, string>} */
const WORK = {
  again: "the repeated comparison",
  clean: "the cleaning",
  diagnose: "the diagnosis",
  evaluate: "the comparison",
  failures: "the search for failures",
  film: "the film",
  fit: "the fitting",
  import: "the import",
  pictures: "the pictures",
  places: "the search for new places",
  preview: "the search for contradictions",
  record: "the recording of takes",
  search: "the search",
  switch: "the switch",
  tune: "the tuning",
};

/** For what jobs that are queued wait: one is done after another. @param {Job[]} jobs */
function waiting(jobs) {
  const first = jobs.find(({ state }) => state === "running");
  return first ? `Waiting for ${WORK[first.kind] ?? "other work"} to be done` : "Waiting";
}

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
      say(message, job.state === "queued" ? waiting(state.jobs) : job.message || "Working");
      bar.value = job.progress;
    });
  }
}
