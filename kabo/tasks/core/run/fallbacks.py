"""The nodes of fallbacks: a child is asked only where the one before it gave nothing [T 3.3.3].

Generating, that is decided once. Propagating, for each state, the cheapest first, and all children for one state before
the next. Connecting, for each pair: a pair is a lane of its own, and while an earlier child has jobs that can run, later
ones wait. Whether a child gave nothing is never told; it is asked, by `may_add` and `may_join`, and only of states that
are alive: what is parked in the child says nothing yet.
"""

from collections.abc import Iterable
from heapq import heappop, heappush
from typing import Any

from kabo.tasks.core.model.flow import Flow
from kabo.tasks.core.model.solutions import LEFT, RIGHT, Solution, State
from kabo.tasks.core.run.graph import meet
from kabo.tasks.core.run.groups import ParallelNode
from kabo.tasks.core.run.job_queues import Leaf
from kabo.tasks.core.run.leaves import Joining
from kabo.tasks.core.run.nodes import StageNode


class FallbacksNode(ParallelNode):
    """Fallbacks that generate: the next child begins when the former ended with nothing at all."""

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        self._index = -1  # the last child that was started
        self._solved = False
        self.asking = False  # a child that waits for what the next would bring about waits in vain

    def start(self) -> None:
        """Starts the first child alone."""
        if self._index < 0:
            self._index = 0
            self.children[0].start()

    def move_on(self, everything: bool) -> bool:
        """Goes on to the next child where the former gave nothing: anywhere, or where that may just have happened.

        Whether it did; then it is to be asked again when all that follows from it is known.
        """
        left = 0 <= self._index < len(self.children) - 1 and not (self._solved or self.closed)
        if not everything or not left:
            return False
        here: StageNode | None = self  # those around it wait for this one to end
        asking = []
        while here is not None:
            asking += [here] if isinstance(here, FallbacksNode) else []
            here = here.parent
        for node in asking:
            node.asking = True
        waits = self.children[self._index].busy()
        for node in asking:
            node.asking = False
        return not waits and self.give_way()

    def give_way(self) -> bool:
        """Goes on though a child waits: for other fallbacks that wait, in a circle, for this one."""
        if not 0 <= self._index < len(self.children) - 1 or self._solved or self.closed:
            return False
        self._index += 1
        self.children[self._index].start()
        self.planning.changes += 1
        return True

    def hands_on(self, child: StageNode) -> bool:
        """Whether the child may still begin."""
        left = self._index >= 0 and not (self._solved or self.closed or self.asking)
        return left and self.children.index(child) > self._index

    def busy(self) -> bool:
        """Whether a child is, or one is left to ask."""
        if self.closed or self.asking or self._index < 0:
            return False
        left = not self._solved and self._index + 1 < len(self.children)
        return left or any(child.busy() for child in self.children[: self._index + 1])

    def child_solved(self, child: StageNode, solution: Solution) -> None:
        """It is one of the container."""
        self._solved = True
        super().child_solved(child, solution)


