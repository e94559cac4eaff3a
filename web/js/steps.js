/** The buttons of the four steps: what is possible, what is not and why, and what comes next. */

import { bar, byId, make, say } from "./dom.js";
import { fitted, needs, nextStep, policy, session } from "./needs.js";
import { notify } from "./notices.js";
import { LEARNERS, count, muchWords, plural } from "./words.js";

/** @typedef {import("./types.js").State} State */
/** @typedef {import("./needs.js").Action} Action */

/** Sentences of what tuning found about a policy that the panel has room for. */
const REPORTED = 3;

/** @type {Action[]} */
const ACTIONS = ["demonstrate", "clean", "fit", "play", "stop", "undo", "unclean"];

/**
 * @param {import("./store.js").Store} store
 * @param {Record<Action, () => void>} act
 */
export function steps(store, act) {
  for (const action of ACTIONS) {
    const button = byId(action, HTMLButtonElement);
    button.addEventListener("click", () => {
      const missing = needs(store.state)[action];
      if (missing === null) act[action]();
      else notify(missing);
    });
  }
  const sayings = ["demonstrate", "clean", "fit", "play"].map((step) =>
    byId(`${step}-says`, HTMLElement),
  );
  for (const [i, step] of ["demonstrate", "clean", "fit", "play"].entries()) {
    byId(step, HTMLButtonElement).setAttribute("aria-describedby", sayings[i].id);
  }

  store.watch((state) => {
    const missing = needs(state);
    const next = nextStep(state);
    for (const action of ACTIONS) {
      const button = byId(action, HTMLButtonElement);
      bar(button, missing[action]);
      button.classList.toggle("next", action === next && missing[action] === null);
    }
    const done = finished(state);
    for (const item of document.querySelectorAll(".step")) {
      const step = /** @type {HTMLElement} */ (item).dataset.step ?? "";
      item.classList.toggle("done", done.includes(step));
    }
    const [demonstrate, clean, fit, play] = sayings;
    say(demonstrate, missing.demonstrate ? demonstrationWords(state) : "Take the keys for a few minutes.");
    say(clean, missing.clean ?? cleanWords(state));
    clean.classList.toggle("warn", missing.clean === null && !!session(state)?.cleaning?.stale);
    const learner = state.scene?.symbols.length ? "voting" : state.learner;
    say(fit, missing.fit ?? LEARNERS[learner]);
    const shown = policy(state);
    const report = shown?.switches.length ? [] : (shown?.report ?? []);
    const old = !!shown?.made_before;
    const short = old || !report.length ? [] : (shown?.in_short ?? []).slice(0, REPORTED);
    say(byId("fit-report", HTMLElement), short.join(" "));
    const more = byId("fit-more", HTMLElement);
    more.hidden = JSON.stringify(report) === JSON.stringify(short);
    const title = /** @type {HTMLElement} */ (more.querySelector("summary"));
    say(title, old ? "All that the fit before found" : "All that fitting found");
    const all = byId("fit-all", HTMLElement);
    if (all.dataset.key !== JSON.stringify(report)) {
      all.dataset.key = JSON.stringify(report);
      all.replaceChildren(...report.map((sentence) => make("li", {}, sentence)));
    }
    say(play, missing.play ?? playWords(state));
    play.classList.toggle("warn", !!policy(state)?.problem || !!policy(state)?.stale);
  });
}

/** @param {State} state */
function finished(state) {
  const now = session(state);
  const steps = [];
  if (now?.pairs) steps.push("demonstrate");
  if (now?.cleaning && !now.cleaning.stale) steps.push("clean");
  if (fitted(state)) steps.push("fit");
  return steps;
}

/** @param {State} state */
function demonstrationWords({ connected, status }) {
  if (!connected || status === null) return "Waiting for the studio";
  return status.phase === "paused" ? "Paused: Space goes on." : "Steer with the keys below the view.";
}

/** @param {State} state */
function cleanWords(state) {
  const cleaning = session(state)?.cleaning;
  if (!cleaning) return "Takes out moves that contradict each other.";
  if (cleaning.stale) return "Your takes have changed since: clean again.";
  const { removed, pairs, settings } = cleaning;
  const share = pairs ? Math.round((100 * removed) / pairs) : 0;
  const much = muchWords(removed, pairs, settings.threshold);
  return `${count(removed)} of ${plural(pairs, "pair")} taken out (${share} %).${much}`;
}

/** @param {State} state */
function playWords(state) {
  const chosen = policy(state);
  if (!chosen) return "";
  if (chosen.made_before) return `It was ${chosen.made_before}. Fit again to use what is there now.`;
  if (chosen.switches.length) return chosen.report.join(" ");
  const from = chosen.session ? ` from “${chosen.session}”` : "";
  return `Learned from ${plural(chosen.pairs ?? 0, "pair")}${from}.`;
}

