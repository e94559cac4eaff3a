/** Going through time: the buttons and keys that every timeline has, whatever it is that moves. */

import { draw, make } from "./dom.js";

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

/** The buttons: what each does, what it is called, and its sign. */
const BUTTONS = [
  ["to-begin", "To the beginning", "M3 3h2v10H3zM13 3v10L6 8z"],
  ["roll-back", "Backwards", "M12 3v10L4 8z"],
  ["roll-on", "Forwards", "M4 3v10l8-5z"],
  ["to-end", "To the end", "M11 3h2v10h-2zM3 3v10l7-5z"],
];

/**
 * What is gone through; places in seconds.
 * @typedef {object} Run
 * @property {() => number} dt from one moment to the next
 * @property {() => number} first
 * @property {() => number} last
 * @property {() => number} place where it is, or will be in a moment
 * @property {() => number} speed how fast it goes on, 0 where it stands
 * @property {(seconds: number) => void} seek
 * @property {(seconds: number) => void} jump go there, to go on from there at once
 * @property {(speed: number) => void} roll
 * @property {(way: number) => boolean} [enter] begin to go through it, where one does not yet
 */

/** @param {string} path */
const sign = (path) =>
  draw("svg", { viewBox: "0 0 16 16", "aria-hidden": "true" }, draw("path", { d: path }));

/**
 * Fill the groups `.rolling` and `.speeds` of a timeline.
 * @param {HTMLElement} box
 * @param {Run} run
 * @returns {{does: Record<string, () => void>, to: (seconds: number) => void, tell: () => void}}
 *   what keys do, by name; going somewhere; and showing which button holds
 */
export function transport(box, run) {
  const rolling = box.querySelector(".rolling");
  const speeds = box.querySelector(".speeds");
  let speed = 1;

  /** @param {number} seconds */
  function to(seconds) {
    const within = Math.min(Math.max(seconds, run.first()), run.last());
    if (run.speed()) run.roll(0);
    run.seek(Math.min(Math.round(within / run.dt()) * run.dt(), run.last()));
  }

  /** @param {number} way 1 on, -1 back, 0 stands */
  function roll(way) {
    const near = run.dt() / 2;
    if (!run.enter?.(way)) {
      if (way > 0 && run.place() >= run.last() - near) run.jump(run.first());
      else if (way < 0 && run.place() <= run.first() + near) run.jump(run.last());
    }
    run.roll(way * speed);
  }

  /** @param {number} chosen */
  function choose(chosen) {
    speed = chosen;
    for (const one of speeds?.querySelectorAll("button") ?? []) {
      one.setAttribute("aria-pressed", String(Number(one.value) === speed));
    }
    if (run.speed()) run.roll(Math.sign(run.speed()) * speed);
  }

  const way = () => Math.sign(run.speed());
  /** @type {Record<string, () => void>} */
  const does = {
    roll: () => roll(way() ? 0 : 1),
    "roll-back": () => roll(way() < 0 ? 0 : -1),
    "roll-on": () => roll(way() > 0 ? 0 : 1),
    stand: () => roll(0),
    slower: () => choose(SPEEDS[Math.max(SPEEDS.indexOf(speed) - 1, 0)]),
    faster: () => choose(SPEEDS[Math.min(SPEEDS.indexOf(speed) + 1, SPEEDS.length - 1)]),
  };
  for (const [name, { moments = 0, seconds = 0 }] of Object.entries(STRIDES)) {
    does[name] = () => to(run.place() + moments * run.dt() + seconds);
  }

  const buttons = BUTTONS.map(([name, words, path]) => {
    const attributes = { type: "button", id: name, "data-does": name, title: words, "aria-label": words };
    const button = make("button", attributes, sign(path));
    button.addEventListener("click", () => does[name]());
    return button;
  });
  rolling?.replaceChildren(...buttons);
  speeds?.replaceChildren(
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
  const [, back, on] = buttons;
  const tell = () => {
    back.setAttribute("aria-pressed", String(way() < 0));
    on.setAttribute("aria-pressed", String(way() > 0));
  };
  tell();
  return { does, to, tell };
}
