/** The review of conflicts: what cleaning would leave out, and why, before it does. */

import { api } from "./api.js";
import { byId, make, say } from "./dom.js";
import { jobOf, needs, session } from "./needs.js";
import { attempt } from "./notices.js";
import { count, muchWords, plural } from "./words.js";

/** @typedef {import("./types.js").Conflict} Conflict */
/** @typedef {import("./types.js").Conflicts} Conflicts */
/** @typedef {import("./types.js").Verdict} Verdict */

/** So many are listed, the farthest off first. */
const SHOWN = 100;
/** What the slider reaches, as shares of the range, and how finely. */
const LEAST = 0.02;
const MOST = 1.5;
const NOTCHES = 100;
/** Moments that each is compared with, unless another number is chosen. */
const NEIGHBORS = 25;

/** From where on a move goes where each moment has a limit of its own, after "Farther off than". */
const OWN_LIMIT = "is usual there";

/** @type {[Verdict, string, string][]} what it is, in words, what it does */
const VERDICTS = [
  ["keep", "Keep", "It was meant: cleaning leaves it in"],
  ["delete", "Delete", "It was a mistake: cleaning takes it out"],
  ["missing", "Something is missing here",
    "Both were right: what told them apart is not in what the character sees"],
];
/** @type {Record<Verdict, string>} */
const SAID = { keep: "kept", delete: "deleted", missing: "something is missing" };

/** @param {{take: number, step: number}} one */
const keyOf = ({ take, step }) => `${take}.${step}`;

/**
 * @param {import("./store.js").Store} store
 * @param {{compare: (take: number, step: number, clicked: boolean) => void,
 *   look: (session: number, neighbors: number) => Promise<void>}} act
 */
