"""The nodes of single stages: generators, monitoring generators, propagators and connectors."""

from collections.abc import Callable, Iterable, Mapping
from typing import Any

from kabo.tasks.core.model.errors import UndefinedProperty
from kabo.tasks.core.model.flow import Flow
from kabo.tasks.core.model.results import SAME, Agreed, Answers, Result, StructuralReason
from kabo.tasks.core.model.solutions import LEFT, RIGHT, Solution, State
from kabo.tasks.core.model.stages import Connector, Generator, Propagator
from kabo.tasks.core.run.graph import meet
from kabo.tasks.core.run.job_queues import Leaf
from kabo.tasks.core.run.jobs import StageJob
from kabo.tasks.core.run.nodes import StageNode

MAX_STRUCTURAL_MISMATCHES = 250  # pairs that the order of stages keeps apart, until a connector counts as wrong


class GeneratorNode(Leaf):
    """The node of a generator, which has one job; the job may have infinitely many answers."""

    stage: Generator

    def start(self) -> None:
        """Queues the generator's only job, unless it was queued before."""
        if not self.jobs and not self.statistics.calls:
            self.queue(StageJob(None, self.arguments((self.planning.scene,))))

    def key(self, job: StageJob) -> tuple[Any, ...]:
        """The sort key: the number of times that the node's only job has run."""
        return (job.asked,)

    def runnable(self, job: StageJob) -> bool:
        """True: a generator's job reads no state, so it can always run."""
        return True

    def lane(self, job: StageJob) -> object:
        """None: the states that a generator writes belong to no lane."""
        return None

    def done(self, job: StageJob) -> None:
        """Does nothing: only connectors wait for a generator, and they check by themselves."""

    def works_on(self, state: State, side: int) -> bool:
        """False: a generator reads no states."""
        return False

    def function(self) -> Callable[..., Answers]:
        """The stage function of a generator: its `generate` method."""
        return self.stage.generate

    def solve(self, job: StageJob, result: Result) -> None:
        """Writes the states of a result on both sides of the generator."""
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
        """Permits the monitoring generator's jobs to run, including those that were triggered before."""
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
        """Whether jobs wait, or the monitored stage may still have solutions that trigger new jobs."""
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
        """Writes the states of a result on both sides, with the interface properties of the monitored solution."""
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
        """Queues a job for an arriving state."""
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
        """The sort key: the job's number of runs, the length of the best path to its state, the path's cost."""
        return (job.asked, *job.subject.order[self._near])

    def runnable(self, job: StageJob) -> bool:
        """Whether the job's state is alive on the side where the propagator reads it."""
        state: State = job.subject
        return state.alive[self._near]

    def lane(self, job: StageJob) -> object:
        """The lane of the job's state."""
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
        """The job's state on the side that the stage reads, and None on the other side."""
        return (job.subject, None) if self._forward else (None, job.subject)

    def solve(self, job: StageJob, result: Result) -> None:
        """Makes a new state of the result, on the side that the propagator writes."""
        near: State = job.subject
        properties = {**near.properties, **result.properties} if result.properties else near.properties
        far = self.new_state(near.scene if result.scene is None else result.scene, properties, near.lane)
        start, end = (near, far) if self._forward else (far, near)
        self.report(self.solution(start, end, result))


