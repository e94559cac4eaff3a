/**
 * Every key of the pages, in one table: what it does, when, and in which words the sheet says so.
 *
 * The keys that steer, and those of a scene's signals, come from the scene and go before these.
 * Of two that share a key the first whose `when` holds is meant. A new control gets a row here; one
 * that needs no key is covered by `WITHOUT`, which says why.
 */

/** @typedef {Pick<import("./types.js").State, "status" | "scene" | "conflict">} State */

/**
 * `keys` as KeyboardEvent.code, or a sign that is typed; with Shift+ or Ctrl+ before it.
 * `does` is the name that `main.js` is given, unless `press`: then the control is pressed.
 * `on` says which controls do the same, by a selector, beside those whose `data-does` is the same;
 * `repeats` while the key is held.
 *
 * @typedef {{keys: string[], does: string, words: string, on?: string, press?: boolean,
 *   repeats?: boolean, when?: (state: State) => boolean}} Shortcut
 * @typedef {{title: string, shortcuts: Shortcut[]}} Group
 */

/** @param {State} state */
export const acting = ({ status }) =>
  ["countdown", "recording", "paused", "playing"].includes(status?.phase ?? "");
/** @param {State} state */
const running = ({ status }) => ["countdown", "recording", "playing"].includes(status?.phase ?? "");
/** @param {State} state */
const paused = ({ status }) => status?.phase === "paused";
/** @param {State} state */
const reviewing = ({ status }) => status?.mode === "review";
/** @param {State} state */
const comparing = (state) => reviewing(state) && state.conflict !== null;
/** @param {State} state */
const going = ({ status }) => status !== null && status.mode !== null && status.mode !== "review";
/** @param {State} state */
const resting = ({ status }) => status?.mode === null && status.next_s !== null;
/** Whether a take was thrown away, and nothing begins by itself. @param {State} state */
export const thrown = ({ status }) =>
  status?.mode === null && status.next_s === null && status.can_undo;
/** @param {State} state */
const still = ({ status }) => ["paused", "ended", "reviewing"].includes(status?.phase ?? "");
/** @param {State} state */
const taking = ({ status }) => status?.mode === "demonstrate";
/** @param {State} state */
const correcting = ({ status }) => status?.mode === "correct" && status.phase !== "ended";
/** @param {State} state */
const playing = ({ status }) =>
  status?.mode === "play" && ["playing", "paused"].includes(status.phase);

/** @type {Group[]} */
const EVERYWHERE = [
  {
    title: "The page",
    shortcuts: [
      { keys: ["?"], does: "sheet", words: "show these keys", on: "#sheet-open", press: true },
      { keys: ["Shift+KeyL"], does: "scheme", words: "light or dark", on: "#scheme", press: true },
    ],
  },
];

/** @type {Shortcut[]} Through time, on every timeline. */
const THROUGH = [
  { keys: ["ArrowLeft"], does: "step-back", words: "a moment back", repeats: true, when: reviewing },
  { keys: ["ArrowRight"], does: "step-on", words: "a moment on", repeats: true, when: reviewing },
  { keys: ["Shift+ArrowLeft"], does: "second-back", words: "a second back", repeats: true, when: reviewing },
  { keys: ["Shift+ArrowRight"], does: "second-on", words: "a second on", repeats: true, when: reviewing },
  { keys: ["Home"], does: "to-begin", words: "to the beginning", when: reviewing },
  { keys: ["End"], does: "to-end", words: "to the end", when: reviewing },
  { keys: ["Space"], does: "roll", words: "go on, stand still", when: reviewing },
  { keys: ["KeyJ"], does: "roll-back", words: "backwards", when: reviewing },
  { keys: ["KeyK"], does: "stand", words: "stand still", when: reviewing },
  { keys: ["KeyL"], does: "roll-on", words: "forwards", when: reviewing },
  { keys: ["Comma"], does: "slower", words: "slower", when: reviewing },
  { keys: ["Period"], does: "faster", words: "faster", when: reviewing },
];

