/** Finding and making elements. */

/**
 * The element with that id, of that class.
 * @template {Element} T
 * @param {string} id
 * @param {new () => T} kind
 * @returns {T}
 */
export function byId(id, kind) {
  const found = document.getElementById(id);
  if (!(found instanceof kind)) throw new Error(`The page has no ${kind.name} #${id}.`);
  return found;
}

/**
 * @template {keyof HTMLElementTagNameMap} K
 * @param {K} tag
 * @param {Record<string, string>} [attributes]
 * @param {...(Node | string)} children
 * @returns {HTMLElementTagNameMap[K]}
 */
export function make(tag, attributes = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
  element.append(...children);
  return element;
}

/** What the browser calls the language of drawings: an address, of which no page here has any. */
const DRAWINGS = new DOMParser().parseFromString("<svg>", "text/html").body.firstElementChild?.namespaceURI;

/**
 * A part of a drawing.
 * @template {keyof SVGElementTagNameMap} K
 * @param {K} tag
 * @param {Record<string, string | number>} [attributes]
 * @param {...Element} children
 * @returns {SVGElementTagNameMap[K]}
 */
export function draw(tag, attributes = {}, ...children) {
  const element = /** @type {SVGElementTagNameMap[K]} */ (document.createElementNS(DRAWINGS ?? null, tag));
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, String(value));
  element.append(...children);
  return element;
}

/**
 * Set the text only where it differs, so that screen readers hear changes alone.
 * @param {HTMLElement} element
 * @param {string} text
 */
export function say(element, text) {
  if (element.textContent !== text) element.textContent = text;
}

/**
 * Say why a control does nothing now; what it does, where nothing is in its way.
 * @param {HTMLElement} control
 * @param {string | null} missing
 */
export function bar(control, missing) {
  control.setAttribute("aria-disabled", String(missing !== null));
  control.title = missing ?? control.dataset.tip ?? "";
}

/**
 * Fill a select, leaving it alone where nothing has changed (an open list would close).
 * @param {HTMLSelectElement} select
 * @param {{value: string, text: string, disabled?: boolean}[]} options
 * @param {string} value
 */
export function fill(select, options, value) {
  const key = JSON.stringify(options);
  if (select.dataset.key !== key) {
    select.dataset.key = key;
    select.replaceChildren(
      ...options.map(({ value: own, text, disabled }) => {
        const option = make("option", { value: own }, text);
        option.disabled = disabled ?? false;
        option.selected = own === value;
        return option;
      }),
    );
  }
  if (select.value !== value) select.value = value;
}
