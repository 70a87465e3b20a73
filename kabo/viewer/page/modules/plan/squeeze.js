// Takes empty columns and rows out of a layout: what is hidden leaves no hole, and nothing overlaps that did not before.

const LEAST = 18; // pixels that are left of an empty column or row

/**
 * The boxes and edges that stay, moved together. Every coordinate is mapped by itself and keeps its order; boxes keep
 * their sizes. Edges are vertical beside boxes and slanted between rows, before as after: so none meets a box.
 * @param {{boxes: {x, y, width, height}[], lines: number[][][]}} kept
 * @returns {{boxes: object[], lines: number[][][], width: number, height: number}}
 */
export function squeezed({ boxes, lines }) {
  const points = lines.flat();
  const across = squeeze(boxes.map((box) => [box.x, box.x + box.width]), points.map((point) => point[0]));
  const down = squeeze(boxes.map((box) => [box.y, box.y + box.height]), points.map((point) => point[1]));
  const moved = boxes.map((box) => ({ ...box, x: across.map(box.x), y: down.map(box.y) }));
  const drawn = lines.map((line) => line.map(([x, y]) => [across.map(x), down.map(y)]));
  return { boxes: moved, lines: drawn, width: across.size, height: down.size };
}

/** A map of one coordinate that shortens what lies between intervals and points to `LEAST`, and moves all to zero. */
function squeeze(intervals, points) {
  const all = [...intervals, ...points.map((x) => [x, x])].sort((a, b) => a[0] - b[0]);
  const pieces = [];
  for (const [low, high] of all) {
    const last = pieces.at(-1);
    if (last && low <= last.high + LEAST) {
      last.high = Math.max(last.high, high);
    } else {
      const at = last ? last.at + last.high - last.low + LEAST : 0;
      pieces.push({ low, high, at });
    }
  }
  const end = pieces.at(-1);
  const map = (x) => {
    let [low, high] = [0, pieces.length - 1];
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      [low, high] = pieces[middle].low <= x ? [middle, high] : [low, middle - 1];
    }
    return pieces[low].at + x - pieces[low].low;
  };
  return { map, size: end ? end.at + end.high - end.low : 0 };
}
