/** What is possible now; where something is not, the sentence that says what it needs first. */

/** @typedef {import("./types.js").State} State */
/** @typedef {"demonstrate" | "clean" | "fit" | "play" | "stop" | "undo" |
 *   "unclean"} Action */

/** The signal that marks the moment of a switch. */
export const MARK = "mark";

/** @param {State} state */
export const session = (state) => state.sessions.find(({ id }) => id === state.session) ?? null;

/** @param {State} state */
export const policy = (state) => state.policies.find(({ name }) => name === state.policy) ?? null;

/** @param {State} state */
const demonstrating = ({ status }) =>
  ["demonstrate", "correct"].includes(status?.mode ?? "") &&
  ["countdown", "recording", "paused"].includes(status?.phase ?? "");

/**
 * @param {Pick<State, "jobs" | "session">} state
 * @param {string} kind
 */
export const jobOf = (state, kind) =>
  state.jobs.find((job) => job.kind === kind && (job.session ?? state.session) === state.session) ??
  null;

/**
 * @param {State} state
 * @param {"clean" | "fit"} kind
 */
function work(state, kind) {
  if (jobOf(state, kind)) return kind === "clean" ? "Cleaning is under way" : "Fitting is under way";
  if (demonstrating(state)) return "Finish the take first";
  return session(state)?.pairs ? null : "Record a take first";
}

/**
 * A sentence for each action that is not possible, null for those that are.
 * @param {State} state
 * @returns {Record<Action, string | null>}
 */
export function needs(state) {
  const { status, connected } = state;
  const away = connected && status !== null ? null : "Waiting for the studio";
  const chosen = policy(state);
  return {
    demonstrate: away ?? (demonstrating(state) ? "You are demonstrating" : null),
    clean: away ?? work(state, "clean"),
    fit: away ?? work(state, "fit"),
    play: away ?? (chosen === null ? "Fit a policy first" : chosen.problem),
    stop: away ?? (status?.phase === "ready" ? "Nothing is running" : null),
    unclean: away ?? (session(state)?.cleaning ? null : "Nothing was cleaned"),
    undo: away ?? (status?.can_undo ? null : "Nothing was thrown away"),
  };
}

/**
 * Why a signal cannot be given now, or another character be led; null where it can.
 * @param {State} state
 * @param {string} name of the signal, or "another"
 */
export function notNow({ status }, name) {
  const { phase, mode } = status ?? { phase: "ready", mode: null };
  if (name === "another") {
    const taking = ["demonstrate", "correct"].includes(mode ?? "") && (phase === "recording" || phase === "paused");
    return taking ? "A take is about one character. Stop it first." : null;
  }
  if (name === MARK && mode !== "demonstrate") return "Moments are marked in a take. Demonstrate first.";
  const moves = phase === "recording" || phase === "playing";
  return moves ? null : "Nothing moves at the moment. Demonstrate or play first.";
}

/**
 * Whether a policy was fitted to the session's present pairs. Older ones may lie beside it.
 * @param {State} state
 */
export function fitted(state) {
  const now = session(state);
  const fits = (/** @type {import("./types.js").Policy} */ one) =>
    one.session === now?.name && !one.stale && !one.shipped;
  return now !== null && state.policies.some(fits);
}

/**
 * The step that leads on from here, for the eye to find.
 * @param {State} state
 * @returns {Action}
 */
export function nextStep(state) {
  const now = session(state);
  if (!now?.pairs) return "demonstrate";
  if (fitted(state)) return "play";
  if (now.cleaning && !now.cleaning.stale) return "fit";
  return "clean";
}