class PropagatingFallbacksNode(FallbacksNode):
    """Fallbacks that decide for each state."""

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        self._near, self._far = (RIGHT, LEFT) if self.flow is Flow.BACKWARD else (LEFT, RIGHT)
        self._heap: list[tuple[tuple[int, float], int, State]] = []
        self._waiting: dict[State, tuple[int, float]] = {}
        self._asked: dict[State, int] = {}  # which child was asked last for a state
        self._trying: dict[State, None] = {}  # the states without a solution that a child was asked for

    def start(self) -> None:
        """Starts all children, for what they hold inside, which serves all states.

        That it is of no use for what comes after the solution of one state says nothing of others.
        """
        ParallelNode.start(self)
        waiting = list(self.children)
        while waiting:
            node = waiting.pop()
            if node.flow is not Flow.GENERATE:
                node.kept |= any(child.flow is Flow.GENERATE for child in node.children)
                waiting.extend(node.children)

    def take(self, state: State, side: int, lane: object) -> None:
        """Queues a state."""
        self.planning.changes += 1
        self._queue(state)

    def _queue(self, state: State) -> None:
        order = self._waiting[state] = state.order[self._near]
        heappush(self._heap, (order, state.number, state))

    def rekey(self, state: State, side: int) -> None:
        """Queues it again, or hands it on to whom has it."""
        if state in self._waiting:
            self._queue(state)
        else:
            super().rekey(state, side)

    def revived(self, state: State) -> None:
        """The same."""
        if state in self._waiting:
            self._queue(state)
        else:
            super().revived(state)

    def move_on(self, everything: bool) -> bool:
        """Hands a state on to the next child; or the best that waits to the first, if none is being asked for."""
        if self.closed:
            return False
        for state in [s for s in self._trying if self._alive(s)]:
            index = self._asked[state]
            if self.children[index].may_add(state, self._far, state.lane):
                continue
            if index + 1 < len(self.children):
                self._ask(state, index + 1)
                return True
            del self._trying[state]
            self.planning.touch(state, self._far)
            self.planning.rested(self, state.lane)
        while self._heap and not any(map(self._alive, self._trying)):
            order, _, state = heappop(self._heap)
            if self._waiting.get(state) == order and self._alive(state):
                del self._waiting[state]
                self._trying[state] = None
                self._ask(state, 0)
                return True
        return False

    def give_way(self) -> bool:
        """Hands the first state on that waits for what does not come."""
        for state in self._trying if not self.closed else ():
            if self._asked[state] + 1 < len(self.children) and self._alive(state):
                self._ask(state, self._asked[state] + 1)
                return True
        return False

    def _alive(self, state: State) -> bool:
        """Whether a state is one to decide for; what is not alive may have pruned jobs."""
        return state.alive[self._near] or self.kept

    def _ask(self, state: State, index: int) -> None:
        self._asked[state] = index
        self.children[index].take(state, self._near, state.lane)
        self.planning.changes += 1

    def child_solved(self, child: StageNode, solution: Solution) -> None:
        """It is one of the container; and the next state may be asked for."""
        near = solution.start if self._near == LEFT else solution.end
        if near in self._trying:
            del self._trying[near]
            self.planning.touch(near, self._far)
        super().child_solved(child, solution)

    def hands_on(self, child: StageNode) -> bool:
        """Not where nothing is delivered."""
        return False

    def _left(self, state: State) -> bool:
        """Whether it waits, or a child is left to ask."""
        return state in self._waiting or (state in self._trying and self._asked[state] + 1 < len(self.children))

    def _had(self, state: State) -> list[StageNode]:
        return self.children[: self._asked.get(state, -1) + 1]

    def works_on(self, state: State, side: int) -> bool:
        """Whether it waits, a child is left to ask, or one that was asked works on it."""
        left = self._left(state) or any(child.works_on(state, side) for child in self._had(state))
        return left and not self.closed

    def may_add(self, state: State, side: int, lane: object) -> bool:
        """The same, of what can run."""
        left = self._left(state) or any(child.may_add(state, side, lane) for child in self._had(state))
        return left and not self.closed

    def busy(self) -> bool:
        """Whether states wait, or a child is busy."""
        if self.closed:
            return False
        return any(map(self._alive, self._waiting)) or any(child.busy() for child in self.children)

    def delivers_to(self, child: StageNode, side: int) -> bool:
        """Whatever waits here, or is with an earlier child, may still come."""
        index = self.children.index(child)  # not what the child has already: monitors would wait
        coming = any(self._asked[state] < index for state in self._trying if self._alive(state))
        return coming or any(map(self._alive, self._waiting)) or super().delivers_to(child, side)


class Lane:
    """A pair that children are asked for one by one; states of different lanes never meet."""

    __slots__ = ("end", "fallbacks", "index", "outer", "solved", "start")

    def __init__(self, fallbacks: "ConnectingFallbacksNode", start: State, end: State, outer: object) -> None:
        self.fallbacks, self.start, self.end, self.outer = fallbacks, start, end, outer
        self.index = 0
        self.solved = False


