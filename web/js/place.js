/** Where one was: kept by scene, so that a page or a studio started anew goes on there. */

/**
 * @typedef {{session: number | null, options: Record<string, number>, policy: string | null,
 *   others: string | null, camera: string, take: number | null, seconds: number}} Place
 */

/** @param {string} scene */
const kept = (scene) => `evastudio.place.${scene}`;

/** Where one was in that scene, or null. @param {string} scene @returns {Partial<Place> | null} */
export const placeIn = (scene) => JSON.parse(localStorage.getItem(kept(scene)) ?? "null");

/**
 * What was chosen in the scene, as far as it still has that.
 * @param {import("./types.js").Scene} scene
 */
export function choicesIn({ name, options }) {
  const { policy = null, others = null, options: were = {} } = placeIn(name) ?? {};
  const good = options.filter((one) => were[one.name] >= one.low && were[one.name] <= one.high);
  return { policy, others, options: Object.fromEntries(good.map((one) => [one.name, were[one.name]])) };
}

/**
 * Keep where one is from now on.
 * @param {import("./store.js").Store} store
 */
export function keepPlace(store) {
  let last = "";
  store.watch(({ scene, status, session, options, policy, others }) => {
    if (scene === null || status === null) return;
    const looking = status.mode === "review" && status.take !== null;
    /** @type {Place} */
    const place = {
      session,
      options,
      policy,
      others,
      camera: status.camera,
      take: looking ? status.take : null,
      seconds: looking && !status.speed ? (status.position_s ?? 0) : 0,
    };
    const words = JSON.stringify(place);
    if (words === last) return;
    last = words;
    localStorage.setItem(kept(scene.name), words);
  });
}

/**
 * Go back to where one was, on a stage that is new.
 * @param {Partial<Place>} place
 * @param {import("./types.js").Status} status of the new stage
 * @param {(name: string, more: object) => void} command
 */
export function goBack({ camera, take, seconds }, status, command) {
  if (camera && camera !== status.camera && status.cameras.includes(camera)) {
    command("camera", { camera });
  }
  if (take != null) command("review", { take, seconds });
}
