/** The page's state: one object, replaced in parts, watched as a whole. */

/** Where the browser keeps which scene was chosen last. */
export const LAST_SCENE = "evastudio.scene";

/** @template [S=import("./types.js").State] */
export class Store {
  /** @param {S} state */
  constructor(state) {
    this.state = state;
    /** @type {((state: S, before: S) => void)[]} */
    this.watchers = [];
  }

  /**
   * Call `watcher` now and after every change.
   * @param {(state: S, before: S) => void} watcher
   */
  watch(watcher) {
    this.watchers.push(watcher);
    watcher(this.state, this.state);
  }

  /** @param {Partial<S>} changes */
  set(changes) {
    const before = this.state;
    this.state = { ...before, ...changes };
    for (const watcher of this.watchers) watcher(this.state, before);
  }
}
