/** Making a switch: first one policy, then, when something is so, another. */

import { api } from "./api.js";
import { byId, fill } from "./dom.js";
import { MARK, session } from "./needs.js";
import { attempt, notify } from "./notices.js";

/** @typedef {import("./types.js").State} State */
/** @typedef {import("./types.js").Job} Job */

const AFTER = "after";

/**
 * @param {import("./store.js").Store} store
 * @param {(job: Job) => void} made
 */
export function switches(store, made) {
  const form = byId("switch-form", HTMLFormElement);
  const first = byId("switch-first", HTMLSelectElement);
  const then = byId("switch-then", HTMLSelectElement);
  const when = byId("switch-when", HTMLSelectElement);
  const seconds = byId("switch-seconds", HTMLInputElement);
  const name = byId("switch-name", HTMLInputElement);

  const showSeconds = () => {
    byId("switch-after", HTMLElement).hidden = when.value !== AFTER;
  };
  when.addEventListener("change", showSeconds);
  const box = byId("switch-box", HTMLDetailsElement);
  box.addEventListener("toggle", () => box.open && form.scrollIntoView({ block: "end" }));
  form.addEventListener("submit", (event) => {
    event.preventDefault();
    if (first.value === then.value) return notify("Choose two different policies.");
    attempt(async () => {
      const condition = when.value === AFTER ? `after:${seconds.value}s` : when.value;
      const entries = [{ policy: then.value, when: condition }, { policy: first.value }];
      made(await api.makeSwitch(name.value.trim(), entries));
    });
  });
  store.watch((state, before) => {
    const same =
      state.policies === before.policies &&
      state.scene === before.scene &&
      state.session === before.session &&
      state.sessions === before.sessions;
    if (same && when.length) return;
    const able = state.policies.filter((one) => !one.problem && !one.switches.length);
    box.hidden = able.length < 2;
    const known = able.map((one) => ({ value: one.name, text: one.name }));
    const names = known.map(({ value }) => value);
    fill(first, known, names.includes(first.value) ? first.value : (names[0] ?? ""));
    fill(then, known, names.includes(then.value) ? then.value : (names[1] ?? ""));
    const choices = conditions(state);
    const kept = state.scene === before.scene && choices.some(({ value }) => value === when.value);
    fill(when, choices, kept ? when.value : choices[0].value);
    showSeconds();
  });
}

/** @param {State} state */
function conditions(state) {
  const events = state.scene?.events ?? [];
  const choices = events.map(({ name, label }) => ({ value: `once event:${name}`, text: label }));
  choices.push({ value: AFTER, text: "some seconds have passed" });
  const now = session(state);
  const marks = state.scene?.signals.some(({ name }) => name === MARK);
  if (marks && now?.pairs) {
    choices.push({ value: `learned:${now.id}`, text: `as I marked in “${now.name}”` });
  }
  return choices;
}
