// Names of robots, regions and movable objects, as text over the canvas.
import { Vector3 } from "three";
import { make } from "kabo/elements.js";

const HEIGHT = 17; // of a label [pixels]
const ORDER = ["link", "body", "region"]; // whose names are placed first

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
      const first = thing.kind === "link" && !robots.has(thing.robotName) && thing.layers.get("original");
      if (first) {
        robots.add(thing.robotName);
        this.add(thing.robotName, "robot", thing);
      } else if (thing.kind === "region" || (thing.kind === "body" && thing.described.movable)) {
        this.add(thing.name, thing.kind, thing);
      }
    }
    this.shown.sort((a, b) => ORDER.indexOf(a.thing.kind) - ORDER.indexOf(b.thing.kind));
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

  /** Puts every label to its thing's place on the canvas, above those that are there; without room it is hidden. */
  place(camera, canvas) {
    const taken = [];
    for (const label of this.shown) {
      const point = anchor(label.thing).project(camera);
      const seen = Math.abs(point.z) < 1 && Math.abs(point.x) < 1 && Math.abs(point.y) < 1;
      label.width ??= label.element.offsetWidth || null;
      const x = (point.x + 1) / 2 * canvas.clientWidth - (label.width ?? 60) / 2;
      const y = (1 - point.y) / 2 * canvas.clientHeight - (label.thing.kind === "body" ? HEIGHT + 2 : HEIGHT / 2);
      const free = seen ? room(taken, x, y, label.width ?? 60) : null;
      label.element.style.visibility = free === null ? "hidden" : "visible";
      if (free !== null) {
        taken.push(free);
        label.element.style.transform = `translate(${x.toFixed(1)}px, ${free.y.toFixed(1)}px)`;
      }
    }
  }
}

/** The first free place at a point, or up to three lines above it; null if there is none. */
function room(taken, x, y, width) {
  for (let line = 0; line < 4; line += 1) {
    const own = { x, y: y - line * HEIGHT, width };
    const meets = taken.some((other) => own.x < other.x + other.width && other.x < own.x + own.width
      && Math.abs(own.y - other.y) < HEIGHT);
    if (!meets) {
      return own;
    }
  }
  return null;
}

/** Where the name of a thing stands: over a body, in the middle of a region, at the base of a robot. */
function anchor(thing) {
  if (thing.kind === "link") {
    return new Vector3().setFromMatrixPosition(thing.group.matrixWorld);
  }
  const box = thing.box();
  const point = box.getCenter(new Vector3());
  if (thing.kind === "body") {
    point.z = box.max.z;
  }
  return point;
}
