"""The nodes of fallbacks: a child is tried only where the children before it failed [T 3.3.3].

Generating fallbacks choose a child once. Propagating fallbacks choose one for each state: the best state comes
first, and all children are tried on it before the next state. Connecting fallbacks choose one for each pair of
states: each pair is a `Lane`, and later children wait while an earlier child has runnable jobs. The methods
`may_add` and `may_join` of a child tell whether it has failed. They are called only for states that are alive (may
still become part of a whole solution), because the jobs of other states are parked, so that the child may not have
tried everything.
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
    """The node of generating fallbacks: the next child starts when the present one ended without solutions."""

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        self._index = -1  # the last child that was started
        self._solved = False
        self.asking = False  # while it finds out whether a child waits: the next child's states do not count

    def start(self) -> None:
        """Starts the first child only."""
        if self._index < 0:
            self._index = 0
            self.children[0].start()

    def move_on(self, everything: bool) -> bool:
        """Starts the next child if the present one has failed; returns whether it started one.

        Args:
            everything: whether to examine every open decision; else only those affected by the latest changes.

        If it returns True, the scheduler calls it again after all states are up to date.
        """
        left = 0 <= self._index < len(self.children) - 1 and not (self._solved or self.closed)
        if not everything or not left:
            return False
        here: StageNode | None = self  # fallbacks around it wait for this one to end
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
        """Starts the next child early, to break a circle of fallbacks that wait for each other."""
        if not 0 <= self._index < len(self.children) - 1 or self._solved or self.closed:
            return False
        self._index += 1
        self.children[self._index].start()
        self.planning.changes += 1
        return True

    def may_pass_on(self, child: StageNode) -> bool:
        """Whether the child may still be started, because the children before it may fail."""
        left = self._index >= 0 and not (self._solved or self.closed or self.asking)
        return left and self.children.index(child) > self._index

    def busy(self) -> bool:
        """Whether a started child is busy, or a further child may be started."""
        if self.closed or self.asking or self._index < 0:
            return False
        left = not self._solved and self._index + 1 < len(self.children)
        return left or any(child.busy() for child in self.children[: self._index + 1])

    def child_solved(self, child: StageNode, solution: Solution) -> None:
        """Reports the child's solution as a solution of the container; no further child will be started."""
        self._solved = True
        super().child_solved(child, solution)


