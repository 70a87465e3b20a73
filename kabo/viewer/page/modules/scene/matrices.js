// Rigid transforms as 4 x 4 matrices in doubles, row by row, as in the view document.

export const IDENTITY = Float64Array.of(1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1);

/** The product of two matrices. */
export function multiply(first, second) {
  const made = new Float64Array(16);
  for (let row = 0; row < 16; row += 4) {
    for (let column = 0; column < 4; column += 1) {
      made[row + column] = first[row] * second[column] + first[row + 1] * second[4 + column]
        + first[row + 2] * second[8 + column] + first[row + 3] * second[12 + column];
    }
  }
  return made;
}

/** The inverse of a rigid transform. */
export function inverse(pose) {
  const made = Float64Array.from(IDENTITY);
  for (let row = 0; row < 3; row += 1) {
    for (let column = 0; column < 3; column += 1) {
      made[4 * row + column] = pose[4 * column + row];
      made[4 * row + 3] -= pose[4 * column + row] * pose[4 * column + 3];
    }
  }
  return made;
}

/** The transform of a position [m] and a quaternion (x, y, z, w). */
export function fromPose(position, quaternion) {
  const length = Math.hypot(...quaternion);
  const [x, y, z, w] = quaternion.map((each) => each / length);
  return Float64Array.of(
    1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w), position[0],
    2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w), position[1],
    2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y), position[2],
    0, 0, 0, 1,
  );
}

/** A turn about z [rad]. */
export function turnAboutZ(angle) {
  const made = Float64Array.from(IDENTITY);
  made[0] = made[5] = Math.cos(angle);
  made[4] = Math.sin(angle);
  made[1] = -made[4];
  return made;
}

/** A shift along z [m]. */
export function shiftAlongZ(length) {
  const made = Float64Array.from(IDENTITY);
  made[11] = length;
  return made;
}

/** A point moved by a transform. */
export function moved(pose, [x, y, z]) {
  return [0, 4, 8].map((row) => pose[row] * x + pose[row + 1] * y + pose[row + 2] * z + pose[row + 3]);
}
