// What is printed of a plan: the graph, and under it one picture for each node of the chosen branch that moves something.
import { make } from "kabo/elements.js";
import { callOf } from "kabo/dag_box.js";
import { printedDag } from "kabo/dag_print.js";

const WIDTH = 640; // pixels of a picture
const MOST = 120; // nodes of a branch

/**
 * Makes a film strip whenever the page is printed, and takes it away afterwards.
 * @param {{plan: object, dag: object, branches: object, player: object, stage: object|null, unmark: function()}} shown
 */
export function printsFilm(shown) {
  let made = null;
  addEventListener("beforeprint", () => {
    made?.remove();
    shown.unmark();
    made = film(shown);
    document.body.append(made);
  });
  addEventListener("afterprint", () => { made?.remove(); made = null; });
}

/** The film strip of the chosen branch. */
export function film({ plan, dag, branches, player, stage }) {
  const branch = branches.branch;
  const heading = make("h2", {}, [`Plan of ${plan.problem}: ${plan.nodes.length} nodes, ${plan.branches} branches`]);
  const way = branch.filter(({ node }) => node.outcomes.length)
    .map(({ node, port }) => `${node.on} = ${node.outcomes[port].outcome}`).join(", ");
  const told = make("p", {}, [way ? `The branch with ${way}:` : "Step by step:"]);
  return make("section", { className: "film" }, [heading, printedDag(dag), told,
    make("div", { className: "frames" }, framesOf(branch.slice(0, MOST), player, stage))]);
}

/** A picture for each node that moves something; the nodes before it that do not are named in its caption. */
function framesOf(branch, player, stage) {
  const frames = [];
  let lines = [];
  branch.forEach(({ node, port }, number) => {
    const step = player.film.steps[number];
    lines.push(captionOf(node, port, step));
    if (stage !== null && step.length > 0) {
      frames.push(make("figure", {}, [picture(player.stateAt(step.end), stage), ...lines]));
      lines = [];
    }
  });
  if (lines.length) {
    frames.push(make("figure", {}, lines));
  }
  stage?.setState(player.state);
  stage?.drawNow();
  return frames;
}

function captionOf(node, port, step) {
  const outcome = node.outcomes.length ? ` → ${node.outcomes[port].outcome}` : "";
  const time = step.length > 0 ? ` ${step.begin.toFixed(1)}–${step.end.toFixed(1)} s` : "";
  return make("figcaption", {}, [make("b", {}, [node.id]), ` ${callOf(node)}${outcome}`, make("span", { className: "dim" }, [time])]);
}

/** The stage in a state, as a canvas of its own: pictures of another kind would not be ready for paper. */
function picture(state, stage) {
  stage.setState(state);
  stage.drawNow();
  const { width, height } = stage.canvas;
  const canvas = make("canvas", { width: WIDTH, height: Math.round((WIDTH * height) / Math.max(1, width)), "aria-hidden": "true" });
  canvas.getContext("2d").drawImage(stage.canvas, 0, 0, canvas.width, canvas.height);
  return canvas;
}
