// The graph of a plan: boxes for nodes, chips for outcomes, edges. Pan, zoom, choose, fold. Only what is in sight is in the
// document; where too many boxes are in sight for their text to be read, they are drawn as a few large paths.
import { make } from "kabo/elements.js";
import { squeezed } from "kabo/squeeze.js";
import { svg } from "kabo/svg.js";
import { boxElement } from "kabo/dag_box.js";

const MOST_BOXES = 260; // that are drawn one by one
const LARGEST = 2.5; // scale
const AROUND = 14; // pixels around the graph

export class Dag {
  /**
   * @param {object} plan the PlanView
   * @param {import("./branches.js").Branches} branches
   * @param {{choose: function(string), follow: function(string, number)}} on what clicks on a box and on a chip do
   */
  constructor(plan, branches, on) {
    this.plan = plan;
    this.branches = branches;
    this.on = on;
    this.folded = new Set();
    this.only = false;
    this.chosen = plan.root;
    this.view = { x: 0, y: 0, scale: 1 };
    this.elements = new Map();
    this.edgePaths = svg("g", { class: "edges" });
    this.boxGroup = svg("g", { class: "boxes" });
    this.world = svg("g", {}, [this.edgePaths, this.boxGroup]);
    this.drawing = svg("svg", { tabindex: 0, role: "img", class: "graph" }, [this.world]);
    this.element = make("div", { className: "dag" }, [this.drawing, this.buttons()]);
    this.arrange();
    this.listen();
  }

  buttons() {
    const button = (text, title, f) => make("button", { type: "button", title, "aria-label": title, onclick: f }, [text]);
    this.onlyButton = make("button", { type: "button", "aria-pressed": "false", title: "only the chosen branch (b)",
      onclick: () => this.toggleOnly() }, ["branch"]);
    return make("div", { className: "dag-tools" }, [
      button("−", "zoom out", () => this.zoom(1 / 1.4)), button("+", "zoom in", () => this.zoom(1.4)),
      button("⤢", "show the whole plan (0)", () => this.fit()), this.onlyButton,
    ]);
  }

  // ------------------------------------------------------------------------------------------------- what is there
  /** Places what is not hidden; empty columns and rows are taken out. */
  arrange() {
    const visible = this.branches.visible(this.folded, this.only);
    const nodes = this.plan.nodes.filter((node) => visible.has(node.id));
    const edges = this.plan.edges.filter((edge) => visible.has(edge.from) && visible.has(edge.to)
      && !this.folded.has(edge.from) && this.isDrawn(edge));
    const placed = squeezed({ boxes: nodes.map((node) => node.box), lines: edges.map((edge) => edge.points) });
    this.size = [placed.width, placed.height];
    this.boxes = new Map(nodes.map((node, i) => [node.id, { node, ...placed.boxes[i] }]));
    this.edges = edges.map((edge, i) => ({ ...edge, points: placed.lines[i] }));
    this.boxGroup.replaceChildren();
    this.elements.clear();
    this.marked();
  }

  isDrawn(edge) {
    return !this.only || this.branches.branch.some(({ node, port }) => node.id === edge.from && port === edge.port);
  }

  /** Marks the chosen branch anew. */
  marked() {
    const branch = this.branches.branch;
    this.onBranch = new Map(branch.map(({ node, port }) => [node.id, port]));
    const { outcomes } = this.branches;
    this.drawing.setAttribute("aria-label", `Plan of ${this.plan.problem}: ${this.plan.nodes.length} nodes, `
      + `${this.plan.branches} branches; chosen: ${this.chosen}, branch of ${branch.length} nodes, ${outcomes.length} outcomes`);
    for (const [id, element] of this.elements) {
      this.markBox(id, element);
    }
    this.draw(true);
  }

  markBox(id, element) {
    element.classList.toggle("on", this.onBranch.has(id));
    element.classList.toggle("chosen", id === this.chosen);
    element.querySelectorAll(".chip").forEach((chip, port) => chip.classList.toggle("on", this.onBranch.get(id) === port));
  }

  /** Shows a node as the present one; moves the graph if it is out of sight. */
  choose(id) {
    if (id === this.chosen) {
      return;
    }
    for (const name of [this.chosen, id]) {
      const element = this.elements.get(name);
      this.chosen = id;
      if (element) {
        this.markBox(name, element);
      }
    }
    this.bringIntoSight(id);
  }

