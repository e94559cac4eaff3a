/** The websocket to a stage: opened again whenever it is lost, on a new stage where need be. */

import { Refusal, api } from "./api.js";

/** @typedef {import("./types.js").Stage} Stage */

const FIRST_WAIT_MS = 400;
const LONGEST_WAIT_MS = 5000;

export class Link extends EventTarget {
  /** @param {() => Promise<Stage>} openStage opens the stage that the page wants */
  constructor(openStage) {
    super();
    this.openStage = openStage;
    /** @type {Stage | null} */
    this.stage = null;
    /** @type {WebSocket | null} */
    this.socket = null;
    this.wait = FIRST_WAIT_MS;
    this.timer = 0;
    this.attempt = 0;
  }

  get open() {
    return this.socket?.readyState === WebSocket.OPEN;
  }

  /** Connect, to a new stage when `fresh`. */
  async connect(fresh = false) {
    const attempt = ++this.attempt;
    clearTimeout(this.timer);
    if (fresh) this.stage = null;
    const former = this.socket;
    this.socket = null;
    former?.close();
    try {
      if (this.stage !== null) await api.stage(this.stage.id).catch(forgetIfGone(this));
      if (this.stage === null) {
        const stage = await this.openStage();
        if (attempt !== this.attempt) return;
        this.stage = stage;
        this.dispatchEvent(new CustomEvent("stage", { detail: stage }));
      }
    } catch (error) {
      if (attempt === this.attempt) this.lost(error instanceof Error ? error.message : "");
      return;
    }
    if (attempt !== this.attempt) return;
    const scheme = location.protocol === "https:" ? "wss:" : "ws:";
    const socket = new WebSocket(`${scheme}//${location.host}${this.stage.socket}`);
    this.socket = socket;
    socket.onopen = () => {
      this.wait = FIRST_WAIT_MS;
      this.dispatchEvent(new Event("open"));
    };
    socket.onmessage = (event) => {
      this.dispatchEvent(new CustomEvent("message", { detail: JSON.parse(event.data) }));
    };
    socket.onclose = () => {
      if (socket === this.socket) this.lost("");
    };
  }

  /** @param {string} why */
  lost(why) {
    this.socket = null;
    this.dispatchEvent(new CustomEvent("lost", { detail: why }));
    this.timer = setTimeout(() => this.connect(), this.wait);
    this.wait = Math.min(this.wait * 2, LONGEST_WAIT_MS);
  }

  /**
   * Whether it went out.
   * @param {object} message
   */
  send(message) {
    if (!this.open) return false;
    this.socket?.send(JSON.stringify(message));
    return true;
  }

  /**
   * @param {string} name
   * @param {object} [more]
   */
  command(name, more = {}) {
    return this.send({ type: "command", name, ...more });
  }
}

/** @param {Link} link */
function forgetIfGone(link) {
  return (/** @type {unknown} */ error) => {
    if (!(error instanceof Refusal) || error.status !== 404) throw error;
    link.stage = null;
  };
}
