/** The page's state: one object, replaced in parts, watched as a whole. */

/** @typedef {import("./types.js").State} State */

export class Store {
  /** @param {State} state */
  constructor(state) {
    this.state = state;
    /** @type {((state: State, before: State) => void)[]} */
    this.watchers = [];
  }

  /**
   * Call `watcher` now and after every change.
   * @param {(state: State, before: State) => void} watcher
   */
  watch(watcher) {
    this.watchers.push(watcher);
    watcher(this.state, this.state);
  }

  /** @param {Partial<State>} changes */
  set(changes) {
    const before = this.state;
    this.state = { ...before, ...changes };
    for (const watcher of this.watchers) watcher(this.state, before);
  }
}
