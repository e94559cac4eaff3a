/** The REST side of the server. Every failure is an Error whose message a person can read. */

/** @typedef {import("./types.js").Scene} Scene */
/** @typedef {import("./types.js").Session} Session */
/** @typedef {import("./types.js").Take} Take */
/** @typedef {import("./types.js").Policy} Policy */
/** @typedef {import("./types.js").Job} Job */
/** @typedef {import("./types.js").Stage} Stage */
/** @typedef {import("./types.js").Clips} Clips */
/** @typedef {import("./types.js").EvaluationFound} EvaluationFound */

const ROOT = "/api/v1";

/** The server answered, but not with what was asked for. */
export class Refusal extends Error {
  /**
   * @param {number} status
   * @param {string} detail
   */
  constructor(status, detail) {
    super(detail);
    this.status = status;
  }
}

/**
 * @param {string} method
 * @param {string} path
 * @param {object} [body] a file as it is, all else as JSON
 * @returns {Promise<any>}
 */
async function ask(method, path, body) {
  let answer;
  const json = body !== undefined && !(body instanceof Blob);
  try {
    answer = await fetch(ROOT + path, {
      method,
      headers: json ? { "Content-Type": "application/json" } : {},
      body: json ? JSON.stringify(body) : body,
    });
  } catch {
    throw new Error("The studio does not answer. Is it still running?");
  }
  const told = answer.status === 204 ? null : await answer.json().catch(() => null);
  if (!answer.ok) {
    const detail = told?.detail ?? `The studio answered ${answer.status} ${answer.statusText}.`;
    throw new Refusal(answer.status, detail);
  }
  return told;
}

/**
 * Every item of a list, page by page.
 * @param {string} path
 * @returns {Promise<any[]>}
 */
async function every(path) {
  const items = [];
  let cursor = null;
  do {
    const from = cursor === null ? "" : `&cursor=${q(String(cursor))}`;
    const page = await ask("GET", `${path}${path.includes("?") ? "&" : "?"}limit=1000${from}`);
    items.push(...page.items);
    cursor = page.next;
  } while (cursor !== null);
  return items;
}

/** @param {string} text */
const q = (text) => encodeURIComponent(text);

