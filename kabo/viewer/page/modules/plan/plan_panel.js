// The panel of a page's plan: the graph above, what happens at the present node below, and the player that moves both and
// the stage.
import { make } from "kabo/elements.js";
import { Branches } from "kabo/branches.js";
import { CertificateList } from "kabo/certificate.js";
import { Dag } from "kabo/dag.js";
import { callOf } from "kabo/dag_box.js";
import { printsFilm } from "kabo/film_strip.js";
import { KnowledgeList } from "kabo/knowledge.js";
import { MarginChart } from "kabo/margins.js";
import { readMoment, writeMoment } from "kabo/moment.js";
import { Player, filmOf } from "kabo/player.js";
import { Sweeps } from "kabo/sweeps.js";
import { TimeLine } from "kabo/timeline.js";

const CALM = 250; // milliseconds between two nodes whose details are shown
const WRITE_AFTER = 250; // milliseconds without a change until the link is written

/** Adds what the document has of the plan to the shell. */
export function show(shown, stage, shell, arrays) {
  const panel = new PlanPanel(shown.plan, stage, arrays);
  shell.addPanel("plan", "Plan", panel.element);
  shell.timeline.append(panel.timeline.element);
  panel.keys(shell);
  const { dag, branches, player } = panel;
  printsFilm({ plan: shown.plan, dag, branches, player, stage, unmark: () => panel.mark([]) });
  window.kabo.player = player;
  window.kabo.plan = panel;
  panel.begin();
}

class PlanPanel {
  constructor(plan, stage, arrays) {
    this.plan = plan;
    this.stage = stage;
    this.branches = new Branches(plan);
    this.player = new Player();
    this.timeline = new TimeLine(this.player, (step) => `${step.id}: ${callOf(this.branches.nodes.get(step.id))}`);
    this.dag = new Dag(plan, this.branches, {
      choose: (id) => this.goTo(id), follow: (id, port) => this.follow(id, port),
    });
    this.knowledge = new KnowledgeList(plan.knowledge);
    this.margins = new MarginChart(plan, (time) => this.scrubLocal(time));
    this.sweeps = new Sweeps(plan, stage, arrays);
    this.certificate = new CertificateList(plan, (names) => this.mark(names));
    this.element = make("div", { className: "plan" }, [this.dag.element, this.details()]);
    this.marked = [];
    /** What a run measured, to be shown in place of what is planned; null: what is planned is shown. */
    this.truth = null;
    this.player.onChange(() => this.moved());
    stage?.onPick((name) => this.picked(name));
  }

  details() {
    this.title = make("h2", {}, [""]);
    this.about = make("p", { className: "dim" });
    this.outcomes = make("div", { className: "outcomes" });
    this.marking = make("input", { type: "checkbox", checked: true, onchange: () => this.markNearest() });
    const nearest = make("label", {}, [this.marking, " mark the nearest pair ", make("i", { className: "mark", "aria-hidden": "true" })]);
    this.marginPart = section("Margin", true, [this.margins.element, legend(nearest, this.sweeps.element)]);
    this.proofPart = section("Certificate", false, [this.certificate.element]);
    const moves = this.plan.nodes.some((node) => node.motion?.segments.length);
    return make("div", { className: "node-details", tabIndex: 0, "aria-label": "the present node" }, [
      this.title, this.about, this.outcomes, ...(moves ? [this.marginPart] : []),
      section("Knowledge", true, [this.knowledge.element]), ...(moves ? [this.proofPart] : [])]);
  }

  /** Shows what the page's link names, else the beginning. */
  begin() {
    this.reload(0);
    this.readLink();
    addEventListener("hashchange", () => this.readLink());
    this.moved();
  }