  /** How much of the chosen node has been played, from 0 to 1. */
  progress(share) {
    const bar = this.elements.get(this.chosen)?.querySelector(".played");
    bar?.setAttribute("width", Math.max(0, Math.min(1, share)) * this.boxes.get(this.chosen).width);
  }

  toggleFold(id) {
    if (this.folded.has(id)) {
      this.folded.delete(id);
    } else if (this.branches.successors(this.branches.nodes.get(id)).length) {
      this.folded.add(id);
    }
    this.keepPlace(id, () => this.arrange());
  }

  toggleOnly() {
    this.only = !this.only;
    this.onlyButton.setAttribute("aria-pressed", String(this.only));
    this.keepPlace(this.chosen, () => this.arrange());
    this.fitIfSmall();
  }

  /** Arranges the graph anew while a box stays where it is on the screen. */
  keepPlace(id, f) {
    const before = this.boxes.get(id);
    f();
    const after = this.boxes.get(id);
    if (before && after) {
      this.view.x += (before.x - after.x) * this.view.scale;
      this.view.y += (before.y - after.y) * this.view.scale;
    }
    this.draw(true);
  }

  // -------------------------------------------------------------------------------------------------------- sight
  get frame() {
    return [this.drawing.clientWidth || 400, this.drawing.clientHeight || 300];
  }

  /** Shows the whole graph. */
  fit() {
    const [width, height] = this.frame;
    const scale = Math.min(1, (width - 2 * AROUND) / this.size[0], (height - 2 * AROUND) / this.size[1]);
    this.view = { scale, x: (width - this.size[0] * scale) / 2, y: AROUND };
    this.draw();
  }

  /** The first sight: the whole graph if it can be read, else its top. */
  fitFirst() {
    this.fit();
    if (this.view.scale < 0.55) {
      const scale = 0.8;
      const root = this.boxes.get(this.plan.root);
      this.view = { scale, x: this.frame[0] / 2 - (root.x + root.width / 2) * scale, y: AROUND };
      this.draw();
    }
  }

  fitIfSmall() {
    const [width, height] = this.frame;
    if (this.size[0] * this.view.scale < width && this.size[1] * this.view.scale < height) {
      this.fit();
    } else {
      this.bringIntoSight(this.chosen);
    }
  }

  zoom(factor, at = null) {
    const [width, height] = this.frame;
    const [x, y] = at ?? [width / 2, height / 2];
    const least = Math.min(0.2, (width / this.size[0]) * 0.8, (height / this.size[1]) * 0.8);
    const scale = Math.min(LARGEST, Math.max(least, this.view.scale * factor));
    const ratio = scale / this.view.scale;
    this.view = { scale, x: x - (x - this.view.x) * ratio, y: y - (y - this.view.y) * ratio };
    this.draw();
  }

  bringIntoSight(id) {
    const box = this.boxes.get(id);
    const [width, height] = this.frame;
    if (box) {
      const { x, y, scale } = this.view;
      const [left, top] = [box.x * scale + x, box.y * scale + y];
      const within = (low, size, all) => (low < 4 || low + size > all - 4 ? (all - size) / 2 - low : 0);
      this.view.x += within(left, box.width * scale, width);
      this.view.y += within(top, box.height * scale, height);
    }
    this.draw();
  }

  // ------------------------------------------------------------------------------------------------------ drawing
  /** Draws with the next frame. */
  draw(edges = false) {
    this.edgesChanged ||= edges;
    this.asked ??= requestAnimationFrame(() => this.drawNow());
  }

  drawNow() {
    cancelAnimationFrame(this.asked);
    this.asked = undefined;
    const { x, y, scale } = this.view;
    const [width, height] = this.frame;
    this.world.setAttribute("transform", `translate(${x.toFixed(2)} ${y.toFixed(2)}) scale(${scale.toFixed(4)})`);
    this.drawWithin({ left: -x / scale, top: -y / scale, right: (width - x) / scale, bottom: (height - y) / scale });
  }

