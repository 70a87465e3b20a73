// The panel of a task's report: why it failed, its solutions with their motions, the tree of its stages with what they did.
import { make } from "kabo/elements.js";
import { FilmBar } from "kabo/film_bar.js";
import { Samples, legend, swatch } from "kabo/samples.js";
import { folded, table, told } from "kabo/tables.js";

/** Adds the panel of the document's report. */
export function show(shown, stage, shell) {
  const { report } = shown;
  const samples = stage ? new Samples(stage, shown.scene) : null;
  const films = stage ? filmsOf(report) : [];
  const bar = films.length ? new FilmBar(shell, stage, shown.scene, films, () => samples.unmark()) : null;
  if (samples) {
    samples.before = () => bar?.player.pause();
  }
  if (bar) {
    window.kabo.player = bar.player;
  }
  const place = make("div", { className: "report" }, [make("p", {}, [report.headline])]);
  if (report.given.length) {
    place.append(make("p", { className: "dim" }, [report.given.join(" · ")]));
  }
  for (const { seed, text } of report.whys) {
    place.append(make("h2", { className: "bad" }, [`No solution with seed ${seed}`]), make("pre", {}, [text]));
  }
  const { top, nodes } = tree(report.stages, samples);
  place.append(...solutions(report, films, bar), ...failing(report.stages, nodes));
  place.append(make("h2", {}, ["Stages"]), make("div", { className: "stages" }, top));
  shell.addPanel("report", "Report", place);
}

// ------------------------------------------------------------------------------------------------------ solutions
/** The films of all solutions that have one, each with the parts that begin in it. */
function filmsOf(report) {
  const several = report.runs.length > 1;
  return report.runs.flatMap((run) => run.solutions.filter((solution) => solution.film).map((solution) => ({
    name: several ? `seed ${run.seed}, ${solution.title}` : solution.title,
    film: solution.film,
    solution,
    parts: solution.parts.filter((part) => part.time !== null).map((part) => ({ text: part.stage, time: part.time })),
  })));
}

function solutions(report, films, bar) {
  const made = [];
  for (const run of report.runs.filter((each) => each.solutions.length)) {
    const seed = report.runs.length > 1 ? ` with seed ${run.seed}` : "";
    made.push(make("h2", {}, [`Solutions${seed}`]));
    made.push(...run.solutions.map((solution) => {
      const number = films.findIndex((each) => each.solution === solution);
      return whole(solution, number, bar);
    }));
  }
  return made;
}

/** One solution: its parts, each with a button that goes to its time; of the first, they are seen at once. */
function whole(solution, number, bar) {
  const title = solution.comment ? `${solution.title}, ${solution.comment}` : solution.title;
  const at = (part) => (number < 0 || part.time === null ? "" : make("button", { type: "button",
    title: `show ${part.stage}`, onclick: () => bar.choose(number, part.time) }, [`${part.time.toFixed(2)} s`]));
  const rows = () => solution.parts.map((part) => [part.stage, at(part), part.cost, told(part.comment, part.changes)]);
  const play = () => (number < 0 ? [] : [make("button", { type: "button", className: "play",
    onclick: () => bar.choose(number, 0, true) }, [`▶ play, ${solution.film.duration.toFixed(1)} s`])]);
  return folded(title, () => [...play(), table(["stage", "from", "cost", "what"], rows())],
    { open: number === 0 });
}

// --------------------------------------------------------------------------------------------------------- stages
/** The stages that failed, those with most failures first, as buttons that unfold their failures in the tree. */
function failing(stages, nodes) {
  const failed = stages.map((stage, k) => ({ stage, node: nodes[k] })).filter(({ stage }) => stage.failures.rows.length);
  failed.sort((a, b) => b.stage.failed - a.stage.failed);
  const lines = failed.map(({ stage, node }) => make("li", {}, [
    make("button", { type: "button", className: "failing", onclick: () => unfold(node) }, [stage.path]), " ",
    ...stage.reasons.flatMap(([reason, words, count]) => [swatch(reason), `${words} ${count} `])]));
  return failed.length ? [make("h2", {}, ["Failures"]), make("ul", { className: "failures" }, lines)] : [];
}

