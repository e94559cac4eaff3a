/** Take me to where it fails: failures are found without a screen, and gone to 3 s before them. */

import { api } from "./api.js";
import { bar, byId, make, say } from "./dom.js";
import { jobOf, needs } from "./needs.js";
import { attempt, notify } from "./notices.js";
import { duration, outcomeWords, plural } from "./words.js";

/** @typedef {import("./types.js").Failure} Failure */
/** @typedef {import("./types.js").Job} Job */

const BEFORE_S = 3;
/** What a world is told for that went well. @type {Record<string, string>} */
const WELL = { near: "A close call", strange: "Least like your takes" };

/** @param {Failure} failure */
const words = ({ outcome }) => WELL[outcome] ?? outcomeWords(outcome);

/** What was found, said in a sentence. @param {{worlds: number, failed: number, failures: Failure[]}} told */
function sentence({ worlds, failed, failures: [first] }) {
  const all = plural(worlds, "world");
  if (failed) return `It failed in ${failed} of ${all}.`;
  const instead = {
    near: "These were its closest calls.",
    strange: "Here it was least like your takes.",
  }[first?.outcome ?? ""];
  return `It failed in none of ${all}. ${instead ?? ""}`;
}

/** Why none can be looked for now. @param {import("./types.js").State} state */
const why = (state) =>
  jobOf(state, "failures") ? "Failures are being looked for" : needs(state).play;

/**
 * @param {import("./store.js").Store} store
 * @param {{play: (more: object) => void, onJob: (job: Job) => void}} act
 * @returns {(job: Job) => void} what to do with a job that is done
 */
export function failures(store, act) {
  const button = byId("fails", HTMLButtonElement);
  const says = byId("fails-says", HTMLElement);
  const list = byId("failures", HTMLElement);
  const placed = byId("placed", HTMLElement);
  /** Where one was brought to. */
  let there = { seed: -1, seconds: 0 };
  /** @type {Failure[]} */
  let found = [];
  let next = 0;
  /** Whose they are, and in which worlds. */
  let key = "";
  let series = 0;
  /** Jobs of this page. @type {Set<number>} */
  const asked = new Set();

  const present = () => JSON.stringify([store.state.policy, store.state.scene?.name, store.state.options]);

  /** @param {number} number */
  function go(number) {
    const { policy, options, scene } = store.state;
    const failure = found[number];
    next = number + 1;
    // Whoever is brought to the very beginning is not held still.
    const seconds = Math.max(failure.seconds - BEFORE_S, scene?.dt_s ?? 0);
    act.play({ policy, options, seed: failure.seed, seconds });
    there = { seed: failure.seed, seconds };
    const left = (failure.seconds - seconds).toFixed(0);
    say(placed, `${words(failure)}, ${left} s from here. Steer to show how it is done.`);
    show();
  }

  async function look() {
    const { policy, scene, options } = store.state;
    if (policy === null || scene === null) return;
    if (key !== present()) series = 0;
    key = present();
    found = [];
    show();
    const job = await api.findFailures(policy, scene.name, options, series++);
    asked.add(job.id);
    act.onJob(job);
  }

  function show() {
    const { state } = store;
    if (key !== present()) say(says, "");
    const mine = key === present() ? found : [];
    list.hidden = mine.length === 0;
    list.replaceChildren(
      ...mine.map((failure, number) => {
        const title = `${words(failure)} after ${duration(failure.seconds)}`;
        const chip = make(
          "button",
          { type: "button", "aria-pressed": String(number === next - 1), title, "aria-label": title },
          duration(failure.seconds),
        );
        chip.addEventListener("click", () => go(number));
        return make("li", {}, chip);
      }),
    );
    const missing = why(state);
    bar(button, missing);
  }

  button.addEventListener("click", () => {
    const missing = why(store.state);
    if (missing) return notify(missing);
    if (key === present() && next < found.length) go(next);
    else attempt(look);
  });
  store.watch((state, before) => {
    const changed = state.policy !== before.policy || state.options !== before.options;
    const { status, scene } = state;
    const here =
      status?.mode === "play" &&
      status.phase === "paused" &&
      status.seed === there.seed &&
      Math.abs(status.seconds - there.seconds) < (scene?.dt_s ?? 1);
    placed.hidden = !here;
    const able = state.jobs !== before.jobs || state.policies !== before.policies;
    if (changed || able || state.connected !== before.connected) show();
  });

  return (job) => {
    if (job.kind !== "failures" || !asked.delete(job.id) || key !== present()) return;
    const told = /** @type {any} */ (job.result);
    found = told.failures;
    next = 0;
    say(says, sentence(told));
    if (found.length) go(0);
    else show();
  };
}
