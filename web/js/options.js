/** Sliders and fields for the options of the scene; they hold for the next world. */

import { byId, make, say } from "./dom.js";

/** @typedef {import("./types.js").Option} Option */

/** Steps from which on a slider is too coarse for a hand, and a number is typed. */
const FINE = 2000;

/** @param {import("./store.js").Store} store */
export function options(store) {
  const box = byId("options", HTMLElement);
  let built = "";
  store.watch(({ scene, options: values }) => {
    if (scene === null) return;
    if (built !== scene.name) {
      built = scene.name;
      const [first, ...others] = scene.options.map((option) => control(option, store));
      const more = make("details", {}, make("summary", {}, "More of the world"), ...others);
      box.replaceChildren(...(first ? [first] : []), ...(others.length ? [more] : []));
    }
    for (const { name, default: usual, step } of scene.options) {
      const value = values[name] ?? usual;
      const digits = (String(step).split(".")[1] ?? "").length;
      const output = box.querySelector(`output[for="option-${name}"]`);
      if (output instanceof HTMLElement) say(output, value.toFixed(digits));
    }
  });
}

/**
 * @param {Option} option
 * @param {import("./store.js").Store} store
 */
function control(option, store) {
  const id = `option-${option.name}`;
  const typed = (option.high - option.low) / option.step > FINE;
  const input = make("input", {
    id,
    type: typed ? "number" : "range",
    min: String(option.low),
    max: String(option.high),
    step: String(option.step),
  });
  input.value = String(store.state.options[option.name] ?? option.default);
  input.addEventListener("input", () => {
    if (!input.value || !input.validity.valid) return;
    const options = { ...store.state.options, [option.name]: Number(input.value) };
    store.set({ options });
  });
  return make(
    "div",
    { class: "option", title: option.help },
    make("label", { for: id }, option.label),
    ...(typed ? [input] : [make("output", { for: id }), input]),
  );
}
