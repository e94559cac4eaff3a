/** What is looked at side by side: who was chosen, or who an evaluation is about, world by world. */

import { api } from "./api.js";
import { bar, byId, fill, make, say } from "./dom.js";
import { lineupBox } from "./lineup.js";
import { attempt } from "./notices.js";
import { plural } from "./words.js";

/** @typedef {import("./types.js").Comparing} Comparing */
/** @typedef {import("./types.js").Lineup} Lineup */
/** @typedef {{scene: string, options: Record<string, number>, seed: number, world: number,
 *   entrants: {pilot?: string, take?: number}[]}} Asked */

const MOST = 4;
/** Worlds of an evaluation that are offered. */
const FIRST = 12;
/** Takes of a session that are offered, the newest. */
const NEWEST = 100;

/**
 * Why nothing can be shown side by side now, or null.
 * @param {string[]} pilots
 * @param {number | null} take
 */
function missing(pilots, take) {
  const many = pilots.length + (take === null ? 0 : 1);
  if (many < 2) return `Choose ${many === 0 ? "two" : "one more"} to see side by side`;
  return many > MOST ? `Choose ${MOST} at most to see side by side` : null;
}

/**
 * @param {import("./store.js").Store<Comparing>} store
 * @param {(frame: HTMLIFrameElement) => void} attach lets keys reach through a view
 */
