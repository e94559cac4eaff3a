/** What each key means at a moment. */

/** Keys that lead through what one looks back at. @type {Record<string, string>} */
const LOOKING_BACK = {
  ArrowLeft: "step-back",
  ArrowRight: "step-on",
  "Shift+ArrowLeft": "second-back",
  "Shift+ArrowRight": "second-on",
  Home: "to-begin",
  End: "to-end",
  Space: "roll",
  KeyJ: "roll-back",
  KeyL: "roll-on",
  KeyK: "stand",
  Comma: "slower",
  Period: "faster",
  KeyF: "fork",
  Escape: "leave",
};
const REPEATED = ["step-back", "step-on", "second-back", "second-on"];

/**
 * @param {KeyboardEvent} event
 * @param {boolean} onControl
 * @returns {Meaning}
 */
function lookingBack(event, onControl) {
  const name = LOOKING_BACK[(event.shiftKey ? "Shift+" : "") + event.code];
  const { id, tagName } = /** @type {Element} */ (event.composedPath()[0]);
  // Radio buttons and sliders use arrows themselves, and all that is pressed uses Space.
  const own = event.code === "Space" ? onControl : tagName === "INPUT";
  const used = /^(Space|Arrow|Home|End)/.test(event.code) && own && id !== "moment";
  if (name === undefined || used) return null;
  return { kind: "command", name, repeats: REPEATED.includes(name) };
}

/** @typedef {import("./types.js").State} State */
/** @typedef {import("./keys.js").Meaning} Meaning */

/**
 * @param {State} state
 * @param {KeyboardEvent} event
 * @param {boolean} onControl a button or the like has the focus, and its own use for Space
 * @returns {Meaning}
 */
export function meaningOf(state, event, onControl) {
  const { status, scene } = state;
  if (status === null || scene === null) return null;
  const { phase, mode } = status;
  const modified = event.ctrlKey || event.metaKey || event.altKey;
  if (event.code === "KeyZ" && modified && !event.altKey && !event.shiftKey) {
    return status.can_undo ? { kind: "command", name: "undo" } : null;
  }
  if (modified) return null;

  const acting = ["countdown", "recording", "paused", "playing"].includes(phase);
  const demonstrating = acting && mode === "demonstrate";
  const steers = scene.controls.some(
    ({ negative, positive }) => negative.includes(event.code) || positive.includes(event.code),
  );
  if (steers && demonstrating) return { kind: "hold" };
  if (steers && acting) return { kind: "swallow" };

  const signal = scene.signals.find(({ key }) => key === event.code);
  if (signal && acting) return { kind: "signal", name: signal.name };

  if (mode === "review") {
    const meant = lookingBack(event, onControl);
    if (meant !== null || ["KeyR", "KeyF"].includes(event.code)) return meant;
  }
  const still = phase === "paused" || phase === "ended";

  switch (event.code) {
    case "Space":
      if (!acting || (onControl && !demonstrating)) return null;
      return { kind: "command", name: phase === "paused" ? "resume" : "pause" };
    case "KeyR":
      if (mode === null) return null;
      return { kind: "command", name: event.shiftKey ? "restart-same" : "restart" };
    case "KeyL":
      return still || phase === "playing" ? { kind: "command", name: "look-back" } : null;
    case "KeyK":
      return mode === "demonstrate" && status.pairs ? { kind: "command", name: "keep-last" } : null;
    case "Backspace":
      return mode === "demonstrate" ? { kind: "command", name: "discard" } : null;
    case "KeyU":
      return status.can_undo ? { kind: "command", name: "undo" } : null;
    case "KeyV":
      return status.cameras.length > 1 ? { kind: "command", name: "camera" } : null;
    case "KeyC":
      return status.lead !== null ? { kind: "command", name: "another" } : null;
    case "Escape":
      return mode === null ? null : { kind: "command", name: "stop" };
    default:
      return null;
  }
}
