/** Where in the 3D view the pointer is, for what is meant at a place. */

/** Across and up, from -1 to 1, and the view's width over its height. */
/** @typedef {[number, number, number]} Place */

/** A press that moves farther, in pixels, or lasts longer, in milliseconds, is no click. */
const NEAR = 5;
const BRIEF = 400;

export class Pointer {
  /** @param {HTMLIFrameElement} frame same-origin, followed through all its reloads */
  constructor(frame) {
    this.frame = frame;
    /** @type {[number, number] | null} Pixels from the view's left and top; null outside it. */
    this.at = null;
    /** @type {((place: Place | null) => void) | null} Who waits for a click in the view. */
    this.waiting = null;
    /** Told of clicks in the view that nobody waits for, and that turn no camera. */
    this.clicked = () => {};
    /** @type {[number, number, number] | null} Where and when the button went down. */
    this.down = null;
    const attach = () => {
      const view = frame.contentWindow;
      const early = { capture: true };
      view?.addEventListener("pointermove", (event) => this.moved(event), early);
      view?.addEventListener("pointerdown", (event) => this.pressed(event), early);
      view?.addEventListener("pointerup", (event) => this.released(event), early);
      view?.document.documentElement.addEventListener("pointerleave", () => (this.at = null));
    };
    frame.addEventListener("load", attach);
    attach();
  }

  get picking() {
    return this.waiting !== null;
  }

  /**
   * Where the next click in the view is, which turns no camera; null where it was cancelled.
   * @returns {Promise<Place | null>}
   */
  pick() {
    this.cancel();
    this.show(true);
    return new Promise((done) => (this.waiting = done));
  }

  /** Wait for a click no longer. */
  cancel() {
    this.answer(null);
  }

  /** @param {PointerEvent} event */
  moved({ clientX, clientY }) {
    this.at = [clientX, clientY];
  }

  /** @param {PointerEvent} event */
  pressed(event) {
    this.moved(event);
    const { button, clientX, clientY, timeStamp } = event;
    this.down = button === 0 && !this.picking ? [clientX, clientY, timeStamp] : null;
    if (!this.picking) return;
    event.stopImmediatePropagation();
    event.preventDefault();
    this.answer(this.place());
  }

  /** @param {PointerEvent} event */
  released({ button, clientX, clientY, timeStamp }) {
    if (this.down === null || button !== 0) return;
    const [x, y, since] = this.down;
    this.down = null;
    const near = Math.hypot(clientX - x, clientY - y) <= NEAR;
    if (near && timeStamp - since <= BRIEF) this.clicked();
  }

  /** @param {Place | null} place */
  answer(place) {
    const done = this.waiting;
    if (done === null) return;
    this.waiting = null;
    this.show(false);
    done(place);
  }

  /** @param {boolean} picking */
  show(picking) {
    this.frame.contentDocument?.documentElement.classList.toggle("picking", picking);
  }

  /** @returns {Place | null} null outside the view */
  place() {
    const { clientWidth: width, clientHeight: height } = this.frame;
    if (this.at === null || width === 0 || height === 0) return null;
    const [x, y] = this.at;
    const inside = (/** @type {number} */ share) => Math.min(1, Math.max(-1, share));
    return [inside((2 * x) / width - 1), inside(1 - (2 * y) / height), width / height];
  }
}
