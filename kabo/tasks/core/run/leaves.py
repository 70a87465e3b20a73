"""The nodes of single stages: generators, monitoring generators, propagators and connectors."""

from collections.abc import Callable, Iterable
from typing import Any

from kabo.tasks.core.model.errors import UndefinedProperty
from kabo.tasks.core.model.flow import Flow
from kabo.tasks.core.model.results import SAME, Answers, Result
from kabo.tasks.core.model.solutions import LEFT, RIGHT, Solution, State
from kabo.tasks.core.model.stages import Connector, Generator, Propagator
from kabo.tasks.core.run.graph import meet
from kabo.tasks.core.run.job_queues import Leaf
from kabo.tasks.core.run.jobs import StageJob
from kabo.tasks.core.run.nodes import StageNode


class GeneratorNode(Leaf):
    """The node of a generator: one job, which may have answers without end."""

    stage: Generator

    def start(self) -> None:
        """Queues the job, once."""
        if not self.jobs and not self.statistics.calls:
            self.queue(StageJob(None, self.arguments((self.planning.scene,))))

    def key(self, job: StageJob) -> tuple[Any, ...]:
        """The sort key: the number of times that the node's only job has run."""
        return (job.asked,)

    def runnable(self, job: StageJob) -> bool:
        """True: the job computes both sides."""
        return True

    def lane(self, job: StageJob) -> object:
        """None: its states belong to no lane."""
        return None

    def done(self, job: StageJob) -> None:
        """Does nothing: only connectors wait for a generator, and they check for themselves."""

    def works_on(self, state: State, side: int) -> bool:
        """False: a generator reads no states."""
        return False

    def function(self) -> Callable[..., Answers]:
        """The stage's `generate`."""
        return self.stage.generate

    def solve(self, job: StageJob, result: Result) -> None:
        """Writes the states on both sides."""
        self.offer(result, {})

    def offer(self, result: Result, inherited: Any, cause: Solution | None = None) -> None:
        """Writes the states on both sides of a result, with its properties and the inherited ones."""
        properties = {**inherited, **result.properties}
        before = result.scene if result.start is SAME else result.start
        start, end = self.new_state(before, properties), self.new_state(result.scene, properties)
        start.cause = end.cause = cause
        self.report(self.solution(start, end, result))


class MonitorNode(GeneratorNode):
    """The node of a monitoring generator: one job for each solution of the stage that it monitors."""

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        self.monitored: StageNode | None = None
        self._started = False

    def start(self) -> None:
        """Lets its jobs run, also those that were triggered before."""
        self._started = True

    def trigger(self, solution: Solution) -> None:
        """Queues a job for a solution of the monitored stage."""
        if solution.end is not None:
            given = self.arguments((solution.end.scene,), solution.end.properties)
            self.queue(StageJob(solution, given))

    def key(self, job: StageJob) -> tuple[Any, ...]:
        """The sort key: the number of runs of the job, then the cost of the solution that triggered it."""
        return job.asked, job.subject.cost

    def best(self) -> StageJob | None:
        """The best runnable job, if the node was started."""
        return super().best() if self._started else None

    def busy(self) -> bool:
        """Whether jobs wait, or the monitored stage may still have solutions."""
        if not self._started:
            return False
        if self.closed or self.jobs or self.monitored is None:
            return super().busy()
        asked = self.planning.asked
        if self in asked:  # stages that monitor each other: only states from elsewhere count
            return False
        first = not asked
        asked.add(self)
        try:
            return self.monitored.may_solve()
        finally:
            if first:
                asked.clear()

    def solve(self, job: StageJob, result: Result) -> None:
        """Writes the states on both sides, with the interface properties of the monitored solution."""
        self.offer(result, job.subject.end.properties, job.subject)

    def cause(self, job: StageJob) -> Solution | None:
        """The solution that triggered the job."""
        return job.subject  # type: ignore[no-any-return]


class PropagatorNode(Leaf):
    """The node of a propagator: one job for each state that arrives."""

    stage: Propagator

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        self._forward = self.flow is Flow.FORWARD
        self._near, self._far = (LEFT, RIGHT) if self._forward else (RIGHT, LEFT)

    def take(self, state: State, side: int, lane: object) -> None:
        """Queues a job for the state."""
        self.queue(StageJob(state, self.arguments((state.scene,), state.properties)))

    def rekey(self, state: State, side: int) -> None:
        """Queues the state's job again at its better priority."""
        if state in self.jobs:
            self.rekey_jobs([self.jobs[state]])

    def revived(self, state: State) -> None:
        """Queues the state's job again if it was parked."""
        if state in self.parked:
            self.unpark([self.parked[state]])

    def key(self, job: StageJob) -> tuple[Any, ...]:
        """The sort key: the number of runs of the job, then the best path to its state, longest and then cheapest first."""
        return (job.asked, *job.subject.order[self._near])

    def runnable(self, job: StageJob) -> bool:
        """Whether the state is alive on the side from which it was written."""
        state: State = job.subject
        return state.alive[self._near]

    def lane(self, job: StageJob) -> object:
        """The lane of the state."""
        return job.subject.lane

    def works_on(self, state: State, side: int) -> bool:
        """Whether the state's job has not ended."""
        return state in self.jobs and not self.closed

    def may_add(self, state: State, side: int, lane: object) -> bool:
        """Whether the state's job has not ended and is not parked."""
        return self.works_on(state, side) and state not in self.parked

    def done(self, job: StageJob) -> None:
        """Rechecks whether the job's state is alive, since this stage adds no more solutions to it."""
        self.planning.recheck(job.subject, self._far)

    def function(self) -> Callable[..., Answers]:
        """The method that a job calls: the stage's `forward` or `backward`."""
        return self.stage.forward if self._forward else self.stage.backward

    def ends(self, job: StageJob) -> tuple[State | None, State | None]:
        """The job's state at the end where the stage reads it, None at the other end."""
        return (job.subject, None) if self._forward else (None, job.subject)

    def solve(self, job: StageJob, result: Result) -> None:
        """Makes a new state on the far side."""
        near: State = job.subject
        properties = {**near.properties, **result.properties} if result.properties else near.properties
        far = self.new_state(near.scene if result.scene is None else result.scene, properties, near.lane)
        start, end = (near, far) if self._forward else (far, near)
        self.report(self.solution(start, end, result))


