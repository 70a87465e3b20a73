// Elements of the page, made without any markup from data.

/**
 * A new element.
 * @param {string} tag
 * @param {object} properties properties of the element; names with a dash are attributes, functions `on…` are listeners
 * @param {(Node|string)[]} content
 */
export function make(tag, properties = {}, content = []) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(properties)) {
    if (name.startsWith("on")) {
      element.addEventListener(name.slice(2), value);
    } else if (name.includes("-") || name === "role") {
      element.setAttribute(name, value);
    } else {
      element[name] = value;
    }
  }
  element.append(...content);
  return element;
}
