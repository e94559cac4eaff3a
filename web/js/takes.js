/** The takes of the session, the newest first: what each looks like, came to and comes from. */

import { api } from "./api.js";
import { byId, make, say } from "./dom.js";
import { session } from "./needs.js";
import { noteForm } from "./note.js";
import { attempt } from "./notices.js";
import { count, duration, originWords, outcomeWords } from "./words.js";

/** @typedef {import("./types.js").Take} Take */
/** @typedef {import("./types.js").Scene} Scene */
/** @typedef {import("./types.js").Remark} Remark */
/** @typedef {{scene: Scene | null, remarks: Remark[], shown: boolean}} Around */

/** Takes that are shown at first, and that are added. */
export const SOME = 20;
/** How wide to high thumbnails are, which the page keeps free for them. */
const WIDTH = 128;
const HEIGHT = 72;

/**
 * @param {import("./store.js").Store} store
 * @param {{look: (take: number) => void, reload: (takes?: number) => Promise<void>}} act
 */
export function takes(store, act) {
  const list = byId("takes", HTMLElement);
  const more = byId("takes-more", HTMLButtonElement);
  /** What each row was made of. @type {Map<number, {key: string, row: HTMLElement}>} */
  const rows = new Map();
  /** @type {Map<number, Remark[]>} */
  let remarks = new Map();
  let asked = 0;

  more.addEventListener("click", () => attempt(() => act.reload(store.state.takes.length + SOME)));

  /** Which of them are suspicious, which the studio need not tell at once. @param {number} id */
  async function judge(id) {
    const mine = ++asked;
    const found = await api.remarks(id).catch(() => []);
    if (mine !== asked) return;
    remarks = new Map(found.map((one) => [one.take, one.remarks]));
    show();
  }

  function show() {
    const state = store.state;
    const now = session(state);
    byId("takes-none", HTMLElement).hidden = state.takes.length > 0;
    const kept = now?.takes_kept ? `${count(now.takes_kept)} kept` : "none kept yet";
    const words = [
      now?.takes_trashed ? `${kept}, ${count(now.takes_trashed)} in the trash` : kept,
      remarks.size ? `${count(remarks.size)} to look at again` : "",
    ];
    say(byId("takes-count", HTMLElement), words.filter(Boolean).join(" · "));
    more.hidden = !state.moreTakes;
    const looked = state.status?.take ?? null;
    const wanted = state.takes.map((take) => {
      const around = {
        scene: state.scene,
        remarks: remarks.get(take.id) ?? [],
        shown: looked === take.id,
      };
      const key = JSON.stringify([take, around.remarks, around.shown]);
      const known = rows.get(take.id);
      if (known && (known.key === key || known.row.querySelector("form"))) return known.row;
      const made = row(take, around, act);
      if (known?.row.contains(document.activeElement)) keepFocus(known.row, made);
      rows.set(take.id, { key, row: made });
      return made;
    });
    for (const id of rows.keys()) {
      if (!state.takes.some((take) => take.id === id)) rows.delete(id);
    }
    if (wanted.length !== list.children.length || wanted.some((one, i) => one !== list.children[i])) {
      replace(list, wanted);
    }
  }

  store.watch((state, before) => {
    const other = state.takes !== before.takes;
    if (other && state.session !== null && state.takes.length) judge(state.session);
    if (other && state.session !== before.session) remarks = new Map();
    const looked = state.status?.take !== before.status?.take;
    if (other || looked || state.sessions !== before.sessions) show();
  });
}

/**
 * Put `wanted` into `list` without taking out what stays, so that the focus stays too.
 * @param {HTMLElement} list
 * @param {HTMLElement[]} wanted
 */
function replace(list, wanted) {
  const stay = new Set(wanted);
  for (const old of [...list.children]) if (!stay.has(/** @type {HTMLElement} */ (old))) old.remove();
  wanted.forEach((one, i) => {
    if (list.children[i] !== one) list.insertBefore(one, list.children[i] ?? null);
  });
}

/**
 * Let the button that had the focus have it after its row was made anew.
 * @param {HTMLElement} before
 * @param {HTMLElement} after
 */
function keepFocus(before, after) {
  const does = /** @type {HTMLElement} */ (document.activeElement).dataset.does;
  queueMicrotask(() => {
    /** @type {HTMLElement | null} */ (after.querySelector(`[data-does="${does}"]`))?.focus();
  });
}

/**
 * @param {Take} take
 * @param {Around} around
 * @param {{look: (take: number) => void, reload: () => Promise<void>}} act
 */
function row(take, { scene, remarks, shown }, act) {
  const good = take.outcome !== null && scene?.successes?.includes(take.outcome);
  const words = take.outcome === null ? "Stopped" : outcomeWords(take.outcome);
  const picture = make("img", {
    src: api.thumbnail(take.id, take.pairs),
    alt: "",
    width: String(WIDTH),
    height: String(HEIGHT),
    loading: "lazy",
    decoding: "async",
  });
  const look = make("button", {
    type: "button",
    class: "thumbnail",
    "data-does": "look",
    "aria-label": `Look at take ${take.number}`,
    "aria-pressed": String(shown),
    title: "Look at this take",
  });
  if (take.pairs) look.append(picture);
  look.addEventListener("click", () => act.look(take.id));

  const note = make("p", { class: "note" }, take.note);
  const from = originWords(take.origin);
  const body = make(
    "div",
    { class: "take" },
    make(
      "p",
      { class: "take-head" },
      make("span", { class: "size" }, `#${take.number}`),
      make("span", { class: `ended ${good ? "good" : ""}` }, words),
      make("span", { class: "size", title: `${count(take.pairs)} pairs` }, duration(take.seconds)),
    ),
    ...(from ? [make("p", { class: "from" }, from)] : []),
    ...remarks.map(({ kind, says }) => make("p", { class: "remark", "data-kind": kind }, says)),
    ...(take.note ? [note] : []),
    make(
      "div",
      { class: "take-does" },
      button("Note", `of take ${take.number}`, "note", "What to remember of it", () =>
        noteForm(body, take, act.reload),
      ),
      button(
        take.trashed ? "Bring back" : "Throw away",
        `take ${take.number}`,
        "trash",
        take.trashed ? "Out of the trash" : "Into the trash; it can be brought back",
        () =>
          attempt(async () => {
            await (take.trashed ? api.restore(take.id) : api.trash(take.id));
            await act.reload();
          }),
      ),
    ),
  );
  const classes = [take.trashed ? "trashed" : "", shown ? "shown" : ""].filter(Boolean).join(" ");
  return make("li", { class: classes, "data-take": String(take.id) }, look, body);
}

/**
 * @param {string} words
 * @param {string} of what it is about, for who hears the page
 * @param {string} does
 * @param {string} title
 * @param {() => void} work
 */
function button(words, of, does, title, work) {
  const label = `${words} ${of}`;
  const made = make(
    "button",
    { type: "button", class: "quiet", "data-does": does, "aria-label": label, title },
    words,
  );
  made.addEventListener("click", work);
  return made;
}
