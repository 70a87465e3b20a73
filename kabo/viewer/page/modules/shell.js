// The layout of the page: header, stage, panels in tabs, time line; keys with their help, and the theme.
import { make } from "kabo/elements.js";

const TITLES = {
  scene: "scene", problem: "problem", task: "task", plan: "plan", report: "report of a task", explanation: "explanation",
  run: "run of a plan",
};

/** Whether a key means something to what has the focus: letters to fields of text, arrows to sliders. */
function isOwn({ target, key }) {
  if (key === "Escape" || !target.closest) {
    return false;
  }
  if (target.closest("select, textarea, input[type=text], input[type=number], input[type=search]")) {
    return true;
  }
  if (key === " " || key === "Enter") {
    return target.closest("input, button, summary, a") !== null;
  }
  return key.length > 1 && target.closest("input") !== null;
}

export class Shell {
  /**
   * @param {HTMLElement} body
   * @param {{title: string, given: string, scene: object|null}} shown the view document
   */
  constructor(body, shown) {
    this.keys = new Map();
    this.notes = new Map();
    this.panels = new Map();
    this.themed = [];
    /** The panel that is shown at first, if it is not the first one. */
    this.first = null;
    this.canvas = make("canvas", { id: "stage", tabIndex: 0, role: "img", "aria-label": `3D view of ${shown.title}` });
    this.view = make("section", { className: "view", "aria-label": "3D view" }, [this.canvas]);
    this.tabs = make("div", { className: "tabs", role: "tablist", "aria-label": "Panels" });
    this.side = make("aside", { className: "side", "aria-label": "Panels" }, [this.tabs]);
    /** Where the time line goes; it is hidden while it is empty. */
    this.timeline = make("footer", { className: "timeline", "aria-label": "Time line" });
    /** Where buttons of the header go, before those of the shell. */
    this.tools = make("div", { className: "tools" });
    this.help = make("dialog", { className: "help", "aria-label": "Keys" });
    body.append(this.header(shown), make("main", { className: shown.scene === null ? "no-stage" : "" }, [this.view, this.side]),
      this.timeline, this.help);
    document.addEventListener("keydown", (event) => this.pressed(event));
    this.onKey("?", "show or hide these keys", () => this.toggleHelp());
    this.onKey("t", "dark or light", () => this.toggleTheme());
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.tellTheme());
  }

  header(shown) {
    const theme = make("button", { type: "button", title: "dark or light (t)", "aria-label": "Dark or light",
      onclick: () => this.toggleTheme() }, ["◐"]);
    const help = make("button", { type: "button", title: "keys (?)", "aria-label": "Keys",
      onclick: () => this.toggleHelp() }, ["?"]);
    const kind = make("span", { className: "kind" }, [TITLES[shown.given] ?? shown.given]);
    this.tools.append(theme, help);
    return make("header", {}, [make("h1", {}, [shown.title]), kind, this.tools]);
  }

  /** Leaves the stage out, and says why. */
  withoutStage(why) {
    this.view.parentElement.classList.add("no-stage");
    this.view.parentElement.before(make("p", { className: "told", role: "status" }, [why]));
  }

  /** Adds a panel with a tab; the first one is shown. */
  addPanel(id, title, element) {
    const tab = make("button", { type: "button", id: `tab-${id}`, role: "tab", "aria-controls": `panel-${id}`,
      onclick: () => this.choose(id), onkeydown: (event) => this.turned(event, id) }, [title]);
    const panel = make("section", { id: `panel-${id}`, className: "panel", role: "tabpanel", tabIndex: 0,
      "aria-labelledby": `tab-${id}` }, [element]);
    this.panels.set(id, { tab, panel });
    this.tabs.append(tab);
    this.side.append(panel);
    this.choose(this.chosen ?? id);
  }

  /** Shows the panel of this name. */
  choose(id) {
    this.chosen = id;
    for (const [name, { tab, panel }] of this.panels) {
      tab.setAttribute("aria-selected", String(name === id));
      tab.tabIndex = name === id ? 0 : -1;
      panel.hidden = name !== id;
    }
  }

  turned(event, id) {
    const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
    if (step !== undefined) {
      const names = [...this.panels.keys()];
      const next = names[(names.indexOf(id) + step + names.length) % names.length];
      this.choose(next);
      this.panels.get(next).tab.focus();
      event.stopPropagation();
      event.preventDefault();
    }
  }

  /**
   * Calls `f` when a key is pressed outside of text fields; `what` stands in the help.
   * @param {string} key as in KeyboardEvent.key; `" "` for the space bar
   */
  onKey(key, what, f) {
    this.keys.set(key, { what, f });
  }

  /** Adds a line to the help that is about no key. */
  note(how, what) {
    this.notes.set(how, what);
  }

  pressed(event) {
    const known = this.keys.get(event.key);
    const inHelp = this.help.open && event.key !== "?"; // Escape closes it, arrows scroll it
    if (!known || inHelp || isOwn(event) || event.ctrlKey || event.metaKey || event.altKey) {
      return;
    }
    event.preventDefault();
    known.f(event);
  }

  toggleHelp() {
    if (this.help.open) {
      this.help.close();
      return;
    }
    const lines = [...[...this.keys].map(([key, { what }]) => [key === " " ? "space" : key, what]), ...this.notes];
    const rows = lines.map(([key, what]) => make("tr", {}, [
      make("th", { scope: "row" }, [make("kbd", {}, [key])]), make("td", {}, [what])]));
    const close = make("button", { type: "button", onclick: () => this.help.close() }, ["Close"]);
    this.help.replaceChildren(make("div", { className: "top" }, [make("h2", {}, ["Keys"]), close]), make("table", {}, rows));
    this.help.showModal();
  }

  get dark() {
    const chosen = document.documentElement.dataset.theme;
    return chosen ? chosen === "dark" : matchMedia("(prefers-color-scheme: dark)").matches;
  }

  toggleTheme() {
    document.documentElement.dataset.theme = this.dark ? "light" : "dark";
    this.tellTheme();
  }

  /** Calls `f` whenever dark and light change. */
  onTheme(f) {
    this.themed.push(f);
  }

  tellTheme() {
    this.themed.forEach((f) => f(this.dark));
  }

  /** Called when all panels are there. */
  begin() {
    this.timeline.hidden = this.timeline.childElementCount === 0;
    this.side.hidden = this.panels.size === 0;
    this.tabs.hidden = this.panels.size < 2;
    const first = this.first ?? this.panels.keys().next().value;
    if (first !== undefined) {
      this.choose(first);
    }
  }
}