export function conflicts(store, act) {
  const box = byId("conflicts-box", HTMLDetailsElement);
  const slider = byId("threshold", HTMLInputElement);
  const auto = byId("threshold-auto", HTMLButtonElement);
  const compared = byId("compared-with", HTMLSelectElement);
  const list = byId("conflicts", HTMLOListElement);
  /** @type {number | "auto"} */
  let threshold = "auto";
  /** @type {Conflicts | null} */
  let found = null;
  /** What is read, and looked for: a session as it was. */
  let looked = "";
  let reading = false;
  let again = false;
  /** @type {Map<string, Row>} */
  const rows = new Map();

  const chosen = () => store.state.conflict;
  const current = () => store.state.session;
  const sees = () => store.state.perception ?? store.state.scene?.perceptions[0]?.name;

  /** Read what would go now; where several are wanted at once, the last. */
  async function read() {
    const id = current();
    if (!box.open || id === null) return;
    if (reading) {
      again = true;
      return;
    }
    reading = true;
    try {
      const told = await api.conflicts(id, threshold, SHOWN);
      if (id !== current()) return;
      found = told;
      if (told === null || told.stale || told.perception !== sees()) look();
      else compared.value = String(told.neighbors);
    } catch (error) {
      if (id !== current()) return;
      found = null;
      throw error;
    } finally {
      reading = false;
      tell();
      if (again) {
        again = false;
        attempt(read);
      }
    }
  }

  /** Have every moment compared with its like, once for each state of the session. */
  function look() {
    const { session: id, status } = store.state;
    const key = [id, status?.takes_kept, status?.pairs_kept, compared.value, sees()].join("|");
    if (id === null || looked === key || jobOf(store.state, "preview")) return;
    if (needs(store.state).clean !== null) return;
    looked = key;
    attempt(() => act.look(id, Number(compared.value)));
  }

  /** @param {Conflict} one @param {Verdict} verdict */
  async function judge(one, verdict) {
    const id = current();
    if (id === null) return;
    if (one.verdict === verdict) await api.withdraw(id, one.take, one.step);
    else await api.judge(id, one.take, one.step, verdict);
    await read();
  }

  /** The others that lie around one in its take, without a gap. @param {Conflict} one */
  function around(one) {
    const items = (found?.items ?? []).filter(({ take }) => take === one.take);
    const steps = new Set(items.map(({ step }) => step));
    let [first, last] = [one.step, one.step];
    while (steps.has(first - 1)) first -= 1;
    while (steps.has(last + 1)) last += 1;
    return items.filter(({ step }) => step >= first && step <= last && step !== one.step);
  }

  /** Say the same of all that lie around one. @param {Conflict} one */
  async function judgeAround({ verdict, ...one }) {
    const id = current();
    if (id === null || verdict === null) return;
    await Promise.all(
      around({ verdict, ...one }).map(({ take, step }) => api.judge(id, take, step, verdict)),
    );
    await read();
  }

  /** @param {Conflict} one @param {boolean} [clicked] with the pointer, not by a key */
  function choose(one, clicked = false) {
    store.set({ conflict: { take: one.take, step: one.step } });
    act.compare(one.take, one.step, clicked);
    tell();
    rows.get(keyOf(one))?.element.scrollIntoView({ block: "nearest" });
  }

  /** @param {Conflict} one @param {Verdict} verdict */
  const judging = (one, verdict) => attempt(() => judge(one, verdict));
  /** @param {Conflict} one */
  const judgingAround = (one) => attempt(() => judgeAround(one));

  /** @param {number} by */
  function move(by) {
    const items = found?.items ?? [];
    const now = chosen();
    const at = items.findIndex((one) => now && keyOf(one) === keyOf(now));
    const next = items[Math.min(Math.max(at + by, 0), items.length - 1)];
    if (next) choose(next);
  }

  /** Why there is nothing to see, where no work is under way that changes it. */
  function tellNone() {
    const idle = found === null && jobOf(store.state, "preview") === null;
    const why = needs(store.state).clean ?? (reading ? "" : "Nothing was compared so far");
    say(byId("conflicts-none", HTMLElement), idle && why ? `${why}.` : "");
  }

  function tell() {
    byId("conflicts-found", HTMLElement).hidden = found === null;
    tellNone();
    if (found === null) {
      rows.clear();
      list.replaceChildren();
      return;
    }
    const { pairs, goes, symbols, limit, items } = found;
    const share = pairs ? Math.max(Math.round((100 * goes) / pairs), goes ? 1 : 0) : 0;
    const much = muchWords(goes, pairs, threshold);
    const left = items.length < found.conflicts ? ` The farthest off ${count(items.length)}:` : "";
    const none = "Nothing would go: in moments alike you did alike.";
    const some = `${count(goes)} of ${plural(pairs, "pair")} would go (${share} %).${much}${left}`;
    say(byId("conflicts-says", HTMLElement), goes || items.length ? some : none);
    if (threshold === "auto") slider.value = String(notchOf(limit, symbols));
    // Each moment then has a limit of its own: one number would be read as that of all.
    const off = threshold === "auto" ? OWN_LIMIT : percent(threshold);
    say(byId("threshold-says", HTMLElement), off);
    slider.setAttribute("aria-valuetext", `Farther off than ${off}: ${count(goes)} would go`);
    auto.setAttribute("aria-pressed", String(threshold === "auto"));

    const focused = document.activeElement;
    const keys = items.map(keyOf);
    for (const key of rows.keys()) if (!keys.includes(key)) rows.delete(key);
    const elements = items.map((one) => {
      const row = rows.get(keyOf(one)) ?? new Row(choose, judging, judgingAround);
      rows.set(keyOf(one), row);
      const now = chosen();
      const near = one.verdict === null ? [] : around(one).filter(({ verdict }) => verdict !== one.verdict);
      row.show(one, now !== null && keyOf(now) === keyOf(one), found?.neighbors ?? 0, near.length);
      return row.element;
    });
    if (elements.some((element, at) => list.children[at] !== element) || list.children.length !== keys.length) {
      list.replaceChildren(...elements);
      if (focused instanceof HTMLElement && list.contains(focused)) focused.focus();
    }
  }

  box.addEventListener("toggle", () => {
    looked = "";
    attempt(read);
  });
  slider.addEventListener("input", () => {
    threshold = thresholdOf(slider.valueAsNumber, found?.symbols ?? false);
    attempt(read);
  });
  auto.addEventListener("click", () => {
    threshold = "auto";
    attempt(read);
  });
  compared.addEventListener("change", () => look());

  store.watch((state, before) => {
    if (state === before) return;
    const other = state.session !== before.session || state.scene?.name !== before.scene?.name;
    if (other) {
      found = null;
      threshold = "auto";
      compared.value = String(NEIGHBORS);
      if (state.conflict) store.set({ conflict: null });
      tell();
    }
    tellNone();
    const ended = ["preview", "clean"].some((kind) => jobOf(before, kind) && !jobOf(state, kind));
    const counted =
      state.status?.pairs_kept !== before.status?.pairs_kept ||
      session(state)?.pairs !== session(before)?.pairs;
    // What stood in the way of a look is over: a take is finished, the studio is there again.
    const able = needs(state).clean === null && needs(before).clean !== null;
    const seen = state.perception !== before.perception;
    if (other || ended || counted || able || seen) attempt(read);
    const now = state.conflict;
    const away = state.status?.mode !== "review" || state.status.take !== now?.take;
    if (now && away && state.status !== before.status && before.status?.take === now.take) {
      store.set({ conflict: null });
      tell();
    }
  });

  /** @type {Record<string, () => void>} */
  const does = {
    "conflict-before": () => move(-1),
    "conflict-after": () => move(1),
  };
  for (const [verdict] of VERDICTS) {
    does[`conflict-${verdict}`] = () =>
      attempt(async () => {
        const now = chosen();
        const one = found?.items.find((item) => now && keyOf(item) === keyOf(now));
        if (!one) return;
        await judge(one, verdict);
        if (one.verdict !== verdict) move(1);
      });
  }

  return {
    /** Do what a key stands for; whether that is known here. @param {string} name */
    does: (name) => {
      const known = does[name];
      known?.();
      return known !== undefined;
    },
    /** How to clean, where that was chosen here. */
    settings: () => ({
      ...(threshold === "auto" ? {} : { threshold }),
      ...(store.state.perception === null ? {} : { perception: store.state.perception }),
      ...(Number(compared.value) === NEIGHBORS ? {} : { n_neighbors: Number(compared.value) }),
    }),
  };
}

