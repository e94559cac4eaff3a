/** Where the tour's card stands: beside what it points at, never over it. */

const GAP = 18;
const MARGIN = 10;
const ROUND_IT = 6;

/** @typedef {{left: number, top: number, right: number, bottom: number}} Box */
/** @typedef {"left" | "right" | "above" | "below"} Side */

/** @param {number} value @param {number} low @param {number} high */
const within = (value, low, high) => Math.max(low, Math.min(value, high));

/**
 * The box around all of `elements` that are seen, or null.
 * @param {Iterable<Element>} elements
 * @returns {Box | null}
 */
export function around(elements) {
  const boxes = [...elements].map((one) => one.getBoundingClientRect());
  const seen = boxes.filter(({ width, height }) => width > 0 && height > 0);
  if (seen.length === 0) return null;
  return {
    left: Math.min(...seen.map(({ left }) => left)) - ROUND_IT,
    top: Math.min(...seen.map(({ top }) => top)) - ROUND_IT,
    right: Math.max(...seen.map(({ right }) => right)) + ROUND_IT,
    bottom: Math.max(...seen.map(({ bottom }) => bottom)) + ROUND_IT,
  };
}

/**
 * Where a card of that size stands to point at `target`: its side of the target, `first` where there
 * is room, its corner, and how far along its edge the arrow is.
 * @param {Box} target
 * @param {{width: number, height: number}} card
 * @param {{width: number, height: number}} window
 * @param {Side} first
 * @returns {{side: Side, x: number, y: number, arrow: number}}
 */
export function placed(target, card, window, first) {
  const { left, top, right, bottom } = target;
  const [acrossTo, downTo] = [window.width - card.width - MARGIN, window.height - card.height - MARGIN];
  const beside = within((top + bottom - card.height) / 2, MARGIN, downTo);
  const over = within((left + right - card.width) / 2, MARGIN, acrossTo);
  /** @type {[Side, number, number, number][]} Side, corner, and how much room is left over. */
  const ways = [
    ["left", left - GAP - card.width, beside, left - GAP - card.width - MARGIN],
    ["above", over, top - GAP - card.height, top - GAP - card.height - MARGIN],
    ["below", over, bottom + GAP, downTo - bottom - GAP],
    ["right", right + GAP, beside, acrossTo - right - GAP],
  ];
  ways.sort(([one], [other]) => Number(other === first) - Number(one === first));
  const roomiest = ways.reduce((best, way) => (way[3] > best[3] ? way : best));
  const [side, x, y] = ways.find(([, , , room]) => room >= 0) ?? roomiest;
  const upright = side === "left" || side === "right";
  const [to, from, length] = upright
    ? [(top + bottom) / 2, y, card.height]
    : [(left + right) / 2, x, card.width];
  return { side, x, y, arrow: within(to - from, 22, length - 22) };
}
