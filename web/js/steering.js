/** All that steers: keys, gamepad and pointer, how they feel, and how fast time goes meanwhile. */

import { feel } from "./feel.js";
import { GamepadHand } from "./gamepad.js";
import { GOOD_MS, Hands, moves, steers } from "./hands.js";
import { showHeld } from "./keyhelp.js";
import { Keys } from "./keys.js";
import { meaningOf } from "./meaning.js";
import { notify } from "./notices.js";
import { pace } from "./pace.js";
import { pad } from "./pad.js";
import { series } from "./series.js";
import { STUDIO } from "./shortcuts.js";
import { ViewStick } from "./viewstick.js";

/**
 * @param {import("./store.js").Store} store
 * @param {import("./link.js").Link} link
 * @param {HTMLIFrameElement} view
 * @param {{command: (name: string) => void, gamepad: (name: string) => void,
 *   signal: (name: string) => void, steers: (touched: boolean) => void}} act what keys and buttons
 *   stand for, and who is told whether a hand is on them
 * @returns {Record<string, () => unknown>} what it does itself, by the name of the command
 */
export function steering(store, link, view, act) {
  let sequence = 0;
  const hands = new Hands(
    () => store.state.scene,
    (held, pushed, timeMs) => {
      showHeld(held);
      const { status } = store.state;
      const touched = held.length > 0 || Object.keys(pushed).length > 0;
      act.steers(touched);
      // Who steers what plays takes over; where there is nowhere to record it yet, that is made first.
      if (touched && status?.mode === "play" && !status.session) link.command("take-over");
      const forMs = touched ? GOOD_MS : null;
      link.send({ type: "keys", held, pushed, time_ms: timeMs, seq: ++sequence, for_ms: forMs });
    },
  );
  const keys = new Keys(
    (event, onControl) => meaningOf(STUDIO, store.state, event, onControl),
    (held, timeMs) => hands.hold(held, timeMs),
    act.command,
    act.signal,
    () => hands.letGo(),
  );
  keys.attachFrame(view);
  const moving = () => moves(store.state.status);
  store.watch(({ status }, before) => {
    if (!moving()) keys.releaseAll();
    else if (status?.phase !== before.status?.phase) hands.again();
  });
  const taking = () => steers(store.state.status);
  const viewStick = new ViewStick(view, hands, taking);
  const feeling = feel({
    changed: ({ sensitivity, ramp, drag }) => {
      viewStick.on = drag;
      link.command("feel", { sensitivity, ramp });
    },
  });
  viewStick.on = feeling.now.drag;
  pad(store, hands, feeling.now, taking);
  const time = pace(store, (speed) => link.command("pace", { speed }));
  const takesFollow = series(store, (wanted, automatic, seconds) =>
    link.command("series", { wanted, automatic, seconds }),
  );
  new GamepadHand(hands, moving, act.gamepad, (name) => feeling.gamepad(name));

  link.addEventListener("lost", () => keys.releaseAll());
  // What this browser keeps of how one works, told to a stage that may be new.
  link.addEventListener("open", () => {
    const { sensitivity, ramp } = feeling.now;
    link.command("feel", { sensitivity, ramp });
    link.command("pace", { speed: time.chosen() });
    takesFollow.tell();
  });

  return {
    automatic: () => notify(takesFollow.toggle() ? "Takes follow one another." : "One take at a time."),
    drag: () => notify(feeling.toggle() ? "Drags in the view steer." : "Drags in the view turn the camera."),
    "slower-time": () => time.step(-1),
    "faster-time": () => time.step(1),
    /** What is still held is not meant for what plays on. */
    "hand-back": () => {
      keys.releaseAll();
      link.command("hand-back");
    },
  };
}
