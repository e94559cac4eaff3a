/** The whole 3D view as a stick: press anywhere and drag; the camera keeps still meanwhile. */

import { inside } from "./pad.js";

/** A drag of this share of the view's smaller side is the stick's end. */
const REACH = 0.2;

export class ViewStick {
  /**
   * @param {HTMLIFrameElement} frame same-origin, followed through all its reloads
   * @param {import("./hands.js").Hands} hands
   * @param {() => boolean} steering whether the hands move the character now
   */
  constructor(frame, hands, steering) {
    this.on = false;
    this.frame = frame;
    this.hands = hands;
    this.steering = steering;
    this.finger = -1;
    this.from = { x: 0, y: 0 };
    const attach = () => {
      const early = { capture: true };
      const view = frame.contentWindow;
      view?.addEventListener("pointerdown", (event) => this.down(event), early);
      view?.addEventListener("pointermove", (event) => this.moved(event), early);
      for (const end of ["pointerup", "pointercancel"]) {
        view?.addEventListener(end, (event) => this.up(/** @type {PointerEvent} */ (event)), early);
      }
    };
    frame.addEventListener("load", attach);
    attach();
  }

  /** @param {PointerEvent} event */
  down(event) {
    if (!this.on || event.button !== 0 || !this.steering()) return;
    event.stopImmediatePropagation();
    this.finger = event.pointerId;
    this.from = { x: event.clientX, y: event.clientY };
    if (event.target instanceof (event.view ?? window).Element) {
      event.target.setPointerCapture(event.pointerId);
    }
  }

  /** @param {PointerEvent} event */
  moved(event) {
    if (event.pointerId !== this.finger) return;
    event.stopImmediatePropagation();
    const reach = REACH * Math.min(this.frame.clientWidth, this.frame.clientHeight);
    const x = (event.clientX - this.from.x) / reach;
    const y = (this.from.y - event.clientY) / reach;
    this.hands.push("view", inside(x, y), timeOf(event));
  }

  /** @param {PointerEvent} event */
  up(event) {
    if (event.pointerId !== this.finger) return;
    event.stopImmediatePropagation();
    this.finger = -1;
    this.hands.push("view", null, timeOf(event));
  }
}

/** Milliseconds since the epoch. @param {PointerEvent} event */
function timeOf(event) {
  return (event.view ?? window).performance.timeOrigin + event.timeStamp;
}
