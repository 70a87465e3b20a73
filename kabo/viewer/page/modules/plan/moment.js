// Links to a moment of a plan: `#n12@1.3s` (the s may be left out), and the outcomes of the branch that leads there: `#n12@1.3s/1.0.1`.

const FORM = /^#(n\d+)(?:@(\d+(?:\.\d+)?)s?)?(?:\/(\d+(?:\.\d+)*))?$/;

/** What a link names: the node, the time within it [s], and the numbers of the outcomes (null: any way); or null. */
export function readMoment(hash) {
  const found = FORM.exec(hash);
  return found && { node: found[1], time: Number(found[2] ?? 0), outcomes: found[3]?.split(".").map(Number) ?? null };
}

/** The link to a moment. */
export function writeMoment({ node, time, outcomes }) {
  return `#${node}@${Number(time.toFixed(2))}s${outcomes.length ? `/${outcomes.join(".")}` : ""}`;
}
