/** Runs of one world side by side: a 3D view for each, and one timeline below them all. */

import { api } from "./api.js";
import { bar, draw, make, say } from "./dom.js";
import { attempt } from "./notices.js";
import { viewed, watchScheme } from "./scheme.js";
import { seeking } from "./seeking.js";
import { drawStrip } from "./strip.js";
import { transport } from "./transport.js";
import { outcomeWords } from "./words.js";

/** @typedef {import("./types.js").Lineup} Lineup */
/** @typedef {import("./types.js").Column} Column */
/** @typedef {import("./types.js").Standing} Standing */

/** How often the studio is asked where it is while it rolls. */
const ASK_MS = 500;
/** Moments this near to one count as that one, seconds. */
const NEAR_S = 0.05;

/** What became of a column, and when. @param {Column} column */
function fate({ outcome, length_s }) {
  const when = `${length_s.toFixed(1)} s`;
  return outcome === null ? `still going after ${when}` : `${outcomeWords(outcome)}, ${when}`;
}

/** What is marked on the timeline. @param {Lineup} lineup */
function strip({ length_s, parts_s, columns }) {
  const happenings = columns.flatMap(({ title, happenings: own }) =>
    own
      .filter(({ kind }) => kind !== "near")
      .map(({ seconds, kind, says }) => ({
        seconds,
        kind,
        says: kind === "sign" ? says : `${title}: ${outcomeWords(says)}`,
      })),
  );
  if (parts_s !== null) happenings.push({ seconds: parts_s, kind: "parts", says: "Here they part" });
  return { first_s: 0, length_s, familiarity: [], happenings };
}

/** @param {string} id @param {string} words @param {string} [title] */
const button = (id, words, title = words) => make("button", { type: "button", id, title }, words);

/**
 * Build it into `box`, which is hidden while there is none.
 * @param {HTMLElement} box
 * @param {{attach: (frame: HTMLIFrameElement) => void, nextWorld?: () => void,
 *   closed: () => void, at?: (seconds: number) => void}} act
 *   `attach` lets keys reach through a view, `at` is told where it is
 */