class PropagatingFallbacksNode(FallbacksNode):
    """The node of propagating fallbacks: each state tries the children one after another."""

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        self._near, self._far = (RIGHT, LEFT) if self.flow is Flow.BACKWARD else (LEFT, RIGHT)
        self._heap: list[tuple[tuple[int, float], int, State]] = []
        self._waiting: dict[State, tuple[int, float]] = {}
        self._asked: dict[State, int] = {}  # by state, the index of the last child that it was given to
        self._trying: dict[State, None] = {}  # states that were given to a child and have no solution yet

    def start(self) -> None:
        """Starts all children, because generators inside them write states for all arriving states.

        These generators are exempt from pruning: their states may be useless for one state, but not for others.
        """
        ParallelNode.start(self)
        waiting = list(self.children)
        while waiting:
            node = waiting.pop()
            if node.flow is not Flow.GENERATE:
                node.kept |= any(child.flow is Flow.GENERATE for child in node.children)
                waiting.extend(node.children)

    def take(self, state: State, side: int, lane: object) -> None:
        """Queues an arriving state; states are tried one after another."""
        self.planning.changes += 1
        self._queue(state)

    def _queue(self, state: State) -> None:
        order = self._waiting[state] = state.order[self._near]
        heappush(self._heap, (order, state.number, state))

    def rekey(self, state: State, side: int) -> None:
        """Requeues a waiting state at its improved priority, or notifies the children that were given it."""
        if state in self._waiting:
            self._queue(state)
        else:
            super().rekey(state, side)

    def revived(self, state: State) -> None:
        """Requeues a waiting state that is alive again.

        If it does not wait, notifies the children that were given it.
        """
        if state in self._waiting:
            self._queue(state)
        else:
            super().revived(state)

    def move_on(self, everything: bool) -> bool:
        """Passes a failed state on to the next child, or gives the best waiting state to the first.

        Returns whether a state was passed on or given.
        """
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
            self.planning.recheck(state, self._far)
            self.planning.work_changed(self, state.lane)
        while self._heap and not any(map(self._alive, self._trying)):
            order, _, state = heappop(self._heap)
            if self._waiting.get(state) == order and self._alive(state):
                del self._waiting[state]
                self._trying[state] = None
                self._ask(state, 0)
                return True
        return False

    def give_way(self) -> bool:
        """Passes a state on early, to break a circle of fallbacks that wait for each other."""
        for state in self._trying if not self.closed else ():
            if self._asked[state] + 1 < len(self.children) and self._alive(state):
                self._ask(state, self._asked[state] + 1)
                return True
        return False

    def _alive(self, state: State) -> bool:
        """Whether a decision about the state is possible; jobs of states that are not alive may be parked."""
        return state.alive[self._near] or self.kept

    def _ask(self, state: State, index: int) -> None:
        self._asked[state] = index
        self.children[index].take(state, self._near, state.lane)
        self.planning.changes += 1

    def child_solved(self, child: StageNode, solution: Solution) -> None:
        """Reports the child's solution as a solution of the container; the next state may be tried."""
        near = solution.start if self._near == LEFT else solution.end
        if near in self._trying:
            del self._trying[near]
            self.planning.recheck(near, self._far)
        super().child_solved(child, solution)

    def may_pass_on(self, child: StageNode) -> bool:
        """False: children are started at once and then given single states, which `delivers_to` counts."""
        return False

    def _left(self, state: State) -> bool:
        """Whether the state waits, or is being tried and a further child remains."""
        return state in self._waiting or (state in self._trying and self._asked[state] + 1 < len(self.children))

    def _had(self, state: State) -> list[StageNode]:
        return self.children[: self._asked.get(state, -1) + 1]

    def works_on(self, state: State, side: int) -> bool:
        """Whether the state waits, can be given to a further child, or is worked on by one that has it."""
        left = self._left(state) or any(child.works_on(state, side) for child in self._had(state))
        return left and not self.closed

    def may_add(self, state: State, side: int, lane: object) -> bool:
        """Whether the state waits, can be given to a further child, or may get solutions from one that has it."""
        left = self._left(state) or any(child.may_add(state, side, lane) for child in self._had(state))
        return left and not self.closed

    def busy(self) -> bool:
        """Whether any waiting state is alive, or any child is busy."""
        if self.closed:
            return False
        return any(map(self._alive, self._waiting)) or any(child.busy() for child in self.children)

    def delivers_to(self, child: StageNode, side: int) -> bool:
        """Whether the child may be given states that wait, are tried elsewhere, or may still arrive."""
        # States that the child has already do not count: monitoring generators would wait for ever.
        index = self.children.index(child)
        coming = any(self._asked[state] < index for state in self._trying if self._alive(state))
        return coming or any(map(self._alive, self._waiting)) or super().delivers_to(child, side)


class Lane:
    """A pair of states to be joined, for which the children are tried in turn.

    States of different lanes are never joined.
    """

    __slots__ = ("end", "fallbacks", "index", "outer", "solved", "start")

    def __init__(self, fallbacks: "ConnectingFallbacksNode", start: State, end: State, outer: object) -> None:
        self.fallbacks, self.start, self.end, self.outer = fallbacks, start, end, outer
        self.index = 0
        self.solved = False


