/**
 * What the server sends, as the page uses it.
 *
 * @typedef {{name: string, label: string, default: number, low: number, high: number,
 *   step: number, help: string}} Option
 * @typedef {{field: string, label: string, negative: string[], positive: string[],
 *   ramp_s: number, reach: number}} Control
 * @typedef {{name: string, label: string, key: string, placed: boolean}} Signal
 * @typedef {{name: string, label: string}} Happening
 * @typedef {{name: string, title: string, version: number, dt_s: number, options: Option[],
 *   controls: Control[], signals: Signal[], events: Happening[],
 *   perceptions: {name: string, summary: string}[],
 *   symbols: string[], outcomes: string[],
 *   successes: string[], many: boolean, people: boolean}} Scene
 * @typedef {{name: string, label: string, file: string | null, clip: string | null,
 *   problem: string | null}} Activity
 * @typedef {{folder: string, files: {name: string, clips: string[], problem: string | null}[],
 *   activities: Activity[], problem: string | null}} Clips
 * @typedef {{pairs: number, removed: number, stale: boolean,
 *   settings: {threshold: number | "auto"}}} Cleaning
 * @typedef {{id: number, name: string, scene: string, takes_kept: number, takes_trashed: number,
 *   pairs: number, seconds: number, cleaning: Cleaning | null}} Session
 * @typedef {{id: number, number: number, seed: number, pairs: number, seconds: number,
 *   outcome: string | null, trashed: boolean, started_at: number, note: string,
 *   origin: Origin | null}} Take
 * @typedef {{step: number, seconds: number, take: number | null, number: number | null,
 *   policy: string | null}} Origin
 * @typedef {{kind: string, says: string}} Remark
 * @typedef {{name: string, scene: string, learner: string, pairs: number, session: string | null,
 *   created: string | null, shipped: boolean, stale: boolean, problem: string | null,
 *   report: string[], in_short: string[], switches: string[], made_before: string | null}} Policy
 * @typedef {"keep" | "delete" | "missing"} Verdict
 * @typedef {{take: number, number: number, step: number, seconds: number, says: string,
 *   deviation: number, limit: number, conflict: boolean, verdict: Verdict | null,
 *   goes: boolean}} Conflict
 * @typedef {{pairs: number, conflicts: number, goes: number, limit: number, neighbors: number,
 *   perception: string, symbols: boolean, stale: boolean, items: Conflict[]}} Conflicts
 * @typedef {"queued" | "running" | "done" | "failed" | "cancelled"} JobState
 * @typedef {{id: number, kind: string, session: number | null, state: JobState, progress: number,
 *   message: string, result: Record<string, any> | null, error: string | null}} Job
 * @typedef {"ready" | "countdown" | "recording" | "paused" | "playing" | "ended" |
 *   "reviewing"} Phase
 * @typedef {{phase: Phase, mode: "demonstrate" | "play" | "correct" | "review" | null, countdown_s: number,
 *   pairs: number, seconds: number, takes_kept: number, pairs_kept: number,
 *   session: {id: number, name: string} | null, progress: number, outcome: string | null,
 *   success: boolean | null, can_undo: boolean, late_steps: number, steps: number,
 *   policy: string | null, others: string | null, decision: string | null,
 *   decides_s: number | null, lead: number | null, camera: string, cameras: string[],
 *   problem: string | null, options: Record<string, number>, position_s: number | null,
 *   length_s: number, speed: number, take: number | null, familiarity: number | null, seed: number,
 *   forked: boolean, silent: string | null, forgotten: number,
 *   by_hand: boolean, pushed: boolean, pushes: boolean, pace: number, wanted: number | null,
 *   automatic: boolean, next_s: number | null,
 *   coach: "seen" | "nothing" | "faint" | "hidden" | null}} Status
 * @typedef {{take: number | null, step: number | null, number: number | null,
 *   session: string | null, seconds: number | null, distance: number, weight: number,
 *   action: Record<string, number> | null}} ShownMoment
 * @typedef {{policy: string, silent: string | null, familiarity: number | null,
 *   agreement: number | null, moments: ShownMoment[]}} Why
 * @typedef {{seed: number, outcome: string, seconds: number}} Failure
 * @typedef {{take: number, number: number, step: number, keys: string[], steps: number,
 *   seconds: number, familiarity: number}} Place
 * @typedef {{first_s: number, length_s: number, familiarity: (number | null)[],
 *   happenings: {seconds: number, kind: string, says: string}[]}} Strip
 * @typedef {{id: string, scene: string, view: string, socket: string}} Stage
 * @typedef {{name: string, kind: "own" | "shipped" | "program"}} PilotEntry
 * @typedef {{id: number, scene: string, created_at: number, says: string[],
 *   labels: Record<string, string>, asked: {options: Record<string, number>, worlds: number},
 *   result: {seed: number, worlds: number, pilots: Record<string, Record<string, any>>}
 *   }} EvaluationFound
 * @typedef {{view: string, title: string, length_s: number, outcome: string | null,
 *   success: boolean | null, parts_s: number | null,
 *   happenings: {seconds: number, kind: string, says: string}[]}} Column
 * @typedef {{position_s: number, speed: number, camera: string, turned: boolean}} Standing
 * @typedef {{id: string, scene: string, dt_s: number, length_s: number, parts_s: number | null,
 *   cameras: string[], columns: Column[], options: Record<string, number>, world: number,
 *   ballot: number | null, standing: Standing}} Lineup
 * @typedef {{id: number, scene: string, title: string, created_at: number, votes: number,
 *   mine: number}} Ballot
 * @typedef {{ballot: number, scene: string, pilots: string[], votes: number[], neither: number,
 *   people: number, share: number | null, interval: number[] | null, says: string}} Preference
 * @typedef {{name: string, title: string, svg: string, png: string}} Picture
 * @typedef {{items: Picture[], left_out: string | null, whole: boolean}} Pictures
 *
 * What the page that compares knows at a moment.
 * @typedef {object} Comparing
 * @property {Scene[]} scenes
 * @property {Scene | null} scene
 * @property {PilotEntry[]} pilots who can act in it
 * @property {string[]} chosen of those, in the order of choosing
 * @property {Session[]} sessions whose takes they may be compared with
 * @property {Record<string, number>} options for the worlds
 * @property {EvaluationFound[]} evaluations earlier ones of the scene
 * @property {EvaluationFound | null} evaluation the one that is shown
 * @property {Pictures | null} pictures of it
 * @property {Lineup | null} lineup what is side by side
 * @property {Ballot[]} ballots of the scene
 * @property {Preference[]} preferences what came of ballots, as far as one may know
 * @property {null} session none is recorded into
 * @property {Job[]} jobs that wait or run
 *
 * What the page knows at a moment.
 * @typedef {object} State
 * @property {Scene[]} scenes
 * @property {Scene | null} scene
 * @property {Session[]} sessions
 * @property {number | null} session the one recorded into
 * @property {Take[]} takes the newest of that session, the newest first
 * @property {boolean} moreTakes whether it has others
 * @property {Policy[]} policies
 * @property {string | null} policy the one that plays
 * @property {string | null} others the policy of everybody else; null: they stand still
 * @property {string} learner of those the page offers
 * @property {string | null} perception to fit by; null: the scene's first
 * @property {Record<string, number>} options for the next world
 * @property {Job[]} jobs that wait or run
 * @property {Status | null} status
 * @property {{take: number, step: number} | null} conflict the one that is looked at
 * @property {boolean} connected
 */
export {};