/** @type {Group[]} The keys of the studio's page. */
export const STUDIO = [
  {
    title: "The four steps",
    shortcuts: [
      { keys: ["Digit1"], does: "demonstrate", words: "demonstrate", on: "#demonstrate", press: true },
      { keys: ["Digit2"], does: "clean", words: "clean", on: "#clean", press: true },
      { keys: ["Digit3"], does: "fit", words: "fit", on: "#fit", press: true },
      { keys: ["Digit4"], does: "play", words: "play", on: "#play", press: true },
      {
        keys: ["KeyU", "Ctrl+KeyZ"],
        does: "undo",
        words: "bring back what was thrown away",
        on: "#undo",
        when: ({ status }) => !!status?.can_undo,
      },
    ],
  },
  {
    title: "While it runs",
    shortcuts: [
      { keys: ["Space"], does: "pause", words: "pause", when: running },
      { keys: ["Space"], does: "resume", words: "go on", when: paused },
      { keys: ["KeyR"], does: "restart", words: "start again, in another world", when: going },
      { keys: ["Shift+KeyR"], does: "restart-same", words: "start again in the same world", when: going },
      {
        keys: ["KeyK"],
        does: "keep-last",
        words: "keep the last seconds",
        when: (state) => taking(state) && !!state.status?.pairs,
      },
      {
        keys: ["Backspace"],
        does: "discard",
        words: "throw the take away",
        when: (state) => taking(state) || correcting(state),
      },
      {
        keys: ["KeyL"],
        does: "look-back",
        words: "look back",
        when: ({ status }) => ["paused", "ended", "playing"].includes(status?.phase ?? ""),
      },
      {
        keys: ["KeyV"],
        does: "camera",
        words: "another camera",
        on: "#camera",
        when: ({ status }) => (status?.cameras.length ?? 0) > 1,
      },
      {
        keys: ["KeyC"],
        does: "another",
        words: "another character",
        on: "#another",
        when: ({ status }) => status != null && status.lead !== null,
      },
      { keys: ["KeyP"], does: "screenshot", words: "a picture of the view, as a file", on: "#screenshot" },
      { keys: ["Escape"], does: "share-close", words: "close what Share offers", on: "#share[open] > summary",
        press: true, when: still },
      { keys: ["Escape"], does: "stop", words: "stop", on: "#stop", when: going },
      { keys: ["Escape"], does: "stop", words: "begin no take by itself", when: resting },
      { keys: ["KeyR"], does: "restart", words: "begin the next take now", when: resting },
      { keys: ["KeyR"], does: "restart", words: "begin another take", when: thrown },
    ],
  },
  {
    title: "How one steers",
    shortcuts: [
      { keys: ["-"], does: "slower-time", words: "slow motion", on: "#slower" },
      { keys: ["="], does: "faster-time", words: "faster again", on: "#faster" },
      { keys: ["KeyN"], does: "automatic", words: "take after take, by itself", on: "#automatic" },
      { keys: ["KeyI"], does: "drag", words: "drag in the view to steer", on: "#drag" },
      { keys: ["Shift+KeyI"], does: "steering", words: "how it steers", on: "#steering > summary", press: true },
    ],
  },
  {
    title: "A contradiction that is looked at",
    shortcuts: [
      { keys: ["ArrowUp"], does: "conflict-before", words: "the one before", repeats: true, when: comparing },
      { keys: ["ArrowDown"], does: "conflict-after", words: "the next one", repeats: true, when: comparing },
      { keys: ["KeyK", "Enter"], does: "conflict-keep", words: "keep it", on: "[data-verdict=keep]", when: comparing },
      { keys: ["Delete"], does: "conflict-delete", words: "delete it", on: "[data-verdict=delete]", when: comparing },
      { keys: ["KeyM"], does: "conflict-missing", words: "something is missing here",
        on: "[data-verdict=missing]", when: comparing },
    ],
  },
  {
    title: "While a policy plays",
    shortcuts: [
      {
        keys: ["KeyY"],
        does: "why",
        words: "why did it do that?",
        on: "#gauge, #why-close",
        when: ({ status }) => ["play", "review", "correct"].includes(status?.mode ?? ""),
      },
      { keys: ["KeyT"], does: "take-over", words: "take over; so does any key that steers", when: playing },
      { keys: ["KeyT"], does: "hand-back", words: "hand back", when: correcting },
      { keys: ["KeyG"], does: "fails", words: "take me to where it fails", on: "#fails", press: true },
      { keys: ["KeyO"], does: "unvisited", words: "take me where I have not been", on: "#unvisited" },
    ],
  },
  {
    title: "Looking back",
    shortcuts: [
      ...THROUGH,
      { keys: ["KeyF"], does: "fork", words: "go on from this moment", when: reviewing },
      { keys: ["Shift+KeyP"], does: "share", words: "hand it on as a file", on: "#share > summary", press: true },
      {
        keys: ["Shift+KeyK"],
        does: "keep-from",
        words: "keep the take from here on",
        when: (state) => reviewing(state) && state.status?.take != null,
      },
      { keys: ["Escape"], does: "leave", words: "back to where you were", when: reviewing },
    ],
  },
  {
    title: "The panel",
    shortcuts: [
      { keys: ["KeyH"], does: "tour", words: "the tour, and out of it", on: "#tour-end" },
      { keys: ["Shift+KeyN"], does: "new-session", words: "a new session", on: "#new-session", press: true },
      { keys: ["Shift+KeyT"], does: "takes", words: "the takes", on: "#takes-box > summary", press: true },
      { keys: ["Shift+KeyE"], does: "earlier", words: "earlier takes", on: "#takes-more", press: true },
      { keys: ["Shift+KeyO"], does: "world", words: "more of the world", on: "#options summary", press: true },
      { keys: ["Shift+KeyV"], does: "further", words: "where I have not been", on: "#further > summary", press: true },
      { keys: ["Shift+KeyM"], does: "movement", words: "movement", on: "#movement > summary", press: true },
      { keys: ["KeyX"], does: "conflicts", words: "what cleaning takes out, and why", on: "#conflicts-summary", press: true },
      { keys: ["Shift+KeyA"], does: "threshold-auto", words: "how far is too far, by itself", on: "#threshold-auto", press: true },
      { keys: ["Shift+KeyF"], does: "fit-more", words: "all that fitting found", on: "#fit-more > summary", press: true },
      { keys: ["Shift+KeyS"], does: "sees", words: "what the character sees", on: "#sees-box > summary", press: true },
      { keys: ["Shift+KeyU"], does: "unclean", words: "take the cleaning back", on: "#unclean", press: true },
      { keys: ["Shift+KeyX"], does: "switch", words: "switch between two", on: "#switch-box > summary", press: true },
      { keys: ["Shift+KeyC"], does: "compare", words: "compare policies", on: ".onward", press: true },
    ],
  },
  ...EVERYWHERE,
];

