/** What lies over the 3D view: phase, countdown, numbers, progress and outcome. */

import { byId, say } from "./dom.js";
import { count, duration, outcomeWords, phaseWords, plural } from "./words.js";

/** @typedef {import("./types.js").State} State */
/** @typedef {import("./types.js").Status} Status */

/** @param {import("./store.js").Store} store */
export function hud(store) {
  const phase = byId("phase", HTMLElement);
  const numbers = {
    pairs: byId("pairs", HTMLElement),
    seconds: byId("seconds", HTMLElement),
    takes: byId("takes-kept", HTMLElement),
    kept: byId("pairs-kept", HTMLElement),
  };
  const countdown = byId("countdown", HTMLElement);
  const paused = byId("paused", HTMLElement);
  const progress = byId("progress", HTMLProgressElement);
  const ending = byId("ending", HTMLElement);
  const outcome = byId("outcome", HTMLElement);
  const hint = byId("ending-hint", HTMLElement);
  const late = byId("late", HTMLElement);

  store.watch(({ status, takes }) => {
    if (status === null) return;
    phase.dataset.phase = status.phase;
    phase.dataset.mode = status.mode ?? "";
    const looked = takes?.find(({ id }) => id === status.take);
    say(phase, phaseWords(status, looked?.number));
    say(numbers.pairs, count(status.pairs));
    say(numbers.seconds, status.seconds.toFixed(1));
    say(numbers.takes, count(status.takes_kept));
    say(numbers.kept, count(status.pairs_kept));
    numbers.pairs.parentElement?.classList.toggle("idle", status.mode !== "demonstrate");
    numbers.seconds.parentElement?.classList.toggle("idle", status.mode === null);

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

    late.classList.toggle("some", status.late_steps > 0);
    say(late, status.late_steps ? `${plural(status.late_steps, "late step")} of ${count(status.steps)}` : "");
  });
}

/** @param {Status} status */
function ended({ mode, pairs, seconds, forked }) {
  if (mode === "play") return `After ${duration(seconds)}. R plays again in another world.`;
  if (pairs === 0) return "R starts again.";
  const again = forked ? "Shift R tries again from there" : "R starts another take";
  return `${plural(pairs, "pair")} kept. ${again}, Backspace throws this one away.`;
}
