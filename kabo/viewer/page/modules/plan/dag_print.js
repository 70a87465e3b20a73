// The graph of a plan on paper: all of its text, in as many columns as let it be read.
import { make } from "kabo/elements.js";
import { edgePath } from "kabo/dag.js";
import { MARK, boxElement } from "kabo/dag_box.js";
import { svg } from "kabo/svg.js";

const SHAPE = 1.25; // width of the whole, as a share of its height
const HALF_CHANNEL = 17; // half of BETWEEN in kabo/viewer/content/plan/layers.py: where a column is cut off

/** The graph as it is folded now, as an element of its own. */
export function printedDag(dag) {
  const [width, height] = dag.size;
  const count = Math.max(1, Math.round(Math.sqrt((SHAPE * height) / (width + 2 * MARK))));
  const cuts = cutsOf([...dag.boxes.values()].map((box) => box.y), height, count);
  const columns = cuts.slice(1).map((end, k) => column(dag, cuts[k], end));
  const longest = Math.max(...cuts.slice(1).map((end, k) => end - cuts[k]));
  columns.forEach((each, k) => { each.style.height = `${(100 * (cuts[k + 1] - cuts[k])) / longest}%`; });
  return make("div", { className: "columns" }, columns);
}

/** Where columns begin and end: between rows, as near as can be to equal shares. */
function cutsOf(tops, height, count) {
  const rows = [...new Set(tops)].sort((a, b) => a - b).slice(1);
  const cuts = [-MARK];
  for (let k = 1; k < count; k += 1) {
    const wish = (height * k) / count;
    const found = rows.reduce((best, top) => (Math.abs(top - wish) < Math.abs(best - wish) ? top : best), Infinity) - HALF_CHANNEL;
    if (found > cuts.at(-1) && Number.isFinite(found)) {
      cuts.push(found);
    }
  }
  return [...cuts, height + MARK];
}

function column(dag, from, to) {
  const boxes = [...dag.boxes.values()].filter((box) => box.y + box.height > from && box.y < to).map((box) => {
    const element = boxElement(box, false, null, null);
    dag.markBox(box.node.id, element);
    element.classList.remove("chosen");
    return element;
  });
  const edges = dag.edges.filter(({ points }) => points.at(-1)[1] > from && points[0][1] < to).map((edge) => svg("path", {
    d: edgePath(edge.points), class: dag.onBranch.get(edge.from) === edge.port ? "edge on" : "edge" }));
  const frame = [-MARK, from, dag.size[0] + 2 * MARK, to - from];
  return svg("svg", { class: "graph", viewBox: frame.join(" "), preserveAspectRatio: "xMidYMin", role: "img", "aria-label": "Plan" },
    [...edges, ...boxes]);
}
