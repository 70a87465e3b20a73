// Names of robots, regions and movable objects, as text over the canvas.
import { Vector3 } from "three";
import { make } from "kabo/elements.js";

export class Labels {
  /**
   * @param {HTMLElement} place the parent of the canvas
   * @param {Map<string, object>} things
   */
  constructor(place, things) {
    this.element = make("div", { className: "labels", "aria-hidden": "true" });
    this.shown = [];
    const robots = new Set();
    for (const thing of things.values()) {
      const first = thing.kind === "link" && !robots.has(thing.robot) && thing.layers.get("original");
      if (first) {
        robots.add(thing.robot);
        this.add(thing.robot, "robot", thing);
      } else if (thing.kind === "region" || (thing.kind === "body" && thing.described.movable)) {
        this.add(thing.name, thing.kind, thing);
      }
    }
    place.append(this.element);
  }

  add(text, kind, thing) {
    const element = make("span", { className: `label ${kind}` }, [text]);
    this.element.append(element);
    this.shown.push({ element, thing });
  }

  setVisible(visible) {
    this.element.hidden = !visible;
  }

  /** Puts every label to its thing's place on the canvas. */
  place(camera, canvas) {
    for (const { element, thing } of this.shown) {
      const point = new Vector3().setFromMatrixPosition(thing.group.matrixWorld).project(camera);
      const seen = Math.abs(point.z) < 1 && Math.abs(point.x) < 1 && Math.abs(point.y) < 1;
      element.hidden = !seen;
      if (seen) {
        const [x, y] = [(point.x + 1) / 2 * canvas.clientWidth, (1 - point.y) / 2 * canvas.clientHeight];
        element.style.transform = `translate(-50%, -50%) translate(${x.toFixed(1)}px, ${y.toFixed(1)}px)`;
      }
    }
  }
}