class ConnectingFallbacksNode(Joining, FallbacksNode):
    """Fallbacks that decide for each pair."""

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        self._sides: tuple[list[tuple[State, object]], list[tuple[State, object]]] = ([], [])
        self._lanes: dict[State, dict[Lane, None]] = {}  # of each state, those of its pairs that are open
        self._pairs: dict[tuple[State, State], list[Lane]] = {}  # the same of each pair
        self.doubtful: dict[Lane, None] = {}  # lanes that may have come to an end
        self.stale = False  # whether any may, as what serves all has changed

    def start(self) -> None:
        """Starts all children, for what they hold inside."""
        ParallelNode.start(self)

    def take(self, state: State, side: int, lane: object) -> None:
        """Tries all pairs that it makes."""
        self._sides[side].append((state, lane))
        for other, its_lane in list(self._sides[1 - side]):
            if meet(lane, its_lane):
                start, end = (state, other) if side == LEFT else (other, state)
                made = Lane(self, start, end, its_lane if lane is None else lane)
                self._pairs.setdefault((start, end), []).append(made)
                for each, far in ((start, RIGHT), (end, LEFT)):
                    self._lanes.setdefault(each, {})[made] = None
                    self.planning.touch(each, far)
                self._ask(made)

    def came(self, side: int) -> Iterable[State]:
        """The states that came to that side so far."""
        return (state for state, _ in self._sides[side])

    def _ask(self, lane: Lane) -> None:
        child = self.children[lane.index]
        child.take(lane.start, LEFT, lane)
        child.take(lane.end, RIGHT, lane)
        self.doubtful[lane] = None
        self.planning.changes += 1

    def move_on(self, everything: bool) -> bool:
        """Closes pairs of which nothing more can come; or hands one on to the next child."""
        if self.closed:
            return False
        if everything and self.stale:
            self.stale = False
            self.doubtful.update({lane: None for lanes in self._pairs.values() for lane in lanes})
        while self.doubtful:
            lane = next(iter(self.doubtful))
            del self.doubtful[lane]
            if lane.index == len(self.children) or not self._alive(lane) or self._works(lane):
                continue
            lane.index = len(self.children) if lane.solved else lane.index + 1
            if lane.index < len(self.children):
                self._ask(lane)
                return True
            self._close(lane)
        return False

    def give_way(self) -> bool:
        """Hands the first pair on that waits for what does not come."""
        for lane in [lane for lanes in self._pairs.values() for lane in lanes] if not self.closed else ():
            if lane.index + 1 < len(self.children) and not lane.solved and self._alive(lane):
                lane.index += 1
                self._ask(lane)
                return True
        return False

    def _alive(self, lane: Lane) -> bool:
        return (lane.start.alive[LEFT] and lane.end.alive[RIGHT]) or self.kept

    def _close(self, lane: Lane) -> None:
        self._pairs[lane.start, lane.end].remove(lane)
        for state, side in ((lane.start, RIGHT), (lane.end, LEFT)):
            del self._lanes[state][lane]
            self.planning.touch(state, side)
        self.planning.rested(self, lane.outer)

    def child_solved(self, child: StageNode, solution: Solution) -> None:
        """It is one of the container."""
        index = self.children.index(child)
        for lane in self._pairs.get((solution.start, solution.end), ()):  # type: ignore[arg-type]
            if lane.index == index:
                lane.solved = True
        super().child_solved(child, solution)

    def works_on(self, state: State, side: int) -> bool:
        """Whether it is in an open pair with a state that is alive, or more may come to the other side."""
        if self.closed:
            return False
        return self.expects[side] or any(partner.alive[side] for partner in self.partners(state, side))

    def may_add(self, state: State, side: int, lane: object) -> bool:
        """The same, for pairs of a lane, of what can run."""
        lanes = (each for each in self._lanes.get(state, ()) if meet(each.outer, lane))
        return not self.closed and (self.expects[side] or any(map(self._may_add, lanes)))

    def may_join(self, start: State, end: State, lane: object) -> bool:
        """The same, for a pair."""
        lanes = (each for each in self._pairs.get((start, end), ()) if each.outer is lane)
        return not self.closed and any(map(self._may_add, lanes))

    def _may_add(self, lane: Lane) -> bool:
        if not self._alive(lane):
            return False
        return (not lane.solved and lane.index + 1 < len(self.children)) or self._works(lane)

    def _works(self, lane: Lane) -> bool:
        return self.children[lane.index].may_join(lane.start, lane.end, lane)

    def busy(self) -> bool:
        """Whether a child is, or pairs may have to be handed on."""
        return not self.closed and (self.stale or bool(self.doubtful) or ParallelNode.busy(self))

    def partners(self, state: State, side: int) -> Iterable[State]:
        """Those with which it is an open pair."""
        return [lane.end if side == RIGHT else lane.start for lane in self._lanes.get(state, ())]

    def delivers_to(self, child: StageNode, side: int) -> bool:
        """A lane has all it will get."""
        return False

    def hands_on(self, child: StageNode) -> bool:
        """Whether new pairs may come, or one that is with an earlier child."""
        index = self.children.index(child)
        lanes = (lane for lanes in self._pairs.values() for lane in lanes)
        coming = any(lane.index < index and not lane.solved and self._alive(lane) for lane in lanes)
        return not self.closed and (coming or self.may_receive())

    def permits(self, child: StageNode) -> bool:
        """Whether a child may run now: while no earlier one can."""
        earlier = self.children[: self.children.index(child)]
        return not any(leaf.best() for node in earlier for leaf in _leaves(node))


def _leaves(node: StageNode) -> Iterable[Leaf]:
    if isinstance(node, Leaf):
        yield node
    for child in node.children:
        yield from _leaves(child)
