// Where everything of a scene is in a state: forward kinematics of the robots, and the parents of the objects.
import { IDENTITY, fromPose, multiply, shiftAlongZ, turnAboutZ } from "kabo/matrices.js";

/** The values of a robot in a state; plan files have them under `joints`. */
export function valuesOf(robotState) {
  return typeof robotState.joints === "object" ? robotState.joints : robotState;
}

/** The poses of all links of a robot by `robot.link`, for values of its joints by name [rad or m]. */
export function linkPoses(robot, values) {
  const joints = [];
  for (const joint of robot.joints) {
    const value = joint.shift + (joint.source === null ? 0 : joint.ratio * values[joint.source]);
    const motion = joint.type === "prismatic" ? shiftAlongZ(value) : turnAboutZ(value);
    const still = joint.parent < 0 ? joint.origin : multiply(joints[joint.parent], joint.origin);
    joints.push(multiply(still, motion));
  }
  const poses = new Map();
  for (const link of robot.links) {
    const carried = link.joint < 0 ? Float64Array.from(link.origin) : multiply(joints[link.joint], link.origin);
    poses.set(`${robot.name}.${link.name}`, carried);
  }
  return poses;
}

/** The pose of every link, body and region of a scene, and of `world`, by name. */
export function scenePoses(scene, state) {
  const poses = new Map([["world", IDENTITY]]);
  for (const robot of scene.robots) {
    for (const [name, pose] of linkPoses(robot, valuesOf(state.robots[robot.name]))) {
      poses.set(name, pose);
    }
  }
  for (const region of scene.regions) {
    poses.set(region.name, region.pose);
  }
  for (const body of scene.bodies) {
    if (body.pose !== null) {
      poses.set(body.name, body.pose);
    }
  }
  for (const name of Object.keys(state.objects)) {
    placeObject(name, state, poses);
  }
  return poses;
}

/** Places an object after what it hangs on; `above` hang on it. Those that hang on each other have no place. */
function placeObject(name, state, poses, above = []) {
  const { parent, position, quaternion } = state.objects[name];
  if (!poses.has(parent) && parent in state.objects && !above.includes(parent)) {
    placeObject(parent, state, poses, [...above, name]);
  }
  if (!poses.has(parent)) {
    return;
  }
  poses.set(name, multiply(poses.get(parent), fromPose(position, quaternion)));
}
