// The joints of a robot: named configurations to choose from, and a slider for each value.
import { make } from "kabo/elements.js";

/** The controls of all robots, which follow what the stage shows. */
export function robotControls(scene, stage) {
  return scene.robots.map((robot) => {
    const sliders = robot.values.map((value) => slider(robot, value, stage));
    const planned = sliders.filter((_, index) => robot.values[index].planned);
    const hand = sliders.filter((_, index) => !robot.values[index].planned);
    const rows = [make("div", { className: "joints" }, planned)];
    if (hand.length) {
      rows.push(make("h3", {}, ["gripper"]), make("div", { className: "joints" }, hand));
    }
    return make("details", { className: "robot", open: scene.robots.length < 4 }, [
      make("summary", {}, [robot.name]), configurations(robot, scene, stage), ...rows]);
  });
}

function configurations(robot, scene, stage) {
  const named = [...Object.entries(robot.configurations), ...Object.entries(robot.hand ?? {})];
  const buttons = named.map(([name, values]) => choice(name, robot, values, stage));
  buttons.unshift(choice("start", robot, scene.start.robots[robot.name], stage));
  return make("div", { className: "choices", role: "group", "aria-label": `configurations of ${robot.name}` }, buttons);
}

function choice(name, robot, values, stage) {
  return make("button", { type: "button", onclick: () => stage.setState({ robots: { [robot.name]: values } }) }, [name]);
}

function slider(robot, value, stage) {
  const id = `joint-${robot.name}-${value.name}`;
  const read = (state) => state.robots[robot.name][value.name];
  const input = make("input", { type: "range", id, min: String(value.lower), max: String(value.upper), step: "any",
    oninput: () => stage.setState({ robots: { [robot.name]: { [value.name]: Number(input.value) } } }) });
  const shown = make("output", { htmlFor: id });
  const update = (state) => {
    input.value = String(read(state));
    shown.textContent = said(read(state), value.unit);
    input.setAttribute("aria-valuetext", shown.textContent);
  };
  update(stage.stateNow());
  stage.onState(update);
  return make("div", { className: "joint" }, [
    make("label", { htmlFor: id, title: `${value.name}: ${said(value.lower, value.unit)} to ${said(value.upper, value.unit)}` },
      [value.name]), input, shown]);
}

/** A value as people read it: degrees or millimetres. */
export function said(value, unit) {
  return unit === "m" ? `${(1000 * value).toFixed(1)} mm` : `${(180 * value / Math.PI).toFixed(1)}°`;
}
