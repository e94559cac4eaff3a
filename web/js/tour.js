/**
 * The tour: six steps, each of which waits until the person has really done it.
 *
 * It times itself: how long somebody was taught. That is kept, in the studio's own store, only where
 * they agreed to it beforehand and skipped nothing; else it is forgotten when the tour ends.
 */

import { api } from "./api.js";
import { byId, say } from "./dom.js";
import { session } from "./needs.js";
import { attempt } from "./notices.js";
import { around, placed } from "./tour_place.js";
import { STEPS, isNew, taught } from "./touring.js";
import { duration } from "./words.js";

/** @typedef {import("./types.js").State} State */
/** @typedef {{study: number, session: number, person: string, instructed_s: number}} Agreed */

/** Where the browser keeps that it has asked, and which study is theirs if they agreed. */
const ASKED = "evastudio.tour.asked";
const AGREED = "evastudio.tour.study";
/** A page that was away for longer was not read. */
const LONGEST_MS = 1000;

/**
 * @param {import("./store.js").Store} store
 * @returns {{toggle: () => void, steers: (touched: boolean) => void}}
 */
export function tour(store) {
  const card = byId("tour", HTMLElement);
  const ring = byId("tour-ring", HTMLElement);
  const title = byId("tour-title", HTMLElement);
  const says = byId("tour-says", HTMLElement);
  const live = byId("tour-live", HTMLElement);
  const form = byId("tour-consent", HTMLFormElement);
  const agrees = byId("tour-agrees", HTMLInputElement);
  const person = byId("tour-person", HTMLInputElement);
  const go = byId("tour-go", HTMLButtonElement);
  const end = byId("tour-end", HTMLButtonElement);
  const skip = byId("tour-skip", HTMLButtonElement);
  const forget = byId("tour-forget", HTMLButtonElement);
  const places = new CSSStyleSheet();
  document.adoptedStyleSheets = [...document.adoptedStyleSheets, places];

  /** @type {"closed" | "offered" | "on" | "over"} */
  let stands = "closed";
  let at = 0;
  let skipped = 0;
  /** Whether who takes the tour had made nothing here before. */
  let newcomer = false;
  /** Whether they were asked once; by itself the tour asks no more. */
  let offered = localStorage.getItem(ASKED) !== null;
  let taughtMs = 0;
  let lastFrame = 0;
  let told = "";
  let css = "";
  /** @type {import("./touring.js").Seen & {pairs: number, held: boolean}} */
  const seen = { steered: 0, pairs: 0, held: false };

  // -- what is seen ------------------------------------------------------------------------------

  /** @param {typeof stands} next */
  function stand(next) {
    stands = next;
    card.hidden = next === "closed";
    card.dataset.stands = next;
    ring.hidden = true;
    card.classList.remove("pointing");
    byId("tour-count", HTMLElement).hidden = next !== "on";
    form.hidden = next !== "offered" || !isNew(store.state);
    skip.hidden = next !== "on";
    forget.hidden = true;
    end.hidden = next === "over";
    go.hidden = next === "on";
    if (next === "closed") say(live, "");
  }

  /** @param {string} heading @param {(string | Node)[]} words */
  function tell(heading, words) {
    const text = words.map((one) => (typeof one === "string" ? one : (one.textContent ?? ""))).join("");
    if (told === heading + text) return;
    told = heading + text;
    say(title, heading);
    says.replaceChildren(...words);
    say(live, `${heading}. ${text}`);
  }

  function offer() {
    offered = true;
    stand("offered");
    say(go, "Show me");
    say(/** @type {HTMLElement} */ (end.firstElementChild), "No, thanks");
    tell("New here?", ["A tour of two minutes shows it: you steer a character, and it learns to go on alone."]);
  }

  function showStep() {
    const { title: heading, says: words } = STEPS[at];
    say(byId("tour-count", HTMLElement), `${at + 1} of ${STEPS.length}`);
    tell(heading, words(store.state));
  }

  /** @param {number} next */
  function come(next) {
    at = next;
    seen.steered = 0;
    if (at === STEPS.length) return over();
    showStep();
    const target = document.querySelector(STEPS[at].at);
    target?.scrollIntoView({ block: "nearest" });
    place();
    if (STEPS[at].presses && target instanceof HTMLElement && !types()) target.focus();
  }

  /** Whether somebody types outside of the tour. */
  function types() {
    const focused = document.activeElement;
    return !card.contains(focused) && /^(INPUT|SELECT|TEXTAREA)$/.test(focused?.tagName ?? "");
  }

  function place() {
    const target = stands === "on" ? around(document.querySelectorAll(STEPS[at].at)) : null;
    ring.hidden = target === null;
    card.classList.toggle("pointing", target !== null);
    if (target === null) return;
    const size = { width: card.offsetWidth, height: card.offsetHeight };
    const window = { width: innerWidth, height: innerHeight };
    const { side, x, y, arrow } = placed(target, size, window, STEPS[at].side);
    card.dataset.side = side;
    const { left, top, right, bottom } = target;
    const now = `#tour.pointing { left: ${x}px; top: ${y}px; --arrow: ${arrow}px; }
      #tour-ring { left: ${left}px; top: ${top}px; width: ${right - left}px; height: ${bottom - top}px; }`;
    if (now !== css) places.replaceSync((css = now));
  }

  // -- what happens ------------------------------------------------------------------------------

  function begin() {
    if (!form.hidden && !form.reportValidity()) return;
    stand("on");
    say(/** @type {HTMLElement} */ (end.firstElementChild), "End the tour");
    [newcomer, skipped, taughtMs, lastFrame] = [isNew(store.state), 0, 0, performance.now()];
    come(0);
    requestAnimationFrame(frame);
  }

  /** @param {number} now */
  function frame(now) {
    if (stands !== "on") return;
    const spent = Math.min(now - lastFrame, LONGEST_MS);
    lastFrame = now;
    if (taught(store.state)) taughtMs += spent;
    place();
    requestAnimationFrame(frame);
  }

  function over() {
    const id = store.state.session;
    const shown = session(store.state)?.seconds ?? 0;
    const times = `You were taught for ${duration(taughtMs / 1000)} and demonstrated for ${duration(shown)}.`;
    stand("over");
    say(go, "Close");
    go.focus();
    const onward = "More takes make it better: demonstrate, clean and fit again, as often as you like. ";
    tell("That is all", skipped ? [onward] : [onward, times]);
    if (!agrees.checked || skipped || !newcomer || id === null) return;
    attempt(async () => {
      const kept = { session: id, person: person.value.trim(), instructed_s: taughtMs / 1000 };
      const { id: study } = await api.keepStudy(kept);
      localStorage.setItem(AGREED, JSON.stringify({ study, ...kept }));
      tell("That is all", [onward, times, " Both are kept, as you agreed."]);
      forget.hidden = false;
    });
  }

  function close() {
    localStorage.setItem(ASKED, "yes");
    stand("closed");
  }

  function takeBack() {
    const agreed = ours();
    if (agreed === null) return;
    attempt(async () => {
      await api.forgetStudy(agreed.study);
      localStorage.removeItem(AGREED);
      forget.hidden = true;
      tell("That is all", ["Your times are forgotten."]);
    });
  }

  /** Demonstrating went on after the tour: how long is told anew. */
  function tellFurther() {
    const agreed = stands === "on" ? null : ours();
    if (agreed === null || agreed.session !== store.state.session) return;
    const { study, ...kept } = agreed;
    api.replaceStudy(study, kept).catch(() => localStorage.removeItem(AGREED)); // forgotten elsewhere
  }

  go.addEventListener("click", () => (stands === "offered" ? begin() : close()));
  form.addEventListener("submit", (event) => {
    event.preventDefault();
    begin();
  });
  end.addEventListener("click", close);
  forget.addEventListener("click", takeBack);
  skip.addEventListener("click", () => {
    skipped += 1;
    come(at + 1);
  });
  agrees.addEventListener("change", () => {
    byId("tour-who", HTMLElement).hidden = !agrees.checked;
    person.required = agrees.checked;
    if (agrees.checked) person.focus();
  });
  card.addEventListener("keydown", ({ key }) => key === "Escape" && close());

  store.watch((state, before) => {
    const { status } = state;
    const ready = state.connected && status?.phase === "ready";
    if (stands === "closed" && ready && isNew(state) && !offered) offer();
    if (stands === "offered" && status !== null && !ready) stand("closed");
    if (fitted(state) !== null && fitted(state) !== fitted(before)) tellFurther();
    if (stands !== "on") return;
    const pairs = status?.pairs ?? 0;
    if (status?.phase === "recording" && seen.held) seen.steered += Math.max(0, pairs - seen.pairs);
    seen.pairs = pairs;
    if (STEPS[at].done(state, seen)) come(at + 1);
    else showStep();
  });

  return {
    toggle: () => {
      if (stands === "offered") begin();
      else if (stands === "closed") {
        offer();
        go.focus();
      } else close();
    },
    steers: (touched) => {
      seen.held = touched;
    },
  };
}

/** When the policy of the present session was fitted, or null. @param {State} state */
function fitted(state) {
  const name = session(state)?.name;
  return state.policies.find((one) => !one.shipped && one.session === name && !one.stale)?.created ?? null;
}

/** @returns {Agreed | null} */
function ours() {
  const kept = localStorage.getItem(AGREED);
  return kept === null ? null : JSON.parse(kept);
}
