// A chart of a run: a deviation over time on a logarithmic scale, with what is proven to be permitted.
import { length } from "kabo/margins.js";
import { svg } from "kabo/svg.js";

const [WIDTH, HEIGHT] = [400, 104];
const [LEFT, RIGHT, TOP, BOTTOM] = [50, 14, 6, 18];
const [LOWEST, HIGHEST] = [1e-5, 0.5]; // metres
const TICKS = [1e-5, 1e-3, 1e-1];

export class RunChart {
  /**
   * @param {string} title
   * @param {function(number)} onTime what a click on a time does
   */
  constructor(title, onTime) {
    this.title = title;
    this.drawing = svg("svg", { viewBox: `0 0 ${WIDTH} ${HEIGHT}`, class: "margins run-chart", role: "img" });
    this.drawing.addEventListener("click", (event) => onTime(this.timeOf(event)));
  }

  /**
   * @param {{time: number, value: number, permitted: number|null}[]} rows
   * @param {number} end of the run [s]
   */
  show(rows, end) {
    this.end = Math.max(end, 1e-6);
    const line = (name, of) => svg("polyline", { class: name, points: rows.filter((row) => of(row) !== null)
      .map((row) => `${this.x(row.time).toFixed(1)},${this.y(of(row)).toFixed(1)}`).join(" ") });
    this.cursor = svg("line", { class: "cursor", y1: TOP, y2: HEIGHT - BOTTOM });
    this.drawing.replaceChildren(...this.axes(), line("permits", (row) => row.permitted),
      line("curve", (row) => row.value), this.cursor);
    const most = rows.reduce((found, row) => (row.value > (found?.value ?? -1) ? row : found), null);
    this.drawing.setAttribute("aria-label", most === null ? `${this.title}: nothing measured`
      : `${this.title} over time; at most ${length(most.value)} at ${most.time.toFixed(2)} s`);
  }

  x(time) {
    return LEFT + (Math.min(time, this.end) / this.end) * (WIDTH - LEFT - RIGHT);
  }

  y(value) {
    const share = Math.log(Math.min(HIGHEST, Math.max(LOWEST, value)) / LOWEST) / Math.log(HIGHEST / LOWEST);
    return HEIGHT - BOTTOM - share * (HEIGHT - TOP - BOTTOM);
  }

  axes() {
    const lines = TICKS.flatMap((tick) => [
      svg("line", { class: "grid", x1: LEFT, x2: WIDTH - RIGHT, y1: this.y(tick), y2: this.y(tick) }),
      svg("text", { class: "tick", x: LEFT - 4, y: this.y(tick) + 3.5, "text-anchor": "end" }, [length(tick)]),
    ]);
    const step = [1, 2, 5, 10, 20, 60, 300].find((each) => this.end / each <= 6) ?? this.end;
    for (let time = 0; time <= this.end + 1e-9; time += step) {
      lines.push(svg("text", { class: "tick", x: this.x(time), y: HEIGHT - 4, "text-anchor": time ? "middle" : "start" },
        [`${time} s`]));
    }
    return lines;
  }

  timeOf(event) {
    const frame = this.drawing.getBoundingClientRect();
    const x = ((event.clientX - frame.left) / frame.width) * WIDTH;
    return Math.min(this.end, Math.max(0, ((x - LEFT) / (WIDTH - LEFT - RIGHT)) * this.end));
  }

  /** Moves the cursor. */
  point(time) {
    this.cursor?.setAttribute("x1", this.x(time));
    this.cursor?.setAttribute("x2", this.x(time));
  }
}