  keys(shell) {
    const { player, timeline, dag } = this;
    shell.onKey(" ", "play or pause", () => player.toggle());
    shell.onKey("ArrowRight", "next node", () => player.go(1));
    shell.onKey("ArrowLeft", "this node's beginning, then the node before", () => player.go(-1));
    shell.onKey(".", "a moment on", () => player.nudge(1));
    shell.onKey(",", "a moment back", () => player.nudge(-1));
    shell.onKey("]", "faster", () => timeline.faster(1));
    shell.onKey("[", "slower", () => timeline.faster(-1));
    shell.onKey("Home", "to the beginning", () => player.scrub(0));
    shell.onKey("End", "to the end", () => player.scrub(player.film.duration));
    shell.onKey("o", "the next outcome at this node, or at the branching before it", () => this.otherOutcome());
    shell.onKey("w", "show or hide the swept volume", () => this.sweeps.element.hidden || this.sweeps.box.click());
    shell.onKey("b", "only the chosen branch, or all of the plan", () => dag.toggleOnly());
    shell.onKey("c", "hide or show what is behind this node", () => dag.toggleFold(dag.chosen));
    shell.onKey("+", "zoom into the plan", () => dag.zoom(1.4));
    shell.onKey("-", "zoom out of the plan", () => dag.zoom(1 / 1.4));
    shell.onKey("0", "show the whole plan", () => dag.fit());
  }

  // ----------------------------------------------------------------------------------------------------- branches
  /** Makes the film of the chosen branch, and shows a time of it. */
  reload(time) {
    this.branch = this.branches.branch;
    const steps = this.branch.map(({ node }) => ({ id: node.id, ...node.motion }));
    this.shownNode = null;
    this.shownAt = -CALM; // what is chosen by hand is shown at once
    this.player.load(filmOf(this.plan.start, steps), time);
    if (this.dag.only) {
      this.dag.arrange();
    } else {
      this.dag.marked();
    }
  }

  /** Leads the branch through a node, and shows the node's beginning, or a time [s] of it. */
  goTo(id, local = 0) {
    this.branches.through(id);
    this.reload(0);
    const step = this.player.film.steps.find((each) => each.id === id);
    this.player.playing = false;
    this.player.scrub((step?.begin ?? 0) + local);
  }

  /** Shows a moment of a run: so many seconds after a node began, or in nodes that overlap it. */
  showRun(id, local) {
    if (!this.branches.nodes.has(id)) {
      return;
    }
    if (!this.player.film.steps.some((each) => each.id === id)) {
      this.branches.through(id);
      this.reload(0);
    }
    this.player.playing = false;
    this.player.scrub(this.player.film.steps.find((each) => each.id === id).begin + local);
  }

  /** Takes an outcome; the time stays where it is, if the branch there is still the same. */
  follow(id, port) {
    const before = this.player.time;
    this.branches.through(id, port);
    this.reload(0);
    const step = this.player.film.steps.find((each) => each.id === id);
    this.player.scrub(Math.max(step.begin, Math.min(before, step.end - 1e-6)));
  }

  /** The next outcome of the present node, or of the last branching before it. */
  otherOutcome() {
    const upTo = this.branch.slice(0, this.player.number + 1).reverse();
    const at = upTo.find(({ node }) => node.outcomes.length > 1);
    if (at) {
      this.follow(at.node.id, (at.port + 1) % at.node.outcomes.length);
    }
  }

  scrubLocal(time) {
    this.player.playing = false;
    this.player.scrub(this.player.step.begin + time);
  }

  // ------------------------------------------------------------------------------------------------------ moments
  moved() {
    const { step, local, number } = this.player;
    if (!step) {
      return;
    }
    this.stage?.setState(this.truth ?? this.player.state);
    if (this.shownNode !== step.id) {
      this.showSoon(this.branch[number]);
    }
    if (this.shownNode === step.id) {
      this.margins.play(local);
      this.sweeps.show(this.branch[number].node, local);
      this.dag.progress(step.length > 0 ? local / step.length : 1);
      this.markNearest();
    }
    clearTimeout(this.writing);
    this.writing = setTimeout(() => this.writeLink(), WRITE_AFTER);
  }

  /** Shows a node at once, or soon if another has just been shown: where time runs through nodes, text is slow to draw. */
  showSoon(met) {
    const wait = (this.shownAt ?? -CALM) + CALM - performance.now();
    if (wait <= 0) {
      this.showNode(met);
    } else {
      this.waiting ??= setTimeout(() => { this.waiting = null; this.moved(); }, wait);
    }
  }

