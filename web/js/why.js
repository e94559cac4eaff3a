/** Why did it do that? The demonstrated moments a decision came from: looked at, or left out. */

import { byId, make, say } from "./dom.js";
import { attempt } from "./notices.js";
import { familiarWords } from "./strip.js";

/** @typedef {import("./types.js").Status} Status */
/** @typedef {import("./types.js").Why} Why */
/** @typedef {import("./types.js").ShownMoment} ShownMoment */

/** Whether one can look at a decision: what plays holds still, or is looked back at. @param {Status} status */
const still = ({ mode, phase }) =>
  mode === "review" || (mode === "play" && ["paused", "ended"].includes(phase));

/** Whether it is one of what plays, and of no take. @param {Status} status */
const ofRun = ({ take, speed }) => take === null && speed === 0;

/** Which decision is looked at. @param {Status} status */
const place = ({ seed, length_s, position_s, phase }) =>
  `${seed} ${length_s} ${position_s} ${phase}`;

/** @param {Why} why @param {number} left how many were left out since it was opened */
function words({ familiarity, agreement, moments }, left) {
  const parts = [];
  const known = familiarWords(familiarity);
  if (known) parts.push(`This moment is ${known}.`);
  if (agreement !== null && moments.length > 1) {
    if (agreement > 0.8) parts.push("What you did in such moments agrees.");
    else if (agreement < 0.4) parts.push("You did quite different things in such moments.");
  }
  if (left) parts.push("It decides without what you left out, from now on.");
  return parts.join(" ");
}

/**
 * @param {import("./store.js").Store} store
 * @param {{ask: () => Promise<Why | null>, command: (name: string, more?: object) => void,
 *   notify: (text: string) => void}} act
 * @returns {() => void} show it, or put it away
 */
export function why(store, act) {
  const box = byId("why", HTMLElement);
  const says = byId("why-says", HTMLElement);
  const list = byId("why-moments", HTMLElement);
  /** @type {Why | null} */
  let found = null;
  let open = false;
  let asked = "";
  let left = 0;
  let drawn = "";
  /** So that answers about what was looked at before are not shown. */
  let turn = 0;

  const now = () => store.state.status;

  function show() {
    const status = now();
    box.hidden = !open || status === null;
    if (box.hidden || status === null) return;
    const inTake = status.take !== null;
    byId("why-back", HTMLElement).hidden = !inTake;
    const key = JSON.stringify([found, left, status.take, inTake && status.position_s, status.silent]);
    if (drawn === key) return;
    drawn = key;
    const silent = found === null ? status.silent : found.silent;
    say(says, found && silent === null ? words(found, left) : (silent ?? "Nothing was decided yet."));
    const rows = silent === null ? (found?.moments ?? []) : [];
    list.replaceChildren(...rows.map((moment) => row(moment, status)));
    list.hidden = rows.length === 0;
  }

  /** Ask anew about the decision that is looked at. */
  async function ask() {
    const mine = ++turn;
    const answer = await act.ask().catch(() => null);
    if (mine !== turn) return;
    found = answer;
    show();
  }

  /** @param {ShownMoment} moment @param {Status} status */
  function row(moment, status) {
    const { take, step, number, seconds, session, weight } = moment;
    const share = `${Math.round(100 * weight)} %`;
    const bar = make("progress", { max: "1", value: String(weight), "aria-label": `Counted ${share}` });
    if (take === null || step === null || seconds === null) {
      const words = number === null ? "A moment of a take that is not here" : "A moment";
      return make("li", {}, make("p", { class: "why-when" }, words), bar);
    }
    const dt = store.state.scene?.dt_s ?? 1;
    const here = status.take === take && Math.abs((status.position_s ?? -1) - seconds) < dt / 2;
    const mine = session === store.state.sessions.find(({ id }) => id === store.state.session)?.name;
    const when = `Take ${number} at ${seconds.toFixed(2)} s`;
    const look = make("button", {
      type: "button", class: "quiet", "data-does": "look", "aria-pressed": String(here),
      title: "Look at that moment of the take", "aria-label": `Look at ${when.toLowerCase()}`,
    }, "Look");
    look.addEventListener("click", () => act.command("review", { take, seconds }));
    const out = make("button", {
      type: "button", class: "quiet", "data-does": "forget",
      title: "It decides without this moment from now on, and so does what you fit next",
      "aria-label": `Leave out ${when.toLowerCase()}`,
    }, "Leave out");
    out.addEventListener("click", () => {
      out.setAttribute("aria-disabled", "true");
      act.command("forget", { take, step });
      act.notify(`${when} is left out. “Take back” at Clean brings it back.`);
    });
    const item = make("li", { "data-take": String(take), "data-step": String(step) },
      make("p", { class: "why-when" }, mine ? when : `${when}, “${session}”`),
      make("span", { class: "why-share" }, share), bar,
      make("div", { class: "why-does" }, look, out));
    item.classList.toggle("here", here);
    return item;
  }

  function toggle() {
    const status = now();
    if (status?.mode === "correct") return act.notify("You steer just now. T hands back.");
    if (status?.phase === "playing") return act.command("pause");
    open = box.hidden && status !== null && still(status);
    asked = "";
    look();
  }

  /** Follow what is looked at. */
  function look() {
    const status = now();
    if (status !== null && open && ofRun(status) && asked !== place(status)) {
      asked = place(status);
      attempt(ask);
    }
    show();
  }

  byId("why-close", HTMLButtonElement).addEventListener("click", toggle);
  byId("why-back", HTMLButtonElement).addEventListener("click", () => act.command("leave"));
  store.watch(({ status }, before) => {
    if (status === before.status || status === null) return;
    const was = before.status;
    const stopped = was?.phase === "playing" && status.phase === "paused" && was.mode === "play";
    if (stopped && was.seed === status.seed) open = true;
    if (!still(status)) {
      open = false;
      left = 0;
    }
    if (was && status.forgotten > was.forgotten && open) {
      left += 1;
      asked = "";
    }
    look();
  });
  return toggle;
}
