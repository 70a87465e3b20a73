"""Layered layout of a directed acyclic graph: boxes in rows, edges that only go down and never pass through a box.

The steps of [Sugiyama, Tagawa, Toda 1981]: rows by the longest path, order within rows by barycentres, places by least
squares. An edge that spans several rows runs through a narrow lane of its own in every row between. Between rows
edges are slanted, within a row they are vertical: so no edge meets a box, whatever the order is.

The same graph always gives the same layout. Lengths are in pixels, x to the right and y downwards.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

LANE = 10.0  # width of the lane of an edge within a row
BESIDE = 18.0  # least distance of boxes that are side by side
BETWEEN = 34.0  # height of the channel between two rows
SWEEPS = 12  # rounds of ordering
PLACING_ROUNDS = 10  # rounds of placing
STIFF = 50.0  # how much more what follows alone is drawn to the place exactly below
STRAIGHT = 6.0  # how much more a lane resists a bend than a box does

Point = tuple[float, float]


@dataclass(frozen=True)
class Box:
    """A node to place: its size, and where on its lower side each edge leaves, measured from its middle."""

    width: float
    height: float
    ports: tuple[float, ...] = ()


@dataclass(frozen=True)
class Place:
    """Where a box was placed: its upper left corner and its size; and its row, counted from the top."""

    x: float
    y: float
    width: float
    height: float
    row: int


@dataclass(frozen=True)
class Route:
    """An edge: the nodes that it joins, the number of its port, and its corners from the upper end to the lower."""

    source: str
    target: str
    port: int
    points: tuple[Point, ...]


@dataclass(frozen=True)
class Layout:
    """All boxes and edges, within (0, 0) and (width, height)."""

    places: Mapping[str, Place]
    routes: tuple[Route, ...]
    width: float
    height: float


def layered(boxes: Mapping[str, Box], successors: Mapping[str, Sequence[str]]) -> Layout:
    """The layout of a graph.

    Args:
        boxes: every node with its size; `ports` as many as the node has successors.
        successors: the nodes that follow each node, in the order in which they are to be drawn.

    Raises:
        ValueError: the graph has a cycle, or a successor is no node.
    """
    rows = _rows(boxes, successors)
    graph = _Graph(boxes, successors, rows)
    _order(graph)
    return _routed(graph, _places(graph))


@dataclass
class _Cell:
    """A box or a lane of an edge, in a row: neighbours above and below, with the port through which each is reached."""

    name: str  # of a box; empty for a lane
    width: float
    above: list[tuple[int, float]]  # (cell, offset of the port on that cell)
    below: list[tuple[int, float]]  # (cell, offset of the own port)


class _Graph:
    """The graph with lanes in place of long edges, as numbered cells in rows."""

    def __init__(
        self, boxes: Mapping[str, Box], successors: Mapping[str, Sequence[str]], rows: Mapping[str, int]
    ) -> None:
        self.boxes = boxes
        self.cells: list[_Cell] = []
        self.rows: list[list[int]] = [[] for _ in range(max(rows.values(), default=-1) + 1)]
        self.row_of: list[int] = []
        self.number = {
            name: self._cell(name, boxes[name].width, rows[name]) for name in _preorder(successors, rows)
        }
        self.edges: list[tuple[str, str, int, list[int]]] = []  # source, target, port, cells of the lanes
        for name in self.number:
            for port, target in enumerate(successors.get(name, ())):
                self._edge(name, target, port, rows)

    def _cell(self, name: str, width: float, row: int) -> int:
        self.cells.append(_Cell(name, width, [], []))
        self.row_of.append(row)
        self.rows[row].append(len(self.cells) - 1)
        return len(self.cells) - 1

    def _edge(self, source: str, target: str, port: int, rows: Mapping[str, int]) -> None:
        lanes = [self._cell("", LANE, row) for row in range(rows[source] + 1, rows[target])]
        chain = [self.number[source], *lanes, self.number[target]]
        offset = self.boxes[source].ports[port]
        for upper, lower in zip(chain, chain[1:], strict=False):
            self.cells[upper].below.append((lower, offset))
            self.cells[lower].above.append((upper, offset))
            offset = 0.0
        self.edges.append((source, target, port, lanes))

    def gap(self, left: int, right: int) -> float:
        """The least distance of the middles of two neighbours in a row."""
        a, b = self.cells[left], self.cells[right]
        between = BESIDE if a.name and b.name else LANE if a.name or b.name else 0.0
        return (a.width + b.width) / 2.0 + between


# ------------------------------------------------------------------------------------------------------------ rows
def _preorder(successors: Mapping[str, Sequence[str]], rows: Mapping[str, int]) -> list[str]:
    """All nodes depth first, so that branches of a tree are side by side from the start."""
    seen: dict[str, None] = {}
    for root in sorted(rows, key=lambda name: rows[name]):
        stack = [root]
        while stack:
            name = stack.pop()
            if name not in seen:
                seen[name] = None
                stack.extend(reversed(successors.get(name, ())))
    return list(seen)


def _rows(boxes: Mapping[str, Box], successors: Mapping[str, Sequence[str]]) -> dict[str, int]:
    """The row of every node: the length of the longest path that leads to it."""
    entering = dict.fromkeys(boxes, 0)
    for name in boxes:
        for target in successors.get(name, ()):
            if target not in entering:
                raise ValueError(f"{name} leads to {target}, which is no node")
            entering[target] += 1
    rows = {name: 0 for name, count in entering.items() if count == 0}
    ready = list(rows)
    for name in ready:  # the list grows during the loop
        for target in successors.get(name, ()):
            rows[target] = max(rows.get(target, 0), rows[name] + 1)
            entering[target] -= 1
            if entering[target] == 0:
                ready.append(target)
    if len(ready) < len(boxes):
        raise ValueError("the graph has a cycle")
    return rows


# ----------------------------------------------------------------------------------------------------------- order
def _order(graph: _Graph) -> None:
    """Orders every row, so that few edges cross: the best order that sweeps down and up came by."""
    best, least = [list(row) for row in graph.rows], _crossings(graph)
    for sweep in range(SWEEPS):
        if least == 0:
            break
        _sweep(graph, down=sweep % 2 == 0)
        found = _crossings(graph)
        if found < least:
            best, least = [list(row) for row in graph.rows], found
    graph.rows[:] = best


def _sweep(graph: _Graph, down: bool) -> None:
    position = _positions(graph)
    rows = range(1, len(graph.rows)) if down else range(len(graph.rows) - 2, -1, -1)
    for row in rows:
        cells = graph.rows[row]
        keys = {}
        for cell in cells:
            beside = graph.cells[cell].above if down else graph.cells[cell].below
            found = [
                position[other] + (_port_share(graph, other, offset) if down else 0.0) for other, offset in beside
            ]
            keys[cell] = sum(found) / len(found) if found else position[cell]
        cells.sort(key=lambda cell: keys[cell])
        position.update({cell: float(i) for i, cell in enumerate(cells)})


def _positions(graph: _Graph) -> dict[int, float]:
    return {cell: float(i) for row in graph.rows for i, cell in enumerate(row)}


def _port_share(graph: _Graph, cell: int, offset: float) -> float:
    """The offset of a port as a share of the box, below one half: ports order the edges of one box."""
    return 0.98 * offset / max(graph.cells[cell].width, 1.0)


def _crossings(graph: _Graph) -> int:
    """The number of crossings between all neighbouring rows."""
    position = _positions(graph)
    total = 0
    for upper, lower in zip(graph.rows, graph.rows[1:], strict=False):
        ends = [
            (position[cell] + _port_share(graph, cell, offset), position[other])
            for cell in upper
            for other, offset in graph.cells[cell].below
        ]
        ends.sort()
        total += _inversions([int(end) for _, end in ends], len(lower))
    return total


def _inversions(values: Sequence[int], size: int) -> int:
    """The number of pairs in the wrong order, by a Fenwick tree."""
    tree, total = [0] * (size + 1), 0
    for seen, value in enumerate(values):
        k, smaller = value + 1, 0
        while k > 0:
            smaller += tree[k]
            k -= k & -k
        total += seen - smaller
        k = value + 1
        while k <= size:
            tree[k] += 1
            k += k & -k
    return total


# ---------------------------------------------------------------------------------------------------------- places
def _places(graph: _Graph) -> list[float]:
    """The x of every cell's middle: near its neighbours', in order, and without overlaps."""
    x = [0.0] * len(graph.cells)
    for row in graph.rows:
        for left, right in zip(row, row[1:], strict=False):
            x[right] = x[left] + graph.gap(left, right)
    for _ in range(PLACING_ROUNDS):
        for row in graph.rows[1:]:
            _place_row(graph, row, x, above=True, below=False)
        for row in graph.rows[-2::-1]:
            _place_row(graph, row, x, above=False, below=True)
    for row in graph.rows:
        _place_row(graph, row, x, above=True, below=True)
    for row in graph.rows[1:]:
        _straighten_row(graph, row, x)
    return x


def _straighten_row(graph: _Graph, row: Sequence[int], x: list[float]) -> None:
    """Places what alone follows one cell exactly below it, unless there is no room: chains and long edges are straight."""
    wishes, weights = [], []
    for number in row:
        above = graph.cells[number].above
        alone = len(above) == 1 and len(graph.cells[above[0][0]].below) == 1
        wishes.append(x[above[0][0]] + above[0][1] if alone else x[number])
        weights.append(STIFF if alone else 1.0)
    for number, place in zip(row, _spread(wishes, weights, _gaps(graph, row)), strict=True):
        x[number] = place


def _gaps(graph: _Graph, row: Sequence[int]) -> list[float]:
    return [graph.gap(left, right) for left, right in zip(row, row[1:], strict=False)]


def _place_row(graph: _Graph, row: Sequence[int], x: list[float], above: bool, below: bool) -> None:
    wishes, weights = [], []
    for number in row:
        cell = graph.cells[number]
        found = [(x[other] + offset, other) for other, offset in cell.above] if above else []
        found += [(x[other] - offset, other) for other, offset in cell.below] if below else []
        strong = [STRAIGHT if not cell.name and not graph.cells[other].name else 1.0 for _, other in found]
        weight = sum(strong)
        wish = sum(w * s for (w, _), s in zip(found, strong, strict=True)) / weight if weight else x[number]
        wishes.append(wish)
        weights.append(max(weight, 0.05))
    for number, place in zip(row, _spread(wishes, weights, _gaps(graph, row)), strict=True):
        x[number] = place


def _spread(wishes: Sequence[float], weights: Sequence[float], gaps: Sequence[float]) -> list[float]:
    """The places nearest to the wishes (weighted least squares) that keep the gaps.

    Without the gaps this is regression by an increasing function: neighbours that are out of order are pooled.
    """
    shifts = [0.0]
    for gap in gaps:
        shifts.append(shifts[-1] + gap)
    pools: list[tuple[float, float, int]] = []  # mean, weight, count
    for wish, weight, shift in zip(wishes, weights, shifts, strict=False):
        mean, heavy, count = wish - shift, weight, 1
        while pools and pools[-1][0] > mean:
            other, w, n = pools.pop()
            mean, heavy, count = (other * w + mean * heavy) / (w + heavy), w + heavy, count + n
        pools.append((mean, heavy, count))
    means = [mean for mean, _, count in pools for _ in range(count)]
    return [mean + shift for mean, shift in zip(means, shifts, strict=False)]


# ---------------------------------------------------------------------------------------------------------- routes
def _routed(graph: _Graph, x: Sequence[float]) -> Layout:
    left = min((x[i] - cell.width / 2.0 for i, cell in enumerate(graph.cells)), default=0.0)
    right = max((x[i] + cell.width / 2.0 for i, cell in enumerate(graph.cells)), default=0.0)
    tops, bottoms, y = [], [], 0.0
    for cells in graph.rows:
        height = max(graph.boxes[name].height for name in (graph.cells[i].name for i in cells) if name)
        tops.append(round(y, 2))
        bottoms.append(round(y + height, 2))
        y += height + BETWEEN
    middle = [round(value - left, 2) for value in x]
    places = {}
    for name, i in graph.number.items():
        box, row = graph.boxes[name], graph.row_of[i]
        places[name] = Place(round(middle[i] - box.width / 2.0, 2), tops[row], box.width, box.height, row)
    routes = []
    for source, target, port, lanes in graph.edges:
        start, begin = graph.number[source], places[source]
        across = round(middle[start] + graph.boxes[source].ports[port], 2)
        points = [(across, round(begin.y + begin.height, 2)), (across, bottoms[begin.row])]
        for lane in lanes:
            row = graph.row_of[lane]
            points += [(middle[lane], tops[row]), (middle[lane], bottoms[row])]
        points.append((middle[graph.number[target]], places[target].y))
        routes.append(Route(source, target, port, tuple(dict.fromkeys(points))))
    return Layout(places, tuple(routes), round(right - left, 2), bottoms[-1] if bottoms else 0.0)
