/** The timeline: any moment of a run or a take is looked at, passed at any speed, and gone on from. */

import { bar, byId, say } from "./dom.js";
import { seeking } from "./seeking.js";
import { drawStrip, familiarWords } from "./strip.js";
import { transport } from "./transport.js";
import { outcomeWords } from "./words.js";

/** @typedef {import("./types.js").Status} Status */
/** @typedef {import("./types.js").Strip} Strip */

/** Later than any run: its end. */
const END_S = 86_400;

/** @param {Status | null} status */
const looking = (status) => status?.mode === "review";

/** Whether there is something that holds still and can be looked back at. @param {Status | null} status */
const shown = (status) =>
  status !== null && status.length_s > 0 && ["paused", "ended", "reviewing"].includes(status.phase);

/**
 * Why nothing can go on from the moment that is looked at, or null.
 * @param {Status | null} status
 */
export function noFork(status) {
  if (!looking(status)) return "Look back at a moment first";
  return status?.outcome ? "It had ended here. Go back a little" : null;
}

/**
 * @param {import("./store.js").Store} store
 * @param {{command: (name: string, more?: object) => void, strip: () => Promise<Strip>,
 *   notify: (text: string) => void}} act
 * @returns {(name: string) => boolean} do what a key stands for; whether that is known here
 */
export function timeline(store, act) {
  const box = byId("timeline", HTMLElement);
  const moment = byId("moment", HTMLInputElement);
  /** @type {Strip | null} */
  let strip = null;
  let asked = "";

  const now = () => store.state.status;
  const dt = () => store.state.scene?.dt_s ?? 1 / 15;
  const first = () => strip?.first_s ?? 0;
  const last = () => now()?.length_s ?? 0;
  const seek = seeking((seconds) => act.command(looking(now()) ? "seek" : "review", { seconds }));
  const place = () => seek.wanted ?? now()?.position_s ?? last();

  const { does: moves, to, tell: tellRolling } = transport(box, {
    dt,
    first,
    last,
    place,
    speed: () => now()?.speed ?? 0,
    seek: (seconds) => {
      seek.to(seconds);
      tell();
    },
    jump: (seconds) => act.command("seek", { seconds }),
    roll: (speed) => act.command("roll", { speed }),
    enter: (way) => {
      if (looking(now())) return false;
      act.command("review", { seconds: way < 0 ? last() : first() });
      return true;
    },
  });
  /** @type {Record<string, () => void>} */
  const does = {
    ...moves,
    "look-back": () => act.command("review", { seconds: END_S }),
    fork: () => {
      const missing = noFork(now());
      if (missing) act.notify(`${missing}.`);
      else act.command("fork", { others: store.state.others });
    },
    "keep-from": () => {
      const { take, position_s, length_s } = now() ?? {};
      if (take == null || position_s == null || length_s === undefined) return;
      act.command("keep-last", { take, seconds: length_s - position_s });
    },
    leave: () => act.command("leave"),
  };
  for (const button of box.querySelectorAll(".looking-back button[data-does]")) {
    button.addEventListener("click", () => does[/** @type {HTMLElement} */ (button).dataset.does ?? ""]());
  }
  moment.addEventListener("input", () => to(moment.valueAsNumber * dt()));

  /** What happened at the moment that is shown. @param {number} at */
  const happening = (at) => strip?.happenings.find(({ seconds }) => Math.abs(seconds - at) < dt());

  function tell() {
    const status = now();
    box.hidden = !shown(status);
    if (status === null || box.hidden) return;
    const at = place();
    // In moments: of seconds the last would be lost to rounding.
    moment.min = String(Math.round(first() / dt()));
    moment.max = String(Math.round(status.length_s / dt()));
    moment.value = String(Math.round(at / dt()));
    const what = happening(at);
    const words = what ? (what.kind === "outcome" ? outcomeWords(what.says) : what.says) : "";
    const time = `${at.toFixed(1)} s of ${status.length_s.toFixed(1)} s`;
    const known = looking(status) ? familiarWords(status.familiarity) : "";
    moment.setAttribute("aria-valuetext", [time, words, known].filter(Boolean).join(", "));
    say(byId("moment-time", HTMLElement), time);
    const says = byId("moment-says", HTMLElement);
    say(says, [words, known].filter(Boolean).join(" · "));
    says.hidden = !says.textContent;
    tellRolling();
    const fork = byId("fork", HTMLButtonElement);
    bar(fork, noFork(status));
    byId("keep-from", HTMLElement).hidden = status.take === null;
    byId("looking-back", HTMLElement).hidden = !looking(status);
    if (strip) drawStrip(byId("strip", SVGSVGElement), strip, at, to);
  }

  /** Read the strip of another run, or of one that went on. @param {Status} status */
  async function look(status) {
    const key = `${status.take}|${status.length_s}|${looking(status)}|${status.seed}`;
    if (asked === key) return;
    asked = key;
    strip = { first_s: 0, length_s: status.length_s, familiarity: [], happenings: [] };
    tell();
    const found = await act.strip().catch(() => null);
    if (asked !== key || found === null) return;
    strip = found;
    tell();
  }

  store.watch(({ status }, before) => {
    if (status === before.status && status !== null) return;
    if (status !== null && looking(status)) seek.seen(status.position_s ?? 0);
    if (status !== null && !looking(status) && looking(before.status)) seek.forget();
    tell();
    if (shown(status) && status) look(status);
    else asked = "";
  });
  new ResizeObserver(tell).observe(byId("strip", SVGSVGElement));
  return (name) => {
    const known = does[name];
    known?.();
    return known !== undefined;
  };
}
