/** Puts the page together: the state, the link to the server, and the parts that show it. */

import { api } from "./api.js";
import { clips } from "./clips.js";
import { coach } from "./coach.js";
import { conflicts } from "./conflicts.js";
import { decisions } from "./decisions.js";
import { byId } from "./dom.js";
import { failures } from "./failures.js";
import { feel } from "./feel.js";
import { GamepadHand } from "./gamepad.js";
import { gauge } from "./gauge.js";
import { GOOD_MS, Hands, moves, steers } from "./hands.js";
import { hud } from "./hud.js";
import { isOpen, jobs } from "./jobs.js";
import { keptSeconds, keyHelp, showHeld } from "./keyhelp.js";
import { Keys } from "./keys.js";
import { Link } from "./link.js";
import { meaningOf } from "./meaning.js";
import { MARK, notNow, session } from "./needs.js";
import { attempt, goOn, notify, withdraw } from "./notices.js";
import { options } from "./options.js";
import { others } from "./others.js";
import { pace } from "./pace.js";
import { pad } from "./pad.js";
import { defaultPolicy, policies } from "./policies.js";
import { choicesIn, goBack, keepPlace, placeIn } from "./place.js";
import { Pointer } from "./pointer.js";
import { viewed, watchScheme } from "./scheme.js";
import { screenshot } from "./screenshot.js";
import { series } from "./series.js";
import { sessions } from "./sessions.js";
import { sharing } from "./sharing.js";
import { sheet } from "./sheet.js";
import { STUDIO } from "./shortcuts.js";
import { steps } from "./steps.js";
import { LAST_SCENE, Store } from "./store.js";
import { switches } from "./switches.js";
import { SOME, takes } from "./takes.js";
import { timeline } from "./timeline.js";
import { tools } from "./tools.js";
import { tour } from "./tour.js";
import { unvisited } from "./unvisited.js";
import { ViewStick } from "./viewstick.js";
import { why } from "./why.js";
import { plural } from "./words.js";

/** @typedef {import("./types.js").Job} Job */
/** @typedef {import("./types.js").Status} Status */

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
const banner = byId("connection", HTMLElement);

// -- the server ----------------------------------------------------------------------------------

/** Everything that the page reads before it can open a stage. */
async function openStage() {
  const scenes = await api.scenes();
  const last = store.state.scene?.name ?? localStorage.getItem(LAST_SCENE);
  const scene = scenes.find(({ name }) => name === last) ?? scenes[0] ?? null;
  if (scene === null) throw new Error("This workspace has no scene.");
  const first = store.state.scene === null;
  const known = await api.sessions(scene.name);
  place = placeIn(scene.name);
  const wanted = store.state.session ?? place?.session;
  const chosen = (known.find(({ id }) => id === wanted) ?? known[0])?.id ?? null;
  store.set({ scenes, scene, sessions: known, session: chosen, ...(first && choicesIn(scene)) });
  return api.openStage(scene.name, store.state.options, chosen);
}

/** Where one was in the scene, until the new stage is there too. @type {ReturnType<typeof placeIn>} */
let place = null;

const link = new Link(openStage);
let viewIsNew = false;
link.addEventListener("stage", (event) => {
  view.src = viewed(/** @type {CustomEvent} */ (event).detail.view);
  viewIsNew = true;
});
watchScheme(() => {
  if (link.stage) view.src = viewed(link.stage.view);
});
/** The session that was chosen while nobody could be told. @type {number | null} */
let unsent = null;
link.addEventListener("open", () => {
  if (unsent !== null) link.command("session", { session: unsent });
  unsent = null;
  // The view connects anew by itself only while it has the focus.
  if (!banner.hidden && !viewIsNew && link.stage) view.src = viewed(link.stage.view);
  viewIsNew = false;
  banner.hidden = true;
  store.set({ connected: true });
  settle();
  attempt(async () => {
    store.set({ jobs: (await api.jobs()).filter(isOpen) });
    await reload();
  });
});
link.addEventListener("lost", (event) => {
  const why = /** @type {CustomEvent<string>} */ (event).detail;
  keys.releaseAll();
  banner.textContent = why || "The connection to the studio was lost. Trying again…";
  banner.hidden = false;
  store.set({ connected: false });
});
link.addEventListener("message", (event) => {
  const { type, ...content } = /** @type {CustomEvent} */ (event).detail;
  if (type === "status") onStatus(content);
  else if (type === "job") onJob(content);
  else if (type === "notice") notify(content.text, content.level);
});

