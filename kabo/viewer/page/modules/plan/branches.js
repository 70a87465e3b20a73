// Ways through a plan: which outcome is taken at each branching, and the nodes that are met then.

export class Branches {
  /** @param {object} plan the PlanView */
  constructor(plan) {
    this.plan = plan;
    this.nodes = new Map(plan.nodes.map((node) => [node.id, node]));
    this.before = new Map(plan.nodes.map((node) => [node.id, []]));
    for (const node of plan.nodes) {
      this.successors(node).forEach((target, port) => this.before.get(target)?.push([node.id, port]));
    }
    this.choices = new Map();
    this.chooseLongest();
  }

  /** The ids of the nodes that follow a node, in the order of its outcomes. */
  successors(node) {
    return node.outcomes.length ? node.outcomes.map((each) => each.to) : node.next === null ? [] : [node.next];
  }

  /** At every branching the outcome with the longest motion behind it: there is most to see. */
  chooseLongest() {
    const longest = new Map();
    for (const node of [...this.plan.nodes].reverse()) { // in the document each is before its successors
      const behind = this.successors(node).map((target) => longest.get(target) ?? 0);
      const best = behind.reduce((at, value, k) => (value > behind[at] + 1e-9 ? k : at), 0);
      this.choices.set(node.id, best);
      longest.set(node.id, (node.motion?.duration ?? 0) + (behind[best] ?? 0));
    }
  }

  /** The chosen branch: the nodes from the root to a leaf, each with the number of the outcome that is taken. */
  get branch() {
    const met = [];
    for (let id = this.plan.root; id !== undefined;) {
      const node = this.nodes.get(id);
      if (!node || met.length > this.plan.nodes.length) {
        break;
      }
      const port = Math.min(this.choices.get(id) ?? 0, Math.max(0, this.successors(node).length - 1));
      met.push({ node, port });
      id = this.successors(node)[port];
    }
    return met;
  }

  /** The numbers of the outcomes that the chosen branch takes, in order. */
  get outcomes() {
    return this.branch.filter(({ node }) => node.outcomes.length).map(({ port }) => port);
  }

  /** Takes these outcomes, one after the other, from the root on. */
  follow(outcomes) {
    let id = this.plan.root;
    for (const outcome of [...outcomes]) {
      while (id !== undefined && this.nodes.get(id).outcomes.length === 0) {
        id = this.successors(this.nodes.get(id))[0];
      }
      if (id === undefined || outcome >= this.nodes.get(id).outcomes.length) {
        return;
      }
      this.choices.set(id, outcome);
      id = this.successors(this.nodes.get(id))[outcome];
    }
  }

  /** Leads the chosen branch through a node, and through one of its outcomes if one is named. */
  through(id, port = null) {
    if (port !== null) {
      this.choices.set(id, port);
    }
    const branch = new Set(this.branch.map(({ node }) => node.id));
    for (const [above, way] of this.wayTo(id, branch)) {
      this.choices.set(above, way);
    }
  }

  /** The branchings from the chosen branch down to a node: [node, outcome]; the nearest way back to the branch. */
  wayTo(id, branch) {
    const from = new Map([[id, null]]);
    const ahead = [id];
    for (const now of ahead) { // the list grows during the loop
      if (branch.has(now) && now !== id) {
        const way = [];
        for (let at = now; from.get(at); at = from.get(at)[0]) {
          way.push([at, from.get(at)[1]]);
        }
        return way;
      }
      if (now === id && branch.has(id)) {
        return [];
      }
      for (const [above, port] of this.before.get(now)) {
        if (!from.has(above)) {
          from.set(above, [now, port]);
          ahead.push(above);
        }
      }
    }
    return [];
  }

  /** The nodes that are not behind a folded one on all ways; `only` the chosen branch, if so asked. */
  visible(folded, only = false) {
    if (only) {
      return new Set(this.branch.map(({ node }) => node.id));
    }
    const seen = new Set([this.plan.root]);
    for (const id of seen) { // the set grows during the loop
      if (!folded.has(id)) {
        this.successors(this.nodes.get(id)).forEach((target) => seen.add(target));
      }
    }
    return seen;
  }
}
