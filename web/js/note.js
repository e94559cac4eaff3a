/** Writing a note of a take, in its row of the list. */

import { api } from "./api.js";
import { make } from "./dom.js";
import { attempt } from "./notices.js";

/** @typedef {import("./types.js").Take} Take */

/**
 * Let a person write in `body`; Enter keeps it, Escape leaves it as it was.
 * @param {HTMLElement} body
 * @param {Take} take
 * @param {() => Promise<void>} reload
 */
export function noteForm(body, take, reload) {
  if (body.querySelector("form")) return;
  const text = make("textarea", {
    rows: "2",
    maxlength: "2000",
    "aria-label": `Note of take ${take.number}`,
    title: "Enter keeps it, Escape leaves it as it was",
    placeholder: "What to remember of it",
  });
  text.value = take.note;
  const save = make("button", { type: "submit", title: "Keep it (Enter)" }, "Keep note");
  const form = make("form", { class: "note-form" }, text, save);
  const back = () => {
    form.remove();
    /** @type {HTMLElement | null} */ (body.querySelector("[data-does=note]"))?.focus();
  };
  form.addEventListener("keydown", (event) => {
    if (event.key === "Escape") back();
    if (event.key === "Enter" && !event.shiftKey && event.target === text) {
      event.preventDefault();
      form.requestSubmit();
    }
  });
  form.addEventListener("submit", (event) => {
    event.preventDefault();
    attempt(async () => {
      await api.note(take.id, text.value);
      back();
      await reload();
    });
  });
  body.append(form);
  text.focus();
}
