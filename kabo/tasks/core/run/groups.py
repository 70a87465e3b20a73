"""The nodes of containers: how solutions of the children become solutions of the container [T 3.3, 3.4]."""

from collections.abc import Iterable
from typing import Any

from kabo.tasks.core.model.solutions import LEFT, RIGHT, Solution, State
from kabo.tasks.core.run.nodes import Level, StageNode
from kabo.tasks.core.run.paths import Paths


class Holder(StageNode):
    """The node of a stage with states inside: each state arriving at its border gets a counterpart inside."""

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        self.inner = Level(self)
        self.inside: dict[State, dict[object, State]] = {}  # the counterparts of each state, by lane

    def take(self, state: State, side: int, lane: object) -> None:
        """Makes a counterpart of the state inside, and gives it to the child at the border on `side`."""
        inner = self.inner.enter(state, side, self.planning.count(), lane)
        self.inside.setdefault(state, {})[lane] = inner
        self.children[0 if side == LEFT else -1].take(inner, side, lane)

    def works_on(self, state: State, side: int) -> bool:
        """Whether a counterpart of the state inside this node is alive on `side`."""
        return not self.closed and any(inner.alive[side] for inner in self.inside.get(state, {}).values())

    def may_add(self, state: State, side: int, lane: object) -> bool:
        """Whether the state's counterpart inside may still lead to another solution of this node."""
        return any(self.may_lead(inner, side) for inner in self.inside.get(state, {}).values())

    def arrived(self, side: int) -> Iterable[State]:
        """The states that have arrived on `side` so far."""
        inside = ((state, inner) for state, lanes in self.inside.items() for inner in lanes.values())
        return (state for state, inner in inside if self.inner.at_border(inner, side))

    def may_join(self, start: State, end: State, lane: object) -> bool:
        """Whether the states' counterparts inside, in the lane, may still lead to a solution of this node."""
        first, last = self.inside[start].get(lane), self.inside[end].get(lane)
        if first is None or last is None:
            return False
        return self.may_lead(first, RIGHT) and self.may_lead(last, LEFT)


class SerialNode(Holder):
    """The node of a serial container: every path of its children's solutions from border to border is a solution."""

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        self.paths = Paths(self.inner)

    def start(self) -> None:
        """Starts all children."""
        for child in self.children:
            child.start()

    def may_lead(self, inner: State, side: int) -> bool:
        """Whether complete paths in the state's lane wait to become solutions, or more may be found."""
        return not self.closed and (self.paths.wait(inner.lane) or self.inner.may_extend(inner, side))

    def busy(self) -> bool:
        """Whether complete paths wait to become solutions of the container, or a child is busy."""
        return not self.closed and (bool(self.paths.heap) or any(child.busy() for child in self.children))

    def child_solved(self, child: StageNode, solution: Solution) -> None:
        """Adds a child's solution to the graph as an edge, and queues the complete paths through the edge."""
        self.inner.add(solution, child.index)
        self.paths.add(solution)
        if self.parent is not None and self.paths.heap and not self.solutions:
            self.lift()  # the first solution at once: other nodes wait for it

    def lift(self) -> bool:
        """Turns the cheapest waiting complete path into a solution of the container.

        Returns False if none waited.
        """
        if self.closed or not self.paths.heap:
            return False
        path = self.paths.pop()
        first, last = path[0].start, path[-1].end
        if first is None or last is None:
            raise ValueError("a path has states at both ends")
        left, right = self.reads
        start = first.outside[0] if first.outside else self._outer(first, last if right and not left else None)
        end = last.outside[0] if last.outside else self._outer(last, first if left and not right else None)
        cost = sum([part.cost for part in path])
        solution = Solution(self.stage, start, end, cost, parts=path, number=self.planning.count())
        for inner, outer in ((first, start), (last, end)):
            if not inner.outside and not solution.failed:
                inner.outside.append(outer)
                outer.inside.append(inner)
        if not self.report(solution):
            for inner, outer in ((first, start), (last, end)):
                if outer.level is None and outer in inner.outside:
                    inner.outside.remove(outer)
                    outer.inside.remove(inner)
        self.planning.work_changed(self, first.lane if last.lane is None else last.lane)
        return True

    def _outer(self, inner: State, followed: State | None) -> State:
        """A counterpart outside of a state at a border, in the lane of `followed`, the state at the other border."""
        lane = followed.outside[0].lane if followed is not None and followed.outside else None
        return self.new_state(inner.scene, inner.properties, lane)


class ParallelNode(StageNode):
    """The node of alternatives: every solution of a child is a solution of the container."""

    def start(self) -> None:
        """Starts all children."""
        for child in self.children:
            child.start()

    def take(self, state: State, side: int, lane: object) -> None:
        """Gives an arriving state to all children."""
        for child in self.children:
            child.take(state, side, lane)

    def rekey(self, state: State, side: int) -> None:
        """Passes the better priority of the state on to all children."""
        for child in self.children:
            child.rekey(state, side)

    def revived(self, state: State) -> None:
        """Notifies all children that the state is alive again."""
        for child in self.children:
            child.revived(state)

    def works_on(self, state: State, side: int) -> bool:
        """Whether any child may still lead from the state to `side`."""
        return not self.closed and any(child.works_on(state, side) for child in self.children)

    def may_add(self, state: State, side: int, lane: object) -> bool:
        """Whether any child may still add solutions from the state."""
        return not self.closed and any(child.may_add(state, side, lane) for child in self.children)

    def may_join(self, start: State, end: State, lane: object) -> bool:
        """Whether any child may still join the two states."""
        return not self.closed and any(child.may_join(start, end, lane) for child in self.children)

    def partners(self, state: State, side: int) -> Iterable[State]:
        """The states with which any child may join the given one."""
        return [partner for child in self.children for partner in child.partners(state, side)]

    def busy(self) -> bool:
        """Whether any child is busy."""
        return not self.closed and any(child.busy() for child in self.children)

    def child_solved(self, child: StageNode, solution: Solution) -> None:
        """Reports a solution of the container that has the states and the cost of the child's solution."""
        start, end, cost, comment = solution.start, solution.end, solution.cost, solution.comment
        number = self.planning.count()
        self.report(Solution(self.stage, start, end, cost, comment, parts=(solution,), number=number))

    def arrived(self, side: int) -> Iterable[State]:
        """The states that have arrived on `side` so far; they are the same for all children."""
        return self.children[0].arrived(side)

    def delivers_to(self, child: StageNode, side: int) -> bool:
        """Whether new states may still arrive at the container, which passes every state on to all children."""
        return self.parent is not None and self.parent.delivers_to(self, side)
