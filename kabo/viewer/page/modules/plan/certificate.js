// What the certificate proves of a pair of bodies while a node moves: by how many axes and boxes, in which stretches.
import { make } from "kabo/elements.js";
import { length } from "kabo/margins.js";

export class CertificateList {
  /**
   * @param {object} plan the PlanView
   * @param {function(string[])} onPair called with the names of the chosen pair
   */
  constructor(plan, onPair) {
    this.plan = plan;
    this.onPair = onPair;
    this.pairs = [];
    this.summary = make("p");
    this.select = make("select", { id: "pair", onchange: () => this.chosenByHand() });
    this.label = make("label", { htmlFor: "pair" }, ["pair "]);
    this.chooser = make("p", {}, [this.label, this.select]);
    this.body = make("div");
    this.element = make("div", { className: "certificate" }, [this.summary, this.chooser, this.body]);
  }

  /** Shows the proofs of a node's motion. */
  show(node) {
    this.node = node;
    const { proofs, gaps } = this.plan;
    const stretches = proofs?.nodes[node.id] ?? [];
    this.chooser.hidden = stretches.length === 0;
    this.body.replaceChildren();
    if (!node.motion || !node.motion.segments.length) {
      this.summary.textContent = "This node moves nothing.";
    } else if (gaps.length) {
      this.summary.textContent = `The plan has no certificate: ${gaps[0]}${gaps.length > 1 ? `, and ${gaps.length - 1} more` : ""}.`;
    } else if (!proofs) {
      this.summary.textContent = "The plan has no certificate: kabo verify measures its motions.";
    } else {
      this.list(stretches);
    }
  }

  list(stretches) {
    const { things } = this.plan.proofs;
    const found = new Map();
    for (const stretch of stretches) {
      for (const [first, second, , walk] of stretch.pairs) {
        const key = `${things[first]} – ${things[second]}`;
        const proof = found.get(key) ?? { names: [things[first], things[second]], stretches: [] };
        proof.stretches.push({ ...stretch, walk });
        found.set(key, proof);
      }
    }
    const walks = stretches.flatMap((stretch) => stretch.pairs.map((pair) => pair[3])).join("");
    const { meshes, parts } = this.plan.proofs.bodies;
    this.summary.textContent = `${found.size} pairs proven apart over ${counted(stretches.length, "stretch", "stretches")}, by `
      + `${counted(count(walks, "ae"), "axis", "axes")} and ${counted(count(walks, "b"), "box", "boxes")}; about ${parts} convex parts `
      + `around ${meshes} meshes. Pairs farther apart than ${length(this.plan.near)} need no more than boxes.`;
    const before = this.select.value;
    this.pairs = [...found.values()];
    this.select.replaceChildren(...[...found.keys()].map((key, i) => make("option", { value: key, selected: i === 0 }, [key])));
    this.select.value = found.has(before) ? before : this.tightest() ?? this.select.value;
    this.showPair();
  }

  /** The pair of the least proven clearance of the node. */
  tightest() {
    const told = this.node.clearances.filter((each) => each.clearance !== null);
    const least = told.reduce((best, each) => (!best || each.clearance < best.clearance ? each : best), null);
    return least ? `${least.between[0]} – ${least.between[1]}` : null;
  }

  /** Chooses the first pair with these names (one or two), if the node has one. */
  choose(names) {
    const found = this.pairs.find((pair) => names.every((name) => pair.names.includes(name)));
    if (found) {
      this.select.value = found.names.join(" – ");
      this.showPair();
    }
  }

  chosenByHand() {
    this.showPair();
    this.onPair(this.pair?.names ?? []);
  }

  get pair() {
    return this.pairs.find((pair) => pair.names.join(" – ") === this.select.value);
  }

  showPair() {
    const head = make("tr", {}, ["segments", "time", "proof", "clearance"].map((text) => make("th", { scope: "col" }, [text])));
    const rows = (this.pair?.stretches ?? []).map((stretch) => make("tr", {}, [
      make("td", {}, [stretch.segments.join(", ")]), make("td", {}, [this.span(stretch.segments)]),
      make("td", {}, [proofText(stretch)]), make("td", {}, [this.clearance(stretch.segments)])]));
    this.body.replaceChildren(make("table", {}, [make("thead", {}, [head]), make("tbody", {}, rows)]));
  }

  span(segments) {
    const times = segments.map((i) => this.node.motion.segments[i].times);
    const from = Math.max(...times.map((each) => each[0]));
    return `${from.toFixed(1)}–${Math.min(...times.map((each) => each.at(-1))).toFixed(1)} s`;
  }

  /** The clearance that is told of these segments, if it is this pair's; else it is larger, by an amount not told. */
  clearance(segments) {
    const { names } = this.pair;
    const told = this.node.clearances.filter((each) => segments.includes(each.segment) && each.clearance !== null);
    const own = told.find((each) => names.every((name) => each.between.includes(name)));
    return own ? length(own.clearance) : told.length ? `≥ ${length(Math.min(...told.map((each) => each.clearance)))}` : `≥ ${length(this.plan.near)}`;
  }
}

/** A walk in words: how the path and the parts were halved, and by what they are apart. */
function proofText({ walk, before }) {
  const parts = [[count(walk, "b"), "box", "boxes"], [count(walk, "ae"), "axis", "axes"]];
  const by = parts.filter(([number]) => number).map(([number, one, many]) => counted(number, one, many)).join(", ");
  const halved = [[count(walk, "t"), "path"], [count(walk, "fs"), "parts"]].filter(([number]) => number);
  const how = halved.map(([number, what]) => `${what} halved ${number}×`).join(", ");
  return `${by}${how ? `; ${how}` : ""}${before.length ? "; at any times, as the motions overlap" : ""}`;
}

function count(walk, letters) {
  return [...walk].filter((letter) => letters.includes(letter)).length;
}

function counted(number, one, many) {
  return `${number} ${number === 1 ? one : many}`;
}