class Joining(StageNode):
    """A node that joins pairs of states.

    A state without a partner stays alive while a partner may still arrive.
    """

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        self.expects = [True, True]  # whether states may still come, by side

    def expect(self, again: bool) -> bool:
        """Updates, for each side, whether states may still arrive; returns whether this changed for any side.

        Args:
            again: whether to update only the sides for which no further states were expected.
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
        self._structural = 0  # pairs that the order of the stages keeps apart
        self._fitted = False  # whether a pair has ever fitted

    def take(self, state: State, side: int, lane: object) -> None:
        """Queues a job for each state on the other side that the new state may be joined with.

        Counts mismatches by reason.
        """
        self._sides[side].setdefault(lane, []).append(state)
        self.open.setdefault(state, {})
        across = self._sides[1 - side]
        for its_lane in list(across) if lane is None else (None, lane):
            for other in across.get(its_lane, ()):
                pair = (state, other) if side == LEFT else (other, state)
                self._pair(*pair, its_lane if lane is None else lane)

    def arrived(self, side: int) -> Iterable[State]:
        """The states that have arrived on `side` so far."""
        return (state for states in self._sides[side].values() for state in states)

    def _pair(self, start: State, end: State, lane: object) -> None:
        disagreement = _disagreement(start.properties, end.properties)
        if disagreement is not None:
            self.statistics.mismatches[disagreement] += 1
            return
        given = self.arguments((start.scene, end.scene), start.properties, end.properties)
        if self._has_mismatch and not isinstance(given, UndefinedProperty):
            reason = self.stage.mismatch(*given[:3])
            if reason is not None:
                self.statistics.mismatches[reason] += 1
                self._structural += isinstance(reason, StructuralReason)
                return
        self._fitted = True
        job = StageJob((start, end, lane), given)
        self.open[start][job] = self.open[end][job] = None
        self.queue(job)
        for state, side in ((start, RIGHT), (end, LEFT)):
            if not state.alive[side]:
                self.planning.recheck(state, side)

    def never_fits(self) -> bool:
        """Whether no pair has ever fitted, and the order of the stages has kept many apart: more states change nothing."""
        return not self._fitted and self._structural >= MAX_STRUCTURAL_MISMATCHES

    def rekey(self, state: State, side: int) -> None:
        """Queues the jobs of all pairs that contain the state again, at their improved priority."""
        self.rekey_jobs(self.open.get(state, ()))

    def revived(self, state: State) -> None:
        """Queues the parked jobs again whose pair contains the state."""
        if self.parked:
            self.unpark(self.open.get(state, ()))

    def key(self, job: StageJob) -> tuple[Any, ...]:
        """The sort key: the job's number of runs, the length of the best paths to both states, their cost."""
        start, end, _ = job.subject
        first, second = start.order[LEFT], end.order[RIGHT]
        return job.asked, first[0] + second[0], first[1] + second[1]

    def runnable(self, job: StageJob) -> bool:
        """Whether the start state is alive on its left and the end state on its right."""
        pair: tuple[State, State, object] = job.subject
        return pair[0].alive[LEFT] and pair[1].alive[RIGHT]

    def lane(self, job: StageJob) -> object:
        """The lane in which the job's pair of states is joined, or None."""
        return job.subject[2]

    def works_on(self, state: State, side: int) -> bool:
        """Whether the state has a waiting job with a partner that is alive, or further partners may arrive."""
        if self.closed:
            return False
        return self.expects[side] or any(job.subject[side].alive[side] for job in self.open.get(state, ()))

    def may_add(self, state: State, side: int, lane: object) -> bool:
        """Whether runnable jobs in the lane may still join the state, or further partners may arrive."""
        if self.closed:
            return False
        pairs = (job.subject for job in self.open.get(state, ()))
        can_run = (p[side].alive[side] and meet(p[2], lane) and p not in self.parked for p in pairs)
        return self.expects[side] or any(can_run)

    def may_join(self, start: State, end: State, lane: object) -> bool:
        """Whether the job that joins the two states in the given lane exists and has not ended."""
        return not self.closed and (start, end, lane) in self.jobs

    def partners(self, state: State, side: int) -> Iterable[State]:
        """The states with which the given state forms a pair whose job has not ended."""
        return [job.subject[side] for job in self.open.get(state, ())]

    def done(self, job: StageJob) -> None:
        """Closes the pair of an ended job, and requests a recheck of both states."""
        start, end, _ = job.subject
        for state, side in ((start, RIGHT), (end, LEFT)):
            self.open[state].pop(job, None)
            self.planning.recheck(state, side)

    def function(self) -> Callable[..., Answers]:
        """The stage function of a connector: its `connect` method."""
        return self.stage.connect

    def ends(self, job: StageJob) -> tuple[State | None, State | None]:
        """The two states that the job was to join."""
        start, end, _ = job.subject
        return start, end

    def solve(self, job: StageJob, result: Result) -> None:
        """Reports a solution between the two states of the job."""
        start, end, _ = job.subject
        self.report(self.solution(start, end, result))


def _disagreement(before: Mapping[str, Any], after: Mapping[str, Any]) -> str | None:
    """The name of a property that has to agree on both sides of a connector and does not; None if there is none."""
    for name, value in before.items():
        if type(value) is Agreed and name in after and after[name] != value:
            return name
    return None