export function lineupBox(box, { attach, nextWorld, closed, at: tellAt }) {
  const columns = make("div", { class: "columns" });
  const moment = make("input", { id: "moment", type: "range", min: "0", step: "1", value: "0" });
  moment.setAttribute("aria-label", "Moment");
  moment.title = "Any moment of them all";
  const line = draw("svg", {
    class: "moment-strip",
    role: "img",
    "aria-label": "Where they part, and what becomes of them",
  });
  const time = make("p", { class: "moment-time" });
  const says = make("p", { class: "moment-says grow" });
  const parting = button("parting", "Where they part", "To the first moment at which they part");
  const camera = button("lineup-camera", "Camera", "See all of them through the next camera");
  const straighten = button("straighten", "Straighten", "Turn the cameras back");
  const next = button("next-world", "Next world", "The same ones in the next world");
  const close = button("close-lineup", "Close", "Close what is side by side");
  const head = make("div", { class: "moment-head" }, make("div", { class: "moment-line" }, moment, line), time);
  const row = make(
    "div",
    { class: "moment-row" },
    make("div", { class: "rolling", role: "group", "aria-label": "Go through it" }),
    make("div", { class: "speeds", id: "speeds", role: "group", "aria-label": "Speed" }),
    says,
    make("div", { class: "looking-back" }, parting),
  );
  const bars = make("div", { class: "lineup-bar" }, camera, straighten, next, close);
  const timeline = make("section", { class: "timeline", "aria-label": "Timeline" }, head, row);
  box.replaceChildren(bars, columns, timeline);

  /** @type {Lineup | null} */
  let lineup = null;
  /** @type {{standing: Standing, at: number} | null} where it was, and when that was told */
  let told = null;
  /** @type {import("./types.js").Strip | null} */
  let marks = null;
  let asking = Promise.resolve();
  let asked = 0;
  let frame = 0;

  /** Where it is by now. */
  function position() {
    if (told === null || lineup === null) return 0;
    const { standing, at } = told;
    const gone = (standing.speed * (performance.now() - at)) / 1000;
    return Math.min(Math.max(standing.position_s + gone, 0), lineup.length_s);
  }

  /** @param {Standing} standing */
  function learn(standing) {
    told = { standing, at: performance.now() };
    seek.seen(standing.position_s);
    tell();
    if (standing.speed && !frame) frame = requestAnimationFrame(roll);
  }

  /**
   * Ask the studio about what is shown, after all that was asked before.
   * @param {(id: string) => Promise<Standing>} ask
   */
  function ask(ask) {
    const about = lineup?.id;
    asking = asking.then(() =>
      attempt(async () => {
        if (about === undefined || lineup?.id !== about) return;
        const standing = await ask(about);
        if (lineup?.id === about) learn(standing);
      }),
    );
  }

  /** Do something with all columns. @param {object} command */
  const command = (command) => ask((id) => api.lineupCommand(id, command));

  /** Follow it while it rolls. */
  function roll() {
    frame = 0;
    if (lineup === null || !told?.standing.speed) return;
    const now = performance.now();
    if (now - Math.max(told.at, asked) > ASK_MS) {
      asked = now;
      ask(api.lineupStanding);
    }
    tell();
    frame = requestAnimationFrame(roll);
  }

  const seek = seeking((seconds) => command({ name: "seek", seconds }));
  const place = () => seek.wanted ?? position();
  const through = transport(timeline, {
    dt: () => lineup?.dt_s ?? 1,
    first: () => 0,
    last: () => lineup?.length_s ?? 0,
    place,
    speed: () => told?.standing.speed ?? 0,
    seek: (seconds) => {
      seek.to(seconds);
      tell();
    },
    jump: (seconds) => command({ name: "seek", seconds }),
    roll: (speed) => command({ name: "roll", speed }),
  });

  function tell() {
    if (lineup === null || told === null || marks === null) return;
    const at = place();
    const { length_s, dt_s } = lineup;
    moment.max = String(Math.round(length_s / dt_s));
    moment.value = String(Math.round(at / dt_s));
    const words = `${at.toFixed(1)} s of ${length_s.toFixed(1)} s`;
    const what = marks.happenings.filter(({ seconds }) => Math.abs(seconds - at) < NEAR_S);
    say(time, words);
    say(says, what.map((one) => one.says).join(" · "));
    moment.setAttribute("aria-valuetext", [words, says.textContent].filter(Boolean).join(", "));
    bar(straighten, told.standing.turned ? null : "The cameras are where the scene has them");
    for (const one of columns.children) {
      const over = Number(one.getAttribute("data-length")) < at - dt_s / 2;
      one.classList.toggle("over", over);
    }
    through.tell();
    drawStrip(line, marks, at, through.to);
    tellAt?.(at);
  }

  /** @param {Column} column @param {number} way */
  function figure(column, way) {
    const title = `3D view of ${column.title}`;
    const view = make("iframe", { title, tabindex: "0", "data-view": column.view });
    view.src = viewed(column.view);
    attach(view);
    // No ways are drawn into those of a ballot.
    const drawn = lineup?.ballot === null ? [make("span", { class: "way", "data-way": String(way) })] : [];
    const name = make("strong", {}, ...drawn, column.title);
    const caption = make("figcaption", {}, name, make("small", {}, fate(column)));
    return make("figure", { class: "column", "data-length": String(column.length_s) }, caption, view);
  }

  function hide() {
    seek.forget();
    lineup = told = marks = null;
    columns.replaceChildren();
    box.hidden = true;
  }

  moment.addEventListener("input", () => through.to(moment.valueAsNumber * (lineup?.dt_s ?? 1)));
  parting.addEventListener("click", () => lineup?.parts_s != null && through.to(lineup.parts_s));
  straighten.addEventListener("click", () => command({ name: "camera" }));
  next.addEventListener("click", () => nextWorld?.());
  close.addEventListener("click", () => {
    made.close();
    closed();
  });
  camera.addEventListener("click", () => {
    const known = lineup?.cameras ?? [];
    const now = known.indexOf(told?.standing.camera ?? "");
    command({ name: "camera", camera: known[(now + 1) % known.length] });
  });
  watchScheme(() => {
    for (const view of columns.querySelectorAll("iframe")) view.src = viewed(view.dataset.view ?? "");
  });
  new ResizeObserver(tell).observe(line);
  addEventListener("pagehide", () => lineup && api.forgetLineup(lineup.id));
  // Turning the cameras by hand is seen at once, and known here a little later.
  setInterval(() => {
    if (lineup && !told?.standing.speed && seek.wanted === null && !document.hidden) {
      ask(api.lineupStanding);
    }
  }, 2000);

  const made = {
    /** What is shown, or null. @returns {Lineup | null} */
    get shown() {
      return lineup;
    },
    /** What keys do, by name. */
    does: through.does,

    /**
     * Show `fresh` in place of what was shown.
     * @param {Lineup} fresh
     * @param {boolean} [series] whether there is a next world
     */
    open(fresh, series = false) {
      made.close();
      lineup = fresh;
      marks = strip(fresh);
      box.hidden = false;
      columns.dataset.many = String(fresh.columns.length);
      columns.replaceChildren(...fresh.columns.map(figure));
      bar(parting, fresh.parts_s === null ? "They never part" : null);
      camera.hidden = fresh.cameras.length < 2;
      next.hidden = !series;
      learn(fresh.standing);
    },

    /** Say who is who. @param {string[]} names */
    name(names) {
      for (const [i, one] of [...columns.children].entries()) {
        one.querySelector("strong")?.append(make("em", {}, names[i]));
      }
    },

    close() {
      if (lineup === null) return;
      const { id } = lineup;
      hide();
      asking = asking.then(() => api.closeLineup(id).catch(() => {})); // it closes by itself, too
    },
  };
  hide();
  return made;
}