  drawWithin(sight) {
    const seen = [...this.boxes.values()].filter((box) => box.x < sight.right && box.x + box.width > sight.left
      && box.y < sight.bottom && box.y + box.height > sight.top);
    const coarse = seen.length > MOST_BOXES;
    const wanted = new Set(coarse ? [] : seen.map((box) => box.node.id));
    for (const [id, element] of this.elements) {
      if (!wanted.has(id)) {
        element.remove();
        this.elements.delete(id);
      }
    }
    seen.filter((box) => wanted.has(box.node.id) && !this.elements.has(box.node.id)).forEach((box) => this.addBox(box));
    this.drawEdges(sight);
    this.drawCoarse(coarse ? seen : []);
  }

  addBox(box) {
    const element = boxElement(box, this.folded.has(box.node.id), this.on, (id) => this.toggleFold(id));
    this.markBox(box.node.id, element);
    this.elements.set(box.node.id, element);
    this.boxGroup.append(element);
  }

  /** All edges in sight as two paths: those of the chosen branch, and the others. */
  drawEdges(sight) {
    const [plain, on] = [[], []];
    for (const edge of this.edges) {
      const [first, last] = [edge.points[0], edge.points.at(-1)];
      if (first[1] < sight.bottom && last[1] > sight.top) {
        (this.onBranch.get(edge.from) === edge.port ? on : plain).push(edgePath(edge.points));
      }
    }
    this.edgePaths.replaceChildren(svg("path", { class: "edge", d: plain.join("") }),
      svg("path", { class: "edge on", d: on.join("") }));
  }

  /** Boxes without text, as one path for each kind. */
  drawCoarse(boxes) {
    this.coarse?.remove();
    this.coarse = null;
    if (boxes.length) {
      const paths = new Map();
      for (const box of boxes) {
        const kind = `${box.node.kind}${this.onBranch.has(box.node.id) ? " on" : ""}`;
        paths.set(kind, `${paths.get(kind) ?? ""}M${box.x} ${box.y}h${box.width}v${box.height}h${-box.width}z`);
      }
      this.coarse = svg("g", {}, [...paths].map(([kind, d]) => svg("path", { class: `box coarse ${kind}`, d })));
      this.world.append(this.coarse);
    }
  }

  // ------------------------------------------------------------------------------------------------------- events
  listen() {
    new ResizeObserver(() => this.resized()).observe(this.drawing);
    this.drawing.addEventListener("wheel", (event) => {
      event.preventDefault();
      const frame = this.drawing.getBoundingClientRect();
      this.zoom(Math.exp(-event.deltaY * 0.0015), [event.clientX - frame.left, event.clientY - frame.top]);
    }, { passive: false });
    let from = null;
    this.drawing.addEventListener("pointerdown", (event) => { from = { x: event.clientX, y: event.clientY, far: false }; });
    this.drawing.addEventListener("pointermove", (event) => {
      if (!from || !(event.buttons & 1)) {
        return;
      }
      const [dx, dy] = [event.clientX - from.x, event.clientY - from.y];
      if (from.far || Math.hypot(dx, dy) > 3) {
        this.view.x += dx;
        this.view.y += dy;
        from = { x: event.clientX, y: event.clientY, far: true };
        this.dragged = true;
        this.draw();
      }
    });
    this.drawing.addEventListener("click", (event) => {
      if (from?.far) {
        event.stopPropagation();
        event.preventDefault();
      } else {
        this.clickedCoarse(event);
      }
      from = null;
    }, true);
  }

  /** Where boxes are drawn as one path, a click finds its box by the place. */
  clickedCoarse(event) {
    if (this.coarse) {
      const frame = this.drawing.getBoundingClientRect();
      const x = (event.clientX - frame.left - this.view.x) / this.view.scale;
      const y = (event.clientY - frame.top - this.view.y) / this.view.scale;
      const hit = [...this.boxes.values()].find((box) => x >= box.x && x <= box.x + box.width && y >= box.y
        && y <= box.y + box.height);
      if (hit) {
        this.on.choose(hit.node.id);
      }
    }
  }

  resized() {
    if (!this.fitted && this.drawing.clientWidth) {
      this.fitted = true;
      this.fitFirst();
      this.bringIntoSight(this.chosen);
    }
    this.draw();
  }
}

/** The corners of an edge as a path. */
export function edgePath(points) {
  return points.map(([x, y], k) => `${k ? "L" : "M"}${x} ${y}`).join("");
}
