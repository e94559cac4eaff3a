/** A run along its time: how familiar each part of it was, what happened, and where one is. */

import { draw } from "./dom.js";

/** @typedef {import("./types.js").Strip} Strip */

/** Colours of a familiarity, as the trail in the view has them. */
const STRANGE = [255, 60, 110];
const UNSURE = [255, 205, 80];
const FAMILIAR = [70, 225, 190];
/** Below it a moment is hardly like any that was demonstrated. */
const LITTLE = 0.2;
/** Half the width of the handle, which the line begins and ends under. */
const INSET = 8;

/** @param {number} familiarity 0 to 1 */
export function familiarColor(familiarity) {
  const [low, high] = familiarity < LITTLE ? [STRANGE, UNSURE] : [UNSURE, FAMILIAR];
  const share = familiarity < LITTLE ? familiarity / LITTLE : (familiarity - LITTLE) / (1 - LITTLE);
  return `rgb(${low.map((one, i) => Math.round(one + (high[i] - one) * share)).join(" ")})`;
}

/** @param {number | null} familiarity */
export function familiarWords(familiarity) {
  if (familiarity === null) return "";
  if (familiarity < LITTLE) return "unlike your takes";
  return familiarity < 0.6 ? "a little like your takes" : "like your takes";
}

/** Which strip, and how wide, each drawing shows. @type {WeakMap<SVGSVGElement, string>} */
const drawn = new WeakMap();
/** @type {WeakMap<Strip, number>} */
const numbers = new WeakMap();
let counted = 0;

/**
 * @param {SVGSVGElement} svg
 * @param {Strip} strip
 * @param {number} at seconds
 * @param {(seconds: number) => void} seek where a mark is clicked
 */
export function drawStrip(svg, strip, at, seek) {
  const { width, height } = svg.getBoundingClientRect();
  if (width === 0) return;
  const span = Math.max(strip.length_s - strip.first_s, 1e-9);
  const x = (/** @type {number} */ seconds) =>
    INSET + ((width - 2 * INSET) * (seconds - strip.first_s)) / span;
  if (!numbers.has(strip)) numbers.set(strip, ++counted);
  const key = `${numbers.get(strip)} ${width}`;
  if (drawn.get(svg) !== key) {
    drawn.set(svg, key);
    const middle = height / 2;
    const line = draw("rect", { x: INSET, y: middle - 3, width: width - 2 * INSET, height: 6, rx: 3, class: "line" });
    const part = (width - 2 * INSET) / Math.max(strip.familiarity.length, 1);
    const parts = strip.familiarity.flatMap((known, i) =>
      known === null
        ? []
        : [draw("rect", { x: INSET + i * part, y: middle - 3, width: part + 0.5, height: 6, fill: familiarColor(known) })],
    );
    const marks = strip.happenings.map(({ seconds, kind, says }) => {
      const mark = draw("g", { class: `mark ${kind}`, "data-kind": kind });
      const title = draw("title", {});
      title.textContent = `${says}, ${seconds.toFixed(1)} s`;
      mark.append(
        title,
        draw("rect", { x: x(seconds) - 6, y: 0, width: 12, height, class: "reach" }),
        draw("rect", { x: x(seconds) - 1, y: 5, width: 2, height: height - 10 }),
        draw("circle", { cx: x(seconds), cy: 5, r: 3.5 }),
      );
      mark.addEventListener("click", () => seek(seconds));
      return mark;
    });
    const been = draw("rect", { class: "been", height: 6, y: middle - 3, rx: 3 });
    const thumb = draw("circle", { class: "thumb", cy: middle, r: INSET });
    svg.replaceChildren(line, been, ...parts, ...marks, thumb);
  }
  svg.querySelector(".thumb")?.setAttribute("cx", String(x(at)));
  const been = svg.querySelector(".been");
  been?.setAttribute("x", String(INSET));
  been?.setAttribute("width", String(Math.max(x(at) - INSET, 0)));
}
