/** How people move: clips of one's own for walking, running, falling, in scenes that show people. */

import { api } from "./api.js";
import { byId, make, say } from "./dom.js";
import { attempt } from "./notices.js";

/** @typedef {import("./types.js").Clips} Clips */
/** @typedef {import("./types.js").Activity} Activity */

/** Names that clips for an activity tend to have; those come first. @type {Record<string, RegExp>} */
const LIKELY = {
  stand: /idle|stand/i,
  walk: /walk/i,
  run: /run|jog|sprint/i,
  stagger: /hit|stagger|stumble/i,
  fallen: /fall|death|die/i,
  getting_up: /up$|rise/i,
};

/** @param {import("./store.js").Store} store */
export function clips(store) {
  const box = byId("movement", HTMLDetailsElement);
  const file = byId("clip-files", HTMLInputElement);
  const rows = byId("clip-choices", HTMLElement);
  /** Files that were not taken, by name, with the reason. @type {Map<string, string>} */
  const refused = new Map();
  let shown = "";

  /** @param {Clips} told */
  function show(told) {
    const key = JSON.stringify(told);
    if (key !== shown) rows.replaceChildren(...told.activities.map((one) => row(one, told, choose)));
    shown = key;
    say(byId("clip-folder", HTMLElement), told.folder);
    const broken = told.files.flatMap(({ problem }) => problem ?? []);
    const gone = told.activities.flatMap(({ problem }) => problem ?? []);
    const all = [told.problem ?? [], [...refused.values()], broken, gone].flat();
    byId("clip-problems", HTMLElement).replaceChildren(
      ...[...new Set(all)].map((text) => make("li", {}, text)),
    );
  }

  /** @param {() => Promise<Clips>} work */
  const after = (work) =>
    attempt(async () => {
      try {
        show(await work());
      } catch (error) {
        shown = ""; // what was chosen on the page did not come about
        show(await api.clips());
        throw error;
      }
    });

  /** @param {string} activity @param {string} value */
  function choose(activity, value) {
    const cut = value.indexOf("/");
    after(() =>
      value
        ? api.chooseClip(activity, value.slice(0, cut), value.slice(cut + 1))
        : api.forgetClip(activity),
    ).then(() => document.getElementById(`clip-${activity}`)?.focus());
  }

  /** @param {Iterable<File>} files */
  async function add(files) {
    for (const one of files) {
      refused.delete(one.name);
      try {
        show(await api.addClips(one));
      } catch (error) {
        refused.set(one.name, error instanceof Error ? error.message : String(error));
      }
    }
    await attempt(look);
  }

  const look = async () => show(await api.clips());
  const renew = () => {
    if (box.open && !box.hidden) attempt(look);
  };

  file.addEventListener("change", async () => {
    await add([...(file.files ?? [])]);
    file.value = "";
  });
  const panel = byId("panel", HTMLElement);
  panel.addEventListener("dragover", (event) => {
    if (!box.hidden && event.dataTransfer?.types.includes("Files")) event.preventDefault();
  });
  panel.addEventListener("drop", (event) => {
    if (box.hidden || !event.dataTransfer?.files.length) return;
    event.preventDefault();
    box.open = true;
    add([...event.dataTransfer.files]);
  });
  box.addEventListener("toggle", renew);
  window.addEventListener("focus", renew); // files may have been put into the folder meanwhile
  store.watch(({ scene }, before) => {
    box.hidden = !scene?.people;
    if (scene !== before.scene) renew();
  });
}

/**
 * One activity with what can be chosen for it.
 * @param {Activity} activity
 * @param {Clips} told
 * @param {(activity: string, value: string) => void} choose
 */
function row(activity, told, choose) {
  const id = `clip-${activity.name}`;
  const chosen = activity.file === null ? "" : `${activity.file}/${activity.clip}`;
  const select = make("select", { id, title: "The clip for this" }, make("option", { value: "" }, "As it comes"));
  const likely = (/** @type {string} */ clip) => Number(LIKELY[activity.name]?.test(clip) ?? false);
  for (const { name, clips: held } of told.files) {
    if (!held.length) continue;
    const sorted = [...held].sort((a, b) => likely(b) - likely(a));
    const options = sorted.map((clip) => make("option", { value: `${name}/${clip}` }, clip));
    select.append(make("optgroup", { label: name }, ...options));
  }
  if (![...select.options].some(({ value }) => value === chosen)) {
    const gone = make("option", { value: chosen }, `${activity.clip} (cannot be read)`);
    gone.disabled = true;
    select.append(gone);
  }
  select.value = chosen;
  select.addEventListener("change", () => choose(activity.name, select.value));
  return make("div", { class: "clip" }, make("label", { for: id }, activity.label), select);
}
