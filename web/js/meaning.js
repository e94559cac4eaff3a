/** What each key means at a moment. */

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

  switch (event.code) {
    case "Space":
      if (!acting || (onControl && !demonstrating)) return null;
      return { kind: "command", name: phase === "paused" ? "resume" : "pause" };
    case "KeyR":
      return mode === null ? null : { kind: "command", name: "restart" };
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
