/**
 * The pad over the view: shows at every moment how far each control goes, and is a stick itself.
 *
 * The dot is what the character gets, the ring where sticks are pushed. It follows held keys by the
 * same ramp as the studio does, so that it need not wait to be told.
 */

import { byId } from "./dom.js";
import { waysOf } from "./hands.js";

/** @typedef {import("./hands.js").Place} Place */
/** @typedef {import("./types.js").Control} Control */

/** Pixels of the drawing from its middle to where a stick ends. */
const REACH = 40;

/**
 * @param {import("./store.js").Store} store
 * @param {import("./hands.js").Hands} hands
 * @param {{sensitivity: number, ramp: number}} feel read anew at every frame
 * @param {() => boolean} steering whether the hands move the character now
 */
export function pad(store, hands, feel, steering) {
  const box = byId("pad", HTMLElement);
  const dot = box.querySelector(".dot");
  const ring = box.querySelector(".ring");
  /** How far keys have got by now, by field. @type {Map<string, number>} */
  const ramped = new Map();
  let drawn = 0;
  let drawing = false;

  /** @param {Control} control @param {number} seconds since the last frame */
  function deflection({ field, positive, negative, ramp_s, reach }, seconds) {
    const most = Math.min(reach * feel.sensitivity, 1);
    const held = (/** @type {string[]} */ keys) => Number(keys.some((key) => hands.held.includes(key)));
    const target = (held(positive) - held(negative)) * most;
    const before = ramped.get(field) ?? 0;
    const ramp = ramp_s * feel.ramp;
    const most_moved = ramp ? seconds / ramp : Infinity;
    const after = before + Math.min(Math.max(target - before, -most_moved), most_moved);
    ramped.set(field, after);
    return Math.min(1, Math.max(-1, after + (hands.pushed[field] ?? 0) * most));
  }

  /** @param {number} at milliseconds */
  function draw(at) {
    drawing = !box.hidden;
    if (!drawing) return;
    const { scene, status } = store.state;
    const seconds = Math.min((at - drawn) / 1000, 0.1) * (status?.pace ?? 1);
    drawn = at;
    const ways = waysOf(scene);
    const gone = new Map((scene?.controls ?? []).map((one) => [one.field, deflection(one, seconds)]));
    const along = (/** @type {"x" | "y"} */ axis) => {
      const way = ways[axis];
      return way ? way.sign * (gone.get(way.field) ?? 0) : 0;
    };
    const { x, y } = hands.place;
    move(dot, along("x"), along("y"));
    move(ring, x, y);
    ring?.classList.toggle("pushed", hands.sticks.size > 0);
    requestAnimationFrame(draw);
  }

  store.watch(({ scene }) => {
    const { x, y } = waysOf(scene);
    box.hidden = !steering() || (x === null && y === null);
    if (box.hidden) ramped.clear();
    else if (!drawing) {
      drawing = true;
      requestAnimationFrame(draw);
    }
  });
  stick(box, () => box.getBoundingClientRect().width / 2, "pad", hands);
}

/** @param {Element | null} mark @param {number} x @param {number} y */
function move(mark, x, y) {
  mark?.setAttribute("cx", String(50 + REACH * x));
  mark?.setAttribute("cy", String(50 - REACH * y));
}

/**
 * Make a stick of an element: it is where one presses in it, and springs back when let go.
 * @param {HTMLElement} element
 * @param {() => number} reach pixels from its middle to its end
 * @param {string} name
 * @param {import("./hands.js").Hands} hands
 */
function stick(element, reach, name, hands) {
  let finger = -1;
  const to = (/** @type {PointerEvent} */ event) => {
    const { left, top, width, height } = element.getBoundingClientRect();
    const x = (event.clientX - left - width / 2) / reach();
    const y = (top + height / 2 - event.clientY) / reach();
    hands.push(name, inside(x, y), performance.timeOrigin + event.timeStamp);
  };
  element.addEventListener("pointerdown", (event) => {
    if (event.button !== 0) return;
    event.preventDefault();
    finger = event.pointerId;
    element.setPointerCapture(finger);
    to(event);
  });
  element.addEventListener("pointermove", (event) => {
    if (event.pointerId === finger) to(event);
  });
  for (const end of ["pointerup", "pointercancel", "lostpointercapture"]) {
    element.addEventListener(end, (event) => {
      if (/** @type {PointerEvent} */ (event).pointerId !== finger) return;
      finger = -1;
      hands.push(name, null, performance.timeOrigin + event.timeStamp);
    });
  }
}

/**
 * The same way, but no further than a stick goes.
 * @param {number} x @param {number} y
 * @returns {Place}
 */
export function inside(x, y) {
  const far = Math.max(1, Math.hypot(x, y));
  return { x: x / far, y: y / far };
}
