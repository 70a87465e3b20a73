// The panel of the scene: what is shown of it, and the joints of its robots.
import { make } from "kabo/elements.js";

/** Adds the panel of the document's scene. */
export function show(shown, stage, shell) {
  const place = make("div", { className: "scene" });
  for (const robot of shown.scene.robots) {
    place.append(make("h2", {}, [robot.name]), configurations(robot, stage), joints(robot, stage));
  }
  shell.addPanel("scene", "Scene", place);
  shell.onKey("f", "look at the whole scene", () => stage.look([]));
}

function configurations(robot, stage) {
  const buttons = Object.entries(robot.configurations).map(([name, values]) => make("button", {
    type: "button", onclick: () => stage.setState({ robots: { [robot.name]: values } }),
  }, [name]));
  return make("div", { className: "configurations" }, buttons);
}

function joints(robot, stage) {
  return make("div", { className: "joints" }, robot.values.map((value) => {
    const id = `joint-${robot.name}-${value.name}`;
    const slider = make("input", { type: "range", id, min: value.lower, max: value.upper, step: "any",
      value: stage.stateNow().robots[robot.name][value.name],
      oninput: () => stage.setState({ robots: { [robot.name]: { [value.name]: Number(slider.value) } } }) });
    return make("label", { htmlFor: id }, [make("span", {}, [value.name]), slider]);
  }));
}
