/** What an evaluation found, in words and in numbers. */

import { byId, make, say } from "./dom.js";
import { count } from "./words.js";

/** @typedef {import("./types.js").EvaluationFound} EvaluationFound */

const LOOKS = 8;
/** Shares that read better in hundredths. */
const SHARES = ["success_rate", "turn", "unlike"];

/** @param {import("./store.js").Store<import("./types.js").Comparing>} store */
export function findings(store) {
  store.watch((state, before) => {
    const { evaluation, evaluations, lineup, scenes } = state;
    byId("empty", HTMLElement).hidden = evaluation !== null || lineup !== null;
    byId("found", HTMLElement).hidden = evaluation === null;
    if (evaluation === null) {
      const some = evaluations.length ? " Or open an earlier one." : "";
      const says = byId("empty-says", HTMLElement);
      says.dataset.plain ??= says.textContent?.trim() ?? "";
      return say(says, says.dataset.plain + some);
    }
    if (evaluation === before.evaluation) return;
    show(evaluation, scenes.find(({ name }) => name === evaluation.scene));
  });
}

/**
 * @param {EvaluationFound} evaluation
 * @param {import("./types.js").Scene | undefined} scene
 */
function show({ id, created_at, asked, result, says, labels }, scene) {
  const pilots = Object.keys(result.pilots);
  const worlds = count(result.worlds);
  say(byId("found-title", HTMLElement), `${pilots.join(", ")} in the same ${worlds} worlds`);
  const when = new Date(created_at * 1000).toLocaleString("en-GB", { dateStyle: "medium", timeStyle: "short" });
  const chosen = Object.entries(asked.options).map(([name, value]) => {
    const known = scene?.options.find((option) => option.name === name);
    return `${(known?.label ?? name).toLowerCase()} ${value}`;
  });
  const how = [scene?.title ?? "", ...chosen, `series ${result.seed}`].filter(Boolean).join(", ");
  say(byId("found-asked", HTMLElement), `Evaluation ${id}, ${when}. ${how}.`);
  byId("words", HTMLElement).replaceChildren(...says.map((words) => make("li", {}, words)));
  byId("words", HTMLElement).parentElement?.toggleAttribute("hidden", says.length === 0);
  byId("table", HTMLTableElement).replaceChildren(head(pilots), body(result, labels));
}

/** @param {string[]} pilots */
function head(pilots) {
  const names = pilots.map((name, look) => {
    const swatch = make("span", { class: "swatch", "data-look": String(look % LOOKS) });
    return make("th", { scope: "col" }, swatch, name);
  });
  const corner = make("th", { scope: "col" }, make("span", { class: "unseen" }, "Figure"));
  return make("thead", {}, make("tr", {}, corner, ...names));
}

/**
 * @param {EvaluationFound["result"]} result
 * @param {Record<string, string>} labels
 */
function body(result, labels) {
  const rows = Object.entries(labels).map(([figure, label]) => {
    const cells = Object.values(result.pilots).map((one) => {
      const found = of(one, figure);
      if (found === null) return null;
      const scale = SHARES.includes(figure) ? 100 : 1;
      const cell = make("td", {}, number(found.mean * scale));
      if (found.interval) {
        const [low, high] = found.interval.map((end) => number(end * scale));
        cell.append(make("small", {}, `${low} to ${high}`));
      }
      return cell;
    });
    if (cells.every((cell) => cell === null)) return "";
    const filled = cells.map((cell) => cell ?? make("td", {}, "–"));
    return make("tr", {}, make("th", { scope: "row" }, label), ...filled);
  });
  return make("tbody", {}, ...rows.filter((row) => row !== ""));
}

/**
 * @param {Record<string, any>} one
 * @param {string} figure
 * @returns {{mean: number, interval?: number[]} | null}
 */
function of(one, figure) {
  if (figure === "success_rate") return { mean: one[figure], interval: one.interval };
  const found = figure in one.figures ? one.figures[figure] : one[figure];
  return typeof found === "number" ? { mean: found } : found;
}

/** @param {number} value three figures that count */
const number = (value) =>
  Math.abs(value) >= 100 ? count(Math.round(value)) : String(Number(value.toPrecision(3)));
