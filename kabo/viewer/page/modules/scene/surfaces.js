// Meshes of the document as geometries of three.js, with smooth normals where faces meet at a small angle.
import { BufferAttribute, BufferGeometry } from "three";

const SMOOTH = Math.cos(35 * Math.PI / 180); // faces at a smaller angle share their normals

/** The vertices of a mesh [m], three numbers each. */
export function verticesOf(mesh, arrays) {
  const numbers = arrays[mesh.vertices.array];
  const made = new Float32Array(numbers.length);
  for (let i = 0; i < numbers.length; i += 1) {
    made[i] = mesh.low[i % 3] + mesh.step[i % 3] * numbers[i];
  }
  return made;
}

/** One geometry of some meshes of the document. */
export function geometryOf(meshes, arrays) {
  const pieces = meshes.map((mesh) => creased(verticesOf(mesh, arrays), arrays[mesh.faces.array]));
  const geometry = new BufferGeometry();
  for (const [name, index] of [["position", 0], ["normal", 1]]) {
    const whole = new Float32Array(pieces.reduce((sum, piece) => sum + piece[index].length, 0));
    let at = 0;
    for (const piece of pieces) {
      whole.set(piece[index], at);
      at += piece[index].length;
    }
    geometry.setAttribute(name, new BufferAttribute(whole, 3));
  }
  geometry.computeBoundingSphere();
  geometry.computeBoundingBox();
  return geometry;
}

/** Positions and normals of the corners of all faces; corners average the normals of faces nearly as steep. */
function creased(vertices, faces) {
  const normals = faceNormals(vertices, faces);
  const [starts, around] = facesAround(vertices.length / 3, faces);
  const positions = new Float32Array(3 * faces.length);
  const smooth = new Float32Array(3 * faces.length);
  for (let corner = 0; corner < faces.length; corner += 1) {
    const vertex = faces[corner];
    const own = 4 * Math.floor(corner / 3);
    let [x, y, z] = [0, 0, 0];
    for (let k = starts[vertex]; k < starts[vertex + 1]; k += 1) {
      const other = 4 * around[k];
      const cosine = normals[own] * normals[other] + normals[own + 1] * normals[other + 1]
        + normals[own + 2] * normals[other + 2];
      if (cosine >= SMOOTH || own === other) {
        x += normals[other] * normals[other + 3];
        y += normals[other + 1] * normals[other + 3];
        z += normals[other + 2] * normals[other + 3];
      }
    }
    const length = Math.hypot(x, y, z) || 1;
    smooth.set([x / length, y / length, z / length], 3 * corner);
    positions.set(vertices.subarray(3 * vertex, 3 * vertex + 3), 3 * corner);
  }
  return [positions, smooth];
}

/** The unit normal and twice the area of each face, four numbers each. */
function faceNormals(vertices, faces) {
  const made = new Float32Array(4 * faces.length / 3);
  for (let face = 0; face < faces.length / 3; face += 1) {
    const [a, b, c] = [3 * faces[3 * face], 3 * faces[3 * face + 1], 3 * faces[3 * face + 2]];
    const [ux, uy, uz] = [vertices[b] - vertices[a], vertices[b + 1] - vertices[a + 1], vertices[b + 2] - vertices[a + 2]];
    const [vx, vy, vz] = [vertices[c] - vertices[a], vertices[c + 1] - vertices[a + 1], vertices[c + 2] - vertices[a + 2]];
    const [x, y, z] = [uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx];
    const length = Math.hypot(x, y, z);
    made.set([x / (length || 1), y / (length || 1), z / (length || 1), length], 4 * face);
  }
  return made;
}

/** For each vertex, the faces around it: those from `starts[v]` to `starts[v + 1]` of `around`. */
function facesAround(count, faces) {
  const starts = new Uint32Array(count + 1);
  for (const vertex of faces) {
    starts[vertex + 1] += 1;
  }
  for (let vertex = 0; vertex < count; vertex += 1) {
    starts[vertex + 1] += starts[vertex];
  }
  const next = starts.slice();
  const around = new Uint32Array(faces.length);
  for (let corner = 0; corner < faces.length; corner += 1) {
    around[next[faces[corner]]++] = Math.floor(corner / 3);
  }
  return [starts, around];
}
