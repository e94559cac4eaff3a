/** Who looks at the page: what only authors can use is left out for viewers. */

import { api } from "./api.js";
import { attempt } from "./notices.js";

/** Mark the page of a viewer, so that its style leaves out what is `.author`'s. */
export function me() {
  attempt(async () => {
    const { role } = await api.me();
    document.body.classList.toggle("viewing", role === "viewer");
  });
}
