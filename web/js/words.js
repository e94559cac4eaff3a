/** The words that a person reads. */

/** @typedef {import("./types.js").State} State */
/** @typedef {import("./types.js").Status} Status */

/** @type {Record<string, string>} */
const OUTCOMES = {
  crossed: "Crossed!",
  hit: "Hit a rock",
  left: "Left the field",
  late: "Out of time",
};

/** @type {Record<string, string>} */
const KEYS = {
  ArrowUp: "↑",
  ArrowDown: "↓",
  ArrowLeft: "←",
  ArrowRight: "→",
  Backspace: "⌫",
  Delete: "Del",
  Escape: "Esc",
  Comma: ",",
  Period: ".",
  Minus: "−",
  Equal: "=",
  Shift: "⇧",
};

/** @param {string} key a KeyboardEvent.code, with Shift+ or Ctrl+ before it where those are held */
export const keyName = (key) =>
  key.replace(/\w+/g, (code) => KEYS[code] ?? code.replace(/^(Key|Digit)/, "")).replace(/\+/g, " ");

/** @param {string} outcome */
export const outcomeWords = (outcome) =>
  OUTCOMES[outcome] ?? outcome.charAt(0).toUpperCase() + outcome.slice(1);

/** @param {number} n */
export const count = (n) => n.toLocaleString("en");

/** @param {number} n @param {string} one @param {string} [many] */
export const plural = (n, one, many = `${one}s`) => `${count(n)} ${n === 1 ? one : many}`;

/** Of enough takes cleaning hardly ever leaves out a larger share by itself (docs/conflicts.md). */
const MUCH = 0.15;

/**
 * What to make of it where cleaning leaves out so many; nothing where one set its limit oneself.
 * @param {number} goes @param {number} pairs @param {number | "auto"} threshold
 */
export const muchWords = (goes, pairs, threshold) =>
  threshold === "auto" && goes > MUCH * pairs
    ? " That is much: where little was shown, what is rare looks like a mistake. Show more takes, or look at these moments one by one."
    : "";

/** @param {number} seconds */
export function duration(seconds) {
  if (seconds < 60) return `${seconds.toFixed(1)} s`;
  const whole = Math.round(seconds);
  return `${Math.floor(whole / 60)}:${String(whole % 60).padStart(2, "0")} min`;
}

/** Where a take comes from. @param {import("./types.js").Origin | null} origin */
export function originWords(origin) {
  if (origin === null) return "";
  const at = `at ${origin.seconds.toFixed(1)} s`;
  if (origin.policy !== null) return `Takes over from “${origin.policy}” ${at}`;
  if (origin.number !== null) return `Goes on from take ${origin.number} ${at}`;
  return origin.take === null ? `Goes on from a run ${at}` : `Goes on from a deleted take ${at}`;
}

/** @param {Status} status @param {number} [number] of the take that is looked back at */
export function phaseWords({ phase, mode, policy, take }, number) {
  switch (phase) {
    case "ready":
      return "Ready";
    case "countdown":
      return "Get ready";
    case "recording":
      return mode === "correct" ? `You steer instead of ${policy}` : "Recording";
    case "paused":
      return "Paused";
    case "playing":
      return policy ? `Playing ${policy}` : "Playing";
    case "ended":
      return mode === "play" ? "Playing ended" : mode === "correct" ? "Correction ended" : "Take ended";
    case "reviewing":
      return take === null ? "Looking back" : `Looking at take ${number ?? ""}`;
  }
}

/** @type {Record<string, string>} */
export const LEARNERS = {
  svr: "Flows between the moves you showed.",
  knn: "Repeats your most similar moments.",
  sampled: "Chooses among the moves you showed here, as often as you did each.",
  voting: "Does what you did most often in such moments.",
  auto: "Compares ways to learn on takes they have not seen.",
};
