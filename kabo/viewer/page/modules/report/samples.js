// Samples: refused attempts as states, shown one at a time, with a dot for each where its hand is, coloured by reason.
import { BufferAttribute, BufferGeometry, Color, Points, PointsMaterial } from "three";
import { make } from "kabo/elements.js";
import { scenePoses } from "kabo/kinematics.js";

/** The colours of reasons: between dark and light, so that they are seen on both; the word always stands beside them. */
const COLOURS = {
  collision: "#d2483c", out_of_reach: "#2f7de1", constraint: "#9a63d1", no_path: "#c98208", empty_family: "#2f9e8f",
  hidden: "#c2559b", out_of_view: "#6f8a2c",
};
const OTHER = "#7d8590";

/** The colour of a reason. */
export function colourOf(reason) {
  return COLOURS[reason] ?? OTHER;
}

/** A square of a reason's colour, to stand beside its name. */
export function swatch(reason) {
  const made = make("span", { className: "swatch", "aria-hidden": "true" });
  made.style.background = colourOf(reason);
  return made;
}

/** The whole state of a scene in which some things are elsewhere than at its start. */
export function wholeState(view, change) {
  const robots = { ...view.start.robots };
  for (const [name, values] of Object.entries(change.robots ?? {})) {
    robots[name] = { ...robots[name], ...values };
  }
  return { robots, objects: { ...view.start.objects, ...change.objects } };
}

export class Samples {
  /** @param {object|null} stage @param {object|null} view the SceneView */
  constructor(stage, view) {
    Object.assign(this, { stage, view, marked: [], button: null, before: () => {},
      looked: new Set() });
  }

  /**
   * A button that shows a sample.
   * @param {{reason: string, state: object, between: string[]|null}} sample
   * @param {string} text what stands on it
   * @param {string} told what a reader hears
   */
  toggle(sample, text, told) {
    const button = make("button", { type: "button", className: "sample", "aria-pressed": "false", "aria-label": told,
      title: told, onclick: () => this.show(sample, button) }, [swatch(sample.reason), text]);
    return button;
  }

  /** Shows a sample at its pose, with the pair that came too close. */
  show(sample, button = null) {
    this.before();
    this.unmark();
    this.stage.setState(wholeState(this.view, sample.state));
    this.mark(sample.between ?? [], "bad");
    if (button) {
      button.setAttribute("aria-pressed", "true");
      this.button = button;
    }
  }

  /** Turns the camera to some things, unless it has been turned for this `what` before. */
  lookOnce(what, names) {
    if (!this.looked.has(what)) {
      this.looked.add(what);
      this.stage.look([...new Set(names)]);
    }
  }

  /** Highlights things until something else is shown. */
  mark(names, kind) {
    if (names.length) {
      this.marked.push(...names);
      this.stage.highlight(names, kind);
    }
  }

  /** Shows nothing any more as highlighted or chosen. */
  unmark() {
    if (this.marked.length) {
      this.stage.highlight(this.marked, null);
    }
    this.marked = [];
    this.button?.setAttribute("aria-pressed", "false");
    this.button = null;
  }

  /** Shows a dot for each sample, where the hand of its robot is. */
  cloud(samples) {
    const at = samples.map((sample) => ({ sample, point: this.handAt(sample) })).filter((each) => each.point);
    if (!at.length) {
      this.stage.overlay("samples", null);
      return;
    }
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", new BufferAttribute(Float32Array.from(at.flatMap((each) => each.point)), 3));
    const colours = at.flatMap((each) => new Color(colourOf(each.sample.reason)).toArray());
    geometry.setAttribute("color", new BufferAttribute(Float32Array.from(colours), 3));
    const dots = new Points(geometry, new PointsMaterial({ size: 9, sizeAttenuation: false, vertexColors: true,
      depthTest: false }));
    dots.renderOrder = 2;
    this.stage.overlay("samples", dots);
  }

  /** Where the hand of the robot of a sample is; null if no robot moved for it. */
  handAt(sample) {
    const poses = scenePoses(this.view, wholeState(this.view, sample.state));
    const robot = this.view.robots.find((each) => each.name in (sample.state.robots ?? {}));
    if (!robot) {
      return null;
    }
    const link = robot.tool?.frame ?? robot.links[robot.links.length - 1].name;
    const pose = poses.get(`${robot.name}.${link}`);
    return pose ? [pose[3], pose[7], pose[11]] : null;
  }
}

/** The reasons among samples with their colours and words, as a line. */
export function legend(reasons) {
  return make("p", { className: "legend" }, reasons.map(([reason, words, count]) => make("span", {}, [
    swatch(reason), `${words} ${count}`])));
}
