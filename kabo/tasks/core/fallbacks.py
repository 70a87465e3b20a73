"""The node of fallbacks: a child is asked only where the one before it gave nothing [T 3.3.3].

Propagating, that is decided for each state, the cheapest first, and all children for one state before the next.
Connecting, for each pair: a pair is a lane of its own, and while the first child has pairs open, later ones wait.
Generating, once: the next child begins when the former ended with nothing at all.
"""

from collections.abc import Iterable
from heapq import heappop, heappush
from typing import Any

from kabo.tasks.core.flow import Flow
from kabo.tasks.core.groups import ParallelNode
from kabo.tasks.core.nodes import Ended, Node
from kabo.tasks.core.solutions import LEFT, RIGHT, Solution, State


class FallbacksNode(ParallelNode):
    """Fallbacks, whichever way states flow."""

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        self._near, self._far = (RIGHT, LEFT) if self.flow is Flow.BACKWARD else (LEFT, RIGHT)
        self._heap: list[tuple[tuple[int, float], int, State]] = []
        self._waiting: dict[State, tuple[int, float]] = {}
        self._asked: dict[object, int] = {}  # which child has a state, or a lane; gone when all is done
        self._solved: set[object] = set()
        self._current: State | None = None
        self._generating = 0
        self._sides: tuple[list[tuple[State, object]], list[tuple[State, object]]] = ([], [])
        self._pairs: dict[object, tuple[State, State]] = {}

    # -------------------------------------------------------------------------------------------- generating
    def start(self) -> None:
        """Starts the first child alone, if they generate; else all, for what they hold inside."""
        for child in self.children[:1] if self.flow is Flow.GENERATE else self.children:
            child.start()

    def advance(self) -> bool:
        """Starts the next child, if the present one ended with nothing; whether it did."""
        if self.flow is not Flow.GENERATE or self.closed or self.children[self._generating].busy():
            return False
        if self.solutions or self._generating + 1 == len(self.children):
            return False
        self._generating += 1
        self.children[self._generating].start()
        return True

    def busy(self) -> bool:
        """Whether a child is, or one is left to ask."""
        if self.closed:
            return False
        if self.flow is Flow.GENERATE:
            left = not self.solutions and self._generating + 1 < len(self.children)
            return left or any(child.busy() for child in self.children[: self._generating + 1])
        return bool(self._waiting) or any(child.busy() for child in self.children)

    # ------------------------------------------------------------------------------------- states and pairs
    def take(self, state: State, side: int, lane: object) -> None:
        """Queues a state, or tries all pairs that it makes."""
        if self.flow is not Flow.CONNECT:
            self._queue(state)
            self._next()
            return
        self._sides[side].append((state, lane))
        for other, its_lane in list(self._sides[1 - side]):
            if its_lane == lane:
                pair = (state, other) if side == LEFT else (other, state)
                key = (pair[0].number, pair[1].number, lane)
                self._pairs[key] = pair
                self._asked[key] = 0
                self._feed(key)

    def _queue(self, state: State) -> None:
        order = self._waiting[state] = state.order[self._near]
        heappush(self._heap, (order, state.number, state))

    def rekey(self, state: State, side: int) -> None:
        """Queues it again, or hands it on to whom has it."""
        if state in self._waiting:
            self._queue(state)
        else:
            super().rekey(state, side)

    def _next(self) -> None:
        """Gives the best state that waits to the first child, if none is being asked for."""
        while self._current is None and self._heap:
            key, _, state = heappop(self._heap)
            if self._waiting.get(state) != key:
                continue
            del self._waiting[state]
            self._current = state
            self._asked[state] = 0
            self.children[0].take(state, self._near, state.lane)

    def _feed(self, lane: object) -> None:
        child = self.children[self._asked[lane]]
        start, end = self._pairs[lane]
        child.take(start, LEFT, lane)
        child.take(end, RIGHT, lane)

    def child_solved(self, child: Node, solution: Solution) -> None:
        """It is one of the container; and the next state may be asked for."""
        if self.flow is Flow.CONNECT:
            self._solved.add(self._lane_of(child, solution))
        elif self.flow is not Flow.GENERATE:
            near = solution.start if self._near == LEFT else solution.end
            self._solved.add(near)
            if near is self._current:
                self._current = None
                self._next()
        super().child_solved(child, solution)

    def _lane_of(self, child: Node, solution: Solution) -> object:
        index = self.children.index(child)
        for lane, pair in self._pairs.items():
            if pair == (solution.start, solution.end) and self._asked.get(lane) == index:
                return lane
        return None

    def child_finished(self, child: Node, state: State, side: int, lane: object) -> Ended:
        """The next child has a try, if there is one and it is needed."""
        key: object = lane if self.flow is Flow.CONNECT else state
        index = self.children.index(child)
        if self._asked.get(key) != index or (self.flow is not Flow.CONNECT and child.works_on(state, side)):
            return []
        if key not in self._solved and index + 1 < len(self.children):
            self._asked[key] = index + 1
            if self.flow is Flow.CONNECT:
                self._feed(key)
            else:
                self.children[index + 1].take(state, self._near, state.lane)
            return []
        del self._asked[key]
        if self.flow is Flow.CONNECT:
            start, end = self._pairs.pop(key)
            return [*self.finished(start, RIGHT, start.lane), *self.finished(end, LEFT, end.lane)]
        if state is self._current:
            self._current = None
            self._next()
        return self.finished(state, side, state.lane)

    def works_on(self, state: State, side: int) -> bool:
        """Whether it waits, is being asked for, or may get partners."""
        if self.closed:
            return False
        if self.flow is not Flow.CONNECT:
            return state in self._waiting or state in self._asked
        beyond = RIGHT if side == RIGHT else LEFT
        for start, end in self._pairs.values():
            near, far = (start, end) if side == RIGHT else (end, start)
            if near is state and far.alive[beyond]:
                return True
        lanes = [lane for s, lane in self._sides[1 - side] if s is state]
        parent = self.parent
        return parent is not None and any(parent.delivers_to(self, side, lane) for lane in lanes)

    def waiting(self) -> Ended:
        """The states that are alive through it only because partners may still come."""
        return [(s, 1 - side) for side in (LEFT, RIGHT) for s, _ in self._sides[side] if s.alive[1 - side]]

    def partners(self, state: State, side: int) -> Iterable[State]:
        """Those with which it is a pair."""
        pairs = self._pairs.values()
        return [end if start is state else start for start, end in pairs if state in (start, end)]

    def delivers_to(self, child: Node, side: int, lane: object) -> bool:
        """A lane has all it will get; else whatever waits here may still come."""
        if self.flow is Flow.CONNECT:
            return False
        return bool(self._waiting) or bool(self._asked) or super().delivers_to(child, side, lane)

    def permits(self, child: Node) -> bool:
        """Whether a child may run now: connecting, while no earlier one has open pairs."""
        if self.flow is not Flow.CONNECT:
            return True
        index = self.children.index(child)
        return not any(asked < index for asked in self._asked.values())