/** @param {Status} status */
function onStatus(status) {
  const before = store.state.status;
  const chosen = status.session?.id ?? store.state.session;
  const moved = chosen !== store.state.session;
  if (place) goBack(place, status, (name, more) => link.command(name, more));
  place = null;
  store.set({ status, session: chosen });
  if (moved || (before && underWay(status) && !underWay(before))) goOn();
  if (before?.problem && status.problem !== before.problem) withdraw(before.problem);
  if (status.problem && status.problem !== before?.problem) notify(status.problem, "error", true);
  if (before && status.can_undo && !before.can_undo) notify("The take is in the trash. U brings it back.");
  const counted =
    status.takes_kept !== before?.takes_kept ||
    status.pairs_kept !== before?.pairs_kept ||
    status.forgotten !== before?.forgotten ||
    status.can_undo !== before?.can_undo;
  if (moved || (before && counted)) attempt(reload);
}

/** Whether a take or a playback is under way. @param {Status} status */
const underWay = ({ phase }) => phase === "countdown" || phase === "recording" || phase === "playing";

/** @param {Job} job */
function onJob(job) {
  const others = store.state.jobs.filter(({ id }) => id !== job.id);
  store.set({ jobs: isOpen(job) ? [...others, job] : others });
  if (job.state === "failed") notify(job.error ?? "It did not work.", "error", true);
  if (job.state !== "done") return;
  if (job.kind === "film") return films.made(job);
  failed(job);
  unshown(job);
  attempt(async () => {
    const mine = job.kind === "fit" && job.session === store.state.session;
    if (mine || (job.kind === "switch" && job.result?.scene === store.state.scene?.name)) {
      await reload(String(job.result?.policy));
      notify(`“${job.result?.policy}” is ready to play.`);
    } else {
      await reload();
      if (job.kind === "clean") notify(`${plural(job.result?.removed ?? 0, "pair")} taken out.`);
    }
  });
}

/**
 * Read sessions, takes and policies again.
 * @param {string | null} [policy] the one to play from now on; the chosen one where there is none
 * @param {number} [some] how many takes at most
 */
async function reload(policy = null, some = Math.max(store.state.takes.length, SOME)) {
  const { scene, session: id } = store.state;
  if (scene === null) return;
  const [known, all, found] = await Promise.all([
    api.sessions(scene.name),
    api.policies(scene.name),
    id === null ? { items: [], more: false } : api.takes(id, Math.min(some, 1000)),
  ]);
  if (store.state.session !== id || store.state.scene !== scene) return;
  store.set({ sessions: known, policies: all, takes: found.items, moreTakes: found.more,
    policy: defaultPolicy(all, policy ?? store.state.policy) });
}

// -- the person ----------------------------------------------------------------------------------

