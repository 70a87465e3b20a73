// A table of a run: how far each body is from its place, beside what is proven to be free for the rest of the plan.
import { make } from "kabo/elements.js";
import { length } from "kabo/margins.js";

export class MarginTable {
  constructor() {
    this.rows = make("tbody");
    const head = ["body", "off", "proven, any way", "nearest"].map((text) => make("th", { scope: "col" }, [text]));
    this.element = make("div", { className: "wide", tabIndex: 0, role: "region", "aria-label": "margins of bodies", hidden: true },
      [make("table", {}, [make("thead", {}, [make("tr", {}, head)]), this.rows])]);
  }

  /** Shows a record of a state, if there is one, with the margins of the node that had begun. */
  show(state, node) {
    const off = state?.displaced ?? {};
    const margins = node?.margins ?? null;
    const share = (name) => off[name] / Math.max(margins?.[name]?.least ?? Infinity, 1e-9);
    const names = Object.keys(off).sort((a, b) => share(b) - share(a) || off[b] - off[a]);
    this.element.hidden = margins === null || !names.length;
    this.rows.replaceChildren(...names.map((name) => {
      const own = margins?.[name];
      const cells = [name, length(off[name]), own ? length(own.least) : "not limited", own?.other ?? ""];
      return make("tr", {}, cells.map((text) => make("td", {}, [text])));
    }));
  }
}