/** @type {Group[]} The keys of a viewer's page. */
export const WATCHING = [
  {
    title: "Watching",
    shortcuts: [
      { keys: ["Shift+KeyF"], does: "films", words: "films to take along", on: "#films-box > summary", press: true },
      { keys: ["KeyP"], does: "screenshot", words: "a picture of the view, as a file", on: "#screenshot", press: true },
      { keys: ["Shift+KeyC"], does: "compare", words: "see who does it best", on: ".onward", press: true },
    ],
  },
  ...EVERYWHERE,
];

/** @type {Group} What runs side by side share. */
const SIDE_BY_SIDE = {
  title: "Side by side",
  shortcuts: [
    ...THROUGH,
    { keys: ["KeyD"], does: "parting", words: "where they part", on: "#parting", press: true },
    { keys: ["KeyN"], does: "next-world", words: "the next world", on: "#next-world", press: true },
    { keys: ["KeyV"], does: "camera", words: "another camera", on: "#lineup-camera", press: true },
    { keys: ["Shift+KeyV"], does: "straighten", words: "turn the cameras back", on: "#straighten", press: true },
    { keys: ["Escape"], does: "close-lineup", words: "close them", on: "#close-lineup", press: true },
  ],
};

/** @type {Group[]} The keys of the page that compares. */
export const COMPARING = [
  {
    title: "Comparing",
    shortcuts: [
      { keys: ["KeyE"], does: "evaluate", words: "evaluate", on: "#evaluate", press: true },
      { keys: ["KeyB"], does: "beside", words: "side by side", on: "#beside", press: true },
      { keys: ["KeyT"], does: "takes-beside", words: "a take beside them", on: "#takes-beside > summary", press: true },
      { keys: ["KeyQ"], does: "ask-people", words: "ask people which is livelier", on: "#ask-people", press: true },
      { keys: ["Digit3"], does: "table-3", words: "the votes as the paper's Table 3", on: "#table-3", press: true },
      { keys: ["KeyI"], does: "in-lineup", words: "side by side, those of the evaluation", on: "#watch-found", press: true },
      { keys: ["KeyA"], does: "again", words: "make it again", on: "#again", press: true },
      { keys: ["KeyM"], does: "more", words: "more to choose", on: "#asking > details > summary", press: true },
      { keys: ["KeyP"], does: "programs", words: "programs", on: "#pilots summary", press: true },
      { keys: ["Shift+KeyO"], does: "world", words: "more of the world", on: "#options summary", press: true },
      { keys: ["Shift+KeyS"], does: "studio", words: "to the studio", on: ".onward", press: true },
    ],
  },
  SIDE_BY_SIDE,
  ...EVERYWHERE,
];