/** One conflict in the list. */
class Row {
  /**
   * @param {(one: Conflict, clicked: boolean) => void} choose
   * @param {(one: Conflict, verdict: Verdict) => void} judge
   * @param {(one: Conflict) => void} judgeAround
   */
  constructor(choose, judge, judgeAround) {
    /** @type {Conflict | null} */
    this.one = null;
    this.where = make("span", { class: "where" });
    this.off = make("span", { class: "off" });
    this.bar = make("progress", { max: "1", "aria-hidden": "true" });
    this.says = make("span", { class: "contradiction" });
    this.said = make("span", { class: "said" });
    this.look = make("button", { type: "button", class: "conflict", title: "Look at this moment" });
    this.look.append(this.where, this.off, this.bar, this.says, this.said);
    this.look.addEventListener("click", ({ detail }) => this.one && choose(this.one, detail > 0));
    this.buttons = VERDICTS.map(([verdict, words, title]) => {
      const button = make("button", { type: "button", "data-verdict": verdict, title });
      button.append(words);
      button.addEventListener("click", () => this.one && judge(this.one, verdict));
      return button;
    });
    this.others = make("span", { class: "others" });
    const ways = make("p", { class: "ways" }, make("span", { class: "own" }, "what you did"), this.others);
    this.more = make("div", { class: "verdicts", role: "group", "aria-label": "What to do with it" });
    this.near = make("button", { type: "button", class: "quiet", "data-does": "around", title: "Judge its neighbours in time alike" });
    this.near.addEventListener("click", () => this.one && judgeAround(this.one));
    this.more.append(ways, ...this.buttons, this.near);
    this.element = make("li", {}, this.look, this.more);
  }

  /**
   * @param {Conflict} one
   * @param {boolean} shown
   * @param {number} neighbors that it was compared with
   * @param {number} near others around it of which something else is said, or nothing
   */
  show(one, shown, neighbors, near) {
    this.one = one;
    this.element.dataset.take = String(one.take);
    this.element.dataset.step = String(one.step);
    this.element.dataset.verdict = one.verdict ?? "";
    this.element.classList.toggle("goes", one.goes);
    this.element.classList.toggle("shown", shown);
    this.look.setAttribute("aria-current", String(shown));
    say(this.where, `Take ${one.number} at ${one.seconds.toFixed(1)} s`);
    say(this.off, `${percent(one.deviation)} off`);
    this.bar.value = Math.min(one.deviation, 1);
    say(this.says, one.says);
    say(this.said, one.verdict ? SAID[one.verdict] : one.goes ? "" : "stays");
    say(this.others, `in ${count(neighbors)} moments like it`);
    this.more.hidden = !shown;
    this.near.hidden = near === 0;
    say(this.near, `The same for ${plural(near, "moment")} around it`);
    for (const button of this.buttons) {
      button.setAttribute("aria-pressed", String(button.dataset.verdict === one.verdict));
    }
  }
}

/** @param {number} share */
const percent = (share) => `${share < 0.1 ? (100 * share).toFixed(1) : Math.round(100 * share)} %`;

/** The threshold at a notch of the slider. @param {number} notch @param {boolean} symbols */
function thresholdOf(notch, symbols) {
  const share = notch / NOTCHES;
  const value = symbols ? LEAST + share * (1 - LEAST) : LEAST * (MOST / LEAST) ** share;
  return Number(value.toPrecision(2));
}

/** The notch nearest to a threshold. @param {number} limit @param {boolean} symbols */
function notchOf(limit, symbols) {
  const share = symbols ? (limit - LEAST) / (1 - LEAST) : Math.log(limit / LEAST) / Math.log(MOST / LEAST);
  return Math.round(Math.min(Math.max(share, 0), 1) * NOTCHES);
}
