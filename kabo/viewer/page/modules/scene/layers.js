// What is drawn beside solid shapes: frames, features, view cones of sensors, the floor's grid.
import {
  BufferAttribute, BufferGeometry, ConeGeometry, DoubleSide, GridHelper, Group, LineBasicMaterial, LineSegments, Matrix4,
  Mesh, MeshBasicMaterial, SphereGeometry, Vector3,
} from "three";

const AXES = [[0.85, 0.2, 0.15], [0.2, 0.62, 0.2], [0.15, 0.35, 0.9]]; // x, y, z
const FEATURE = 0xc026d3;
const VIEW = 0xe0a100;
const ROUND = 48; // sides of a view cone

/** The axes of a frame: x red, y green, z blue. */
export function frame(length) {
  const positions = AXES.flatMap((_, axis) => [0, 0, 0, ...[0, 1, 2].map((each) => (each === axis ? length : 0))]);
  const made = segments(positions, AXES.flatMap((colour) => [...colour, ...colour]));
  made.renderOrder = 2;
  made.material.depthTest = false;
  return made;
}

/** Segments between pairs of points; `colours` are of each point, or one for all. */
export function segments(positions, colours) {
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(Float32Array.from(positions), 3));
  if (Array.isArray(colours)) {
    geometry.setAttribute("color", new BufferAttribute(Float32Array.from(colours), 3));
    return new LineSegments(geometry, new LineBasicMaterial({ vertexColors: true }));
  }
  return new LineSegments(geometry, new LineBasicMaterial({ color: colours }));
}

/** Points as balls, lines as arrows, planes as squares with their normals, all in the frame of their owner. */
export function features(described, size) {
  const made = new Group();
  for (const { kind, origin, direction } of described) {
    const at = new Vector3(...origin);
    if (kind === "point" || direction === null) {
      const ball = new Mesh(new SphereGeometry(size / 8, 12, 8), new MeshBasicMaterial({ color: FEATURE }));
      ball.position.copy(at);
      made.add(ball);
    } else {
      made.add(arrow(at, new Vector3(...direction), size, kind === "plane"));
    }
  }
  return made;
}

function arrow(at, along, size, square) {
  const side = new Vector3(1, 0, 0);
  if (Math.abs(along.x) > 0.7) {
    side.set(0, 1, 0);
  }
  const first = new Vector3().crossVectors(along, side).normalize();
  const second = new Vector3().crossVectors(along, first).normalize();
  const point = (a, b, c) => at.clone().addScaledVector(along, a * size).addScaledVector(first, b * size)
    .addScaledVector(second, c * size).toArray();
  const positions = [...point(0, 0, 0), ...point(1, 0, 0)];
  if (square) {
    const corners = [[0.5, 0.5], [0.5, -0.5], [-0.5, -0.5], [-0.5, 0.5]].map(([b, c]) => point(0, b, c));
    corners.forEach((corner, index) => positions.push(...corner, ...corners[(index + 1) % 4]));
  }
  const made = new Group();
  const head = new Mesh(new ConeGeometry(size / 12, size / 5, 10), new MeshBasicMaterial({ color: FEATURE }));
  head.position.fromArray(point(1, 0, 0));
  head.quaternion.setFromUnitVectors(new Vector3(0, 1, 0), along);
  made.add(segments(positions, FEATURE), head);
  return made;
}

/** The volume that a sensor sees: a cone, or a pyramid, between its nearest and farthest distance. */
export function viewCone({ angles, near, far, origin }) {
  const rim = angles.length === 1
    ? Array.from({ length: ROUND }, (_, i) => [Math.cos(2 * Math.PI * i / ROUND), Math.sin(2 * Math.PI * i / ROUND)])
      .map(([x, y]) => [Math.tan(angles[0]) * x, Math.tan(angles[0]) * y])
    : [[1, 1], [-1, 1], [-1, -1], [1, -1]].map(([x, y]) => [Math.tan(angles[0]) * x, Math.tan(angles[1]) * y]);
  const at = ([x, y], depth) => [x * depth, y * depth, depth];
  const edges = [];
  const faces = [];
  rim.forEach((corner, index) => {
    const next = rim[(index + 1) % rim.length];
    edges.push(...at(corner, near), ...at(next, near), ...at(corner, far), ...at(next, far));
    if (index % Math.max(1, rim.length / 4) === 0) {
      edges.push(...at(corner, near), ...at(corner, far));
    }
    faces.push(...at(corner, near), ...at(corner, far), ...at(next, far));
    faces.push(...at(corner, near), ...at(next, far), ...at(next, near));
  });
  const surface = new BufferGeometry();
  surface.setAttribute("position", new BufferAttribute(Float32Array.from(faces), 3));
  const made = new Group();
  made.add(segments(edges, VIEW), new Mesh(surface, new MeshBasicMaterial({
    color: VIEW, transparent: true, opacity: 0.12, side: DoubleSide, depthWrite: false,
  })));
  made.applyMatrix4(new Matrix4().set(...origin));
  return made;
}

/** A grid on the floor under a box, with lines every half metre, or every decimetre below small scenes. */
export function grid(box, colour) {
  const size = box.getSize(new Vector3());
  const step = Math.max(size.x, size.y) > 1.2 ? 0.5 : 0.1;
  const count = 2 * Math.ceil((Math.max(size.x, size.y) / 2) / step + 2);
  const made = new GridHelper(count * step, count, colour, colour);
  made.rotation.x = Math.PI / 2;
  const middle = box.getCenter(new Vector3());
  made.position.set(Math.round(middle.x / step) * step, Math.round(middle.y / step) * step, box.min.z - 0.002);
  return made;
}
