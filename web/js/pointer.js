/** Where in the 3D view the pointer is, for what is meant at a place. */

export class Pointer {
  /** @param {HTMLIFrameElement} frame same-origin, followed through all its reloads */
  constructor(frame) {
    this.frame = frame;
    /** @type {[number, number] | null} Pixels from the view's left and top; null outside it. */
    this.at = null;
    const attach = () => {
      const view = frame.contentWindow;
      view?.addEventListener("pointermove", ({ clientX, clientY }) => (this.at = [clientX, clientY]), {
        capture: true,
      });
      view?.document.documentElement.addEventListener("pointerleave", () => (this.at = null));
    };
    frame.addEventListener("load", attach);
    attach();
  }

  /**
   * Across and up, from -1 to 1, and the view's width over its height; null outside the view.
   * @returns {[number, number, number] | null}
   */
  place() {
    const { clientWidth: width, clientHeight: height } = this.frame;
    if (this.at === null || width === 0 || height === 0) return null;
    const [x, y] = this.at;
    const inside = (/** @type {number} */ share) => Math.min(1, Math.max(-1, share));
    return [inside((2 * x) / width - 1), inside(1 - (2 * y) / height), width / height];
  }
}
