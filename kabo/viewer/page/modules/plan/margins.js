// The margin over time: how far apart the nearest pair of bodies is while a node moves, with epsilon, what is proven of
// each segment, and where contacts are permitted. A logarithmic scale, for millimetres count and half a metre fits.
import { make } from "kabo/elements.js";
import { svg } from "kabo/svg.js";

const [WIDTH, HEIGHT] = [400, 128];
const [LEFT, RIGHT, TOP, BOTTOM] = [46, 8, 6, 26];
const [LOWEST, HIGHEST] = [1e-4, 0.5]; // metres
const TICKS = [1e-4, 1e-3, 1e-2, 1e-1];

/** A length in words: millimetres below a metre. */
export function length(metres) {
  return metres >= 1 ? `${metres.toFixed(2)} m` : `${Number((metres * 1000).toPrecision(3))} mm`;
}

export class MarginChart {
  /**
   * @param {object} plan the PlanView
   * @param {function(number)} onTime what a click on a time of the node does
   */
  constructor(plan, onTime) {
    this.plan = plan;
    this.drawing = svg("svg", { viewBox: `0 0 ${WIDTH} ${HEIGHT}`, class: "margins", role: "img" });
    this.told = make("p", { className: "told" });
    this.element = make("div", {}, [this.drawing, this.told]);
    this.drawing.addEventListener("pointermove", (event) => this.hovered(event));
    this.drawing.addEventListener("pointerleave", () => { this.hover = null; this.tell(); });
    this.drawing.addEventListener("click", (event) => onTime(this.timeOf(event)));
  }

  /** Shows the margins of a node; what moves nothing has none. */
  show(node) {
    this.node = node;
    this.rows = node.margin ?? [];
    this.end = Math.max(node.motion?.duration ?? 0, 1e-6);
    this.drawing.toggleAttribute("hidden", this.rows.length === 0);
    this.told.textContent = this.rows.length ? "" : this.why(node);
    this.drawing.setAttribute("aria-label", this.summary());
    this.drawing.replaceChildren(...this.axes(), ...this.permitted(), ...this.proven(), ...this.epsilon(), ...this.curve(),
      ...this.epsilonName());
    this.cursor = svg("line", { class: "cursor", y1: TOP, y2: HEIGHT - BOTTOM });
    this.dot = svg("circle", { class: "dot", r: 3 });
    this.drawing.append(this.cursor, this.dot);
  }

  /** Why a motion has no curve. */
  why(node) {
    const { unmeasured } = this.plan;
    if (!node.motion?.segments.length) {
      return "";
    }
    return unmeasured.length ? `Not measured: ${unmeasured.length} things, such as ${unmeasured[0]}, have no convex parts yet; `
      + "kabo view --prepare makes them." : "Not measured.";
  }

  summary() {
    const least = this.least;
    return least ? `Margin over time; least ${length(least[1])} at ${least[0].toFixed(2)} s: ${this.pairText(least)}` : "Margin over time";
  }

  /** The row with the least distance. */
  get least() {
    return this.rows.reduce((found, row) => (row[2] >= 0 && (!found || row[1] < found[1]) ? row : found), null);
  }

  pairText(row) {
    return row[2] < 0 ? "nothing is near" : this.plan.pairs[row[2]].join(" – ");
  }

  x(time) {
    return LEFT + (time / this.end) * (WIDTH - LEFT - RIGHT);
  }

  y(distance) {
    const share = Math.log(Math.min(HIGHEST, Math.max(LOWEST, distance)) / LOWEST) / Math.log(HIGHEST / LOWEST);
    return HEIGHT - BOTTOM - share * (HEIGHT - TOP - BOTTOM);
  }

  axes() {
    const lines = TICKS.flatMap((tick) => [
      svg("line", { class: "grid", x1: LEFT, x2: WIDTH - RIGHT, y1: this.y(tick), y2: this.y(tick) }),
      svg("text", { class: "tick", x: LEFT - 4, y: this.y(tick) + 3.5, "text-anchor": "end" }, [length(tick)]),
    ]);
    const step = [0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 60].find((each) => this.end / each <= 6) ?? this.end;
    for (let time = 0; time <= this.end + 1e-9; time += step) {
      lines.push(svg("text", { class: "tick", x: this.x(time), y: HEIGHT - 4, "text-anchor": time ? "middle" : "start" },
        [`${Number(time.toFixed(2))} s`]));
    }
    return lines;
  }

