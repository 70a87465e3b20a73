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

  /** Puts every label to its thing's place on the canvas; one that finds no room is hidden. */
  place(camera, canvas) {
    this.shown.forEach((label) => { label.width ??= label.element.offsetWidth || null; });
    for (const { label, at } of this.places(camera, canvas.clientWidth, canvas.clientHeight)) {
      label.element.style.visibility = at === null ? "hidden" : "visible";
      if (at !== null) {
        label.element.style.transform = `translate(${at.x.toFixed(1)}px, ${at.y.toFixed(1)}px)`;
      }
    }
  }

  /** Where each label stands in a picture of a width and height: above those before it; null without room. */
  places(camera, width, height) {
    const taken = [];
    return this.shown.map((label) => {
      const point = anchor(label.thing).project(camera);
      const seen = Math.abs(point.z) < 1 && Math.abs(point.x) < 1 && Math.abs(point.y) < 1;
      const x = (point.x + 1) / 2 * width - (label.width ?? 60) / 2;
      const y = (1 - point.y) / 2 * height - (label.thing.kind === "body" ? HEIGHT + 2 : HEIGHT / 2);
      const at = seen ? room(taken, x, y, label.width ?? 60) : null;
      if (at !== null) {
        taken.push(at);
      }
      return { label, at };
    });
  }

  /** Writes the labels into a picture that was drawn with the camera; `scale` is that of its letters. */
  write(context, camera, scale) {
    if (this.element.hidden) {
      return;
    }
    const { width, height } = context.canvas;
    context.font = `${12 * scale}px system-ui, sans-serif`;
    for (const { label, at } of this.places(camera, width / scale, height / scale)) {
      if (at !== null) {
        context.fillStyle = "#ffffffd0";
        context.fillRect(at.x * scale, at.y * scale, at.width * scale, (HEIGHT - 1) * scale);
        context.fillStyle = "#1b1f24";
        context.fillText(label.element.textContent, (at.x + 4) * scale, (at.y + 12.5) * scale);
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
