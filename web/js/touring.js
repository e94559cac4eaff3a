/** What the tour tells, step by step, and by what it sees that a person has done it. */

import { make } from "./dom.js";
import { isOpen } from "./jobs.js";
import { policy, session } from "./needs.js";
import { keyOf } from "./shortcuts.js";
import { duration, keyName } from "./words.js";

/** @typedef {import("./types.js").State} State */

/** What a first policy needs at least: so many seconds, and so many decisions. */
const ENOUGH_S = 8;
const ENOUGH = 40;
/** So many decisions fall with a key held before a person has steered, and so long a policy plays. */
const STEERED = 4;
const PLAYED_S = 2;

/** What the tour remembers of what was done since it came to its present step. */
/** @typedef {{steered: number}} Seen */

/**
 * @typedef {object} Step
 * @property {string} title
 * @property {(state: State) => (string | Node)[]} says
 * @property {string} at selector of what it points at: all that it finds
 * @property {import("./tour_place.js").Side} side on which the tour's card stands, if there is room
 * @property {boolean} [presses] whether that is to be pressed, and so gets the focus
 * @property {(state: State, seen: Seen) => boolean} done
 */

/** @param {string} name */
const key = (name) => make("kbd", {}, name);

/** @param {State} state */
const acting = ({ status }) =>
  status?.mode === "demonstrate" && ["countdown", "recording", "paused"].includes(status.phase);

/**
 * What to make of a take that has just ended badly, where one has.
 * @param {State} state
 * @returns {(string | Node)[]}
 */
const wentWrong = ({ status }) =>
  status?.mode === "demonstrate" && status.phase === "ended" && status.success === false
    ? ["That take went wrong and is kept all the same: what led to that may be learned too. ",
        key(keyName(keyOf("discard"))), " throws it away. "]
    : [];

/** @param {State} state */
const enough = (state) => {
  const now = session(state);
  return now !== null && now.seconds >= ENOUGH_S && now.pairs >= ENOUGH;
};

/** @param {State} state @param {string} kind */
const atWork = (state, kind) => state.jobs.some((job) => job.kind === kind && isOpen(job));

/** @type {Step[]} */
export const STEPS = [
  {
    title: "Take the keys",
    says: () => ["Press Demonstrate. It counts to three; from then on what you decide is recorded."],
    at: "#demonstrate",
    side: "left",
    presses: true,
    done: acting,
  },
  {
    title: "Steer",
    says: (state) =>
      state.status?.phase === "countdown"
        ? ["In a moment you have the keys."]
        : [...wentWrong(state), "Hold one of these keys: the character turns, for as long as you hold it."],
    at: '#keys li[data-use="steer"]',
    side: "above",
    done: (_, { steered }) => steered >= STEERED,
  },
  {
    title: "Show how it should move",
    says: (state) => {
      const shown = session(state)?.seconds ?? 0;
      if (acting(state)) {
        return ["Go on for half a minute, in the style you want. ", key("Esc"), " ends the take, ",
          key("Space"), " pauses it."];
      }
      if (enough(state)) return ["Kept."];
      return [...wentWrong(state), `${duration(shown)} are kept so far, which is little to learn from. `, key("R"),
        " begins another take."];
    },
    at: "#stage .numbers",
    side: "below",
    done: (state) => enough(state) && !acting(state),
  },
  {
    title: "Clean",
    says: (state) =>
      atWork(state, "clean")
        ? ["Moments that are alike are compared with one another…"]
        : [...wentWrong(state), "Nobody does the same twice. Clean takes out the moves that contradict the others."],
    at: "#clean",
    side: "left",
    presses: true,
    done: (state) => session(state)?.cleaning?.stale === false,
  },
  {
    title: "Fit",
    says: (state) =>
      atWork(state, "fit")
        ? ["It learns from what you showed…"]
        : ["Fit makes a policy of it: what it would do in moments that you never showed, too."],
    at: "#fit",
    side: "left",
    presses: true,
    done: (state) => own(state),
  },
  {
    title: "Play",
    says: ({ status }) =>
      status?.phase === "playing"
        ? ["Nobody steers now: it goes on alone, as you showed it."]
        : ["Press Play: it goes on alone, in a world that you have never seen."],
    at: "#play",
    side: "left",
    presses: true,
    done: (state) =>
      state.status?.phase === "playing" && own(state) && state.status.seconds >= PLAYED_S,
  },
];

/** Whether what would play was learned from the present session, as it is. @param {State} state */
function own(state) {
  const chosen = policy(state);
  return chosen !== null && !chosen.stale && chosen.session === session(state)?.name;
}

/**
 * Whether a moment counts as being taught: not while one demonstrates, nor while one waits for work.
 * @param {State} state
 */
export const taught = (state) => !acting(state) && !state.jobs.some(isOpen);

/** Whether nobody has demonstrated or fitted anything here. @param {State} state */
export const isNew = (state) =>
  state.scene !== null &&
  state.sessions.every(({ pairs }) => pairs === 0) &&
  state.policies.every(({ shipped }) => shipped);
