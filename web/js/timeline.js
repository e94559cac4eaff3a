/** The timeline: any moment of a run or a take is looked at, passed at any speed, and gone on from. */

import { bar, byId, make, say } from "./dom.js";
import { seeking } from "./seeking.js";
import { drawStrip, familiarWords } from "./strip.js";
import { outcomeWords } from "./words.js";

/** @typedef {import("./types.js").Status} Status */
/** @typedef {import("./types.js").Strip} Strip */

/** Later than any run: its end. */
const END_S = 86_400;
const SPEEDS = [0.25, 0.5, 1, 2, 4, 8];

/** How far keys move, in moments or in seconds. @type {Record<string, {moments?: number, seconds?: number}>} */
const STRIDES = {
  "step-back": { moments: -1 },
  "step-on": { moments: 1 },
  "second-back": { seconds: -1 },
  "second-on": { seconds: 1 },
  "to-begin": { seconds: -Infinity },
  "to-end": { seconds: Infinity },
};

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
  const speeds = byId("speeds", HTMLElement);
  /** @type {Strip | null} */
  let strip = null;
  let asked = "";
  let speed = 1;

  const now = () => store.state.status;
  const dt = () => store.state.scene?.dt_s ?? 1 / 15;
  const first = () => strip?.first_s ?? 0;
  const last = () => now()?.length_s ?? 0;
  const seek = seeking((seconds) => act.command(looking(now()) ? "seek" : "review", { seconds }));
  const place = () => seek.wanted ?? now()?.position_s ?? last();

  /** @param {number} seconds */
  function to(seconds) {
    const whole = Math.round(Math.min(Math.max(seconds, first()), last()) / dt()) * dt();
    if (now()?.speed) act.command("roll", { speed: 0 });
    seek.to(Math.min(whole, last()));
    tell();
  }

  /** @param {number} way 1 on, -1 back, 0 stands */
  function roll(way) {
    if (!looking(now())) act.command("review", { seconds: way < 0 ? last() : first() });
    else if (way > 0 && place() >= last() - dt() / 2) act.command("seek", { seconds: first() });
    else if (way < 0 && place() <= first() + dt() / 2) act.command("seek", { seconds: last() });
    act.command("roll", { speed: way * speed });
  }

  /** @param {number} chosen */
  function choose(chosen) {
    speed = chosen;
    for (const one of speeds.querySelectorAll("button")) {
      one.setAttribute("aria-pressed", String(Number(one.value) === speed));
    }
    const rolling = now()?.speed ?? 0;
    if (rolling) act.command("roll", { speed: Math.sign(rolling) * speed });
  }

  const rolls = () => Math.sign(now()?.speed ?? 0);
  /** @type {Record<string, () => void>} */
  const does = {
    roll: () => roll(rolls() ? 0 : 1),
    "roll-back": () => roll(rolls() < 0 ? 0 : -1),
    "roll-on": () => roll(rolls() > 0 ? 0 : 1),
    stand: () => roll(0),
    slower: () => choose(SPEEDS[Math.max(SPEEDS.indexOf(speed) - 1, 0)]),
    faster: () => choose(SPEEDS[Math.min(SPEEDS.indexOf(speed) + 1, SPEEDS.length - 1)]),
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
  for (const [name, { moments = 0, seconds = 0 }] of Object.entries(STRIDES)) {
    does[name] = () => to(place() + moments * dt() + seconds);
  }
  for (const button of box.querySelectorAll("button[data-does]")) {
    button.addEventListener("click", () => does[/** @type {HTMLElement} */ (button).dataset.does ?? ""]());
  }
  speeds.append(
    ...SPEEDS.map((one) => {
      const words = { 0.25: "¼", 0.5: "½" }[one] ?? String(one);
      const title = `${one} times as fast (comma is slower, point faster)`;
      const pressed = String(one === speed);
      const attributes = { type: "button", value: String(one), title, "aria-pressed": pressed };
      const button = make("button", attributes, `${words}×`);
      button.addEventListener("click", () => choose(one));
      return button;
    }),
  );
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
    for (const [id, way] of [["roll-back", -1], ["roll-on", 1]]) {
      byId(String(id), HTMLButtonElement).setAttribute("aria-pressed", String(rolls() === way));
    }
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
