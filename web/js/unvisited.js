/** Take me where I have not been: takes begin where a short push leads to what none shows. */

import { api } from "./api.js";
import { bar, byId } from "./dom.js";
import { jobOf, session } from "./needs.js";
import { attempt, notify } from "./notices.js";

/** @typedef {import("./types.js").Job} Job */
/** @typedef {import("./types.js").Place} Place */
/** @typedef {import("./types.js").State} State */

/** @param {State} state */
function missing(state) {
  if (!state.connected) return "Waiting for the studio";
  if (jobOf(state, "places")) return "Places are being looked for";
  return session(state)?.pairs ? null : "Record a take first";
}

/**
 * @param {import("./store.js").Store} store
 * @param {{visit: (more: object) => void, onJob: (job: Job) => void}} act
 * @returns {(job: Job) => void} what to do with a job that is done
 */
export function unvisited(store, act) {
  const button = byId("unvisited", HTMLButtonElement);
  /** @type {Place[]} */
  let found = [];
  /** The session whose takes they are off. @type {number | null} */
  let whose = null;
  let series = 0;
  /** @type {Set<number>} */
  const asked = new Set();

  function go() {
    const place = found.shift();
    if (place === undefined) return notify("A short push leads nowhere new: your takes cover it all.");
    const { take, number, step, keys, steps, seconds } = place;
    act.visit({ take, step, push: { keys, steps }, others: store.state.others });
    notify(`Off the way of take ${number} at ${seconds.toFixed(1)} s. Show how to get back from there.`);
  }

  button.addEventListener("click", () => {
    const why = missing(store.state);
    if (why) return notify(why);
    if (found.length && whose === store.state.session) return go();
    attempt(async () => {
      const id = store.state.session;
      if (id === null) return;
      whose = id;
      const job = await api.findPlaces(id, series++);
      asked.add(job.id);
      act.onJob(job);
    });
  });
  store.watch((state) => {
    const why = missing(state);
    bar(button, why);
  });

  return (job) => {
    if (job.kind !== "places" || !asked.delete(job.id) || whose !== store.state.session) return;
    found = /** @type {any} */ (job.result).places;
    go();
  };
}
