// What is printed of a plan: the graph, and under it one picture for each node of the chosen branch that moves something.
import { make } from "kabo/elements.js";
import { callOf } from "kabo/dag_box.js";

const [WIDTH, HEIGHT] = [640, 400]; // pixels of a picture
const MOST = 60; // pictures

/**
 * Makes a film strip whenever the page is printed, and takes it away afterwards.
 * @param {{plan: object, dag: object, branches: object, player: object, stage: object|null, place: HTMLElement}} shown
 */
export function printsFilm(shown) {
  let made = null;
  addEventListener("beforeprint", () => {
    made?.remove();
    made = film(shown);
    shown.place.append(made);
  });
  addEventListener("afterprint", () => { made?.remove(); made = null; });
}

/** The film strip of the chosen branch. */
export function film({ plan, dag, branches, player, stage }) {
  const branch = branches.branch;
  const heading = make("h2", {}, [`Plan of ${plan.problem}: ${plan.nodes.length} nodes, ${plan.branches} branches`]);
  const way = branch.filter(({ node }) => node.outcomes.length)
    .map(({ node, port }) => `${node.on} = ${node.outcomes[port].outcome}`).join(", ");
  const frames = make("div", { className: "frames" });
  const steps = player.film.steps;
  branch.slice(0, MOST).forEach(({ node, port }, number) => {
    frames.append(frame(node, port, steps[number], player, stage));
  });
  stage?.setState(player.state);
  stage?.drawNow();
  const told = make("p", {}, [way ? `The branch with ${way}:` : "Step by step:"]);
  return make("section", { className: "film" }, [heading, dag.printed(), told, frames]);
}

function frame(node, port, step, player, stage) {
  const outcome = node.outcomes.length ? ` → ${node.outcomes[port].outcome}` : "";
  const text = make("figcaption", {}, [make("b", {}, [node.id]), ` ${callOf(node)}${outcome}`,
    ...(step.length > 0 ? [make("span", { className: "dim" }, [` ${step.begin.toFixed(1)}–${step.end.toFixed(1)} s`])] : [])]);
  const moved = stage !== null && step.length > 0;
  return make("figure", { className: moved ? "" : "still" }, moved ? [picture(step, player, stage), text] : [text]);
}

/** The stage at the end of a step, as a canvas of its own: pictures of another kind would not be ready for paper. */
function picture(step, player, stage) {
  stage.setState(player.stateAt(step.end));
  stage.drawNow();
  const { width, height } = stage.canvas;
  const scale = Math.max(WIDTH / width, HEIGHT / height);
  const canvas = make("canvas", { width: WIDTH, height: HEIGHT, "aria-hidden": "true" });
  canvas.getContext("2d").drawImage(stage.canvas, (WIDTH - width * scale) / 2, (HEIGHT - height * scale) / 2, width * scale, height * scale);
  return canvas;
}