/** Unfolds what holds a stage, the stage and its failures, and shows the first sample. */
function unfold({ above, made }) {
  [...above, made].forEach((each) => each.unfold());
  const failures = made.querySelector(":scope > details.failed");
  failures.unfold();
  made.scrollIntoView({ block: "start" });
  failures.querySelector("button.sample")?.click();
}

/** The stages, each inside its container: those at the top, and all in their order with what holds them. */
function tree(stages, samples) {
  const top = [];
  const nodes = [];
  const open = []; // the containers above the present stage
  for (const [k, stage] of stages.entries()) {
    const holds = k + 1 < stages.length && stages[k + 1].depth > stage.depth;
    const made = folded(summary(stage), () => details(stage, samples), {
      open: stage.open && (holds || stage.blamed), className: stage.blamed ? "stage blame" : "stage" });
    open.length = stage.depth;
    nodes.push({ made, above: [...open] });
    (open.at(-1) ?? { append: (each) => top.push(each) }).append(made);
    open.push(made);
  }
  return { top, nodes };
}

function summary(stage) {
  const parts = [
    make("span", { className: "arrows" }, [stage.arrows]), make("b", {}, [stage.name]),
    make("span", { className: "dim" }, [stage.type]),
    make("span", { className: stage.solved ? "good" : "dim" }, [`${stage.solved} solved`]),
    make("span", { className: stage.failed ? "bad" : "dim" }, [`${stage.failed} failed`]),
  ];
  if (stage.mismatches) {
    parts.push(make("span", { className: "bad" }, [`never fit: ${stage.mismatches}`]));
  }
  if (stage.work) {
    parts.push(make("span", { className: "dim" }, [stage.work]));
  }
  if (stage.share !== null) {
    const bar = make("span", { className: "share", "aria-hidden": "true" });
    bar.style.width = `${(4 * stage.share).toFixed(2)}em`;
    parts.push(make("span", { className: "dim" }, [bar, `${(100 * stage.share).toFixed(0)} % of the time`]));
  }
  if (stage.blamed) {
    parts.push(make("span", { className: "bad" }, ["never succeeds"]));
  }
  return parts.flatMap((part) => [part, " "]);
}

function details(stage, samples) {
  const made = [];
  if (stage.reasons.length) {
    made.push(legend(stage.reasons));
  }
  if (stage.properties.length) {
    made.push(folded("properties", () => [table(["property", "value"], stage.properties)]));
  }
  if (stage.solutions.rows.length) {
    const rows = () => stage.solutions.rows.map((each) => [each.cost, told(each.comment, each.changes)]);
    made.push(folded(stage.solutions.title, () => [table(["cost", "what"], rows())]));
  }
  if (stage.failures.rows.length) {
    made.push(failures(stage, samples));
  }
  return made;
}

/** The failures of a stage; where they have samples, buttons show these, and a dot each while the section is open. */
function failures(stage, samples) {
  const { rows, title } = stage.failures;
  const seen = samples ? rows.filter((row) => row.state) : [];
  const button = (row, k) => (samples && row.state
    ? samples.toggle(row, row.said, `show failure ${k + 1}: ${row.said}`) : row.said);
  const between = (row) => (row.between && !row.comment.includes(row.between[0]) ? row.between.join(" and ") : "");
  const cells = () => rows.map((row, k) => [button(row, k), [...told(row.comment, []), ...told(between(row), []),
    ...told("", row.changes)]]);
  const made = folded(title, () => [table(["reason", "what"], cells())], { className: "failed" });
  if (seen.length) {
    made.addEventListener("toggle", () => samples.cloud(made.open ? seen : []));
  }
  return made;
}
