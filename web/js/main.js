/** Puts the page together: the state, what steers, and the parts that show it. */

import { api } from "./api.js";
import { clips } from "./clips.js";
import { coach } from "./coach.js";
import { conflicts } from "./conflicts.js";
import { decisions } from "./decisions.js";
import { byId } from "./dom.js";
import { failures } from "./failures.js";
import { gauge } from "./gauge.js";
import { hud } from "./hud.js";
import { jobs } from "./jobs.js";
import { keptSeconds, keyHelp } from "./keyhelp.js";
import { MARK, notNow, session } from "./needs.js";
import { news } from "./news.js";
import { attempt, notify } from "./notices.js";
import { options } from "./options.js";
import { others } from "./others.js";
import { policies } from "./policies.js";
import { keepPlace } from "./place.js";
import { Pointer } from "./pointer.js";
import { screenshot } from "./screenshot.js";
import { sharing } from "./sharing.js";
import { sheet } from "./sheet.js";
import { STUDIO } from "./shortcuts.js";
import { steering } from "./steering.js";
import { steps } from "./steps.js";
import { Store } from "./store.js";
import { switches } from "./switches.js";
import { takes } from "./takes.js";
import { timeline } from "./timeline.js";
import { tools } from "./tools.js";
import { tour } from "./tour.js";
import { unvisited } from "./unvisited.js";
import { why } from "./why.js";

const store = new Store({
  scenes: [],
  scene: null,
  sessions: [],
  session: null,
  takes: [],
  moreTakes: false,
  policies: [],
  policy: null,
  others: null,
  learner: "svr",
  perception: null,
  options: {},
  jobs: [],
  status: null,
  conflict: null,
  connected: false,
});
const view = byId("view", HTMLIFrameElement);
const pointer = new Pointer(view);
const { link, onJob, reload } = news(store, view, (job) => {
  if (job.kind === "film") films.made(job);
  failed(job);
  unshown(job);
});

/** @param {string} name @param {import("./pointer.js").Place | null} place */
function signal(name, place) {
  const missing = notNow(store.state, name);
  if (missing) return notify(missing);
  link.command("signal", { signal: name, pointer: place });
  if (name === MARK) notify(`Marked at ${store.state.status?.seconds.toFixed(1)} s.`);
}
/** @param {string} name */
function command(name) {
  const missing = name === "another" ? notNow(store.state, name) : null;
  if (missing) notify(missing);
  else if (does[name]) does[name]();
  else if (!lookBack(name) && !review.does(name)) link.command(name);
}
/** @param {number} seconds */
function keepLast(seconds) {
  const { status, scene } = store.state;
  const whole = (status?.pairs ?? 0) * (scene?.dt_s ?? 0);
  if (whole <= seconds) return notify(`The take has ${whole.toFixed(1)} s so far; all of it is kept.`);
  link.command("keep-last", { seconds });
  notify(`Its last ${seconds} s are kept, the rest is in the trash.`);
}
const takePicture = () => attempt(() => screenshot(view, store.state.scene?.name ?? "view"));
const lookBack = timeline(store, {
  command: (name, more) => link.command(name, more),
  strip: () => (link.stage ? api.strip(link.stage.id) : Promise.reject(new Error("No stage."))),
  notify,
});
const review = conflicts(store, {
  compare: (take, step, clicked) => {
    link.command("compare", { take, step });
    if (clicked) focusView();
  },
  look: async (id, neighbors) => onJob(await api.look(id, neighbors, store.state.perception)),
});
/** @param {string} name */
function gamepadCommand(name) {
  const { phase, mode } = store.state.status ?? { phase: "ready", mode: null };
  if (name !== "pad-go") {
    if (mode === "demonstrate") command(name);
  } else if (mode === null) byId("demonstrate", HTMLButtonElement).click();
  else if (mode === "demonstrate" && phase === "ended") command("restart");
  else if (mode !== "review") command(phase === "paused" ? "resume" : "pause");
}

/** What is done on the page itself, by the name of its command. @type {Record<string, () => unknown>} */
const does = {
  ...steering(store, link, view, {
    command,
    gamepad: gamepadCommand,
    signal: (name) => signal(name, pointer.place()),
    steers: (touched) => guide.steers(touched),
  }),
  // Where a take was thrown away there is nothing to begin again: another begins as the first did.
  restart: () =>
    store.state.status?.mode === null
      ? byId("demonstrate", HTMLButtonElement).click()
      : link.command("restart"),
  "restart-same": () => link.command("restart", { same: true }),
  "keep-last": () => keepLast(keptSeconds()),
  tour: () => guide.toggle(),
  screenshot: () => takePicture(),
  why: () => whyNow(),
  unvisited: () => byId("unvisited", HTMLButtonElement).click(),
};

/** Keys go to the character, Space to the pause: no button must be in their way. */
const focusView = () => (view.contentWindow ?? view).focus();

/** @param {(id: number) => Promise<unknown>} work */
const onSession = (work) =>
  attempt(async () => {
    const now = session(store.state);
    if (now) await work(now.id);
  });

sheet(STUDIO, () => store.state.scene);
steps(store, {
  demonstrate: () => {
    const { options, others } = store.state;
    const pushes = byId("pushes", HTMLInputElement).checked;
    link.command("demonstrate", { options, others, pushes });
    focusView();
  },
  clean: () => onSession(async (id) => onJob(await api.clean(id, review.settings()))),
  fit: () =>
    onSession(async (id) => {
      const { scene, learner, perception } = store.state;
      return onJob(await api.fit(id, scene?.symbols.length ? null : learner, perception));
    }),
  play: () => {
    link.command("play", { policy: store.state.policy, options: store.state.options });
    focusView();
  },
  stop: () => link.command("stop"),
  undo: () => link.command("undo"),
  unclean: () =>
    onSession(async (id) => {
      await api.unclean(id);
      await reload();
    }),
});
tools(store, pointer, {
  signal: (name, place) => {
    signal(name, place);
    focusView();
  },
  camera: () => {
    link.command("camera");
    focusView();
  },
  another: () => {
    link.command("another");
    focusView();
  },
  screenshot: takePicture,
});
takes(store, {
  look: (take) => {
    link.command("review", { take });
    link.command("roll", { speed: 1 });
    focusView();
  },
  reload: (some) => reload(null, some),
});
const failed = failures(store, {
  play: (more) => {
    link.command("play", more);
    focusView();
  },
  onJob,
});
const unshown = unvisited(store, {
  visit: (more) => {
    link.command("visit", more);
    focusView();
  },
  onJob,
});
const whyNow = why(store, {
  ask: () => (link.stage ? api.why(link.stage.id) : Promise.resolve(null)),
  command: (name, more) => {
    link.command(name, more);
    focusView();
  },
  notify,
});
gauge(store, whyNow);
pointer.clicked = () => {
  const { status } = store.state;
  if (status?.mode === "play" && status.phase === "playing") whyNow();
};
options(store);
keepPlace(store);
policies(store);
switches(store, onJob);
others(store);
clips(store);
jobs(store);
coach(store);
hud(store, { acts: true });
const guide = tour(store);
const films = sharing(store, { stage: () => link.stage?.id ?? null, job: onJob });
decisions(store);
keyHelp(store, (name) => {
  command(name);
  focusView();
});
link.connect();
