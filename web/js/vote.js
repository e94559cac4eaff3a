/** Puts the page together on which people choose between two whose names they do not know. */

import { api } from "./api.js";
import { bar, byId, make, say } from "./dom.js";
import { lineupBox } from "./lineup.js";
import { me } from "./me.js";
import { attempt } from "./notices.js";
import { pageKeys, sheet, throughTime } from "./sheet.js";
import { VOTING } from "./shortcuts.js";
import { plural } from "./words.js";

/** @typedef {import("./types.js").Ballot} Ballot */
/** @typedef {"left" | "right" | "neither"} Choice */

/** So much of two is looked at before one can choose, seconds. */
const LOOKED_AT_S = 3;
const CHOICES = /** @type {Choice[]} */ (["left", "right", "neither"]);

/** @type {Ballot[]} */
let open = [];
/** The ballot that is voted on. @type {number | null} */
let ballot = null;
let looked = 0;
let voted = false;
let under = false;

const empty = byId("empty", HTMLElement);
const choosing = byId("choosing", HTMLElement);
const next = byId("next-pair", HTMLButtonElement);
const buttons = CHOICES.map((name) => byId(`vote-${name}`, HTMLButtonElement));
const lineup = lineupBox(byId("lineup-box", HTMLElement), {
  attach: (frame) => keys.attachFrame(frame),
  closed: () => {
    location.hash = "";
  },
  at: (seconds) => {
    if (seconds <= looked) return;
    looked = seconds;
    tell();
  },
});
const keys = pageKeys(
  VOTING,
  (name) => lineup.does[name]?.(),
  () => throughTime(lineup.shown !== null),
);

/** Why one cannot choose now, or null. */
function missing() {
  if (voted) return "You have chosen between these two";
  const enough = Math.min(LOOKED_AT_S, lineup.shown?.length_s ?? 0);
  return looked >= enough ? null : "Let them go for a few seconds first";
}

function tell() {
  const why = missing();
  for (const button of buttons) bar(button, why);
  next.hidden = !voted;
  empty.hidden = lineup.shown !== null;
  choosing.hidden = lineup.shown === null;
  if (!voted) say(byId("choosing-says", HTMLElement), why === null ? "" : `${why}.`);
}

function list() {
  say(
    byId("ballots-say", HTMLElement),
    open.length ? "" : "Nobody asks anything now. Authors ask on the page that compares.",
  );
  byId("ballots", HTMLElement).replaceChildren(
    ...open.map(({ id, title, votes, mine }) => {
      const counted = votes ? `${plural(votes, "vote")}, ${mine} of them yours` : "no votes yet";
      const link = make("a", { href: `#${id}`, title: "Choose between the two" }, `${title}, ballot ${id}`, make("small", {}, counted));
      link.setAttribute("aria-current", String(id === ballot));
      return make("li", {}, link);
    }),
  );
}

async function look() {
  open = await api.ballots();
  list();
}

/** Show the next two of the ballot that the address names. */
async function show() {
  ballot = Number(location.hash.slice(1)) || null;
  list();
  lineup.close();
  voted = false;
  looked = 0;
  tell();
  if (ballot === null || under) return;
  under = true;
  say(byId("empty-says", HTMLElement), "The two are on their way through the world…");
  try {
    lineup.open(await api.showPair(ballot));
  } finally {
    under = false;
    const says = byId("empty-says", HTMLElement);
    say(says, says.dataset.plain ?? "");
    tell();
  }
}

/** @param {Choice} choice */
async function vote(choice) {
  const shown = lineup.shown;
  if (shown === null || ballot === null || missing() !== null) return;
  const found = await api.vote(ballot, shown.id, choice);
  voted = true;
  lineup.name([found.left, found.right]);
  const said = found.livelier === null ? "You saw no difference." : `You chose ${found.livelier}.`;
  say(byId("choosing-says", HTMLElement), `${said} ${found.preference.says}`);
  tell();
  await look();
}

sheet(VOTING);
me();
for (const [i, button] of buttons.entries()) {
  button.addEventListener("click", () => attempt(() => vote(CHOICES[i])));
}
next.addEventListener("click", () => attempt(show));
addEventListener("hashchange", () => attempt(show));
byId("empty-says", HTMLElement).dataset.plain = byId("empty-says", HTMLElement).textContent ?? "";
attempt(async () => {
  await look();
  await show();
});
