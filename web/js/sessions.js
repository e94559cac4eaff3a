/** Choosing a scene and a session, and making new sessions. */

import { api } from "./api.js";
import { byId, fill } from "./dom.js";
import { attempt } from "./notices.js";
import { plural } from "./words.js";

/**
 * @param {import("./store.js").Store} store
 * @param {{chooseScene: (name: string) => void, chooseSession: (id: number) => void}} act
 */
export function sessions(store, act) {
  const scene = byId("scene", HTMLSelectElement);
  const choice = byId("session", HTMLSelectElement);
  const open = byId("new-session", HTMLButtonElement);
  const form = byId("session-form", HTMLFormElement);
  const name = byId("session-name", HTMLInputElement);

  scene.addEventListener("change", () => act.chooseScene(scene.value));
  choice.addEventListener("change", () => {
    if (choice.value) act.chooseSession(Number(choice.value));
  });

  const toggle = (/** @type {boolean} */ shown) => {
    form.hidden = !shown;
    open.setAttribute("aria-expanded", String(shown));
    if (shown) name.focus();
  };
  open.addEventListener("click", () => toggle(form.hidden));
  form.addEventListener("keydown", (event) => {
    if (event.key === "Escape") {
      toggle(false);
      open.focus();
    }
  });
  form.addEventListener("submit", (event) => {
    event.preventDefault();
    attempt(async () => {
      const now = store.state.scene;
      if (now === null || !name.value.trim()) return;
      const made = await api.makeSession(now.name, name.value.trim());
      store.set({ sessions: [made, ...store.state.sessions] });
      act.chooseSession(made.id);
      name.value = "";
      toggle(false);
      open.focus();
    });
  });

  store.watch((state, before) => {
    if (state.scenes !== before.scenes || state.scene !== before.scene) {
      byId("scene-choice", HTMLElement).hidden = state.scenes.length < 2;
      const titles = state.scenes.map((one) => ({ value: one.name, text: one.title }));
      fill(scene, titles, state.scene?.name ?? "");
    }
    if (state.sessions !== before.sessions || state.session !== before.session) {
      const known = state.sessions.map((one) => ({
        value: String(one.id),
        text: `${one.name} (${plural(one.takes_kept, "take")})`,
      }));
      const none = { value: "", text: "A new one, with the first take" };
      const value = state.session === null ? "" : String(state.session);
      fill(choice, state.session === null ? [none, ...known] : known, value);
    }
  });
}
