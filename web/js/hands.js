/** The person's hands: keys, sticks and the feel of both, told to the studio as one thing. */

/** @typedef {import("./types.js").Scene} Scene */
/** @typedef {import("./types.js").Status} Status */
/** @typedef {{x: number, y: number}} Place across and up, each from -1 to 1 */
/** @typedef {{field: string, sign: number}} Way which control, and whether it grows that way */

const REST = { x: 0, y: 0 };
/** Sticks are told in steps of this; smaller moves are the hand's tremble. */
const FINEST = 0.01;
/** What is held is told so often, and counts as released where nothing was heard for so long. */
const BEAT_MS = 250;
export const GOOD_MS = 1000;

/** Whether the character is a person's to steer. @param {Status | null} status */
export function steers(status) {
  const acting = ["countdown", "recording", "paused"].includes(status?.phase ?? "");
  return acting && ["demonstrate", "correct"].includes(status?.mode ?? "");
}

/** Whether a hand moves it, also by taking over from what plays. @param {Status | null} status */
export const moves = (status) =>
  steers(status) || (status?.mode === "play" && ["playing", "paused"].includes(status.phase));

/**
 * Which controls a stick moves: those of the keys that point the same way.
 * @param {Scene | null} scene
 * @returns {{x: Way | null, y: Way | null}}
 */
export function waysOf(scene) {
  /** @param {string[]} up @param {string[]} down @returns {Way | null} */
  const along = (up, down) => {
    for (const { field, positive, negative } of scene?.controls ?? []) {
      const has = (/** @type {string[]} */ keys, /** @type {string[]} */ own) =>
        keys.some((key) => own.includes(key));
      if (has(up, positive) || has(down, negative)) return { field, sign: 1 };
      if (has(down, positive) || has(up, negative)) return { field, sign: -1 };
    }
    return null;
  };
  return {
    x: along(["ArrowRight", "KeyD"], ["ArrowLeft", "KeyA"]),
    y: along(["ArrowUp", "KeyW"], ["ArrowDown", "KeyS"]),
  };
}

/** @param {number} share */
const tidy = (share) => Math.round(Math.min(1, Math.max(-1, share)) / FINEST) * FINEST;

/** Milliseconds since the epoch, as events of keys have them. */
const now = () => performance.timeOrigin + performance.now();

export class Hands {
  /**
   * @param {() => Scene | null} scene
   * @param {(held: string[], pushed: Record<string, number>, timeMs: number) => void} tell
   */
  constructor(scene, tell) {
    this.scene = scene;
    this.tell = tell;
    /** @type {string[]} */
    this.held = [];
    /** Where each stick is that is pushed, by its name. @type {Map<string, Place>} */
    this.sticks = new Map();
    /** Sticks that count again once they were at rest. @type {Set<string>} */
    this.ignored = new Set();
    this.told = JSON.stringify([[], {}]);
    setInterval(() => this.again(), BEAT_MS);
  }

  /** All sticks together. @returns {Place} */
  get place() {
    const sum = (/** @type {"x" | "y"} */ axis) =>
      [...this.sticks.values()].reduce((total, stick) => total + stick[axis], 0);
    return { x: tidy(sum("x")), y: tidy(sum("y")) };
  }

  /** How far each control is pushed by sticks. @returns {Record<string, number>} */
  get pushed() {
    const { x, y } = waysOf(this.scene());
    const place = this.place;
    /** @type {Record<string, number>} */
    const pushed = {};
    if (x && place.x) pushed[x.field] = x.sign * place.x;
    if (y && place.y) pushed[y.field] = y.sign * place.y;
    return pushed;
  }

  /** @param {string[]} held @param {number} timeMs */
  hold(held, timeMs) {
    this.held = held;
    this.say(timeMs);
  }

  /**
   * @param {string} stick its name
   * @param {Place | null} place null where it was let go
   * @param {number} [timeMs]
   */
  push(stick, place, timeMs = now()) {
    const at = place ?? REST;
    if (!tidy(at.x) && !tidy(at.y)) {
      this.sticks.delete(stick);
      this.ignored.delete(stick);
    } else if (!this.ignored.has(stick)) this.sticks.set(stick, at);
    this.say(timeMs);
  }

  /** Nothing is held or pushed any more. */
  letGo() {
    for (const stick of this.sticks.keys()) this.ignored.add(stick);
    this.held = [];
    this.sticks.clear();
    this.say(now());
  }

  /** Tell it all once more: the studio may have begun anew. */
  again() {
    if (!this.held.length && !this.sticks.size) return;
    this.told = "";
    this.say(now());
  }

  /** @param {number} timeMs */
  say(timeMs) {
    const pushed = this.pushed;
    const what = JSON.stringify([this.held, pushed]);
    if (what === this.told) return;
    this.told = what;
    this.tell(this.held, pushed, timeMs);
  }
}
