/** The buttons over the 3D view: signals of the scene, another character, another camera. */

import { bar, byId, make, say } from "./dom.js";
import { notNow } from "./needs.js";
import { notify } from "./notices.js";
import { keyOf } from "./shortcuts.js";
import { keyName } from "./words.js";

/** @typedef {import("./types.js").State} State */
/** @typedef {import("./pointer.js").Place} Place */

/**
 * @param {import("./store.js").Store} store
 * @param {import("./pointer.js").Pointer} pointer
 * @param {{signal: (name: string, place: Place | null) => void, camera: () => void,
 *   another: () => void, screenshot: () => void}} act
 */
export function tools(store, pointer, act) {
  const box = byId("tools", HTMLElement);
  /** @type {Map<string, HTMLButtonElement>} By id. */
  const buttons = new Map();
  let built = "";

  /**
   * @param {string} id
   * @param {string} code
   * @param {() => void} work
   */
  function button(id, code, work) {
    const made = make("button", { type: "button", id });
    made.append(make("span"), make("kbd", { "data-code": code }, keyName(code)));
    made.addEventListener("click", () => {
      if (made.getAttribute("aria-disabled") === "true") notify(made.title);
      else work();
    });
    buttons.set(id, made);
    return made;
  }

  /**
   * @param {string} id
   * @param {string} text
   * @param {string | null} missing why it cannot be pressed now
   * @param {boolean} [hidden]
   */
  function tell(id, text, missing, hidden = false) {
    const made = buttons.get(id);
    if (made === undefined) return;
    made.hidden = hidden;
    say(/** @type {HTMLElement} */ (made.firstElementChild), text);
    bar(made, missing);
  }

  /** @param {import("./types.js").Signal} signal */
  async function give({ name, label, placed }) {
    if (!placed) return act.signal(name, null);
    if (pointer.picking) return pointer.cancel();
    notify(`Click in the view where to ${label}.`);
    const place = await pointer.pick();
    if (place !== null) act.signal(name, place);
  }

  store.watch((state) => {
    const { scene, status } = state;
    if (scene === null) return;
    if (built !== scene.name) {
      built = scene.name;
      box.replaceChildren(
        ...scene.signals.map((one) => button(`signal-${one.name}`, one.key, () => give(one))),
        button("another", keyOf("another"), act.another),
        button("camera", keyOf("camera"), act.camera),
        button("screenshot", keyOf("screenshot"), act.screenshot),
      );
    }
    const moves = ["recording", "playing"].includes(status?.phase ?? "");
    if (!moves) pointer.cancel();
    for (const { name, label } of scene.signals) {
      const words = label.charAt(0).toUpperCase() + label.slice(1);
      tell(`signal-${name}`, words, notNow(state, name));
    }
    tell("another", "Another character", notNow(state, "another"), (status?.lead ?? null) === null);
    const cameras = status?.cameras ?? [];
    tell("screenshot", "Take a picture", null);
    tell("camera", `Camera: ${status?.camera ?? ""}`, null, cameras.length < 2);
  });
}
