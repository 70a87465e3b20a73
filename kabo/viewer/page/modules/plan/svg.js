// Elements of drawings, made without any markup from data.

/**
 * A new element of a drawing.
 * @param {string} tag
 * @param {object} attributes functions `on…` are listeners
 * @param {(Node|string)[]} content
 */
export function svg(tag, attributes = {}, content = []) {
  const element = document.createElementNS("http://www.w3.org/2000/svg", tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith("on")) {
      element.addEventListener(name.slice(2), value);
    } else {
      element.setAttribute(name, value);
    }
  }
  element.append(...content);
  return element;
}