export function beside(store, attach) {
  const box = byId("lineup", HTMLElement);
  const title = byId("lineup-title", HTMLElement);
  const where = byId("lineup-where", HTMLElement);
  const choose = byId("beside", HTMLButtonElement);
  const ofFound = byId("watch-found", HTMLButtonElement);
  const session = byId("beside-session", HTMLSelectElement);
  const takes = byId("beside-take", HTMLSelectElement);
  /** @type {Asked | null} */
  let asked = null;
  let opening = false;

  const lineup = lineupBox(byId("lineup-box", HTMLElement), {
    attach,
    nextWorld: () => asked && show({ ...asked, world: asked.world + 1 }),
    closed: () => shown(null),
  });
  const take = () => (takes.value ? Number(takes.value) : null);

  /** @param {Lineup | null} found */
  function shown(found) {
    box.hidden = found === null;
    store.set({ lineup: found });
    if (found === null || asked === null) return;
    const names = found.columns.map((column) => column.title);
    say(title, names.join(", "));
    const own = asked.entrants.some((one) => one.take !== undefined);
    const world = own ? "in the world of the take" : `in world ${asked.world + 1} of series ${asked.seed}`;
    const parts = found.parts_s === null ? "They never part." : `They part after ${found.parts_s.toFixed(1)} s.`;
    say(where, `Side by side ${world}. ${parts}`);
  }

  function leave() {
    lineup.close();
    shown(null);
  }

  /** @param {Asked} wanted */
  function show(wanted) {
    if (opening) return;
    attempt(async () => {
      opening = true;
      tell();
      try {
        const found = await api.openLineup(wanted);
        asked = wanted;
        shown(found);
        lineup.open(
          found,
          wanted.entrants.every(({ pilot }) => pilot !== undefined),
        );
        byId("findings", HTMLElement).scrollTop = 0;
      } finally {
        opening = false;
        tell();
      }
    });
  }

  /** The newest evaluation that tells of all who are shown, to stand beneath. @param {string[]} pilots */
  function figuresOf(pilots) {
    const { evaluations, options, evaluation, scene } = store.state;
    const holds = (/** @type {import("./types.js").EvaluationFound} */ one) =>
      pilots.every((name) => name in one.result.pilots) &&
      (scene?.options ?? []).every(
        ({ name, default: usual }) => one.asked.options[name] === (options[name] ?? usual),
      );
    if (evaluation && holds(evaluation)) return evaluation;
    return evaluations.find(holds);
  }

  choose.addEventListener("click", () => {
    const { scene, chosen, options } = store.state;
    if (scene === null || missing(chosen, take()) !== null) return;
    const seed = byId("seed", HTMLInputElement).valueAsNumber;
    const entrants = chosen.map((pilot) => ({ pilot }));
    const own = take();
    const found = figuresOf(chosen);
    location.hash = found === undefined ? "" : `#${found.id}`;
    show({
      scene: scene.name,
      options,
      seed,
      world: 0,
      entrants: own === null ? entrants : [{ take: own }, ...entrants],
    });
  });
  /** Those of an evaluation, in one of its worlds. @param {number} world from 0 */
  function ofEvaluation(world) {
    const { evaluation } = store.state;
    if (evaluation === null) return;
    const { result, scene, asked: of } = evaluation;
    const pilots = Object.keys(result.pilots).slice(0, MOST);
    const entrants = pilots.map((pilot) => ({ pilot }));
    show({ scene, options: of.options, seed: result.seed, world, entrants });
  }

  /** The worlds that ended well for some only. @param {import("./types.js").EvaluationFound} evaluation */
  async function disputed({ id, result }) {
    const { worlds, count } = await api.disputed(id);
    if (store.state.evaluation?.id !== id) return;
    const many = Object.keys(result.pilots).length;
    byId("disputed-box", HTMLElement).hidden = count === 0 || many > MOST;
    const more = count > FIRST ? `, of which the first ${FIRST}` : "";
    const says = `${plural(count, "world")} ended well for some and not for others${more}. See one side by side:`;
    say(byId("disputed-says", HTMLElement), says);
    byId("disputed", HTMLElement).replaceChildren(
      ...worlds.slice(0, FIRST).map((world) => {
        const title = `World ${world + 1} side by side`;
        const button = make("button", { type: "button", title }, String(world + 1));
        button.addEventListener("click", () => ofEvaluation(world));
        return make("li", {}, button);
      }),
    );
  }

  ofFound.addEventListener("click", () => ofEvaluation(0));
  session.addEventListener("change", () =>
    attempt(async () => {
      takes.replaceChildren();
      delete takes.dataset.key;
      if (session.value) {
        const { items } = await api.takes(Number(session.value), NEWEST);
        offer(items.filter(({ pairs, trashed }) => pairs && !trashed));
      }
      tell();
    }),
  );
  takes.addEventListener("change", tell);

  /** @param {import("./types.js").Take[]} items */
  function offer(items) {
    const options = items.map(({ id, number, seconds, note }) => ({
      value: String(id),
      text: [`Take ${number}`, `${seconds.toFixed(1)} s`, note].filter(Boolean).join(", "),
    }));
    fill(takes, options, options[0]?.value ?? "");
  }

  function tell() {
    const { chosen, evaluation } = store.state;
    const why = opening ? "They are on their way through the world" : missing(chosen, take());
    bar(choose, why);
    takes.hidden = !takes.options.length;
    const many = evaluation ? Object.keys(evaluation.result.pilots).length : 0;
    ofFound.hidden = many < 2;
    bar(ofFound, opening ? "They are on their way through the world" : null);
    const ready = `${plural(chosen.length + (take() === null ? 0 : 1), "run")} of one world, one timeline.`;
    say(byId("beside-says", HTMLElement), why === null ? ready : `${why}.`);
  }

  store.watch((state, before) => {
    if (state.scene !== before.scene && state.lineup !== null) leave();
    if (state.sessions !== before.sessions) {
      const items = state.sessions
        .filter(({ pairs }) => pairs)
        .map(({ id, name }) => ({ value: String(id), text: name }));
      fill(session, [{ value: "", text: "None" }, ...items], "");
      takes.replaceChildren();
      delete takes.dataset.key;
      byId("takes-beside", HTMLElement).hidden = items.length === 0;
    }
    const { evaluation } = state;
    byId("lineup-beneath", HTMLElement).hidden = evaluation !== null;
    if (evaluation !== before.evaluation) {
      byId("disputed-box", HTMLElement).hidden = true;
      if (evaluation) attempt(() => disputed(evaluation));
    }
    if (evaluation !== before.evaluation && evaluation !== null && asked !== null) {
      const others = asked.entrants.some(({ pilot }) => pilot && !(pilot in evaluation.result.pilots));
      if (others && state.lineup !== null) leave();
    }
    tell();
  });
  return lineup;
}
