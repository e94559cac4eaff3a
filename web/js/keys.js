/**
 * Held keys, on the page and inside the 3D view.
 *
 * Listeners sit in the capture phase on both windows, so that they come before those of the view's
 * own camera. A key is taken only while it means something; the release of a key whose press was
 * not taken goes to whoever had the press.
 */

/** What a key does: steer, give a command or a signal, press a control, or nothing here. */
/** @typedef {{kind: "hold"} | {kind: "command" | "signal", name: string, repeats?: boolean} |
 *   {kind: "press", control: HTMLElement} | null} Meaning */

const TYPED = /^(text|search|email|url|tel|password|number)$/;

/** @param {EventTarget | undefined} target */
function isField(target) {
  if (!(target && "tagName" in target)) return false;
  const element = /** @type {HTMLInputElement} */ (target);
  if (element.isContentEditable || /^(TEXTAREA|SELECT)$/.test(element.tagName)) return true;
  return element.tagName === "INPUT" && TYPED.test(element.type);
}

/** @param {EventTarget | undefined} target */
function isPressable(target) {
  if (!(target && "tagName" in target)) return false;
  return /^(BUTTON|INPUT|SUMMARY|A)$/.test(/** @type {Element} */ (target).tagName);
}

export class Keys {
  /**
   * @param {(event: KeyboardEvent, onControl: boolean) => Meaning} meaning
   * @param {(held: string[], timeMs: number) => void} tell
   * @param {(name: string) => void} command
   * @param {(name: string) => void} signal
   * @param {() => void} [letGo] nothing is held any more, whatever the keyboard says
   */
  constructor(meaning, tell, command, signal, letGo = () => {}) {
    this.letGo = letGo;
    this.meaning = meaning;
    this.tell = tell;
    this.command = command;
    this.signal = signal;
    /** @type {Set<string>} Keys that steer, held now. */
    this.held = new Set();
    /** @type {Set<string>} Keys whose press was taken, and so is their release. */
    this.taken = new Set();
    /** @type {WeakSet<Document>} */
    this.attached = new WeakSet();
    this.attach(window);
  }

  /**
   * Listen inside a same-origin frame too, through all its reloads.
   * @param {HTMLIFrameElement} frame
   */
  attachFrame(frame) {
    const attach = () => frame.contentWindow && this.attach(frame.contentWindow);
    frame.addEventListener("load", attach);
    attach();
  }

  /** @param {Window} target */
  attach(target) {
    if (this.attached.has(target.document)) return;
    this.attached.add(target.document);
    const early = { capture: true };
    target.addEventListener("keydown", (event) => this.down(event), early);
    target.addEventListener("keyup", (event) => this.up(event), early);
    target.addEventListener("blur", () =>
      // Between page and frame the focus leaves one window before it reaches the other.
      setTimeout(() => document.hasFocus() || this.releaseAll()),
    );
    target.addEventListener("pagehide", () => this.releaseAll());
    target.document.addEventListener("visibilitychange", () => {
      if (target.document.hidden) this.releaseAll();
    });
  }

  /** @param {KeyboardEvent} event */
  down(event) {
    const target = event.composedPath()[0];
    if (isField(target) || document.querySelector("dialog:modal")) return;
    const meaning = this.meaning(event, isPressable(target));
    if (meaning === null) return;
    event.stopImmediatePropagation();
    event.preventDefault();
    this.taken.add(event.code);
    if (event.repeat && !(meaning.kind === "command" && meaning.repeats)) return;
    if (meaning.kind === "command") this.command(meaning.name);
    if (meaning.kind === "signal") this.signal(meaning.name);
    if (meaning.kind === "press") press(meaning.control);
    if (meaning.kind === "hold" && !this.held.has(event.code)) {
      this.held.add(event.code);
      this.tell([...this.held], timeOf(event));
    }
  }

  /** @param {KeyboardEvent} event */
  up(event) {
    if (!this.taken.delete(event.code)) return;
    event.stopImmediatePropagation();
    event.preventDefault();
    if (this.held.delete(event.code)) this.tell([...this.held], timeOf(event));
  }

  /** Nothing is held any more, whatever the keyboard says. */
  releaseAll() {
    this.held.clear();
    this.letGo();
  }
}

/**
 * Press it as a click does; the focus goes to what unfolds, so that the keyboard goes on there.
 * @param {HTMLElement} control
 */
function press(control) {
  if (control.tagName === "SUMMARY") {
    control.focus();
    control.scrollIntoView({ block: "nearest" });
  }
  control.click();
}

/**
 * Milliseconds since the epoch; every window counts from a start of its own.
 * @param {KeyboardEvent} event
 */
function timeOf(event) {
  return (event.view ?? window).performance.timeOrigin + event.timeStamp;
}
