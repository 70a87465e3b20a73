"""Nodes of wrappers, which transform each solution of their child, and of limits, which pass on the first few."""

from collections.abc import Callable
from typing import Any

from kabo.tasks.core.model.containers import Wrapper
from kabo.tasks.core.model.flow import Flow
from kabo.tasks.core.model.results import SAME, Answers, Result
from kabo.tasks.core.model.solutions import LEFT, RIGHT, Solution, State
from kabo.tasks.core.run.groups import Holder
from kabo.tasks.core.run.job_queues import Leaf
from kabo.tasks.core.run.jobs import StageJob
from kabo.tasks.core.run.nodes import StageNode


class WrapperNode(Holder, Leaf):
    """The node of a wrapper: one job for each solution of its child."""

    stage: Wrapper

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        self._useful: set[Solution] = set()  # the child's solutions of which one was made

    def start(self) -> None:
        """Starts the child."""
        self.children[0].start()

    def may_lead(self, inner: State, side: int) -> bool:
        """Whether a child's solution at the state waits to be transformed, or more may be found."""
        return not self.closed and (self.works_at_border(inner) or self.inner.may_extend(inner, side))

    def works_at_border(self, state: State) -> bool:
        """Whether a child's solution that starts or ends in the state waits to be transformed."""
        return not self.closed and any(state in (s.start, s.end) for s in self.jobs)

    def revived_inside(self, inner: State) -> None:
        """Queues the parked jobs again whose solution starts or ends in the state."""
        self.unpark([job for s, job in self.parked.items() if inner in (s.start, s.end)])

    def busy(self) -> bool:
        """Whether solutions of the child wait to be transformed, or the child is busy."""
        return super().busy() or (not self.closed and self.children[0].busy())

    def child_solved(self, child: StageNode, solution: Solution) -> None:
        """Queues a job that transforms the child's solution."""
        self.inner.add(solution, 0)
        if self.closed or solution.end is None:
            return
        interfaces = [s.properties for s in self._interfaces(solution) if s is not None]
        self.queue(StageJob(solution, self.arguments((solution,), *interfaces)))

    def _interfaces(self, solution: Solution) -> tuple[State | None, ...]:
        """The states whose properties a job reads: the one that the child wrote, or both that it joins."""
        if self.flow is Flow.CONNECT:
            return solution.start, solution.end
        return (solution.start if self.flow is Flow.BACKWARD else solution.end,)

    def rekey(self, state: State, side: int) -> None:
        """Does nothing: jobs are ordered by the states inside the wrapper, not by the outer state."""

    def key(self, job: StageJob) -> tuple[Any, ...]:
        """The sort key: the job's number of runs, the length of the paths to the states read, the total cost."""
        solution: Solution = job.subject
        depth, cost = 0, solution.cost
        if self.reads[LEFT] and solution.start is not None:
            depth, cost = depth + solution.start.order[LEFT][0], cost + solution.start.order[LEFT][1]
        if self.reads[RIGHT] and solution.end is not None:
            depth, cost = depth + solution.end.order[RIGHT][0], cost + solution.end.order[RIGHT][1]
        return job.asked, depth, cost

    def runnable(self, job: StageJob) -> bool:
        """Whether the job can run: on each side that the wrapper reads, the solution's state is alive."""
        solution: Solution = job.subject
        start, end = solution.start, solution.end
        left = not self.reads[LEFT] or start is None or start.alive[LEFT]
        return left and (not self.reads[RIGHT] or end is None or end.alive[RIGHT])

    def lane(self, job: StageJob) -> object:
        """The lane of the states of the child's solution; None if they are in no lane."""
        solution: Solution = job.subject
        ends = solution.start, solution.end
        return next((state.lane for state in ends if state is not None and state.lane is not None), None)

    def done(self, job: StageJob) -> None:
        """Removes the child's solution from the graph if the wrapper made no solution from it.

        In either case a recheck of the states on both sides of the child's solution is requested.
        """
        solution: Solution = job.subject
        start, end = solution.start, solution.end
        if start is None or end is None:
            return
        if solution not in self._useful:
            start.edges[RIGHT].remove(solution)
            end.edges[LEFT].remove(solution)
            self.planning.recheck(start, RIGHT)
            self.planning.recheck(end, LEFT)
        self.planning.recheck(end, RIGHT)
        self.planning.recheck(start, LEFT)

    def cause(self, job: StageJob) -> Solution | None:
        """The monitored solution that triggered the child's solution, if a monitoring generator wrote it.

        The result is None if there was no such generator.
        """
        return job.subject.start.cause if self.flow is Flow.GENERATE else None

    def function(self) -> Callable[..., Answers]:
        """The stage function of a wrapper: its `transform` method."""
        return self.stage.transform

    def ends(self, job: StageJob) -> tuple[State | None, State | None]:
        """The start and end states of the child's solution."""
        return job.subject.start, job.subject.end

    def solve(self, job: StageJob, result: Result) -> None:
        """Makes a solution of the wrapper, with new states on the sides that the child wrote."""
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
    """The node of a limit: after it has passed on enough solutions, nothing inside it runs again."""

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        self._most: int = self.stage.properties.value("max_solutions")

    def start(self) -> None:
        """Starts the child, unless the limit is 0."""
        super().start()
        if self._most < 1:
            self._close()

    def take(self, state: State, side: int, lane: object) -> None:
        """Gives the state to the child.

        If the limit is reached, requests a recheck, because nothing can follow from it.
        """
        if self.closed:
            self.planning.recheck(state, 1 - side)
        else:
            super().take(state, side, lane)

    def solve(self, job: StageJob, result: Result) -> None:
        """Makes a solution of the child's solution, and closes the node when the limit is reached."""
        super().solve(job, result)
        if not self.closed and self.statistics.successes >= self._most:
            self._close()

    def _close(self) -> None:
        """Closes this node and everything inside, and has the states rechecked that waited for them."""
        waiting: list[StageNode] = [self]
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
                        self.planning.recheck(state, 1 - side)
                self.planning.work_changed(self, inner.lane)
