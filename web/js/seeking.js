/** Seeking: one place is asked for at a time; of those wanted meanwhile the newest wins. */

/** A place counts as seen this near to it, seconds. */
const NEAR_S = 1e-3;
/** After so long the next is asked for, though the last was not seen. */
const PATIENCE_MS = 400;

/** @param {(seconds: number) => void} ask */
export function seeking(ask) {
  /** @type {number | null} */
  let asked = null;
  let timer = 0;

  const seek = {
    /** Where the person is, though the studio may not be there yet. @type {number | null} */
    wanted: null,

    /** @param {number} seconds */
    to(seconds) {
      seek.wanted = seconds;
      if (asked === null) next();
    },

    /** The studio shows this place now. @param {number} seconds */
    seen(seconds) {
      if (asked !== null && Math.abs(seconds - asked) < NEAR_S) next();
    },

    /** Nothing is sought any more. */
    forget() {
      clearTimeout(timer);
      seek.wanted = asked = null;
    },
  };

  function next() {
    clearTimeout(timer);
    if (seek.wanted === null || seek.wanted === asked) return seek.forget();
    asked = seek.wanted;
    ask(asked);
    timer = setTimeout(next, PATIENCE_MS);
  }
  return seek;
}
