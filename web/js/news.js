/** The studio at the other end: the stage that is open there, and what follows from what it tells. */

import { api } from "./api.js";
import { byId } from "./dom.js";
import { isOpen } from "./jobs.js";
import { Link } from "./link.js";
import { attempt, goOn, notify, withdraw } from "./notices.js";
import { choicesIn, goBack, placeIn } from "./place.js";
import { defaultPolicy } from "./policies.js";
import { viewed, watchScheme } from "./scheme.js";
import { sessions } from "./sessions.js";
import { LAST_SCENE } from "./store.js";
import { SOME } from "./takes.js";
import { muchWords, plural } from "./words.js";

/** @typedef {import("./types.js").Job} Job */
/** @typedef {import("./types.js").Status} Status */

/** Whether a take or a playback is under way. @param {Status} status */
const underWay = ({ phase }) => phase === "countdown" || phase === "recording" || phase === "playing";

/** @param {Record<string, any>} found by cleaning */
const cleanedWords = ({ removed, pairs, threshold }) =>
  `${plural(removed, "pair")} taken out.${muchWords(removed, pairs, threshold)}`;

/**
 * @param {import("./store.js").Store} store
 * @param {HTMLIFrameElement} view
 * @param {(job: Job) => void} done what other parts make of work that is done
 */
export function news(store, view, done) {
  const banner = byId("connection", HTMLElement);
  const link = new Link(openStage);
  /** Where one was in the scene, until the new stage is there too. @type {ReturnType<typeof placeIn>} */
  let place = null;
  let viewIsNew = false;
  /** The session that was chosen while nobody could be told. @type {number | null} */
  let unsent = null;

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

  link.addEventListener("stage", (event) => {
    view.src = viewed(/** @type {CustomEvent} */ (event).detail.view);
    viewIsNew = true;
  });
  watchScheme(() => {
    if (link.stage) view.src = viewed(link.stage.view);
  });
  link.addEventListener("open", () => {
    if (unsent !== null) link.command("session", { session: unsent });
    unsent = null;
    // The view connects anew by itself only while it has the focus.
    if (!banner.hidden && !viewIsNew && link.stage) view.src = viewed(link.stage.view);
    viewIsNew = false;
    banner.hidden = true;
    store.set({ connected: true });
    attempt(async () => {
      store.set({ jobs: (await api.jobs()).filter(isOpen) });
      await reload();
    });
  });
  link.addEventListener("lost", (event) => {
    const why = /** @type {CustomEvent<string>} */ (event).detail;
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

  /** @param {Job} job */
  function onJob(job) {
    const others = store.state.jobs.filter(({ id }) => id !== job.id);
    store.set({ jobs: isOpen(job) ? [...others, job] : others });
    if (job.state === "failed") notify(job.error ?? "It did not work.", "error", true);
    if (job.state !== "done") return;
    done(job);
    if (job.kind === "film") return; // nothing of the scene has changed
    attempt(async () => {
      const mine = job.kind === "fit" && job.session === store.state.session;
      if (mine || (job.kind === "switch" && job.result?.scene === store.state.scene?.name)) {
        await reload(String(job.result?.policy));
        notify(`“${job.result?.policy}” is ready to play.`);
      } else {
        await reload();
        if (job.kind === "clean") notify(cleanedWords(job.result ?? {}));
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

  return { link, onJob, reload };
}
