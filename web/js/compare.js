/** Puts the page that compares together: what is asked, what is under way, and what was found. */

import { Refusal, api } from "./api.js";
import { asking, question } from "./asking.js";
import { ballots } from "./ballots.js";
import { beside } from "./beside.js";
import { byId } from "./dom.js";
import { earlier } from "./earlier.js";
import { findings } from "./findings.js";
import { isOpen, jobs } from "./jobs.js";
import { me } from "./me.js";
import { attempt, notify } from "./notices.js";
import { options } from "./options.js";
import { pictures } from "./pictures.js";
import { choicesIn } from "./place.js";
import { pageKeys, sheet, throughTime } from "./sheet.js";
import { COMPARING } from "./shortcuts.js";
import { LAST_SCENE, Store } from "./store.js";

/** @typedef {import("./types.js").Job} Job */
/** @typedef {import("./types.js").Comparing} Comparing */

/** Where this tab keeps which jobs it began. */
const BEGUN = "evastudio.begun";

/** @type {Store<Comparing>} */
const store = new Store({
  scenes: [],
  scene: null,
  pilots: [],
  chosen: [],
  sessions: [],
  options: {},
  evaluations: [],
  evaluation: null,
  pictures: null,
  lineup: null,
  ballots: [],
  preferences: [],
  session: null,
  jobs: [],
});
/** For the parts that both pages have. */
const shared = /** @type {Store} */ (/** @type {unknown} */ (store));

// -- work under way ------------------------------------------------------------------------------

/** @type {Set<number>} Jobs that this tab began, also before it was loaded anew. */
const begun = new Set(JSON.parse(sessionStorage.getItem(BEGUN) ?? "[]"));
/** @type {Map<number, Job>} Every job of the studio as it was last told. */
const told = new Map();

/** Follow a job that was begun here. @param {Job} job */
function follow(job) {
  begun.add(job.id);
  onJob(told.get(job.id) ?? job); // it may have ended before the answer came
}

/** @param {Job} job */
function onJob(job) {
  store.set({ jobs: [...store.state.jobs.filter(({ id }) => id !== job.id), job].filter(isOpen) });
  if (!isOpen(job)) begun.delete(job.id);
  sessionStorage.setItem(BEGUN, JSON.stringify([...begun]));
  if (job.state === "failed") notify(job.error ?? "It did not work.", "error", true);
  else if (job.state === "done") attempt(() => ended(job));
}

/** Everybody's jobs are told; what others evaluate is listed once it is there. */
function listen() {
  const events = new EventSource("/api/v1/jobs/events");
  for (const kind of ["change", "end"]) {
    events.addEventListener(kind, ({ data }) => {
      const job = JSON.parse(data);
      told.set(job.id, job);
      if (begun.has(job.id)) onJob(job);
      else if (kind === "end" && job.kind === "evaluate") attempt(listEarlier);
    });
  }
}

/** @param {Job} job */
async function ended({ kind, result }) {
  const { evaluation } = result ?? {};
  if (kind === "evaluate") {
    await listEarlier();
    location.hash = `#${evaluation}`;
  } else if (kind === "pictures" && evaluation === store.state.evaluation?.id) {
    store.set({ pictures: await api.pictures(evaluation) });
  } else if (kind === "again") {
    notify(againWords(result ?? {}));
  }
}

/** @param {Record<string, any>} told */
function againWords({ evaluation, same, differs, changed }) {
  if (same) return `Evaluation ${evaluation} came out the same again, in every world.`;
  const why = changed.length ? ` What has changed since: ${changed.join(", ")}.` : "";
  return `Evaluation ${evaluation} came out otherwise: ${differs.join(", ")}.${why}`;
}

// -- what is looked at ---------------------------------------------------------------------------

/** @param {string} name */
async function chooseScene(name) {
  const scene = store.state.scenes.find((one) => one.name === name) ?? null;
  if (scene === null) return;
  localStorage.setItem(LAST_SCENE, name);
  const { options: values } = choicesIn(scene);
  store.set({ scene, pilots: [], chosen: [], sessions: [], options: values, evaluations: [], ballots: [] });
  const [all, known] = await Promise.all([api.pilots(name), api.sessions(name), listEarlier()]);
  if (store.state.scene === scene) store.set({ pilots: all, sessions: known });
}

async function listEarlier() {
  const { scene } = store.state;
  if (scene === null) return;
  const evaluations = await api.evaluations(scene.name);
  if (store.state.scene === scene) store.set({ evaluations });
}

/** Show the evaluation that the address names. */
async function open() {
  const id = Number(location.hash.slice(1));
  if (!id) return store.set({ evaluation: null, pictures: null });
  const evaluation = await api.evaluation(id);
  if (evaluation.scene !== store.state.scene?.name) await chooseScene(evaluation.scene);
  store.set({ evaluation, pictures: null });
  byId("findings", HTMLElement).scrollTop = 0;
  const drawn = await api.pictures(id);
  if (store.state.evaluation !== evaluation) return;
  store.set({ pictures: drawn });
  const underWay = store.state.jobs.some(({ kind }) => kind === "pictures");
  if (drawn.whole || underWay) return;
  try {
    follow(await api.drawPictures(id));
  } catch (error) {
    if (error instanceof Refusal && error.status === 403) return; // viewers see what is drawn
    store.set({ pictures: { ...drawn, left_out: error instanceof Error ? error.message : "" } });
  }
}

const lineup = beside(store, (frame) => keys.attachFrame(frame));
const keys = pageKeys(
  COMPARING,
  (name) => lineup.does[name]?.(),
  () => throughTime(lineup.shown !== null),
);
sheet(COMPARING);
me();
asking(store, {
  chooseScene: (name) => {
    location.hash = "";
    attempt(() => chooseScene(name));
  },
  evaluate: () => attempt(async () => follow(await api.evaluate(question(store.state)))),
});
findings(store);
ballots(store);
pictures(store);
earlier(store);
options(shared);
jobs(shared);
byId("again", HTMLButtonElement).addEventListener("click", () =>
  attempt(async () => {
    const { evaluation } = store.state;
    if (evaluation) follow(await api.again(evaluation.id));
  }),
);
addEventListener("hashchange", () => attempt(open));
attempt(async () => {
  const scenes = await api.scenes();
  store.set({ scenes });
  const last = localStorage.getItem(LAST_SCENE);
  await chooseScene((scenes.find(({ name }) => name === last) ?? scenes[0])?.name ?? "");
  listen();
  await open();
});
