// One box of the graph of a plan: its lines of text, a chip for each outcome, and the mark that folds what is behind it.
import { svg } from "kabo/svg.js";

export const MARK = 7; // pixels: radius of the mark
const LINE = 15; // as in kabo/viewer/content/plan/boxes.py
const CHIP = 16;

/**
 * @param {{node: object, x: number, y: number, width: number, height: number}} box
 * @param {boolean} folded
 * @param {{choose: function(string), follow: function(string, number)}|null} on
 * @param {function(string)|null} fold
 */
export function boxElement({ node, x, y, width, height }, folded, on, fold) {
  const { lines, chips } = node.box;
  const text = lines.map((line, k) => svg("text", { class: k ? "with" : "what", x: width / 2, y: 4 + LINE * (k + 0.78) }, [line]));
  const frame = svg("rect", { class: `box ${node.kind}`, width, height, rx: node.kind === "goal" ? height / 2 : 5 });
  const played = svg("rect", { class: "played", y: height - 3, width: 0, height: 3 });
  const parts = [svg("title", {}, [titleOf(node)]), frame, ...text, played];
  chips.forEach((chip, port) => parts.push(chipElement(node, chip, port, height - CHIP - 4, on)));
  if (fold && (node.next !== null || node.outcomes.length)) {
    parts.push(markElement(node.id, width, folded, fold));
  }
  const click = on ? { onclick: () => on.choose(node.id) } : {};
  return svg("g", { class: "node", "data-node": node.id, transform: `translate(${x} ${y})`, ...click }, parts);
}

function chipElement(node, chip, port, y, on) {
  const follow = on ? { onclick: (event) => { event.stopPropagation(); on.follow(node.id, port); } } : {};
  return svg("g", { class: "chip", "data-outcome": node.outcomes[port].outcome, transform: `translate(${chip.x} ${y})`, ...follow }, [
    svg("title", {}, [`follow ${node.on} = ${node.outcomes[port].outcome}`]),
    svg("rect", { width: chip.width, height: CHIP, rx: CHIP / 2 }),
    svg("text", { x: chip.width / 2, y: CHIP * 0.73 }, [chip.text]),
  ]);
}

function markElement(id, width, folded, fold) {
  const click = (event) => { event.stopPropagation(); fold(id); };
  return svg("g", { class: `mark${folded ? " folded" : ""}`, transform: `translate(${width} 0)`, onclick: click }, [
    svg("title", {}, [folded ? "show what is behind (c)" : "hide what is behind (c)"]),
    svg("circle", { r: MARK }), svg("path", { d: folded ? "M-4 0h8M0 -4v8" : "M-4 0h8" }),
  ]);
}

/** A node in words: its id, action and arguments. */
export function titleOf(node) {
  return `${node.id}: ${callOf(node)}`;
}

/** The action of a node with its arguments, as the plan's text has it. */
export function callOf(node) {
  if (node.kind === "branch") {
    return `branch on ${node.on}`;
  }
  if (node.action === null) {
    return node.kind;
  }
  return `${node.action}(${node.arguments.map(([name, value]) => `${name}=${value}`).join(", ")})`;
}
