"""Complete paths through a container, generated lazily, the cheapest first [T 3.6].

Edges are solutions of child stages. To find every path exactly once, each new edge starts a search for the paths in
which it is the newest edge: from both its ends to the borders of the container, over older edges only. The cost of
the cheapest path from each state guides the search; it can enter a dead end only where that cost is due to an edge
newer than the one that started the search.
"""

from collections.abc import Iterator
from heapq import heappop, heappush

from kabo.tasks.core.model.solutions import LEFT, RIGHT, Solution, State
from kabo.tasks.core.run.graph import meet
from kabo.tasks.core.run.nodes import Level

Path = tuple[Solution, ...]


class Paths:
    """The complete paths through one container that have not yet been made solutions of it."""

    def __init__(self, level: Level) -> None:
        self._level = level
        # (bound, number, path, search for further paths or None)
        self.heap: list[tuple[float, int, Path, Iterator[tuple[float, Path]] | None]] = []
        self._count = 0

    def add(self, edge: Solution) -> None:
        """Records the complete paths through a new edge, if there are any."""
        level, start, end = self._level, edge.start, edge.end
        if start is None or end is None or not (level.complete(start, LEFT) and level.complete(end, RIGHT)):
            return
        only = _only(level, edge)
        if only is None:
            self._push(_through(level, edge))
            return
        self._count += 1
        first, last = only[0].start, only[-1].end
        if first is not None and last is not None and meet(first.lane, last.lane):
            heappush(self.heap, (_bound(first, last, sum([e.cost for e in only])), self._count, only, None))

    def wait(self, lane: object) -> bool:
        """Whether any of the waiting paths may belong to the given lane."""
        return any(rest is not None or meet(_lane(path), lane) for _, _, path, rest in self.heap)

    def _push(self, source: Iterator[tuple[float, Path]]) -> None:
        first = next(source, None)
        if first is not None:
            self._count += 1
            heappush(self.heap, (first[0], self._count, first[1], source))

    def pop(self) -> Path:
        """Removes the cheapest waiting path and returns it."""
        _, _, path, source = heappop(self.heap)
        if source is not None:
            self._push(source)
        return path


def _lane(path: Path) -> object:
    ends = path[0].start, path[-1].end
    return next((state.lane for state in ends if state is not None and state.lane is not None), None)


def _only(level: Level, edge: Solution) -> Path | None:
    """The path through an edge if it is the only one; None if there is a choice on either side."""
    left: list[Solution] = []
    state, steps = edge.start, 0 if edge.start is None else edge.start.position
    for _ in range(steps):
        if state is None or len(state.edges[LEFT]) != 1:
            return None
        left.append(state.edges[LEFT][0])
        state = left[-1].start
    right: list[Solution] = []
    state, steps = edge.end, 0 if edge.end is None else len(level.children) - edge.end.position
    for _ in range(steps):
        if state is None or len(state.edges[RIGHT]) != 1:
            return None
        right.append(state.edges[RIGHT][0])
        state = right[-1].end
    return (*reversed(left), edge, *right)


def _through(level: Level, edge: Solution) -> Iterator[tuple[float, Path]]:
    """The paths through an edge over edges that are not newer, by increasing cost, of equal ones the longest first."""
    count = 0
    waiting: list[tuple[float, int, int, float, Path]] = [(0.0, 0, 0, edge.cost, (edge,))]
    while waiting:
        bound, _, _, cost, path = heappop(waiting)
        start, end = path[0].start, path[-1].end
        if start is None or end is None:
            continue
        if not level.at_border(start, LEFT):
            steps = ((e, e.start, (e, *path)) for e in start.edges[LEFT])
            grown = [(e, s, end, p) for e, s, p in steps if s is not None and level.complete(s, LEFT)]
        elif not level.at_border(end, RIGHT):
            ahead = ((e, e.end, (*path, e)) for e in end.edges[RIGHT])
            grown = [(e, start, t, p) for e, t, p in ahead if t is not None and level.complete(t, RIGHT)]
        else:
            if meet(start.lane, end.lane):
                yield bound, path
            continue
        for step, first, last, longer in grown:
            if step.number <= edge.number:
                count += 1
                total = cost + step.cost
                # Sums of the same costs in another order differ in their last digits.
                bound = round(_bound(first, last, total), ndigits=9)
                heappush(waiting, (bound, -len(longer), count, total, longer))


def _bound(start: State, end: State, cost: float) -> float:
    return start.best[LEFT][2] + cost + end.best[RIGHT][2]
