/** What lies over the 3D view: phase, countdown, numbers, progress and outcome. */

import { byId, make, say } from "./dom.js";
import { keyOf } from "./shortcuts.js";
import { count, duration, outcomeWords, phaseWords, plural } from "./words.js";

/** @typedef {import("./types.js").State} State */
/** @typedef {import("./types.js").Status} Status */

/** Of a take that is kept. */
const WENT_WRONG = "though it went wrong: what led to that may be learned too";

/**
 * @param {import("./store.js").Store} store
 * @param {{acts: boolean}} who whether the person at the page is told what they could do
 */
export function hud(store, { acts }) {
  const polite = { role: "status", "aria-live": "polite" };
  const phase = make("p", { id: "phase", class: "phase", "data-phase": "ready", ...polite }, "Ready");
  const numbers = {
    pairs: make("span", { id: "pairs" }, "0"),
    seconds: make("span", { id: "seconds" }, "0.0"),
    takes: make("span", { id: "takes-kept" }, "0"),
    kept: make("span", { id: "pairs-kept" }, "0"),
  };
  const named = Object.values(numbers).map((number) =>
    make("div", {}, make("dt", {}, number.id.replace("-", " ")), make("dd", {}, number)),
  );
  const wanted = make("span", { id: "of-wanted", class: "of-wanted" });
  numbers.takes.after(wanted);
  const before = make("p", { id: "made-before", class: "made-before", role: "status" });
  byId("hud", HTMLElement).append(phase, before, make("dl", { class: "numbers" }, ...named));

  const countdown = make("p", { id: "countdown", class: "countdown", "aria-hidden": "true" });
  const outcome = make("p", { id: "outcome", class: "outcome", ...polite });
  const hint = make("p", { id: "ending-hint", class: "ending-hint" });
  const ending = make("div", { id: "ending", class: "ending" }, outcome, hint);
  const paused = make("p", { id: "paused", class: "paused" }, "Paused");
  if (acts) paused.append(" ", make("kbd", {}, "Space"), " goes on");
  for (const part of [countdown, ending, paused]) part.hidden = true;
  hint.hidden = !acts;
  byId("centre", HTMLElement).append(countdown, ending, paused);

  const pushed = make("p", { id: "pushed", class: "pushed", ...polite });
  byId("centre", HTMLElement).append(pushed);

  const progress = byId("progress", HTMLProgressElement);
  const late = byId("late", HTMLElement);
  late.title =
    "Steps that began more than half a step after their time, because the computer was busy. Nothing is lost by it, but it looks less smooth";

  store.watch(({ status, takes, policies }) => {
    if (status === null) return;
    phase.dataset.phase = status.phase;
    phase.dataset.mode = status.mode ?? "";
    const looked = takes?.find(({ id }) => id === status.take);
    say(phase, phaseWords(status, looked?.number));
    const played = status.mode === "play" ? policies?.find(({ name }) => name === status.policy) : null;
    say(before, played?.made_before ?? "");
    say(numbers.pairs, count(status.pairs));
    say(numbers.seconds, status.seconds.toFixed(1));
    say(numbers.takes, count(status.takes_kept));
    say(wanted, status.wanted === null ? "" : ` of ${count(status.wanted)}`);
    wanted.classList.toggle("reached", status.takes_kept >= (status.wanted ?? Infinity));
    say(numbers.kept, count(status.pairs_kept));
    const taking = ["demonstrate", "correct"].includes(status.mode ?? "");
    numbers.pairs.closest("div")?.classList.toggle("idle", !taking);
    numbers.seconds.closest("div")?.classList.toggle("idle", status.mode === null);

    countdown.hidden = status.phase !== "countdown";
    say(countdown, String(Math.max(1, Math.ceil(status.countdown_s))));
    paused.hidden = status.phase !== "paused";
    progress.value = status.progress;
    progress.hidden = ["paused", "ended", "reviewing"].includes(status.phase) && status.length_s > 0;

    ending.hidden = status.phase !== "ended" || status.outcome === null;
    outcome.dataset.success = String(status.success ?? "");
    outcome.dataset.outcome = status.outcome ?? "";
    say(outcome, ending.hidden ? "" : outcomeWords(status.outcome ?? ""));
    say(hint, ending.hidden ? "" : ended(status));

    pushed.classList.toggle("idle", !status.pushed);
    say(pushed, status.pushed ? "Pushed off your way: get back from here" : "");

    late.classList.toggle("some", status.late_steps > 0);
    say(late, status.late_steps ? `${count(status.late_steps)} of ${plural(status.steps, "step")} late` : "");
  });
}

/** @param {Status} status */
function ended({ mode, pairs, seconds, forked, success }) {
  if (mode === "correct") return `${plural(pairs, "pair")} kept as a correction. R plays again.`;
  if (mode === "play") return `After ${duration(seconds)}. R plays again in another world.`;
  if (pairs === 0) return "R starts again.";
  const again = forked ? "Shift R tries again from there" : "R starts another take";
  const kept = `${plural(pairs, "pair")} kept${success === false ? `, ${WENT_WRONG}` : ""}`;
  return `${kept}. ${again}, ${keyOf("discard")} throws this one away.`;
}
