/** A picture of the 3D view, as it is seen, handed to whoever looks at it. */

import { make } from "./dom.js";

/** @param {string} name of the file @param {string} address */
export function hand(name, address) {
  make("a", { download: name, href: address }).click();
}

/**
 * Hand out what the view shows now as a PNG file, of as many points as it is drawn with.
 * @param {HTMLIFrameElement} view
 * @param {string} name of the scene
 */
export async function screenshot(view, name) {
  const canvas = view.contentDocument?.querySelector("canvas[data-engine]");
  if (!canvas || !("toBlob" in canvas)) throw new Error("Nothing is drawn yet.");
  const drawn = /** @type {HTMLCanvasElement} */ (canvas);
  const picture = await new Promise((done) => drawn.toBlob(done, "image/png"));
  if (picture === null) throw new Error("The browser could not make a picture of the view.");
  const address = URL.createObjectURL(picture);
  const time = new Date().toISOString().slice(0, 19).replaceAll(":", "-");
  hand(`${name}-${time}.png`, address);
  setTimeout(() => URL.revokeObjectURL(address), 60_000);
}
