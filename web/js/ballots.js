/** Ballots on the page that compares: asking people, and what they have said so far. */

import { api } from "./api.js";
import { bar, byId, make, say } from "./dom.js";
import { attempt, notify } from "./notices.js";
import { plural } from "./words.js";

/** @typedef {import("./types.js").Comparing} Comparing */

/** Why others cannot open a link of this page, or nothing. */
const HERE_ONLY = /^(localhost|127\.[\d.]+|\[::1\])$/.test(location.hostname)
  ? "Only this computer can open such a link: for others, start the studio with --host 0.0.0.0 and put this computer's own address into it."
  : "";

/** @param {import("./store.js").Store<Comparing>} store */
export function ballots(store) {
  const list = byId("ballots", HTMLElement);
  const ask = byId("ask-people", HTMLButtonElement);

  async function look() {
    const { scene } = store.state;
    if (scene === null) return;
    const [open, preferences] = await Promise.all([api.ballots(scene.name), api.preferences()]);
    if (store.state.scene === scene) store.set({ ballots: open, preferences });
  }

  ask.addEventListener("click", () => {
    const { scene, chosen, options } = store.state;
    if (scene === null || chosen.length !== 2) return;
    attempt(async () => {
      const seed = byId("seed", HTMLInputElement).valueAsNumber;
      const made = await api.openBallot({ scene: scene.name, pilots: chosen, options, seed });
      await look();
      const link = `${location.origin}/vote#${made.id}`;
      notify(`People can choose now: send them to ${link}. ${HERE_ONLY}`, "info", true);
    });
  });

  store.watch((state, before) => {
    const { chosen, ballots: open, preferences } = state;
    bar(ask, chosen.length === 2 ? null : "Choose two for people to choose between");
    if (state.scene !== before.scene) attempt(look);
    if (open === before.ballots && preferences === before.preferences && open.length) return;
    say(
      byId("ballots-say", HTMLElement),
      open.length ? HERE_ONLY : "Nobody was asked yet. Two runs are shown without their names, and people say which is livelier.",
    );
    byId("table-3", HTMLElement).hidden = preferences.length === 0;
    list.replaceChildren(
      ...open.map(({ id, votes, mine }) => {
        const found = preferences.find(({ ballot }) => ballot === id);
        const counted = votes ? `${plural(votes, "vote")}, ${mine} of them yours` : "no votes yet";
        const link = make("a", { href: `/vote#${id}`, title: "Choose between the two" }, `Ballot ${id}`, make("small", {}, counted));
        return make("li", {}, link, ...(found ? [make("p", { class: "says" }, found.says)] : []));
      }),
    );
  });
}