  showNode({ node, port }) {
    this.shownNode = node.id;
    this.shownAt = performance.now();
    this.dag.choose(node.id);
    this.title.replaceChildren(make("span", { className: "id" }, [node.id]), ` ${callOf(node)}`);
    this.about.textContent = this.words(node);
    this.outcomes.replaceChildren(...node.outcomes.map((each, k) => make("button", { type: "button",
      "aria-pressed": String(k === port), onclick: () => this.follow(node.id, k) }, [each.outcome])));
    this.outcomes.hidden = node.outcomes.length === 0;
    if (node.outcomes.length) {
      this.outcomes.prepend(make("span", {}, [`${node.on} is `]));
    }
    this.knowledge.show(node, port);
    this.margins.show(node);
    this.marginPart.hidden = !node.motion?.segments.length;
    this.proofPart.hidden = !node.motion?.segments.length;
    this.certificate.show(node);
  }

  /** What else is to be said of a node: its time, its segments, what it delivers, what was learned. */
  words(node) {
    const said = [];
    const { segments = [], duration = 0, overlap = 0 } = node.motion ?? {};
    if (segments.length) {
      const robots = [...new Set(segments.map((segment) => segment.robot))];
      said.push(`${robots.join(", ")}: ${segments.length} ${segments.length === 1 ? "segment" : "segments"}, ${duration.toFixed(2)} s`);
    }
    if (overlap) {
      said.push(`begins ${overlap.toFixed(2)} s before the node before has ended`);
    }
    if (node.delivers.length) {
      said.push(`delivers ${node.delivers.join(", ")}`);
    }
    for (const each of node.learned) {
      said.push(`learned ${Object.entries(each.parameters).map(([name, value]) => `${name} = ${Number(value.toPrecision(4))}`).join(", ")}`);
    }
    return said.join("; ");
  }

  // -------------------------------------------------------------------------------------------------------- marks
  markNearest() {
    const pair = this.marking.checked ? this.margins.pairNow : null;
    this.mark(pair ?? []);
  }

  mark(names) {
    if (this.stage && names.join() !== this.marked.join()) {
      if (this.marked.length) { // without names, all things would lose their marks
        this.stage.highlight(this.marked, null);
      }
      this.marked = [...names];
      if (names.length) {
        this.stage.highlight(this.marked, "good");
      }
    }
  }

  /** What is clicked on the stage: its proofs are shown. */
  picked(name) {
    if (name !== null && this.plan.proofs) {
      this.certificate.choose([name]);
    }
  }

  // -------------------------------------------------------------------------------------------------------- links
  readLink() {
    const moment = readMoment(location.hash);
    if (moment && location.hash !== this.written && this.branches.nodes.has(moment.node)) {
      if (moment.outcomes) {
        this.branches.follow(moment.outcomes);
      }
      this.goTo(moment.node, moment.time);
    }
  }

  writeLink() {
    if (this.player.playing || !this.player.step) {
      return;
    }
    this.written = writeMoment({ node: this.player.step.id, time: this.player.local, outcomes: this.branches.outcomes });
    try {
      history.replaceState(null, "", this.written);
    } catch { // a page within a notebook has no link of its own
    }
  }
}

function legend(...choices) {
  const names = [
    ["accent", "nearest pair", "the least distance of two bodies that may not touch, measured at these moments"],
    ["good", "proven", "what the certificate proves of the pair named there, all along its segment; the distance may be larger"],
    ["bad", "ε", "the accuracy that was asked for: what is farther apart is never refused"],
    ["warn", "may touch", "while a contact is permitted: that pair is left out of the curve"]];
  return make("p", { className: "legend" }, [...names.map(([colour, name, title]) => {
    const line = make("i");
    line.style.borderColor = `var(--${colour})`;
    return make("span", { title }, [line, name]);
  }), ...choices]);
}

function section(title, open, content) {
  return make("details", { open, className: "part" }, [make("summary", {}, [title]), ...content]);
}
