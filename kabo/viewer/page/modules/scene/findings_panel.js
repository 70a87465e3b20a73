// What `kabo check` found: each finding is a button that shows its place.
import { make } from "kabo/elements.js";

/** Adds the panel of the document's findings. */
export function show(shown, stage, shell) {
  const items = shown.findings.map((finding) => make("li", { className: finding.severity }, row(finding, shown, stage)));
  shell.addPanel("findings", `Findings (${shown.findings.length})`, make("ul", { className: "findings" }, items));
  if (shown.given !== "plan" && shown.findings.some((finding) => finding.severity === "error")) {
    shell.first = "findings";
  }
}

function row(finding, shown, stage) {
  const content = [make("span", { className: finding.severity === "error" ? "bad" : "warn" }, [finding.severity]),
    " ", finding.message];
  const place = finding.place && stage && finding.place.things.length ? finding.place : null;
  const said = place
    ? make("button", { type: "button", className: "finding", onclick: () => visit(finding, shown, stage) }, content)
    : make("div", { className: "finding" }, content);
  const below = [make("span", {}, [`${finding.file}:${finding.line}`])];
  if (place && place.metres !== null) {
    const depth = `${Number((1000 * Math.abs(place.metres)).toPrecision(3))} mm`;
    below.push(make("span", { className: "depth" }, [place.metres < 0 ? `${depth} deep` : depth]));
  }
  const rows = [said, make("div", { className: "dim at" }, below)];
  if (finding.hint) {
    rows.push(make("div", { className: "hint" }, [finding.hint]));
  }
  return rows;
}

/** Shows the place of a finding: the state in which it is so, its things in colour, all else faded. */
function visit(finding, shown, stage) {
  const { things, robots, metres } = finding.place;
  stage.setState(shown.scene.start);
  stage.setState({ robots });
  stage.highlight([], null);
  stage.highlight(things.slice(0, 1), finding.severity === "error" ? "bad" : "warn");
  stage.highlight(things.slice(1), "chosen");
  stage.focus(things, metres !== null && metres < 0);
  stage.look(things);
}