class ConnectingFallbacksNode(Joining, FallbacksNode):
    """The node of fallbacks that connect two states: each pair of states tries the children one after another."""

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        self._sides: tuple[list[tuple[State, object]], list[tuple[State, object]]] = ([], [])
        self._lanes: dict[State, dict[Lane, None]] = {}  # by state, the open lanes of its pairs
        self._pairs: dict[tuple[State, State], list[Lane]] = {}  # by pair of states, its open lanes
        self.doubtful: dict[Lane, None] = {}  # lanes that may be ready to be passed on or closed
        self.stale = False  # whether all lanes may be, because work outside any lane has changed

    def start(self) -> None:
        """Starts all children, because generators inside them write states for all pairs."""
        ParallelNode.start(self)

    def take(self, state: State, side: int, lane: object) -> None:
        """Creates a lane for every pair of the new state with a state on the other side.

        Gives each pair to the first child.
        """
        self._sides[side].append((state, lane))
        for other, its_lane in list(self._sides[1 - side]):
            if meet(lane, its_lane):
                start, end = (state, other) if side == LEFT else (other, state)
                made = Lane(self, start, end, its_lane if lane is None else lane)
                self._pairs.setdefault((start, end), []).append(made)
                for each, far in ((start, RIGHT), (end, LEFT)):
                    self._lanes.setdefault(each, {})[made] = None
                    self.planning.recheck(each, far)
                self._ask(made)

    def arrived(self, side: int) -> Iterable[State]:
        """The states that have arrived on `side` so far."""
        return (state for state, _ in self._sides[side])

    def _ask(self, lane: Lane) -> None:
        child = self.children[lane.index]
        child.take(lane.start, LEFT, lane)
        child.take(lane.end, RIGHT, lane)
        self.doubtful[lane] = None
        self.planning.changes += 1

    def move_on(self, everything: bool) -> bool:
        """Passes one failed lane on to the next child, and closes finished lanes.

        Returns whether a lane was passed on.
        """
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
        """Passes a lane on early, to break a circle of fallbacks that wait for each other."""
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
            self.planning.recheck(state, side)
        self.planning.work_changed(self, lane.outer)

    def child_solved(self, child: StageNode, solution: Solution) -> None:
        """Reports the child's solution as a solution of the container.

        Further children are not tried on its pair of states.
        """
        index = self.children.index(child)
        for lane in self._pairs.get((solution.start, solution.end), ()):  # type: ignore[arg-type]
            if lane.index == index:
                lane.solved = True
        super().child_solved(child, solution)

    def works_on(self, state: State, side: int) -> bool:
        """Whether the state has an open lane with a state that is alive, or further partners may arrive."""
        if self.closed:
            return False
        return self.expects[side] or any(partner.alive[side] for partner in self.partners(state, side))

    def may_add(self, state: State, side: int, lane: object) -> bool:
        """Whether runnable jobs in the lane may still join the state, or further partners may arrive."""
        lanes = (each for each in self._lanes.get(state, ()) if meet(each.outer, lane))
        return not self.closed and (self.expects[side] or any(map(self._may_add, lanes)))

    def may_join(self, start: State, end: State, lane: object) -> bool:
        """Whether runnable jobs of the children may still join the two states in the lane."""
        lanes = (each for each in self._pairs.get((start, end), ()) if each.outer is lane)
        return not self.closed and any(map(self._may_add, lanes))

    def _may_add(self, lane: Lane) -> bool:
        if not self._alive(lane):
            return False
        return (not lane.solved and lane.index + 1 < len(self.children)) or self._works(lane)

    def _works(self, lane: Lane) -> bool:
        return self.children[lane.index].may_join(lane.start, lane.end, lane)

    def busy(self) -> bool:
        """Whether any child is busy, or any lane has to be examined: passed on, or closed."""
        return not self.closed and (self.stale or bool(self.doubtful) or ParallelNode.busy(self))

    def partners(self, state: State, side: int) -> Iterable[State]:
        """The states with which the given state shares a lane that is still open."""
        return [lane.end if side == RIGHT else lane.start for lane in self._lanes.get(state, ())]

    def delivers_to(self, child: StageNode, side: int) -> bool:
        """False: a child gets both states of a lane at once, so no single state of a pair is still to come."""
        return False

    def may_pass_on(self, child: StageNode) -> bool:
        """Whether new pairs may arrive, or a pair tried with an earlier child may be passed on to `child`."""
        index = self.children.index(child)
        lanes = (lane for lanes in self._pairs.values() for lane in lanes)
        coming = any(lane.index < index and not lane.solved and self._alive(lane) for lane in lanes)
        return not self.closed and (coming or self.may_receive())

    def permits(self, child: StageNode) -> bool:
        """Whether a child may run jobs now, that is, whether no earlier child has a runnable job."""
        earlier = self.children[: self.children.index(child)]
        return not any(leaf.best() for node in earlier for leaf in _leaves(node))


def _leaves(node: StageNode) -> Iterable[Leaf]:
    if isinstance(node, Leaf):
        yield node
    for child in node.children:
        yield from _leaves(child)
