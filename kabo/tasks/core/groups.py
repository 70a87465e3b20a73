"""The nodes of containers: how the solutions of children become those of a container [T 3.3, 3.4]."""

from collections.abc import Callable, Iterable
from itertools import product
from typing import Any

from kabo.tasks.core.containers import Limit
from kabo.tasks.core.flow import Flow
from kabo.tasks.core.graph import Level
from kabo.tasks.core.jobs import Job
from kabo.tasks.core.nodes import Ended, Leaf, Node
from kabo.tasks.core.paths import Paths
from kabo.tasks.core.results import SAME, Answers, Result
from kabo.tasks.core.solutions import LEFT, RIGHT, Solution, State


class _Inside:
    """What a node with a level of its own does with states at its borders."""

    def __init__(self) -> None:
        self.inside: dict[State, list[State]] = {}

    def let_in(self, node: Node, level: Level, state: State, side: int, lane: object) -> None:
        """Hands a state to the child at that border."""
        inner = level.enter(state, side, node.planning.count(), lane)
        self.inside.setdefault(state, []).append(inner)
        level.children[0 if side == LEFT else -1].take(inner, side, lane)

    def alive(self, state: State, side: int) -> bool:
        """Whether a counterpart of the state is alive on that side."""
        return any(inner.alive[side] for inner in self.inside.get(state, ()))


class SerialNode(Node):
    """A serial container: every whole path of its children's solutions is a solution."""

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        self.inner = Level(self)
        self.paths = Paths(self.inner)
        self._inside = _Inside()

    def start(self) -> None:
        """Starts all children."""
        for child in self.children:
            child.start()

    def take(self, state: State, side: int, lane: object) -> None:
        """Lets it in."""
        self._inside.let_in(self, self.inner, state, side, lane)

    def works_on(self, state: State, side: int) -> bool:
        """Whether its counterpart is alive, or paths wait to be lifted."""
        return not self.closed and (bool(self.paths) or self._inside.alive(state, side))

    def partners(self, state: State, side: int) -> Iterable[State]:
        """Whom the inner connectors might still join with it: all that were let in on the other side."""
        if self.flow is not Flow.CONNECT:
            return ()
        inner = self._inside.inside
        return [s for s, found in inner.items() if any(self.inner.at_border(i, 1 - side) for i in found)]

    def busy(self) -> bool:
        """Whether a child is, or paths wait."""
        return bool(self.paths) or any(child.busy() for child in self.children)

    def child_solved(self, child: Node, solution: Solution) -> None:
        """One more edge, and maybe whole paths."""
        self.inner.add(solution, child.index)
        self.paths.add(solution)
        if self.parent is not None and self.paths and not self.solutions:
            self.lift()  # the first at once: others wait for it

    def lift(self) -> bool:
        """Makes a solution of the cheapest path that waits; False if none does."""
        if not self.paths:
            return False
        path = self.paths.pop()
        first, last = path[0].start, path[-1].end
        if first is None or last is None:
            raise ValueError("a path has states at both ends")
        start = self._outer(first, self.flow.reads_end and not self.flow.reads_start, last)
        end = self._outer(last, self.flow.reads_start and not self.flow.reads_end, first)
        cost = sum([part.cost for part in path])
        solution = Solution(self.stage, start, end, cost, parts=path, number=self.planning.count())
        for inner, outer in ((first, start), (last, end)):
            if not inner.outside and solution.cost != float("inf"):
                inner.outside.append(outer)
                outer.inside.append(inner)
        if not self.report(solution):
            for inner, outer in ((first, start), (last, end)):
                if outer.level is None and outer in inner.outside:
                    inner.outside.remove(outer)
                    outer.inside.remove(inner)
        elif not self.paths:
            self.planning.ended([(state, side) for state, side in self._settled(start, end)])
        return True

    def _outer(self, inner: State, follows: bool, other: State) -> State:
        """The counterpart of an inner border state; a new one has the lane of the state at the other end."""
        if inner.outside:
            return inner.outside[0]
        lane = other.outside[0].lane if follows and other.outside else None
        return self.new_state(inner.scene, inner.properties, lane)

    def _settled(self, start: State, end: State) -> Ended:
        """The states that were alive through paths that waited."""
        found: Ended = []
        if self.flow.reads_start:
            found += [(s, RIGHT) for s in self._inside.inside if s.alive[RIGHT]]
        if self.flow.reads_end:
            found += [(s, LEFT) for s in self._inside.inside if s.alive[LEFT]]
        return found


