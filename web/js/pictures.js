/** The pictures of an evaluation, once they are drawn. */

import { byId, make, say } from "./dom.js";
import { jobOf } from "./needs.js";

/** @param {import("./store.js").Store<import("./types.js").Comparing>} store */
export function pictures(store) {
  store.watch((state, before) => {
    const { evaluation, pictures: drawn } = state;
    const none = !drawn?.items.length && !jobOf(state, "pictures");
    const says = drawn?.left_out ?? (evaluation && drawn && none ? "No pictures are drawn." : "");
    say(byId("pictures-say", HTMLElement), says);
    if (drawn === before.pictures) return;
    byId("pictures", HTMLElement).replaceChildren(
      ...(drawn?.items ?? []).map(({ name, title, svg, png }) =>
        make(
          "figure",
          { "data-picture": name },
          make(
            "figcaption",
            {},
            make("span", { class: "unseen" }, title),
            make("a", { href: svg, download: "", title: "Keep it as SVG", "aria-label": `${title}, SVG` }, "SVG"),
            make("a", { href: png, download: "", title: "Keep it as PNG", "aria-label": `${title}, PNG` }, "PNG"),
          ),
          make("img", { src: svg, alt: title }),
        ),
      ),
    );
  });
}