  /** Bars below the curve while a contact is permitted, with what grants it. */
  permitted() {
    return (this.node.motion?.segments ?? []).filter((segment) => segment.allowed.length).map((segment) => {
      const [from, to] = [this.x(segment.times[0]), this.x(segment.times.at(-1))];
      return svg("rect", { class: "permitted", x: from, width: Math.max(1, to - from), y: HEIGHT - BOTTOM + 3, height: 5 }, [
        svg("title", {}, [`may touch: ${segment.allowed.map((pair) => pair.join(" – ")).join(", ")}`])]);
    });
  }

  /** The proven clearance of every segment, where a pair comes near. */
  proven() {
    return this.node.clearances.filter((each) => each.clearance !== null).map((each) => {
      const { times } = this.node.motion.segments[each.segment];
      const y = this.y(each.clearance);
      return svg("line", { class: "proven", x1: this.x(times[0]), x2: this.x(times.at(-1)), y1: y, y2: y }, [
        svg("title", {}, [`proven: ${each.between.join(" – ")} stay ${length(each.clearance)} apart`])]);
    });
  }

  epsilon() {
    const { epsilon } = this.plan;
    return epsilon === null ? [] : [
      svg("line", { class: "epsilon", x1: LEFT, x2: WIDTH - RIGHT, y1: this.y(epsilon), y2: this.y(epsilon) }),
    ];
  }

  /** The name of the line of epsilon, to be drawn over the curve. */
  epsilonName() {
    const { epsilon } = this.plan;
    return epsilon === null ? [] : [svg("text", { class: "epsilon-name", x: WIDTH - RIGHT, y: this.y(epsilon) - 3,
      "text-anchor": "end" }, [`ε ${length(epsilon)}`])];
  }

  curve() {
    const points = this.rows.map(([time, distance]) => `${this.x(time).toFixed(1)},${this.y(distance).toFixed(1)}`);
    return [svg("polyline", { class: "curve", points: points.join(" ") })];
  }

  // -------------------------------------------------------------------------------------------------------- times
  /** The row that is next to a time. */
  at(time) {
    let [low, high] = [0, this.rows.length - 1];
    while (low < high) {
      const middle = (low + high) >> 1;
      [low, high] = this.rows[middle][0] < time ? [middle + 1, high] : [low, middle];
    }
    const before = this.rows[low - 1];
    return before && time - before[0] < this.rows[low][0] - time ? before : this.rows[low];
  }

  timeOf(event) {
    const frame = this.drawing.getBoundingClientRect();
    const x = ((event.clientX - frame.left) / frame.width) * WIDTH;
    return Math.min(this.end, Math.max(0, ((x - LEFT) / (WIDTH - LEFT - RIGHT)) * this.end));
  }

  hovered(event) {
    this.hover = this.rows.length ? this.at(this.timeOf(event)) : null;
    this.tell();
  }

  /** Moves the cursor to a time of the node. */
  play(time) {
    if (this.rows.length) {
      this.now = this.at(time);
      this.cursor.setAttribute("x1", this.x(time));
      this.cursor.setAttribute("x2", this.x(time));
      this.tell();
    }
  }

  /** Says which pair is nearest at the pointer, or now. */
  tell() {
    const row = this.hover ?? this.now;
    if (row && this.rows.length) {
      this.dot.setAttribute("cx", this.x(row[0]));
      this.dot.setAttribute("cy", this.y(row[1]));
      const far = row[2] < 0 ? `more than ${length(row[1])}` : length(row[1]);
      this.told.textContent = `${row[0].toFixed(2)} s: ${far}, ${this.pairText(row)}`;
    }
  }

  /** The pair that is nearest now: two names, or null. */
  get pairNow() {
    return this.rows.length && this.now && this.now[2] >= 0 ? this.plan.pairs[this.now[2]] : null;
  }
}
