// The panel of a live page: what the server is doing with the request, what it refuses, and when it has ended.
import { make } from "kabo/elements.js";
import { swatch } from "kabo/samples.js";

/** Adds the panel, and listens to the server of the page. */
export function show(shown, stage, shell) {
  const panel = new Live(shown, stage);
  shell.addPanel("live", "Live", panel.element);
  panel.listen();
}

class Live {
  constructor(shown, stage) {
    Object.assign(this, { live: shown.live, stage, marked: [], chosen: null });
    this.state = make("p", { className: "headline", role: "status" }, [`waiting for a request at ${shown.live.where}`]);
    this.doing = make("p", {});
    this.bar = make("progress", { max: 1, hidden: true, "aria-label": "share that is done" });
    this.counts = make("p", { className: "dim" });
    this.refused = make("div", { className: "refused" });
    this.details = make("ul", {});
    this.element = make("div", { className: "live" },
      [this.state, this.doing, this.bar, this.counts, this.refused, this.details]);
  }

  listen() {
    const events = new EventSource(this.live.events);
    const on = (kind, f) => events.addEventListener(kind, (event) => f(JSON.parse(event.data)));
    on("page", ({ version }) => {
      if (version !== this.live.version) {
        events.close();
        location.reload();
      }
    });
    on("state", (state) => this.told(state));
    on("progress", (progress) => this.progressed(progress));
    on("follow", (followed) => this.followed(followed));
    events.addEventListener("error", () => {
      this.state.textContent = "the connection is lost; kabo view may have ended";
      this.element.dataset.state = "lost";
    });
  }

  told({ text, details = [], done }) {
    this.state.textContent = text;
    this.element.dataset.state = done ? "done" : "running";
    this.details.replaceChildren(...details.map((line) => make("li", {}, [line])));
    if (done) {
      this.doing.textContent = "";
      this.bar.hidden = true;
    }
  }

  progressed({ doing, expanded, generated, procedure_calls: calls, fraction }) {
    if (this.element.dataset.state === "done") {
      return;
    }
    this.doing.textContent = `${doing} …`;
    this.bar.hidden = fraction === null;
    this.bar.value = fraction ?? 0;
    if (expanded || generated || calls) {
      this.counts.textContent = `${expanded} nodes expanded, ${generated} generated, ${calls} procedure calls`;
    }
  }

  /** Lists the calls that are refused so far, the pairs that came too close as buttons that show them. */
  followed({ answered = 0, refused = [] }) {
    const title = refused.length ? `Refused so far (${answered} calls have succeeded)` : "";
    this.refused.replaceChildren(...(title ? [make("h2", {}, [title])] : []),
      make("ul", { className: "failures" }, refused.map((each) => this.call(each))));
  }

  call({ call, reason, attempts, message, pairs }) {
    const buttons = pairs.map(([first, second, count]) => {
      const button = make("button", { type: "button", className: "sample", "aria-pressed": String(this.chosen === `${first}|${second}`),
        onclick: () => this.mark(first, second, button) }, [`${count} × ${first} and ${second}`]);
      button.disabled = this.stage === null;
      return button;
    });
    const times = attempts > 1 ? ` in ${attempts} attempts` : "";
    return make("li", {}, [swatch(reason), make("b", {}, [call]), `: ${reason.replaceAll("_", " ")}${times} `,
      ...(buttons.length ? buttons : [make("span", { className: "dim" }, [message])])]);
  }

  mark(first, second, button) {
    if (this.marked.length) {
      this.stage.highlight(this.marked, null);
    }
    this.element.querySelectorAll("button[aria-pressed=true]").forEach((each) => each.setAttribute("aria-pressed", "false"));
    const again = this.chosen === `${first}|${second}`;
    this.marked = again ? [] : [first, second];
    this.chosen = again ? null : `${first}|${second}`;
    button.setAttribute("aria-pressed", String(!again));
    if (this.marked.length) {
      this.stage.highlight(this.marked, "bad");
    }
  }
}
