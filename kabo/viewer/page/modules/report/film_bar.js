// The time line of a page that has films: which film, play and scrub, and what is done in it at each time.
import { make } from "kabo/elements.js";
import { Player, filmOf } from "kabo/player.js";
import { wholeState } from "kabo/samples.js";

const SPEEDS = [0.25, 0.5, 1, 2, 4];

/**
 * @typedef {{name: string, film: {start: object, segments: object[], handovers: object[], after: object},
 *   parts: {text: string, time: number}[]}} Titled
 */

export class FilmBar {
  /**
   * @param {object} shell @param {object} stage @param {object} view the SceneView
   * @param {Titled[]} films
   * @param {() => void} before called before a moment of a film is shown
   */
  constructor(shell, stage, view, films, before) {
    Object.assign(this, { stage, films, before, quiet: true });
    this.made = films.map(({ film, name }) => filmOf(wholeState(view, film.start), [{ id: name, ...film }]));
    this.player = new Player();
    this.player.onChange(() => this.changed());
    this.build(shell);
    this.load(0);
    this.quiet = false;
    shell.onKey(" ", "play or pause", () => this.player.toggle());
    shell.onKey("ArrowRight", "next part", () => this.go(1));
    shell.onKey("ArrowLeft", "part before", () => this.go(-1));
    shell.onKey(".", "a small step on", () => this.player.nudge(1));
    shell.onKey(",", "a small step back", () => this.player.nudge(-1));
  }

  build(shell) {
    const button = (text, label, f) => make("button", { type: "button", title: label, "aria-label": label, onclick: f }, [text]);
    this.choice = make("select", { "aria-label": "Solution", onchange: () => this.choose(Number(this.choice.value)) },
      this.films.map(({ name }, k) => make("option", { value: String(k) }, [name])));
    this.playing = button("▶", "play (space)", () => this.player.toggle());
    this.slider = make("input", { type: "range", min: "0", step: "any", "aria-label": "Time",
      oninput: () => { this.player.pause(); this.player.scrub(Number(this.slider.value)); } });
    const speed = make("select", { "aria-label": "Speed", onchange: () => this.player.setSpeed(Number(speed.value)) },
      SPEEDS.map((each) => make("option", { value: String(each), selected: each === 1 }, [`${each} ×`])));
    this.doing = make("span", { className: "doing" });
    this.clock = make("span", { className: "clock dim" });
    shell.timeline.append(make("div", { className: "films" }, [this.choice,
      button("|◀", "part before (left)", () => this.go(-1)), this.playing, button("▶|", "next part (right)", () => this.go(1)),
      this.slider, this.clock, speed, this.doing]));
  }

  load(number, time = 0) {
    this.number = number;
    this.choice.value = String(number);
    this.slider.max = String(this.made[number].duration);
    this.player.load(this.made[number], time);
  }

  /** Shows a film from a time on [s]; plays it if it is not to stand there. */
  choose(number, time = 0, play = false) {
    this.player.pause();
    this.load(number, time);
    if (play) {
      this.player.play();
    }
  }

  go(by) {
    const times = this.films[this.number].parts.map((part) => part.time);
    const { time } = this.player;
    const to = by > 0 ? times.find((each) => each > time + 1e-6) ?? this.player.film.duration
      : times.findLast((each) => each < time - 0.3) ?? 0;
    this.player.pause();
    this.player.scrub(to);
  }

  changed() {
    if (!this.quiet) {
      this.before();
      this.stage.setState(this.player.state);
    }
    const { time, film, playing } = this.player;
    this.slider.value = String(time);
    this.clock.textContent = `${time.toFixed(2)} / ${film.duration.toFixed(2)} s`;
    this.playing.textContent = playing ? "❚❚" : "▶";
    this.playing.setAttribute("aria-label", playing ? "pause (space)" : "play (space)");
    const part = this.films[this.number].parts.findLast((each) => each.time <= time + 1e-9);
    this.doing.textContent = part?.text ?? "";
  }
}
