/** What is to be compared: the scene, who, in how many worlds, and the button that begins. */

import { bar, byId, fill, make, say } from "./dom.js";
import { jobOf } from "./needs.js";
import { notify } from "./notices.js";
import { plural } from "./words.js";

/** @typedef {import("./types.js").Comparing} Comparing */

/** @type {Record<string, string>} */
const KINDS = { own: "Your policies", shipped: "They come with the studio", program: "Programs" };

/** What a session is called among those to be like. */
const TAKES = "session:";

/** What the form asks for. @param {Comparing} state */
export function question({ scene, chosen, options }) {
  const like = byId("like", HTMLSelectElement).value;
  const takes = like.startsWith(TAKES) ? like.slice(TAKES.length) : null;
  return {
    scene: scene?.name ?? "",
    policies: chosen,
    options,
    worlds: byId("worlds", HTMLInputElement).valueAsNumber,
    seed: byId("seed", HTMLInputElement).valueAsNumber,
    ...(takes ? { like_session: Number(takes) } : { like: like || null }),
  };
}

/**
 * Why nothing can be evaluated now, or null.
 * @param {Comparing} state
 */
function missing(state) {
  if (jobOf(state, "evaluate")) return "An evaluation is under way";
  if (state.chosen.length === 0) return "Choose two or more to compare";
  if (state.chosen.length === 1) return "Choose one more to compare with";
  for (const [id, what] of [["worlds", "Worlds"], ["seed", "Series"]]) {
    const { validationMessage } = byId(id, HTMLInputElement);
    if (validationMessage) return `${what}: ${validationMessage}`;
  }
  return null;
}

/**
 * @param {import("./store.js").Store<Comparing>} store
 * @param {{chooseScene: (name: string) => void, evaluate: () => void}} act
 */
export function asking(store, act) {
  const scene = byId("scene", HTMLSelectElement);
  const like = byId("like", HTMLSelectElement);
  const button = byId("evaluate", HTMLButtonElement);
  scene.addEventListener("change", () => act.chooseScene(scene.value));
  byId("asking", HTMLFormElement).noValidate = true;
  byId("asking", HTMLFormElement).addEventListener("submit", (event) => {
    event.preventDefault();
    if (document.body.classList.contains("viewing")) return byId("beside", HTMLElement).click();
    const why = missing(store.state);
    if (why === null) act.evaluate();
    else notify(`${why}.`);
  });
  const tell = () => {
    const why = missing(store.state);
    bar(button, why);
    button.classList.toggle("next", why === null);
    const many = byId("worlds", HTMLInputElement).valueAsNumber;
    const ready = `${plural(store.state.chosen.length, "pilot")} through the same ${plural(many, "world")}.`;
    say(byId("evaluate-says", HTMLElement), why === null ? ready : `${why}.`);
  };
  for (const id of ["worlds", "seed"]) byId(id, HTMLInputElement).addEventListener("input", tell);

  store.watch((state, before) => {
    fill(
      scene,
      state.scenes.map(({ name, title }) => ({ value: name, text: title })),
      state.scene?.name ?? "",
    );
    if (state.pilots !== before.pilots) list(store, state.pilots);
    const kept = like.value;
    const alike = [{ value: "", text: "Nobody" }];
    for (const name of state.chosen) alike.push({ value: name, text: name });
    for (const { id, name, pairs } of state.sessions) {
      if (pairs) alike.push({ value: `${TAKES}${id}`, text: `The takes of “${name}”` });
    }
    fill(like, alike, alike.some(({ value }) => value === kept) ? kept : "");
    tell();
  });
}

/**
 * @param {import("./store.js").Store<Comparing>} store
 * @param {import("./types.js").PilotEntry[]} pilots
 */
function list(store, pilots) {
  const groups = Object.entries(KINDS).map(([kind, title]) => {
    const boxes = pilots
      .filter((one) => one.kind === kind)
      .map(({ name }) => {
        const box = make("input", { type: "checkbox", value: name });
        box.addEventListener("change", () => {
          const others = store.state.chosen.filter((one) => one !== name);
          store.set({ chosen: box.checked ? [...others, name] : others });
        });
        return make("label", { title: `Compare ${name}` }, box, name);
      });
    if (boxes.length === 0) return "";
    const group = make("fieldset", {}, make("legend", {}, title), ...boxes);
    if (kind !== "program") return group;
    group.firstElementChild?.classList.add("unseen");
    return make("details", {}, make("summary", { title: "Pilots that are written, not learned" }, title), group);
  });
  byId("pilots", HTMLElement).replaceChildren(...groups.filter((group) => group !== ""));
}
