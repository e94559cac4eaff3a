/** What each key means at a moment. */

import { acting } from "./shortcuts.js";

/** @typedef {import("./shortcuts.js").State} State */
/** @typedef {import("./keys.js").Meaning} Meaning */

/**
 * @param {import("./shortcuts.js").Group[]} groups
 * @param {State} state
 * @param {KeyboardEvent} event
 * @param {boolean} onControl a button or the like has the focus
 * @returns {Meaning}
 */
export function meaningOf(groups, state, event, onControl) {
  const { status, scene } = state;
  const demonstrating = acting(state) && ["demonstrate", "correct"].includes(status?.mode ?? "");
  if (scene && acting(state) && !event.ctrlKey && !event.metaKey && !event.altKey) {
    const steers = scene.controls.some(
      ({ negative, positive }) => negative.includes(event.code) || positive.includes(event.code),
    );
    if (steers) return { kind: "hold" };
    const signal = scene.signals.find(({ key }) => key === event.code);
    if (signal) return { kind: "signal", name: signal.name };
  }
  if (usesItself(event, onControl && !demonstrating)) return null;
  for (const { shortcuts } of groups) {
    for (const { keys, does, when, press, on, repeats } of shortcuts) {
      if (!keys.some((key) => isPressed(key, event))) continue;
      const control = press ? shown(on ?? "") : null;
      if ((press && control === null) || (when && !when(state))) continue;
      return control ? { kind: "press", control } : { kind: "command", name: does, repeats };
    }
  }
  return null;
}

/** @param {string} key as the table has it @param {KeyboardEvent} event */
function isPressed(key, event) {
  if (event.altKey) return false;
  const ctrl = event.ctrlKey || event.metaKey;
  if (key.length === 1) return key === event.key && !ctrl;
  return key === (ctrl ? "Ctrl+" : "") + (event.shiftKey ? "Shift+" : "") + event.code;
}

/**
 * Whether what has the focus has a use of its own for the key: buttons for Space and Enter, sliders
 * and radio buttons for arrows. The timeline's is the same as the page's.
 *
 * @param {KeyboardEvent} event
 * @param {boolean} onControl
 */
function usesItself(event, onControl) {
  const { id, tagName } = /** @type {Element} */ (event.composedPath()[0]);
  if (id === "moment") return false;
  if (/^(Space|Enter)$/.test(event.code)) return onControl;
  return /^(Arrow|Home|End|Page)/.test(event.code) && tagName === "INPUT";
}

/** The first control of that kind that a person can see now. @param {string} selector */
function shown(selector) {
  for (const one of document.querySelectorAll(selector)) {
    if (one instanceof HTMLElement && one.checkVisibility({ visibilityProperty: true })) return one;
  }
  return null;
}
