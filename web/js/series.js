/** Takes one after another: how many are wanted, how many are kept, and when the next begins. */

import { byId, say } from "./dom.js";
import { notify } from "./notices.js";
import { plural } from "./words.js";

const AUTOMATIC = "evastudio.automatic";
const REST = "evastudio.rest";
const USUAL = 10;

/** How many were wanted last; what a session without a number of its own begins with. */
const LATEST = "evastudio.wanted";

/** @param {number | null} session */
const wantedOf = (session) => `${LATEST}.${session}`;

/**
 * @param {import("./store.js").Store} store
 * @param {(wanted: number, automatic: boolean, seconds: number) => void} arrange
 */
export function series(store, arrange) {
  const wanted = byId("wanted", HTMLInputElement);
  const automatic = byId("automatic", HTMLInputElement);
  const rest = byId("rest", HTMLInputElement);
  const next = byId("next-take", HTMLElement);
  const left = byId("next-in", HTMLElement);
  automatic.checked = localStorage.getItem(AUTOMATIC) === "true";
  rest.value = localStorage.getItem(REST) ?? rest.value;

  const number = () => {
    const own = localStorage.getItem(wantedOf(store.state.session));
    return Number(own ?? localStorage.getItem(LATEST) ?? USUAL);
  };
  const tell = () => arrange(number(), automatic.checked, rest.valueAsNumber);

  wanted.addEventListener("change", () => {
    if (!wanted.value || !wanted.validity.valid) {
      wanted.valueAsNumber = number();
      return;
    }
    localStorage.setItem(LATEST, wanted.value);
    if (store.state.session !== null) localStorage.setItem(wantedOf(store.state.session), wanted.value);
    tell();
  });
  rest.addEventListener("change", () => {
    if (!rest.value || !rest.validity.valid) rest.value = localStorage.getItem(REST) ?? "3";
    localStorage.setItem(REST, rest.value);
    tell();
  });
  automatic.addEventListener("change", () => {
    localStorage.setItem(AUTOMATIC, String(automatic.checked));
    tell();
  });

  store.watch(({ session, status }, before) => {
    if (session !== before.session || !wanted.value) wanted.valueAsNumber = number();
    if (session !== before.session && status !== null) tell();
    const [kept, had] = [status, before.status].map((one) => one?.takes_kept ?? 0);
    const many = status?.wanted ?? Infinity;
    const same = status?.session?.id === before.status?.session?.id;
    if (same && before.status && had < many && kept >= many) {
      notify(`${plural(kept, "take")} kept, as many as you wanted. Clean them next.`);
    }
    next.hidden = (status?.next_s ?? null) === null;
    say(left, String(Math.max(1, Math.ceil(status?.next_s ?? 0))));
  });
  return {
    tell,
    toggle() {
      automatic.click();
      return automatic.checked;
    },
  };
}