/** @type {Group[]} The keys of the page on which people choose. */
export const VOTING = [
  {
    title: "Which is livelier?",
    shortcuts: [
      { keys: ["Digit1"], does: "left", words: "the left one", on: "#vote-left", press: true },
      { keys: ["Digit2"], does: "right", words: "the right one", on: "#vote-right", press: true },
      { keys: ["Digit0"], does: "neither", words: "no difference", on: "#vote-neither", press: true },
      { keys: ["Enter"], does: "next-pair", words: "the next two", on: "#next-pair", press: true },
      { keys: ["Shift+KeyC"], does: "compare", words: "see who does it best", on: ".onward", press: true },
    ],
  },
  SIDE_BY_SIDE,
  ...EVERYWHERE,
];

/** Controls that need no key of their own: [which, why, as the sheet says it]. */
export const WITHOUT = [
  ["select, textarea, input", "Fields and lists", "take what is typed: Tab leads to them, arrows choose"],
  ["ul button, ul a, ul summary, ol:not(.steps) button, figcaption a", "Rows of a list", "Tab goes through them, Enter presses"],
  ["form button[type=submit]", "Forms", "Enter in a field sends them, Esc closes them"],
  ["#speeds button", "Speeds", "the keys for slower and faster choose the next one"],
  [".notice button", "Notices", "close with their cross or by themselves"],
  [".share-menu button", "Sharing", "Tab leads through what its menu offers"],
  ["#tour button", "The tour", "Tab leads through its card, Esc closes it"],
  [".job button", "Work under way", "is ended with the button beside it"],
  ["dialog button, #why button", "Dialogs", "Esc closes them"],
  ["iframe", "The 3D view", "drag turns the camera, W A S D move it while nothing runs"],
];

/** @param {Group[]} groups @param {string} does */
const row = (groups, does) =>
  groups.flatMap(({ shortcuts }) => shortcuts).find((one) => one.does === does);

/** The first key of what the studio's page does. @param {string} does */
export const keyOf = (does) => row(STUDIO, does)?.keys[0] ?? "";