class Joining(StageNode):
    """A node that joins pairs of states: a state without a partner stays alive while one may still arrive."""

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        self.expects = [True, True]  # whether states may still come, by side

    def expect(self, again: bool) -> bool:
        """Updates whether further states may come to each side; returns whether that has changed.

        Args:
            again: update only the sides to which none could come any more.
        """
        changed = False
        for side in (LEFT, RIGHT):
            if again and self.expects[side]:
                continue
            now = self.parent is not None and not self.closed and self.parent.delivers_to(self, side)
            if now != self.expects[side]:
                self.expects[side], changed = now, True
                for state in self.arrived(1 - side):
                    self.planning.recheck(state, side)
        return changed


class ConnectorNode(Joining, Leaf):
    """The node of a connector: one job for each pair of states that may be joined."""

    stage: Connector

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        self._sides: tuple[dict[object, list[State]], dict[object, list[State]]] = ({}, {})  # by lane
        self.open: dict[State, dict[StageJob, None]] = {}  # by state, the jobs of its open pairs
        self._has_mismatch = type(self.stage).mismatch is not Connector.mismatch

    def take(self, state: State, side: int, lane: object) -> None:
        """Queues a job for each state on the other side that it may be joined with; mismatches are counted by reason."""
        self._sides[side].setdefault(lane, []).append(state)
        self.open.setdefault(state, {})
        across = self._sides[1 - side]
        for its_lane in list(across) if lane is None else (None, lane):
            for other in across.get(its_lane, ()):
                pair = (state, other) if side == LEFT else (other, state)
                self._pair(*pair, its_lane if lane is None else lane)

    def arrived(self, side: int) -> Iterable[State]:
        """The states that have arrived on that side so far."""
        return (state for states in self._sides[side].values() for state in states)

    def _pair(self, start: State, end: State, lane: object) -> None:
        given = self.arguments((start.scene, end.scene), start.properties, end.properties)
        if self._has_mismatch and not isinstance(given, UndefinedProperty):
            reason = self.stage.mismatch(*given[:3])
            if reason is not None:
                self.statistics.mismatches[reason] += 1
                return
        job = StageJob((start, end, lane), given)
        self.open[start][job] = self.open[end][job] = None
        self.queue(job)
        for state, side in ((start, RIGHT), (end, LEFT)):
            if not state.alive[side]:
                self.planning.recheck(state, side)

    def rekey(self, state: State, side: int) -> None:
        """Queues the jobs of all the state's pairs again at their better priority."""
        self.rekey_jobs(self.open.get(state, ()))

    def revived(self, state: State) -> None:
        """Queues those of the jobs of the state's pairs again that were parked."""
        if self.parked:
            self.unpark(self.open.get(state, ()))

    def key(self, job: StageJob) -> tuple[Any, ...]:
        """The sort key: the number of runs of the job, the sum of both path lengths (longest first), then of both costs."""
        start, end, _ = job.subject
        first, second = start.order[LEFT], end.order[RIGHT]
        return job.asked, first[0] + second[0], first[1] + second[1]

    def runnable(self, job: StageJob) -> bool:
        """Whether both states are alive on their far sides."""
        pair: tuple[State, State, object] = job.subject
        return pair[0].alive[LEFT] and pair[1].alive[RIGHT]

    def lane(self, job: StageJob) -> object:
        """The lane of the pair."""
        return job.subject[2]

    def works_on(self, state: State, side: int) -> bool:
        """Whether the state has an open pair with a state that is alive, or may still get another partner."""
        if self.closed:
            return False
        return self.expects[side] or any(job.subject[side].alive[side] for job in self.open.get(state, ()))

    def may_add(self, state: State, side: int, lane: object) -> bool:
        """Whether runnable jobs may still join pairs of the state in the lane, or it may still get another partner."""
        if self.closed:
            return False
        pairs = (job.subject for job in self.open.get(state, ()))
        can_run = (p[side].alive[side] and meet(p[2], lane) and p not in self.parked for p in pairs)
        return self.expects[side] or any(can_run)

    def may_join(self, start: State, end: State, lane: object) -> bool:
        """Whether the job of the pair in the lane has not ended."""
        return not self.closed and (start, end, lane) in self.jobs

    def partners(self, state: State, side: int) -> Iterable[State]:
        """The states that the given state makes an open pair with."""
        return [job.subject[side] for job in self.open.get(state, ())]

    def done(self, job: StageJob) -> None:
        """Closes the pair, and has both states rechecked."""
        start, end, _ = job.subject
        for state, side in ((start, RIGHT), (end, LEFT)):
            self.open[state].pop(job, None)
            self.planning.recheck(state, side)

    def function(self) -> Callable[..., Answers]:
        """The stage's `connect`."""
        return self.stage.connect

    def ends(self, job: StageJob) -> tuple[State | None, State | None]:
        """The states on both sides."""
        start, end, _ = job.subject
        return start, end

    def solve(self, job: StageJob, result: Result) -> None:
        """Adds an edge between both states."""
        start, end, _ = job.subject
        self.report(self.solution(start, end, result))
