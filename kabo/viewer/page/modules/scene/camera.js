// Where the camera stands: so near that a box fills the view, and where few things hide the robots and objects.
import { Box3, Ray, Vector3 } from "three";

const UP = 0.62; // height of the direction from which the camera looks at first, of a length of about 1.4
const TURNS = 12; // directions around the scene that are compared
const FILLED = 0.9; // of the view, at most
const HIDDEN = 1.5; // how much worse a view is in which all is hidden: as one from 1.5 times as far
const ASIDE = 0.02; // how much worse each turn from the front right is

const LARGE = 1.7; // times the robots' and objects' size: other things that are larger are not shown whole at first
const NEAR = 0.25; // of that size: as far around them such things are shown

function diagonal(box) {
  return box.getSize(new Vector3()).length();
}

/** The corners of a box. */
function corners(box) {
  const made = [];
  for (const x of [box.min.x, box.max.x]) {
    for (const y of [box.min.y, box.max.y]) {
      for (const z of [box.min.z, box.max.z]) {
        made.push(new Vector3(x, y, z));
      }
    }
  }
  return made;
}

/** The least distance from the middle of a box, in a unit direction, at which the camera sees all of it. */
export function distanceTo(box, direction, camera) {
  const middle = box.getCenter(new Vector3());
  const right = new Vector3().crossVectors(camera.up, direction).normalize();
  const up = new Vector3().crossVectors(direction, right);
  const high = FILLED * Math.tan((camera.fov / 2) * Math.PI / 180);
  const wide = high * camera.aspect;
  return Math.max(0.02, ...corners(box).map((corner) => {
    const arm = corner.sub(middle);
    return arm.dot(direction) + Math.max(Math.abs(arm.dot(right)) / wide, Math.abs(arm.dot(up)) / high);
  }));
}

/**
 * The box that is looked at first: of the wanted boxes, of regions that are no larger, and of all others, of which
 * large ones, as floors, count as far as they are near.
 */
export function viewedBox(wanted, regions, all) {
  const first = wanted.reduce((whole, each) => whole.union(each), new Box3());
  if (first.isEmpty()) {
    return all.reduce((whole, each) => whole.union(each), new Box3());
  }
  const small = regions.filter((each) => diagonal(each) <= diagonal(first));
  const core = small.reduce((whole, each) => whole.union(each), first);
  const size = diagonal(core);
  const near = core.clone().expandByScalar(NEAR * size);
  return all.reduce((whole, each) => {
    const both = core.clone().union(each);
    return whole.union(diagonal(both) > LARGE * size ? each.clone().intersect(near) : each);
  }, core.clone());
}

/**
 * The unit direction in which the camera stands at first: of some around the scene, one from which little of the wanted
 * boxes is behind others, from which the scene is near, and which is at the front right.
 */
export function freeDirection(wanted, all, box, camera) {
  const middle = box.getCenter(new Vector3());
  const points = wanted.flatMap((each) => pointsOf(each).map((point) => [point, each]));
  const views = Array.from({ length: TURNS }, (_, turn) => {
    const side = turn % 2 ? -(turn + 1) / 2 : turn / 2;
    const angle = -0.9 + (side * 2 * Math.PI) / TURNS;
    const direction = new Vector3(Math.cos(angle), Math.sin(angle), UP).normalize();
    const distance = distanceTo(box, direction, camera);
    const eye = middle.clone().addScaledVector(direction, distance);
    const hidden = points.filter(([point, own]) => isHidden(point, own, all, eye)).length / Math.max(1, points.length);
    return { direction, distance, hidden, side: Math.abs(side) };
  });
  const nearest = Math.min(...views.map((view) => view.distance));
  const cost = (view) => HIDDEN * view.hidden + view.distance / nearest + ASIDE * view.side;
  return views.reduce((best, view) => (cost(view) < cost(best) ? view : best)).direction;
}

/** The middle of a box, and points half-way to its corners. */
function pointsOf(box) {
  const middle = box.getCenter(new Vector3());
  return [middle, ...corners(box).map((corner) => corner.lerp(middle, 0.5))];
}

function isHidden(point, own, all, eye) {
  const away = point.clone().sub(eye);
  const ray = new Ray(eye, away.clone().normalize());
  return all.some((other) => {
    if (other === own || other.containsPoint(point) || own.containsBox(other)) {
      return false;
    }
    const hit = ray.intersectBox(other, new Vector3());
    return hit !== null && hit.distanceTo(eye) < away.length() - 0.02;
  });
}
