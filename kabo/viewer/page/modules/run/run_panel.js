// The panel of a run: how far robots and bodies were from the plan, what was decided, and the true state on the stage.
import { make } from "kabo/elements.js";
import { Ghost } from "kabo/ghost.js";
import { MarginTable } from "kabo/margin_table.js";
import { length } from "kabo/margins.js";
import { RunChart } from "kabo/run_chart.js";
import { svg } from "kabo/svg.js";

const QUIET = ["state", "followed"]; // events that are no decision
const NEW_PLAN = "from here on by a plan of its own, whose graph is not shown beside";
const REDRAW = 200; // milliseconds between two drawings of a run that goes on

/** Adds the panel; of a run that goes on, it listens for more. */
export function show(shown, stage, shell) {
  const panel = new RunPanel(shown, stage);
  shell.addPanel("run", "Run", panel.element);
  shell.first = "run";
  window.kabo.run = panel;
  panel.begin();
}

class RunPanel {
  constructor(shown, stage) {
    Object.assign(this, { stage, shown, records: [...shown.run.records], live: shown.run.live });
    this.ghost = stage ? new Ghost(stage) : null;
    this.headline = make("p", { className: "headline", role: "status" });
    this.slider = make("input", { type: "range", min: 0, step: "any", value: 0, "aria-label": "time of the run",
      oninput: () => { this.newest.checked = false; this.go(Number(this.slider.value)); } });
    this.newest = make("input", { type: "checkbox", checked: this.live !== null });
    this.told = make("p", { className: "told" });
    this.tracking = new RunChart("Tracking error", (time) => this.pick(time));
    this.bodies = new RunChart("Bodies off their places", (time) => this.pick(time));
    this.strip = svg("svg", { viewBox: "0 0 400 14", class: "run-states", role: "img" });
    this.margins = new MarginTable();
    this.rows = make("tbody");
    const head = ["time", "state", "what"].map((text) => make("th", { scope: "col" }, [text]));
    this.element = make("div", { className: "run" }, [this.headline, this.slider,
      ...(this.live === null ? [] : [make("label", {}, [this.newest, " stay at the newest"])]), this.told,
      make("h2", {}, ["States"]), this.strip, make("h2", {}, ["Tracking error"]), this.tracking.drawing,
      make("h2", {}, ["Bodies off their places"]), this.bodies.drawing, legend(), this.margins.element,
      make("h2", {}, ["Decisions"]), make("div", { className: "wide", tabIndex: 0, role: "region", "aria-label": "decisions" },
        [make("table", {}, [make("thead", {}, [make("tr", {}, head)]), this.rows])])]);
  }

  begin() {
    this.plan = window.kabo.plan ?? null;
    window.kabo.player?.onChange(() => this.left());
    this.draw();
    this.go(this.records[0]?.time ?? 0);
    if (this.live !== null) {
      this.listen();
    }
  }

  listen() {
    const events = new EventSource(this.live);
    const on = (kind, f) => events.addEventListener(kind, (event) => f(JSON.parse(event.data)));
    on("records", ({ from, items }) => {
      this.records = [...this.records.slice(0, from), ...items];
      this.waiting ??= setTimeout(() => { this.waiting = null; this.grown(); }, REDRAW);
    });
    on("restart", () => { this.records = []; this.grown(); });
    on("fault", ({ text }) => { this.headline.textContent = text; });
    events.addEventListener("error", () => { this.told.textContent = "the connection is lost; kabo view may have ended"; });
  }

  grown() {
    const time = Number(this.slider.value);
    this.draw();
    this.go(this.newest.checked ? this.end : time);
  }

  get end() {
    return this.records.at(-1)?.time ?? 0;
  }

  // ----------------------------------------------------------------------------------------------------- drawings
  draw() {
    const last = this.records.at(-1);
    this.headline.textContent = !last ? "waiting for the first record" : last.event === "goal"
      ? `goal at ${last.node}` : last.event === "stopped" ? `stopped at ${last.node}: ${last.reason}` : "the run goes on";
    this.headline.dataset.state = last?.event ?? "waiting";
    this.slider.max = this.end;
    this.states = this.records.filter((each) => each.event === "state");
    this.tracking.show(this.measured((each) => each.tracking, (each) => each.permitted), this.end);
    this.bodies.show(this.measured((each) => Math.max(0, ...Object.values(each.displaced ?? each.bodies ?? {})),
      (each) => each.proven ?? each.permitted), this.end);
    this.drawStates();
    this.decisions = this.records.filter((each) => !QUIET.includes(each.event));
    this.rows.replaceChildren(...this.decisions.map((each) => this.row(each)));
  }

  /** Rows of a chart: of states, or of whole motions where states were not logged. */
  measured(of, permitted) {
    const from = this.states.length ? this.states : this.records.filter((each) => each.event === "followed");
    return from.map((each) => ({ time: each.time, value: of(each), permitted: permitted(each) ?? null }));
  }