let sequence = 0;
/** @param {string} name @param {import("./pointer.js").Place | null} place */
function signal(name, place) {
  const missing = notNow(store.state, name);
  if (missing) return notify(missing);
  link.command("signal", { signal: name, pointer: place });
  if (name === MARK) notify(`Marked at ${store.state.status?.seconds.toFixed(1)} s.`);
}
/** What is done on the page itself, by the name of its command. @type {Record<string, () => unknown>} */
const here = {
  automatic: () => notify(takesFollow.toggle() ? "Takes follow one another." : "One take at a time."),
  drag: () => notify(feeling.toggle() ? "Drags in the view steer." : "Drags in the view turn the camera."),
  "slower-time": () => time.step(-1),
  "faster-time": () => time.step(1),
  // Where a take was thrown away there is nothing to begin again: another begins as the first did.
  restart: () =>
    store.state.status?.mode === null
      ? byId("demonstrate", HTMLButtonElement).click()
      : link.command("restart"),
  "restart-same": () => link.command("restart", { same: true }),
  "keep-last": () => keepLast(keptSeconds()),
  "hand-back": () => handBack(),
  tour: () => guide.toggle(),
  screenshot: () => takePicture(),
  why: () => whyNow(),
  unvisited: () => byId("unvisited", HTMLButtonElement).click(),
};
/** @param {string} name */
function command(name) {
  const missing = name === "another" ? notNow(store.state, name) : null;
  if (missing) notify(missing);
  else if (here[name]) here[name]();
  else if (!lookBack(name) && !review.does(name)) link.command(name);
}
/** What is still held is not meant for what plays on. */
function handBack() {
  keys.releaseAll();
  link.command("hand-back");
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
const pointer = new Pointer(view);
const hands = new Hands(
  () => store.state.scene,
  (held, pushed, timeMs) => {
    showHeld(held);
    const { status } = store.state;
    const touched = held.length > 0 || Object.keys(pushed).length > 0;
    guide.steers(touched);
    // Who steers what plays takes over; where there is nowhere to record it yet, that is made first.
    if (touched && status?.mode === "play" && !status.session) link.command("take-over");
    const forMs = touched ? GOOD_MS : null;
    link.send({ type: "keys", held, pushed, time_ms: timeMs, seq: ++sequence, for_ms: forMs });
  },
);
const keys = new Keys(
  (event, onControl) => meaningOf(STUDIO, store.state, event, onControl),
  (held, timeMs) => hands.hold(held, timeMs),
  command,
  (name) => signal(name, pointer.place()),
  () => hands.letGo(),
);
keys.attachFrame(view);
const steering = () => moves(store.state.status);
store.watch(({ status }, before) => {
  if (!steering()) keys.releaseAll();
  else if (status?.phase !== before.status?.phase) hands.again();
});
const taking = () => steers(store.state.status);
const viewStick = new ViewStick(view, hands, taking);
const feeling = feel({
  changed: ({ sensitivity, ramp, drag }) => {
    viewStick.on = drag;
    link.command("feel", { sensitivity, ramp });
  },
});
viewStick.on = feeling.now.drag;
pad(store, hands, feeling.now, taking);
const time = pace(store, (speed) => link.command("pace", { speed }));
const takesFollow = series(store, (wanted, automatic, seconds) =>
  link.command("series", { wanted, automatic, seconds }),
);
coach(store);
new GamepadHand(hands, steering, gamepadCommand, (name) => feeling.gamepad(name));

/** What this browser keeps of how one works, told to a stage that may be new. */
function settle() {
  const { sensitivity, ramp } = feeling.now;
  link.command("feel", { sensitivity, ramp });
  link.command("pace", { speed: time.chosen() });
  takesFollow.tell();
}

/** @param {string} name */
function gamepadCommand(name) {
  const { phase, mode } = store.state.status ?? { phase: "ready", mode: null };
  if (name !== "pad-go") {
    if (mode === "demonstrate") command(name);
  } else if (mode === null) byId("demonstrate", HTMLButtonElement).click();
  else if (mode === "demonstrate" && phase === "ended") command("restart");
  else if (mode !== "review") command(phase === "paused" ? "resume" : "pause");
}

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
sessions(store, {
  chooseScene: (name) => {
    const scene = store.state.scenes.find((one) => one.name === name) ?? null;
    localStorage.setItem(LAST_SCENE, name);
    if (scene === null) return;
    unsent = null;
    goOn();
    store.set({ scene, session: null, takes: [], status: null, ...choicesIn(scene) });
    link.connect(true);
  },
  chooseSession: (id) => {
    goOn();
    store.set({ session: id, takes: [] });
    unsent = link.command("session", { session: id }) ? null : id;
    attempt(reload);
  },
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
hud(store, { acts: true });
const guide = tour(store);
const films = sharing(store, { stage: () => link.stage?.id ?? null, job: onJob });
decisions(store);
keyHelp(store, (name) => {
  command(name);
  focusView();
});
link.connect();