class WrapperNode(Leaf):
    """A wrapper: one job for each success of its child."""

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        self.inner = Level(self)
        self._inside = _Inside()
        self._limit = self.stage.properties.value("max_solutions") if isinstance(self.stage, Limit) else None

    def start(self) -> None:
        """Starts the child."""
        self.children[0].start()

    def take(self, state: State, side: int, lane: object) -> None:
        """Lets it in."""
        if not self.closed:
            self._inside.let_in(self, self.inner, state, side, lane)

    def works_on(self, state: State, side: int) -> bool:
        """Whether its counterpart is alive."""
        return not self.closed and self._inside.alive(state, side)

    def works_at_border(self, state: State) -> bool:
        """Whether a success of the child with this state waits to be transformed."""
        return not self.closed and any(state in (s.start, s.end) for s in self.jobs)

    def busy(self) -> bool:
        """Whether successes wait, or the child may have more."""
        return not self.closed and (bool(self.jobs) or self.children[0].busy())

    def partners(self, state: State, side: int) -> Iterable[State]:
        """As those of the child."""
        found = [self.children[0].partners(i, side) for i in self._inside.inside.get(state, ())]
        return [outer for inner in found for partner in inner for outer in partner.outside]

    def child_solved(self, child: Node, solution: Solution) -> None:
        """One more job."""
        self.inner.add(solution, 0)
        if self.closed or solution.end is None:
            return
        self.queue(Job(solution, self.arguments((solution,), solution.end.properties)))

    def rekey(self, state: State, side: int) -> None:
        """The child's jobs are ordered by their inner states."""

    def key(self, job: Job) -> tuple[Any, ...]:
        """Those asked less often, then by the paths to the states that came in, then the cheaper ones."""
        solution: Solution = job.subject
        depth, cost = 0, solution.cost
        if self.flow.reads_start and solution.start is not None:
            depth, cost = depth + solution.start.order[LEFT][0], cost + solution.start.order[LEFT][1]
        if self.flow.reads_end and solution.end is not None:
            depth, cost = depth + solution.end.order[RIGHT][0], cost + solution.end.order[RIGHT][1]
        return job.asked, depth, cost

    def runnable(self, job: Job) -> bool:
        """Whether the states that came in are alive outside."""
        solution: Solution = job.subject
        start, end = solution.start, solution.end
        left = not self.flow.reads_start or start is None or start.alive[LEFT]
        return left and (not self.flow.reads_end or end is None or end.alive[RIGHT])

    def dropped(self, job: Job) -> Ended:
        """The inner states may have lost what kept them alive."""
        solution: Solution = job.subject
        found: Ended = []
        if solution.end is not None:
            found.append((solution.end, RIGHT))
        if solution.start is not None:
            found.append((solution.start, LEFT))
        return found

    def function(self) -> Callable[..., Answers]:
        """`transform`."""
        return self.stage.transform  # type: ignore[attr-defined]

    def ends(self, job: Job) -> tuple[State | None, State | None]:
        """Those of the child's solution."""
        return job.subject.start, job.subject.end

    def solve(self, job: Job, result: Result) -> None:
        """A solution made of the child's; on sides that were not given, states of its own."""
        if self.closed:
            return
        inner: Solution = job.subject
        if inner.start is None or inner.end is None:
            raise ValueError("a success has a state on both sides")
        start, end = self._ends(inner.start, inner.end, result)
        if self.report(self.solution(start, end, result, (inner,))):
            for state, outer in ((inner.start, start), (inner.end, end)):
                if outer not in state.outside:
                    state.outside.append(outer)
                    outer.inside.append(state)
            if self._limit is not None and self.statistics.successes >= self._limit:
                self._close()

    def _ends(self, first: State, last: State, result: Result) -> tuple[State, State]:
        properties = {**last.properties, **result.properties}
        if self.flow is Flow.CONNECT:
            return first.outside[0], last.outside[0]
        if self.flow is Flow.FORWARD:
            outer = first.outside[0]
            return outer, self.new_state(
                last.scene if result.scene is None else result.scene, properties, outer.lane
            )
        if self.flow is Flow.BACKWARD:
            properties = {**first.properties, **result.properties}
            outer = last.outside[0]
            return self.new_state(
                first.scene if result.scene is None else result.scene, properties, outer.lane
            ), outer
        after = last.scene if result.scene is None else result.scene
        before = result.start
        if before is SAME:
            before = first.scene if result.scene is None or first.scene is not last.scene else result.scene
        return self.new_state(before, properties), self.new_state(after, properties)

    def _close(self) -> None:
        """The limit is reached: nothing in here is wanted any more."""
        waiting: list[Node] = [self]
        while waiting:
            node = waiting.pop()
            node.closed = True
            waiting.extend(node.children)
        self.jobs.clear()
        outer: Ended = []
        for state in self._inside.inside:
            outer += self.finished(state, RIGHT if self.flow.reads_start else LEFT, state.lane)
            if self.flow is Flow.CONNECT:
                outer += self.finished(state, LEFT, state.lane)
        self.planning.ended(outer)


