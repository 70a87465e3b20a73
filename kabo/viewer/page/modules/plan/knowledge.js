// What is known at a node of a plan: what its action adds and removes, what its outcome tells, and all that is known there.
import { make } from "kabo/elements.js";

const NAMES = {
  Kf: "known facts", Kw: "will know whether", Kv: "will know the value", Kx: "exactly one of", Kor: "at least one of",
  LCW: "local closed world",
};

export class KnowledgeList {
  /** @param {object|null} knowledge of the PlanView */
  constructor(knowledge) {
    this.knowledge = knowledge;
    this.element = make("div", { className: "knowledge" });
    this.open = false;
  }

  /** Shows what a node changes; `port` is the number of the outcome that the chosen branch takes. */
  show(node, port) {
    const known = this.knowledge?.nodes[node.id];
    if (!known) {
      this.element.replaceChildren(make("p", { className: "dim" }, ["What is known is not shown: the problem was not given, or the plan is not of it."]));
      return;
    }
    const outcome = node.outcomes[port]?.outcome;
    const told = outcome === undefined ? null : known.outcomes[outcome];
    const parts = [this.changes("+", "good", known.added), this.changes("−", "bad", known.removed),
      this.changes("+", "maybe", known.maybe_added, "on some ways"), this.changes("−", "maybe", known.maybe_removed, "on some ways")];
    const changed = known.added.length + known.removed.length + known.maybe_added.length + known.maybe_removed.length;
    if (told) {
      parts.push(make("h3", {}, [`if ${node.on} is ${outcome}`]), this.changes("+", "good", told.added),
        this.changes("−", "bad", told.removed), this.changes("+", "maybe", told.sometimes, "on some ways"));
    } else if (changed === 0) {
      parts.push(make("p", { className: "dim" }, [node.kind === "goal" ? "The goal is known to hold." : "Nothing changes."]));
    }
    this.element.replaceChildren(...parts.filter(Boolean), this.before(known), key([known, told ?? {}], this.knowledge.facts));
  }

  changes(sign, style, numbers, note = "") {
    if (!numbers.length) {
      return null;
    }
    const rows = numbers.map((number) => {
      const [database, text] = this.knowledge.facts[number];
      return make("li", { className: style }, [make("span", { className: "sign", "aria-hidden": "true" }, [sign]),
        make("abbr", { title: NAMES[database] }, [database]), make("code", {}, [text]),
        ...(note ? [make("span", { className: "dim" }, [note])] : [])]);
    });
    return make("ul", { className: "facts", "aria-label": sign === "+" ? "added" : "removed" }, rows);
  }

  /** All that is known before the node. */
  before(known) {
    const ways = known.ways === 1 ? "" : `; this node is reached in ${known.ways} states of knowledge${known.more ? " or more" : ""}`;
    const summary = make("summary", {}, [`${known.before.length} facts known before${ways}`]);
    const list = make("details", { open: this.open, ontoggle: () => { this.open = list.open; } }, [summary,
      this.changes("", "", known.before) ?? "", this.changes("", "maybe", known.sometimes, "on some ways only") ?? ""]);
    return list;
  }
}

/** What the abbreviations mean of the databases whose facts are told. */
function key(told, facts) {
  const numbers = told.flatMap((each) => Object.values(each).filter(Array.isArray).flat());
  const used = new Set(numbers.map((number) => facts[number][0]));
  const said = Object.entries(NAMES).filter(([database]) => used.has(database));
  return make("p", { className: "key" }, [said.map(([database, name]) => `${database}: ${name}`).join(" · ")]);
}
