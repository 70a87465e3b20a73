// The panel of an explanation: why there is no plan, the samples of each refused call, and what one change would do.
import { make } from "kabo/elements.js";
import { Changes } from "kabo/scene_changes.js";
import { Samples, swatch } from "kabo/samples.js";
import { folded } from "kabo/tables.js";

/** Adds the panel of the document's explanation. */
export function show(shown, stage, shell) {
  const { explanation } = shown;
  const samples = stage ? new Samples(stage, shown.scene) : null;
  const place = make("div", { className: "explanation" },
    explanation.summary.map((sentence, k) => make("p", { className: k ? "" : "headline" }, [sentence])));
  place.append(...sentences("Parts of the goal that never hold", explanation.goals));
  place.append(...sentences("At the start", explanation.start));
  if (explanation.calls.length) {
    place.append(make("h2", {}, ["Procedures that failed"]), ...explanation.calls.map((each, k) => call(each, k, samples)));
  }
  if (explanation.changes.length) {
    const changes = stage ? new Changes(stage, shown.scene, samples) : null;
    place.append(make("h2", {}, ["What one change would do"]),
      make("ul", { className: "changes" }, explanation.changes.map((each) => change(each, changes))));
  }
  place.append(...sentences("Of no use, or never known", explanation.useless));
  place.append(...sentences("Not finished", explanation.unfinished));
  shell.addPanel("explanation", "Explanation", place);
  firstOf(place, explanation.calls)?.click();
}

/** The button of a sample that shows what matters most: of the first call, what it would pass without. */
function firstOf(place, calls) {
  const body = calls[0]?.without.find(([, count]) => count > 0)?.[0];
  const row = Math.max(0, calls[0]?.failures.findIndex((failure) => failure.between?.includes(body)) ?? 0);
  return place.querySelectorAll("details.call:first-of-type .failures > li")[row]?.querySelector("button.sample")
    ?? place.querySelector("button.sample");
}

function sentences(title, lines) {
  return lines.length ? [make("h2", {}, [title]), make("ul", {}, lines.map((line) => make("li", {}, [line])))] : [];
}

/** One refused call: its failures, each with buttons that show samples of it. */
function call(each, number, samples) {
  const title = [make("b", {}, [each.text]), " ",
    make("span", { className: "bad" }, [`${each.refused} of ${each.attempts} samples refused`])];
  const shown = each.samples.map((sample) => ({ ...sample, reason: each.failures[sample.failure].reason }));
  const content = () => [
    make("ul", { className: "failures" }, each.failures.map((failure, row) => make("li", {}, [
      swatch(failure.reason), `${failure.count} × ${failure.text} `,
      ...buttons(shown.filter((sample) => sample.failure === row), samples, each)]))),
    ...facts(each),
  ];
  const made = folded(title, content, { open: number === 0, className: "call" });
  if (samples && shown.length) {
    made.addEventListener("toggle", () => samples.cloud(made.open ? shown : []));
  }
  return made;
}

function buttons(chosen, samples, each) {
  return samples === null ? [] : chosen.map((sample, k) => {
    const button = samples.toggle(sample, String(k + 1), `show sample ${k + 1} of ${each.text}`);
    button.addEventListener("click", () => {
      samples.lookOnce(each, each.things);
      samples.mark(each.things.filter((name) => !(sample.between ?? []).includes(name)
        && !(sample.between ?? []).some((other) => other.startsWith(`${name}.`))), "chosen");
      samples.mark(sample.between ?? [], "bad");
    });
    return button;
  });
}

function facts(each) {
  const lines = [
    ...each.without.map(([body, count]) => `${count} of them pass without ${body}`),
    ...each.measures,
    ...(each.needed ? ["no plan does without this call"] : []),
  ];
  return lines.length ? [make("ul", { className: "facts" }, lines.map((line) => make("li", {}, [line])))] : [];
}

/** What one change would do; if it changes the scene, a button shows how. */
function change(each, changes) {
  const result = make("span", { className: each.solved ? "good" : "dim" }, [each.result]);
  if (changes === null || each.scene === null) {
    return make("li", {}, [`${each.text}: `, result]);
  }
  const button = make("button", { type: "button", "aria-pressed": "false",
    onclick: () => changes.toggle(each.scene, button) }, [each.text]);
  return make("li", {}, [button, ": ", result]);
}