class ParallelNode(Node):
    """Alternatives: each success of a child is one of the container."""

    def start(self) -> None:
        """Starts all children."""
        for child in self.children:
            child.start()

    def take(self, state: State, side: int, lane: object) -> None:
        """All children take it."""
        for child in self.children:
            child.take(state, side, lane)

    def rekey(self, state: State, side: int) -> None:
        """For all children."""
        for child in self.children:
            child.rekey(state, side)

    def works_on(self, state: State, side: int) -> bool:
        """Whether a child does."""
        return not self.closed and any(child.works_on(state, side) for child in self.children)

    def partners(self, state: State, side: int) -> Iterable[State]:
        """Those of all children."""
        return [partner for child in self.children for partner in child.partners(state, side)]

    def busy(self) -> bool:
        """Whether a child is."""
        return not self.closed and any(child.busy() for child in self.children)

    def child_solved(self, child: Node, solution: Solution) -> None:
        """The same solution, one floor up."""
        start, end, cost, comment = solution.start, solution.end, solution.cost, solution.comment
        number = self.planning.count()
        self.report(Solution(self.stage, start, end, cost, comment, parts=(solution,), number=number))

    def child_finished(self, child: Node, state: State, side: int, lane: object) -> Ended:
        """Its work is done when that of all children is."""
        return [] if self.works_on(state, side) else self.finished(state, side, lane)

    def delivers_to(self, child: Node, side: int, lane: object) -> bool:
        """What comes to it comes to all children."""
        return self.parent is not None and self.parent.delivers_to(self, side, lane)


class MergerNode(Leaf):
    """A merger: one job for each combination of one solution of every child from the same state."""

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        self._near, self._far = (LEFT, RIGHT) if self.flow is Flow.FORWARD else (RIGHT, LEFT)
        self._found: dict[State, dict[Node, list[Solution]]] = {}

    take, start, partners, delivers_to = (
        ParallelNode.take,
        ParallelNode.start,
        ParallelNode.partners,
        ParallelNode.delivers_to,
    )

    def rekey(self, state: State, side: int) -> None:
        """For the children, and for the combinations that wait."""
        for child in self.children:
            child.rekey(state, side)
        for subject, job in self.jobs.items():
            if subject[0] is state:
                self._push(job)

    def works_on(self, state: State, side: int) -> bool:
        """Whether a combination waits, or every child has solutions or works on them."""
        if self.closed:
            return False
        if any(subject[0] is state for subject in self.jobs):
            return True
        found = self._found.get(state, {})
        working = [child.works_on(state, side) for child in self.children]
        return any(working) and all(w or found.get(c) for w, c in zip(working, self.children, strict=True))

    def busy(self) -> bool:
        """Whether combinations wait, or a child is busy."""
        return not self.closed and (bool(self.jobs) or any(child.busy() for child in self.children))

    def child_solved(self, child: Node, solution: Solution) -> None:
        """All combinations with what the others found."""
        state = solution.start if self._near == LEFT else solution.end
        if state is None:
            raise ValueError("a success has a state on both sides")
        found = self._found.setdefault(state, {})
        found.setdefault(child, []).append(solution)
        choices = [[solution] if other is child else found.get(other, []) for other in self.children]
        for chosen in product(*choices):
            self.queue(Job((state, *chosen), self.arguments((state.scene, chosen), state.properties)))

    def child_finished(self, child: Node, state: State, side: int, lane: object) -> Ended:
        """Its work is done when nothing waits and the children's is."""
        return [] if self.works_on(state, side) else self.finished(state, side, lane)

    def key(self, job: Job) -> tuple[Any, ...]:
        """Those asked less often, by the priority of the state, then the cheaper ones."""
        state, *chosen = job.subject
        depth, cost = state.order[self._near]
        return job.asked, depth, cost + sum(s.cost for s in chosen)

    def runnable(self, job: Job) -> bool:
        """Whether the state is alive on the side it comes from."""
        return job.subject[0].alive[self._near]

    def dropped(self, job: Job) -> Ended:
        """Nothing more may lead on from the state."""
        state = job.subject[0]
        return [] if self.works_on(state, self._far) else self.finished(state, self._far, state.lane)

    def function(self) -> Callable[..., Answers]:
        """`merge`."""
        return self.stage.merge  # type: ignore[attr-defined]

    def solve(self, job: Job, result: Result) -> None:
        """A new state on the far side."""
        near, *chosen = job.subject
        far = self.new_state(result.scene, {**near.properties, **result.properties}, near.lane)
        start, end = (near, far) if self._near == LEFT else (far, near)
        self.report(self.solution(start, end, result, tuple(chosen)))