export const api = {
  /** @returns {Promise<Scene[]>} */
  scenes: () => every("/scenes"),
  /** @param {string} scene @returns {Promise<Session[]>} */
  sessions: (scene) => every(`/sessions?scene=${q(scene)}`),
  /** @param {string} scene @param {string} name @returns {Promise<Session>} */
  makeSession: (scene, name) => ask("POST", "/sessions", { scene, name }),
  /**
   * The newest takes, the newest first, and whether there are more.
   * @param {number} session
   * @param {number} limit up to 1000
   * @returns {Promise<{items: Take[], more: boolean}>}
   */
  takes: async (session, limit) => {
    const page = await ask("GET", `/sessions/${session}/takes?newest=true&limit=${limit}`);
    return { items: page.items, more: page.next !== null };
  },
  /** @param {number} session @returns {Promise<{take: number, remarks: import("./types.js").Remark[]}[]>} */
  remarks: async (session) => (await ask("GET", `/sessions/${session}/remarks`)).items,
  /** @param {number} take @param {string} note @returns {Promise<Take>} */
  note: (take, note) => ask("PUT", `/takes/${take}/note`, { note }),
  /** Address of a picture of a take that has so many pairs. @param {number} take @param {number} pairs */
  thumbnail: (take, pairs) => `${ROOT}/takes/${take}/thumbnail.svg?pairs=${pairs}`,
  /** @param {number} take @returns {Promise<Take>} */
  trash: (take) => ask("POST", `/takes/${take}/trash`),
  /** @param {number} take @returns {Promise<Take>} */
  restore: (take) => ask("POST", `/takes/${take}/restore`),
  /** @param {number} session @param {object} settings @returns {Promise<Job>} */
  clean: (session, settings) => ask("POST", `/sessions/${session}/clean`, settings),
  /**
   * Look for conflicts.
   * @param {number} session
   * @param {number} neighbors
   * @param {string | null} perception the scene's first, if null
   * @returns {Promise<Job>}
   */
  look: (session, neighbors, perception) =>
    ask("POST", `/sessions/${session}/clean/preview`, { n_neighbors: neighbors, perception, worst: 0 }),
  /**
   * What would go at that threshold, by the latest look; null where nobody has looked.
   * @param {number} session
   * @param {number | "auto"} threshold
   * @param {number} limit
   * @returns {Promise<import("./types.js").Conflicts | null>}
   */
  conflicts: (session, threshold, limit) =>
    ask("GET", `/sessions/${session}/conflicts?threshold=${threshold}&limit=${limit}`),
  /**
   * @param {number} session
   * @param {number} take
   * @param {number} step
   * @param {import("./types.js").Verdict} verdict
   * @returns {Promise<object>}
   */
  judge: (session, take, step, verdict) =>
    ask("PUT", `/sessions/${session}/verdicts/${take}/${step}`, { verdict }),
  /** @param {number} session @param {number} take @param {number} step @returns {Promise<null>} */
  withdraw: (session, take, step) => ask("DELETE", `/sessions/${session}/verdicts/${take}/${step}`),
  /** @param {number} session @returns {Promise<Session>} */
  unclean: (session) => ask("DELETE", `/sessions/${session}/clean`),
  /**
   * @param {number} session
   * @param {string | null} learner the one that suits the scene, if null
   * @param {string | null} perception its first, if null
   * @returns {Promise<Job>}
   */
  fit: (session, learner, perception) =>
    ask("POST", `/sessions/${session}/fit`, { learner, perception }),
  /**
   * @param {string} name
   * @param {{policy: string, when?: string}[]} entries the last without a condition
   * @returns {Promise<Job>}
   */
  makeSwitch: (name, entries) => ask("POST", "/switches", { name, entries }),
  /** @returns {Promise<Job[]>} */
  jobs: () => every("/jobs"),
  /** @param {number} job @returns {Promise<Job>} */
  cancel: (job) => ask("DELETE", `/jobs/${job}`),
  /** @param {string} scene @returns {Promise<Policy[]>} */
  policies: (scene) => every(`/policies?scene=${q(scene)}`),
  /** @param {string} scene @returns {Promise<import("./types.js").PilotEntry[]>} */
  pilots: (scene) => every(`/pilots?scene=${q(scene)}`),
  /** @param {string} scene @returns {Promise<EvaluationFound[]>} */
  evaluations: (scene) => every(`/evaluations?scene=${q(scene)}`),
  /** @param {number} evaluation @returns {Promise<EvaluationFound>} */
  evaluation: (evaluation) => ask("GET", `/evaluations/${evaluation}`),
  /** @param {object} question @returns {Promise<Job>} */
  evaluate: (question) => ask("POST", "/evaluations", question),
  /** @param {number} evaluation @returns {Promise<Job>} */
  again: (evaluation) => ask("POST", `/evaluations/${evaluation}/again`),
  /** @param {number} evaluation @returns {Promise<import("./types.js").Pictures>} */
  pictures: (evaluation) => ask("GET", `/evaluations/${evaluation}/pictures`),
  /** @param {number} evaluation @returns {Promise<Job>} */
  drawPictures: (evaluation) => ask("POST", `/evaluations/${evaluation}/pictures`),
  /** @returns {Promise<Clips>} */
  clips: () => ask("GET", "/clips"),
  /** @param {File} file @returns {Promise<Clips>} */
  addClips: (file) => ask("PUT", `/clips/files/${q(file.name)}`, file),
  /** @param {string} activity @param {string} file @param {string} clip @returns {Promise<Clips>} */
  chooseClip: (activity, file, clip) => ask("PUT", `/clips/activities/${q(activity)}`, { file, clip }),
  /** @param {string} activity @returns {Promise<Clips>} */
  forgetClip: (activity) => ask("DELETE", `/clips/activities/${q(activity)}`),
  /**
   * @param {string} scene
   * @param {Record<string, number>} options
   * @param {number | null} session
   * @returns {Promise<Stage>}
   */
  openStage: (scene, options, session) =>
    ask("POST", "/stages", session === null ? { scene, options } : { scene, options, session }),
  /** @returns {Promise<Stage[]>} */
  stages: () => every("/stages"),
  /** @param {{session: number, person: string, instructed_s: number}} told @returns {Promise<{id: number}>} */
  keepStudy: (told) => ask("POST", "/studies", told),
  /** @param {number} study @param {{session: number, person: string, instructed_s: number}} told */
  replaceStudy: (study, told) => ask("PUT", `/studies/${study}`, told),
  /** What happens on a stage as one file. @param {string} stage @param {string} form @returns {Promise<Job>} */
  film: (stage, form) => ask("POST", `/stages/${q(stage)}/film`, { form }),
  /** @returns {Promise<{name: string, bytes: number}[]>} */
  films: () => every("/films"),
  /** @param {string} name */
  filmFile: (name) => `${ROOT}/films/${q(name)}`,
  /** @param {number} study */
  forgetStudy: (study) => ask("DELETE", `/studies/${study}`),
  /** @returns {Promise<{name: string, role: "author" | "viewer"}>} */
  me: () => ask("GET", "/me"),
  /** @param {number} evaluation @returns {Promise<{worlds: number[], count: number}>} */
  disputed: (evaluation) => ask("GET", `/evaluations/${evaluation}/disputed`),
  /** @param {object} asked @returns {Promise<import("./types.js").Lineup>} */
  openLineup: (asked) => ask("POST", "/lineups", asked),
  /** @param {string} lineup @returns {Promise<import("./types.js").Standing>} */
  lineupStanding: (lineup) => ask("GET", `/lineups/${q(lineup)}/standing`),
  /** @param {string} lineup @param {object} command @returns {Promise<import("./types.js").Standing>} */
  lineupCommand: (lineup, command) => ask("POST", `/lineups/${q(lineup)}/commands`, command),
  /** @param {string} lineup @returns {Promise<void>} */
  closeLineup: (lineup) => ask("DELETE", `/lineups/${q(lineup)}`),
  /** The same from a page that is left. @param {string} lineup */
  forgetLineup: (lineup) => {
    fetch(`${ROOT}/lineups/${q(lineup)}`, { method: "DELETE", keepalive: true }).catch(() => {});
  },
  /** @param {string} [scene] @returns {Promise<import("./types.js").Ballot[]>} */
  ballots: (scene) => every(`/ballots${scene === undefined ? "" : `?scene=${q(scene)}`}`),
  /** @param {object} asked @returns {Promise<import("./types.js").Ballot>} */
  openBallot: (asked) => ask("POST", "/ballots", asked),
  /** @param {number} ballot @returns {Promise<void>} */
  deleteBallot: (ballot) => ask("DELETE", `/ballots/${ballot}`),
  /** @returns {Promise<import("./types.js").Preference[]>} */
  preferences: () => every("/ballots/preferences"),
  /** @param {number} ballot @returns {Promise<import("./types.js").Lineup>} */
  showPair: (ballot) => ask("POST", `/ballots/${ballot}/showings`),
  /**
   * @param {number} ballot
   * @param {string} lineup
   * @param {"left" | "right" | "neither"} livelier
   * @returns {Promise<{left: string, right: string, livelier: string | null,
   *   preference: import("./types.js").Preference}>}
   */
  vote: (ballot, lineup, livelier) => ask("POST", `/ballots/${ballot}/votes`, { lineup, livelier }),
  /** @param {string} stage @returns {Promise<import("./types.js").Strip>} */
  strip: (stage) => ask("GET", `/stages/${q(stage)}/strip`),
  /** @param {string} stage @returns {Promise<import("./types.js").Why | null>} */
  why: (stage) => ask("GET", `/stages/${q(stage)}/why`),
  /**
   * @param {string} policy
   * @param {string} scene
   * @param {Record<string, number>} options
   * @param {number} seed of the series of worlds
   * @returns {Promise<Job>}
   */
  findFailures: (policy, scene, options, seed) =>
    ask("POST", "/failures", { policy, scene, options, seed }),
  /** @param {number} session @param {number} seed @returns {Promise<Job>} */
  findPlaces: (session, seed) => ask("POST", `/sessions/${session}/places`, { seed }),
  /** @param {string} stage @returns {Promise<object>} */
  stage: (stage) => ask("GET", `/stages/${q(stage)}`),
};
