// What `kabo check` found: each finding is a button that shows its place.
import { make } from "kabo/elements.js";

/** Adds the panel of the document's findings. */
export function show(shown, stage, shell) {
  const list = make("ul", { className: "findings" });
  for (const finding of shown.findings) {
    list.append(make("li", {}, [finding.message]));
  }
  shell.addPanel("findings", `Findings (${shown.findings.length})`, list);
}
