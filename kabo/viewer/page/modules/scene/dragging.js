// Dragging a link with the shift key: the joint that carries it follows the pointer, within its limits.
import { Vector3 } from "three";
import { linkPoses } from "kabo/kinematics.js";
import { inverse, moved } from "kabo/matrices.js";

const SMALL = 1e-4; // rad or m: by which a joint is moved to see where a point goes
const DAMPING = 20; // pixels per rad or m: a joint that moves points less than that follows the pointer slowly

/** Lets links of a stage be dragged. */
export function drag(stage) {
  let held = null;
  stage.canvas.addEventListener("pointerdown", (event) => {
    held = event.shiftKey ? grasp(stage, event) : null;
    if (held) {
      stage.controls.enabled = false;
      stage.canvas.setPointerCapture(event.pointerId);
    }
  }, { capture: true });
  stage.canvas.addEventListener("pointermove", (event) => {
    if (held) {
      follow(stage, held, event);
    }
  });
  const release = () => {
    held = null;
    stage.controls.enabled = true;
  };
  stage.canvas.addEventListener("pointerup", release);
  stage.canvas.addEventListener("pointercancel", release);
}

/** The joint and the point of the link under the pointer; null if nothing there moves. */
function grasp(stage, event) {
  const hit = stage.at(event);
  const thing = hit && stage.things.get(hit.name);
  if (!thing?.robot) {
    return null;
  }
  const { robot } = thing;
  let joint = robot.joints[thing.described.joint];
  while (joint && joint.source === null) {
    joint = robot.joints[joint.parent];
  }
  if (!joint) {
    return null;
  }
  const point = moved(inverse(stage.poseOf(hit.name)), hit.point.toArray());
  const limits = robot.values.find((each) => each.name === joint.source);
  return { robot, link: hit.name, point, limits, last: [event.clientX, event.clientY] };
}

/** Moves the joint as far as brings the held point nearest to the pointer, on the screen. */
function follow(stage, held, event) {
  const values = stage.stateNow().robots[held.robot.name];
  const { name, lower, upper } = held.limits;
  const seen = (value) => onScreen(stage, held, { ...values, [name]: value });
  const here = seen(values[name]);
  const there = seen(values[name] + SMALL);
  const [x, y] = [(there[0] - here[0]) / SMALL, (there[1] - here[1]) / SMALL];
  const along = (event.clientX - held.last[0]) * x + (event.clientY - held.last[1]) * y;
  const value = values[name] + along / (x * x + y * y + DAMPING * DAMPING);
  stage.setState({ robots: { [held.robot.name]: { [name]: Math.min(upper, Math.max(lower, value)) } } });
  held.last = [event.clientX, event.clientY];
}

/** Where the held point is on the screen for some values of the robot's joints [pixels]. */
function onScreen(stage, { robot, link, point }, values) {
  const at = new Vector3(...moved(linkPoses(robot, values).get(link), point)).project(stage.camera);
  return [(at.x + 1) / 2 * stage.canvas.clientWidth, (1 - at.y) / 2 * stage.canvas.clientHeight];
}
