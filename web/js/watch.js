/** Puts the viewer's page together: which stage is watched, and how it stands. */

import { api } from "./api.js";
import { decisions } from "./decisions.js";
import { byId, fill, make } from "./dom.js";
import { hud } from "./hud.js";
import { Link } from "./link.js";
import { attempt, notify } from "./notices.js";
import { screenshot } from "./screenshot.js";
import { viewed, watchScheme } from "./scheme.js";
import { pageKeys, sheet } from "./sheet.js";
import { WATCHING } from "./shortcuts.js";
import { Store } from "./store.js";

/** @typedef {import("./types.js").Stage} Stage */

/** How often the page looks which stages are open. */
const LOOK_MS = 3000;
const NOBODY = "Nobody has a stage open now. As soon as somebody does, it is shown here.";

const store = /** @type {Store} */ (
  /** @type {unknown} */ (new Store({ scenes: [], scene: null, status: null }))
);
const view = byId("view", HTMLIFrameElement);
const banner = byId("connection", HTMLElement);
const choice = byId("watched", HTMLSelectElement);
/** @type {string | null} */
let wanted = null;

/** What is open now, in the list; the one that is watched, or else the one opened last. */
async function openStage() {
  const [stages, scenes] = await Promise.all([api.stages(), api.scenes()]);
  const titles = new Map(scenes.map(({ name, title }) => [name, title]));
  const found = stages.find(({ id }) => id === wanted) ?? stages.at(-1);
  wanted = found?.id ?? null;
  const items = stages.map(({ id, scene }, number) => ({
    value: id,
    text: `${titles.get(scene) ?? scene}, stage ${number + 1}`,
  }));
  fill(choice, items.length ? items : [{ value: "", text: "No stage is open" }], wanted ?? "");
  if (found === undefined) throw new Error(NOBODY);
  store.set({ scenes, scene: scenes.find(({ name }) => name === found.scene) ?? null });
  return found;
}

const link = new Link(openStage);
link.addEventListener("stage", (event) => {
  view.src = viewed(/** @type {CustomEvent<Stage>} */ (event).detail.view);
});
watchScheme(() => {
  if (link.stage) view.src = viewed(link.stage.view);
});
link.addEventListener("open", () => {
  banner.hidden = true;
});
link.addEventListener("lost", (event) => {
  const why = /** @type {CustomEvent<string>} */ (event).detail;
  banner.textContent = why || "The connection to the studio was lost. Trying again…";
  banner.hidden = false;
});
link.addEventListener("message", (event) => {
  const { type, ...content } = /** @type {CustomEvent} */ (event).detail;
  if (type === "status") store.set({ status: content });
  else if (type === "notice") notify(content.text, content.level);
});
byId("screenshot", HTMLButtonElement).addEventListener("click", () =>
  attempt(() => screenshot(view, store.state.scene?.name ?? "view")),
);
const box = byId("films-box", HTMLDetailsElement);
box.addEventListener("toggle", () =>
  attempt(async () => {
    const found = box.open ? await api.films() : [];
    const links = found.map(({ name }) =>
      make("a", { href: api.filmFile(name), download: name, title: "Take it along" }, name),
    );
    const items = links.length ? links : ["None has been made yet: authors make them with Share."];
    byId("films", HTMLUListElement).replaceChildren(...items.map((one) => make("li", {}, one)));
  }),
);
choice.addEventListener("change", () => {
  wanted = choice.value;
  store.set({ status: null });
  link.connect(true);
});
setInterval(() => {
  if (link.open) openStage().catch(() => {});
}, LOOK_MS);

pageKeys(WATCHING).attachFrame(view);
sheet(WATCHING);
hud(store, { acts: false });
decisions(store);
link.connect();
