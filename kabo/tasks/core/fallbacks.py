"""The node of fallbacks: a child is asked only where the one before it gave nothing [T 3.3.3].

Propagating, that is decided for each state, the cheapest first, and all children for one state before the next.
Connecting, for each pair: a pair is a lane of its own, and while the first child has pairs open, later ones wait.
Generating, once: the next child begins when the former ended with nothing at all.
"""

from collections.abc import Iterable
from heapq import heappop, heappush
from typing import Any

from kabo.tasks.core.flow import Flow
from kabo.tasks.core.graph import meet
from kabo.tasks.core.groups import ParallelNode
from kabo.tasks.core.nodes import Ended, Node
from kabo.tasks.core.solutions import LEFT, RIGHT, Solution, State

Lane = tuple[int, int, object]  # the numbers of both states, and the lane that they came in


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
        self._generating = -1  # the last child that was started
        self._sides: tuple[list[tuple[State, object]], list[tuple[State, object]]] = ([], [])
        self._pairs: dict[Lane, tuple[State, State]] = {}
        self._lanes: dict[State, dict[Lane, None]] = {}  # of each state, those of its pairs that are open
        self._between: dict[tuple[State, State], list[Lane]] = {}  # the same of each pair
        self._came: dict[State, list[object]] = {}  # the lanes in which a state was let in
        self._lonely: dict[State, int] = {}  # states without open pairs, and the side on which partners may come
        self._open = [0] * len(self.stage.children)  # how many pairs each child is asked for, and solved none yet

    # -------------------------------------------------------------------------------------------- generating
    def start(self) -> None:
        """Starts the first child alone, if they generate; else all, for what they hold inside."""
        if self.flow is not Flow.GENERATE:
            super().start()
        elif self._generating < 0:
            self._generating = 0
            self.children[0].start()

    def advance(self) -> bool:
        """Goes on to the next child, if the present one ended with nothing, or to the next state; whether it did."""
        if self._current is not None:
            ended = self._state_finished(self._current, self._asked[self._current])
            self.planning.ended(ended or [])
            return ended is not None
        if self._generating < 0 or self.closed or self.children[self._generating].busy():
            return False
        if self._solved or self._generating + 1 == len(self.children):
            return False
        self._generating += 1
        self.children[self._generating].start()
        return True

    def busy(self) -> bool:
        """Whether a child is, or one is left to ask."""
        if self.closed:
            return False
        if self.flow is Flow.GENERATE:
            left = not self._solved and self._generating + 1 < len(self.children)
            return left or any(child.busy() for child in self.children[: self._generating + 1])
        return bool(self._waiting) or any(child.busy() for child in self.children)

    def keep_shared(self) -> None:
        """What a child generates inside serves all states; that it is of no use for one says nothing of others."""
        waiting = [] if self.flow is Flow.GENERATE else list(self.children)
        while waiting:
            node = waiting.pop()
            if node.flow is not Flow.GENERATE:
                node.kept |= any(child.flow is Flow.GENERATE for child in node.children)
                waiting.extend(node.children)

    # ------------------------------------------------------------------------------------- states and pairs
    def take(self, state: State, side: int, lane: object) -> None:
        """Queues a state, or tries all pairs that it makes."""
        if self.flow is not Flow.CONNECT:
            self._queue(state)
            self._next()
            return
        self._sides[side].append((state, lane))
        self._came.setdefault(state, []).append(lane)
        self._lonely[state] = 1 - side
        for other, its_lane in list(self._sides[1 - side]):
            if meet(lane, its_lane):
                pair = (state, other) if side == LEFT else (other, state)
                key = (pair[0].number, pair[1].number, its_lane if lane is None else lane)
                self._pairs[key] = pair
                self._between.setdefault(pair, []).append(key)
                for each in pair:
                    self._lanes.setdefault(each, {})[key] = None
                    self._lonely.pop(each, None)
                self._feed(key, 0)

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

    def _feed(self, lane: Lane, index: int) -> None:
        self._asked[lane] = index
        self._open[index] += 1
        child = self.children[index]
        start, end = self._pairs[lane]
        child.take(start, LEFT, lane)
        child.take(end, RIGHT, lane)

    def child_solved(self, child: Node, solution: Solution) -> None:
        """It is one of the container; and the next state may be asked for."""
        if self.flow is Flow.CONNECT:
            for lane in self._unsolved(child, solution):
                self._open[self._asked[lane]] -= 1
                self._solved.add(lane)
        elif self.flow is Flow.GENERATE:
            self._solved.add(None)
        else:
            near = solution.start if self._near == LEFT else solution.end
            self._solved.add(near)
            if near is self._current:
                self._current = None
                self._next()
        super().child_solved(child, solution)

    def _unsolved(self, child: Node, solution: Solution) -> list[Lane]:
        index = self.children.index(child)
        lanes = self._between.get((solution.start, solution.end), ())  # type: ignore[arg-type]
        return [x for x in lanes if self._asked[x] == index and x not in self._solved]

    def child_finished(self, child: Node, state: State, side: int, lane: object) -> Ended:
        """The next child has a try, if there is one and it is needed."""
        index = self.children.index(child)
        if self.flow is Flow.CONNECT:
            return self._pair_finished(lane, index)  # type: ignore[arg-type]
        return self._state_finished(state, index) or []

    def _state_finished(self, state: State, index: int) -> Ended | None:
        """None if a child is not asked for a state, or not done with it."""
        if self._asked.get(state) != index or self.children[index].may_add(state, self._far):
            return None
        if state not in self._solved and index + 1 < len(self.children):
            self._asked[state] = index + 1
            self.children[index + 1].take(state, self._near, state.lane)
            return []
        del self._asked[state]
        if state is self._current:
            self._current = None
            self._next()
        return self.finished(state, self._far, state.lane)

    def _pair_finished(self, lane: Lane, index: int) -> Ended:
        if self._asked.get(lane) != index:
            return []
        if lane not in self._solved:
            self._open[index] -= 1
            if index + 1 < len(self.children):
                self._feed(lane, index + 1)
                return []
        del self._asked[lane]
        start, end = pair = self._pairs.pop(lane)
        self._between[pair].remove(lane)
        for state, side in ((start, RIGHT), (end, LEFT)):
            self._lanes[state].pop(lane, None)
            if not self._lanes[state]:
                self._lonely[state] = side
        return [*self.finished(start, RIGHT, lane[2]), *self.finished(end, LEFT, lane[2])]

    def works_on(self, state: State, side: int) -> bool:
        """Whether it waits, is being asked for, or may get partners."""
        if self.closed:
            return False
        if self.flow is not Flow.CONNECT:
            return state in self._waiting or state in self._asked
        if any(partner.alive[side] for partner in self.partners(state, side)):
            return True
        parent = self.parent
        if parent is None or not any(parent.delivers_to(self, side, lane) for lane in self._came.get(state, ())):
            return False
        self._lonely[state] = side
        return True

    def may_add(self, state: State, side: int) -> bool:
        """Whether it waits, a child may, or another is left to ask."""
        if self.flow is Flow.CONNECT or state not in self._asked:
            return self.works_on(state, side)
        index = self._asked[state]
        left = state not in self._solved and index + 1 < len(self.children)
        return not self.closed and (left or self.children[index].may_add(state, side))

    def waiting(self) -> Ended:
        """The states that are alive through it only because partners may still come."""
        for state, side in list(self._lonely.items()):
            if not state.alive[side] or state.leads_on(side):
                del self._lonely[state]  # dead; or alive by itself, and noted again when that ends
        return list(self._lonely.items())

    def partners(self, state: State, side: int) -> Iterable[State]:
        """Those with which it is a pair."""
        for lane in self._lanes.get(state, ()):
            start, end = self._pairs[lane]
            yield end if start is state else start

    def delivers_to(self, child: Node, side: int, lane: object) -> bool:
        """A lane has all it will get; else whatever waits here may still come."""
        if self.flow is Flow.CONNECT:
            return False
        index = self.children.index(child)
        coming = any(
            at < index for at in self._asked.values()
        )  # not what the child has already: monitors would wait
        return bool(self._waiting) or coming or super().delivers_to(child, side, lane)

    def permits(self, child: Node) -> bool:
        """Whether a child may run now: connecting, while no earlier one has open pairs."""
        if self.flow is not Flow.CONNECT:
            return True
        return not any(self._open[: self.children.index(child)])
