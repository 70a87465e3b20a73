// The time line: play, step, speed, and a slider over the nodes of the chosen branch.
import { make } from "kabo/elements.js";

const SPEEDS = [0.1, 0.25, 0.5, 1, 2, 4, 8];

export class TimeLine {
  /**
   * @param {import("./player.js").Player} player
   * @param {function(object): string} nameOf the name of a step
   */
  constructor(player, nameOf) {
    this.player = player;
    this.nameOf = nameOf;
    const button = (text, title, f) => make("button", { type: "button", title, "aria-label": title, onclick: f }, [text]);
    this.playButton = button("▶", "play or pause (space)", () => player.toggle());
    this.slider = make("input", { type: "range", min: 0, step: "any", value: 0, "aria-label": "time on the branch",
      oninput: () => { player.playing = false; player.scrub(Number(this.slider.value)); } });
    this.strip = make("div", { className: "strip", "aria-hidden": "true" });
    this.speeds = make("select", { "aria-label": "speed", onchange: () => player.setSpeed(Number(this.speeds.value)) },
      SPEEDS.map((speed) => make("option", { value: speed, selected: speed === 1 }, [`${speed} ×`])));
    this.told = make("output", { className: "told", "aria-live": "off" });
    this.element = make("div", { className: "time" }, [
      button("|◀", "node before (←)", () => player.go(-1)), this.playButton, button("▶|", "next node (→)", () => player.go(1)),
      make("div", { className: "track" }, [this.strip, this.slider]), this.told, this.speeds]);
    player.onChange(() => this.show());
    this.show();
  }

  show() {
    const { player } = this;
    if (player.film !== this.film) {
      this.film = player.film;
      this.slider.max = this.film.duration;
      this.strip.replaceChildren(...this.film.steps.map((step) => this.block(step)));
    }
    this.slider.value = player.time;
    const text = `${player.time.toFixed(2)} / ${this.film.duration.toFixed(2)} s`;
    this.told.textContent = text;
    this.slider.setAttribute("aria-valuetext", `${text}, ${player.step ? this.nameOf(player.step) : ""}`);
    this.playButton.textContent = player.playing ? "❚❚" : "▶";
    this.speeds.value = String(player.speed);
    [...this.strip.children].forEach((block, number) => block.classList.toggle("now", number === player.number));
  }

  block(step) {
    const share = (time) => `${(100 * time) / Math.max(this.film.duration, 1e-9)}%`;
    const block = make("span", { className: step.length > 0 ? "block moves" : "block", title: this.nameOf(step) });
    block.style.left = share(step.begin);
    block.style.width = share(step.end - step.begin);
    return block;
  }

  /** The next faster (1) or slower (-1) speed. */
  faster(by) {
    const at = SPEEDS.indexOf(this.player.speed) + by;
    this.player.setSpeed(SPEEDS[Math.min(SPEEDS.length - 1, Math.max(0, at))]);
  }
}
