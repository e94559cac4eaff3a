/** A gamepad: its left stick and its cross steer, some buttons give commands. */

/** Nearer to its middle than this a stick rests, which no stick does exactly. */
const DEAD = 0.12;
/** Buttons of the standard layout. */
const CROSS = { up: 12, down: 13, left: 14, right: 15 };
/** What buttons do, in the standard layout: A, B, Y. @type {Record<number, string>} */
const DOES = { 0: "pad-go", 1: "discard", 3: "restart" };

export class GamepadHand {
  /**
   * @param {import("./hands.js").Hands} hands
   * @param {() => boolean} steering whether the hands move the character now
   * @param {(name: string) => void} command
   * @param {(name: string | null) => void} connected told the name of the one that is used
   */
  constructor(hands, steering, command, connected) {
    this.hands = hands;
    this.steering = steering;
    this.command = command;
    this.connected = connected;
    /** @type {Set<number>} */
    this.pressed = new Set();
    this.polling = false;
    for (const change of ["gamepadconnected", "gamepaddisconnected"]) {
      window.addEventListener(change, () => this.look());
    }
    this.look();
  }

  /** The first that is there. */
  get pad() {
    return [...navigator.getGamepads()].find((one) => one?.connected) ?? null;
  }

  look() {
    const pad = this.pad;
    this.connected(pad?.id ?? null);
    if (pad === null) this.rest();
    else if (!this.polling) requestAnimationFrame(() => this.poll());
    this.polling = pad !== null;
  }

  rest() {
    this.pressed.clear();
    this.hands.push("gamepad", null);
  }

  poll() {
    const pad = this.pad;
    if (pad === null) return this.look();
    requestAnimationFrame(() => this.poll());
    // Into a page that has not the focus nobody steers.
    if (!document.hasFocus()) return this.rest();
    const down = (/** @type {number} */ button) => pad.buttons[button]?.pressed ?? false;
    for (const [button, name] of Object.entries(DOES)) {
      const code = Number(button);
      if (down(code) && !this.pressed.has(code)) this.command(name);
      if (down(code)) this.pressed.add(code);
      else this.pressed.delete(code);
    }
    if (!this.steering()) return this.hands.push("gamepad", null);
    const [x = 0, y = 0] = pad.axes;
    const far = Math.hypot(x, y);
    const share = far > DEAD ? Math.min(1, (far - DEAD) / (1 - DEAD)) / far : 0;
    const cross = {
      x: Number(down(CROSS.right)) - Number(down(CROSS.left)),
      y: Number(down(CROSS.up)) - Number(down(CROSS.down)),
    };
    this.hands.push("gamepad", { x: x * share + cross.x, y: cross.y - y * share });
  }
}