  drawStates() {
    const entered = this.records.filter((each) => !QUIET.includes(each.event));
    const x = (time) => (400 * time) / Math.max(this.end, 1e-6);
    this.strip.replaceChildren(...entered.map((each, k) => svg("rect", { class: `in-${each.event}`, x: x(each.time), y: 0,
      width: Math.max(1, x(entered[k + 1]?.time ?? this.end) - x(each.time)), height: 14 },
    [svg("title", {}, [`${each.time.toFixed(2)} s: ${each.event}`])])));
    this.strip.setAttribute("aria-label", `states over time: ${[...new Set(entered.map((each) => each.event))].join(", ")}`);
  }

  row(record) {
    const button = make("button", { type: "button", onclick: () => this.pick(record.time) }, [`${record.time.toFixed(2)} s`]);
    return make("tr", { className: `of-${record.event}` },
      [make("td", {}, [button]), make("td", {}, [record.event]), make("td", {}, [wordsOf(record)])]);
  }

  // --------------------------------------------------------------------------------------------------------- times
  pick(time) {
    this.newest.checked = false;
    this.go(time);
  }

  /** Shows a time of the run: what was measured last by then, and where the plan has it. */
  go(time) {
    this.slider.value = time;
    this.tracking.point(time);
    this.bodies.point(time);
    const state = this.states.findLast((each) => each.time <= time + 1e-6) ?? this.states[0];
    const doing = this.decisions.findLast((each) => each.time <= time + 1e-6);
    // Nodes after an answer are those of another plan: what this page has as n0 says nothing of them.
    const answer = this.decisions.findLast((each) => each.event === "answer" && each.kind !== "none" && each.time <= time + 1e-6);
    this.told.textContent = `${time.toFixed(2)} s${doing ? `: ${doing.event} ${wordsOf(doing)}` : ""}${state
      ? `; ${length(state.tracking)} off the path, ${state.permitted === null ? "nothing moves" : `${length(state.permitted)} permitted`}` : ""}${answer ? `; after ${answer.kind} at ${answer.time.toFixed(2)} s` : ""}`;
    this.margins.show(state ?? null, this.decisions.findLast((each) => each.event === "node" && each.time <= time + 1e-6) ?? null);
    if (state && this.stage) {
      this.place(state, Boolean(answer));
    }
  }

  place(state, elsewhere) {
    const robots = this.configurations(state.robots);
    const objects = inWorld(state.bodies);
    this.moving = true;
    if (this.plan) {
      this.plan.truth = { robots, objects };
      if (!elsewhere) {
        this.plan.showRun(state.node, state.motion_time);
      }
    }
    this.moving = false;
    this.stage.setState({ robots, objects });
    const planned = state.planned ?? { robots: {}, bodies: {} }; // older logs do not tell where the plan has things
    this.ghost.show({ robots: { ...robots, ...this.configurations(planned.robots) },
      objects: { ...objects, ...inWorld(planned.bodies) } });
  }

  /** Joint values by name, of robots whose values a record lists. */
  configurations(listed) {
    return Object.fromEntries(this.shown.scene.robots.filter(({ name }) => listed[name]).map(({ name, values }) =>
      [name, Object.fromEntries(values.map((value, k) => [value.name, listed[name][k]]))]));
  }

  /** The plan's own time line was used: the stage is the plan's again. */
  left() {
    if (!this.moving && this.plan?.truth) {
      this.plan.truth = null;
      this.ghost?.show(null);
      this.stage?.setState(window.kabo.player.state);
    }
  }
}

/** Poses of bodies as those of objects of a state. */
function inWorld(poses) {
  return Object.fromEntries(Object.entries(poses).map(([name, pose]) => [name, { parent: "world", ...pose }]));
}

/** What a record says, in words. */
function wordsOf(record) {
  const { event } = record;
  if (event === "node") {
    const given = Object.entries(record.arguments ?? {}).map(([name, value]) => `${name}=${value}`).join(", ");
    return `${record.node} ${record.action ?? record.kind}${given ? `(${given})` : ""}`;
  }
  if (event === "sensing") {
    return `${record.formula ?? record.term} is ${record.outcome ?? record.value ?? "not measured"}`;
  }
  if (event === "answer") {
    return `${record.kind}: ${record.reason}${record.kind === "none" ? "" : ` (${NEW_PLAN})`}`;
  }
  if (event === "moving") {
    return `${record.nodes.join(", ")}, ${(record.end - record.begin).toFixed(2)} s`;
  }
  if (event === "gripping" || event === "releasing") {
    return `${record.robot}: ${record.bodies.join(", ")}`;
  }
  return record.reason ?? record.node ?? record.problem ?? "";
}

function legend() {
  const item = (colour, text) => {
    const line = make("i");
    line.style.borderColor = `var(--${colour})`;
    return make("span", {}, [line, text]);
  };
  return make("p", { className: "legend" }, [item("accent", "measured"), item("good", "proven to be free")]);
}
