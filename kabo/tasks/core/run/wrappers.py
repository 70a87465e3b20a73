"""The nodes of wrappers: each success of the child becomes what the stage makes of it; a limit lets so many through."""

from collections.abc import Callable
from typing import Any

from kabo.tasks.core.model.containers import Wrapper
from kabo.tasks.core.model.flow import Flow
from kabo.tasks.core.model.results import SAME, Answers, Result
from kabo.tasks.core.model.solutions import LEFT, RIGHT, Solution, State
from kabo.tasks.core.run.groups import Holder
from kabo.tasks.core.run.jobs import Job
from kabo.tasks.core.run.nodes import Leaf, Node


class WrapperNode(Holder, Leaf):
    """A wrapper: one job for each success of its child."""

    stage: Wrapper

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        self._useful: set[Solution] = set()  # the child's, of which something came

    def start(self) -> None:
        """Starts the child."""
        self.children[0].start()

    def may_lead(self, inner: State, side: int) -> bool:
        """Whether a success with the inner state waits, or may come."""
        return not self.closed and (self.works_at_border(inner) or self.inner.may_extend(inner, side))

    def works_at_border(self, state: State) -> bool:
        """Whether a success of the child with this state waits to be transformed."""
        return not self.closed and any(state in (s.start, s.end) for s in self.jobs)

    def revived_inside(self, inner: State) -> None:
        """What the child made of it can be transformed again."""
        self.unpark([job for s, job in self.parked.items() if inner in (s.start, s.end)])

    def busy(self) -> bool:
        """Whether successes wait, or the child may have more."""
        return super().busy() or (not self.closed and self.children[0].busy())

    def child_solved(self, child: Node, solution: Solution) -> None:
        """One more job."""
        self.inner.add(solution, 0)
        if self.closed or solution.end is None:
            return
        interfaces = [s.properties for s in self._interfaces(solution) if s is not None]
        self.queue(Job(solution, self.arguments((solution,), *interfaces)))

    def _interfaces(self, solution: Solution) -> tuple[State | None, ...]:
        """The states whose properties a job reads: the one that the child wrote, or both that it joins."""
        if self.flow is Flow.CONNECT:
            return solution.start, solution.end
        return (solution.start if self.flow is Flow.BACKWARD else solution.end,)

    def rekey(self, state: State, side: int) -> None:
        """The child's jobs are ordered by their inner states."""

    def key(self, job: Job) -> tuple[Any, ...]:
        """Those asked less often, then by the paths to the states that came in, then the cheaper ones."""
        solution: Solution = job.subject
        depth, cost = 0, solution.cost
        if self.reads[LEFT] and solution.start is not None:
            depth, cost = depth + solution.start.order[LEFT][0], cost + solution.start.order[LEFT][1]
        if self.reads[RIGHT] and solution.end is not None:
            depth, cost = depth + solution.end.order[RIGHT][0], cost + solution.end.order[RIGHT][1]
        return job.asked, depth, cost

    def runnable(self, job: Job) -> bool:
        """Whether the states that came in are alive outside."""
        solution: Solution = job.subject
        start, end = solution.start, solution.end
        left = not self.reads[LEFT] or start is None or start.alive[LEFT]
        return left and (not self.reads[RIGHT] or end is None or end.alive[RIGHT])

    def lane(self, job: Job) -> object:
        """That of the states."""
        solution: Solution = job.subject
        ends = solution.start, solution.end
        return next((state.lane for state in ends if state is not None and state.lane is not None), None)

    def done(self, job: Job) -> None:
        """The inner states may have lost what kept them alive; a solution of which nothing came leads nowhere."""
        solution: Solution = job.subject
        start, end = solution.start, solution.end
        if start is None or end is None:
            return
        if solution not in self._useful:
            start.edges[RIGHT].remove(solution)
            end.edges[LEFT].remove(solution)
            self.planning.touch(start, RIGHT)
            self.planning.touch(end, LEFT)
        self.planning.touch(end, RIGHT)
        self.planning.touch(start, LEFT)

    def cause(self, job: Job) -> Solution | None:
        """That of what it wraps."""
        return job.subject.start.cause if self.flow is Flow.GENERATE else None

    def function(self) -> Callable[..., Answers]:
        """`transform`."""
        return self.stage.transform

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
            self._useful.add(inner)
            for state, outer in ((inner.start, start), (inner.end, end)):
                if outer not in state.outside:
                    state.outside.append(outer)
                    outer.inside.append(state)

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
        return self.new_state(before, {**first.properties, **result.properties}), self.new_state(after, properties)


class LimitNode(WrapperNode):
    """A wrapper that closes, with all it holds, once it has let enough through."""

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        self._most: int = self.stage.properties.value("max_solutions")

    def start(self) -> None:
        """Starts the child, unless nothing is wanted of it."""
        super().start()
        if self._most < 1:
            self._close()

    def take(self, state: State, side: int, lane: object) -> None:
        """Lets it in; a closed one says at once that nothing will come of it."""
        if self.closed:
            self.planning.touch(state, 1 - side)
        else:
            super().take(state, side, lane)

    def solve(self, job: Job, result: Result) -> None:
        """As wrappers do; the last one that is let through closes it."""
        super().solve(job, result)
        if not self.closed and self.statistics.successes >= self._most:
            self._close()

    def _close(self) -> None:
        """Nothing in here is wanted any more; who waits for its work on a state is told that it is done."""
        waiting: list[Node] = [self]
        while waiting:
            node = waiting.pop()
            node.closed = True
            waiting.extend(node.children)
        self.jobs.clear()
        self.parked.clear()
        for state, inside in self.inside.items():
            for inner in inside.values():
                for side in (LEFT, RIGHT):
                    if self.reads[side] and self.inner.at_border(inner, side):
                        self.planning.touch(state, 1 - side)
                self.planning.rested(self, inner.lane)
