"""The nodes of single stages: generators, monitors, propagators and connectors, with a job for each of what."""

from collections.abc import Callable, Iterable
from typing import Any

from kabo.tasks.core.model.errors import UndefinedProperty
from kabo.tasks.core.model.flow import Flow
from kabo.tasks.core.model.results import SAME, Answers, Result
from kabo.tasks.core.model.solutions import LEFT, RIGHT, Solution, State
from kabo.tasks.core.model.stages import Connector, Generator, Propagator
from kabo.tasks.core.run.graph import meet
from kabo.tasks.core.run.jobs import Job
from kabo.tasks.core.run.nodes import Leaf, Node


class GeneratorNode(Leaf):
    """A generator: one job, which may go on for ever."""

    stage: Generator

    def start(self) -> None:
        """Queues the job, once."""
        if not self.jobs and not self.statistics.calls:
            self.queue(Job(None, self.arguments((self.planning.scene,))))

    def key(self, job: Job) -> tuple[Any, ...]:
        """There is only one."""
        return (job.asked,)

    def runnable(self, job: Job) -> bool:
        """Always: it computes both sides."""
        return True

    def lane(self, job: Job) -> object:
        """What it offers is for all."""
        return None

    def done(self, job: Job) -> None:
        """Nothing waits for a generator but connectors, and those look for themselves."""

    def works_on(self, state: State, side: int) -> bool:
        """It reads no states."""
        return False

    def function(self) -> Callable[..., Answers]:
        """`generate`."""
        return self.stage.generate

    def solve(self, job: Job, result: Result) -> None:
        """A state on either side."""
        self.offer(result, {})

    def offer(self, result: Result, inherited: Any, cause: Solution | None = None) -> None:
        """Writes both states of a result."""
        properties = {**inherited, **result.properties}
        before = result.scene if result.start is SAME else result.start
        start, end = self.new_state(before, properties), self.new_state(result.scene, properties)
        start.cause = end.cause = cause
        self.report(self.solution(start, end, result))


class MonitorNode(GeneratorNode):
    """A generator with one job for each success of the stage that it monitors."""

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        self.monitored: Node | None = None
        self._started = False

    def start(self) -> None:
        """Triggers count from now on, and those before."""
        self._started = True

    def trigger(self, solution: Solution) -> None:
        """A success of the monitored stage."""
        if solution.end is not None:
            given = self.arguments((solution.end.scene,), solution.end.properties)
            self.queue(Job(solution, given))

    def key(self, job: Job) -> tuple[Any, ...]:
        """Those asked less often, then the cheaper ones."""
        return job.asked, job.subject.cost

    def best(self) -> Job | None:
        """The best trigger."""
        return super().best() if self._started else None

    def busy(self) -> bool:
        """Whether triggers wait, or may come."""
        if not self._started:
            return False
        if self.closed or self.jobs or self.monitored is None:
            return super().busy()
        asked = self.planning.asked
        if self in asked:  # of stages that monitor each other something comes only if it comes from elsewhere
            return False
        first = not asked
        asked.add(self)
        try:
            return self.monitored.may_solve()
        finally:
            if first:
                asked.clear()

    def solve(self, job: Job, result: Result) -> None:
        """A state on either side, with the properties of what was monitored."""
        self.offer(result, job.subject.end.properties, job.subject)

    def cause(self, job: Job) -> Solution | None:
        """What triggered it."""
        return job.subject  # type: ignore[no-any-return]


class PropagatorNode(Leaf):
    """A propagator: one job for each state that comes to it."""

    stage: Propagator

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        self._forward = self.flow is Flow.FORWARD
        self._near, self._far = (LEFT, RIGHT) if self._forward else (RIGHT, LEFT)

    def take(self, state: State, side: int, lane: object) -> None:
        """Queues a job for it."""
        self.queue(Job(state, self.arguments((state.scene,), state.properties)))

    def rekey(self, state: State, side: int) -> None:
        """Queues its job again."""
        if state in self.jobs:
            self.rekey_jobs([self.jobs[state]])

    def revived(self, state: State) -> None:
        """Its job can run again."""
        if state in self.parked:
            self.unpark([self.parked[state]])

    def key(self, job: Job) -> tuple[Any, ...]:
        """Those asked less often, then by the path to the state."""
        return (job.asked, *job.subject.order[self._near])

    def runnable(self, job: Job) -> bool:
        """Whether the state is alive on the side it comes from."""
        state: State = job.subject
        return state.alive[self._near]

    def lane(self, job: Job) -> object:
        """That of the state."""
        return job.subject.lane

    def works_on(self, state: State, side: int) -> bool:
        """Whether its job is not done."""
        return state in self.jobs and not self.closed

    def may_add(self, state: State, side: int, lane: object) -> bool:
        """Whether its job can run."""
        return self.works_on(state, side) and state not in self.parked

    def done(self, job: Job) -> None:
        """Nothing more leads on from the state through here."""
        self.planning.touch(job.subject, self._far)

    def function(self) -> Callable[..., Answers]:
        """`forward` or `backward`."""
        return self.stage.forward if self._forward else self.stage.backward

    def ends(self, job: Job) -> tuple[State | None, State | None]:
        """The state on the side it comes from."""
        return (job.subject, None) if self._forward else (None, job.subject)

    def solve(self, job: Job, result: Result) -> None:
        """A new state on the far side."""
        near: State = job.subject
        properties = {**near.properties, **result.properties} if result.properties else near.properties
        far = self.new_state(near.scene if result.scene is None else result.scene, properties, near.lane)
        start, end = (near, far) if self._forward else (far, near)
        self.report(self.solution(start, end, result))


class Joining(Node):
    """What nodes that connect have in common: partners that may still come keep states alive that have none."""

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        self.expects = [True, True]  # whether states may still come, by side

    def expect(self, again: bool) -> bool:
        """Finds out whether states may still come, or only whether they may `again`; whether that has changed."""
        changed = False
        for side in (LEFT, RIGHT):
            if again and self.expects[side]:
                continue
            now = self.parent is not None and not self.closed and self.parent.delivers_to(self, side)
            if now != self.expects[side]:
                self.expects[side], changed = now, True
                for state in self.came(1 - side):
                    self.planning.touch(state, side)
        return changed


class ConnectorNode(Joining, Leaf):
    """A connector: one job for each pair of states that may fit."""

    stage: Connector

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        self._sides: tuple[dict[object, list[State]], dict[object, list[State]]] = ({}, {})  # by lane
        self.open: dict[State, dict[Job, None]] = {}  # of each state, the jobs of its pairs
        self._choosy = type(self.stage).mismatch is not Connector.mismatch

    def take(self, state: State, side: int, lane: object) -> None:
        """Queues a job for each state on the other side with which it may fit; counts those that do not."""
        self._sides[side].setdefault(lane, []).append(state)
        self.open.setdefault(state, {})
        across = self._sides[1 - side]
        for its_lane in list(across) if lane is None else (None, lane):
            for other in across.get(its_lane, ()):
                pair = (state, other) if side == LEFT else (other, state)
                self._pair(*pair, its_lane if lane is None else lane)

    def came(self, side: int) -> Iterable[State]:
        """The states that came to that side so far."""
        return (state for states in self._sides[side].values() for state in states)

    def _pair(self, start: State, end: State, lane: object) -> None:
        given = self.arguments((start.scene, end.scene), start.properties, end.properties)
        if self._choosy and not isinstance(given, UndefinedProperty):
            reason = self.stage.mismatch(*given[:3])
            if reason is not None:
                self.statistics.mismatches[reason] += 1
                return
        job = Job((start, end, lane), given)
        self.open[start][job] = self.open[end][job] = None
        self.queue(job)
        for state, side in ((start, RIGHT), (end, LEFT)):
            if not state.alive[side]:
                self.planning.touch(state, side)

    def rekey(self, state: State, side: int) -> None:
        """Queues all its pairs again."""
        self.rekey_jobs(self.open.get(state, ()))

    def revived(self, state: State) -> None:
        """Its pairs can be joined again."""
        if self.parked:
            self.unpark(self.open.get(state, ()))

    def key(self, job: Job) -> tuple[Any, ...]:
        """Those asked less often, then by the sum of depths, then of costs."""
        start, end, _ = job.subject
        first, second = start.order[LEFT], end.order[RIGHT]
        return job.asked, first[0] + second[0], first[1] + second[1]

    def runnable(self, job: Job) -> bool:
        """Whether both ends are alive on their far sides."""
        pair: tuple[State, State, object] = job.subject
        return pair[0].alive[LEFT] and pair[1].alive[RIGHT]

    def lane(self, job: Job) -> object:
        """That of the pair."""
        return job.subject[2]

    def works_on(self, state: State, side: int) -> bool:
        """Whether a pair is open with a state that is alive, or more states may come to the other side."""
        if self.closed:
            return False
        return self.expects[side] or any(job.subject[side].alive[side] for job in self.open.get(state, ()))

    def may_add(self, state: State, side: int, lane: object) -> bool:
        """The same, for pairs of a lane that can be joined."""
        if self.closed:
            return False
        pairs = (job.subject for job in self.open.get(state, ()))
        can_run = (p[side].alive[side] and meet(p[2], lane) and p not in self.parked for p in pairs)
        return self.expects[side] or any(can_run)

    def may_join(self, start: State, end: State, lane: object) -> bool:
        """Whether the pair is open."""
        return not self.closed and (start, end, lane) in self.jobs

    def partners(self, state: State, side: int) -> Iterable[State]:
        """Those with which it has open pairs."""
        return [job.subject[side] for job in self.open.get(state, ())]

    def done(self, job: Job) -> None:
        """Both ends have one partner less."""
        start, end, _ = job.subject
        for state, side in ((start, RIGHT), (end, LEFT)):
            self.open[state].pop(job, None)
            self.planning.touch(state, side)

    def function(self) -> Callable[..., Answers]:
        """`connect`."""
        return self.stage.connect

    def ends(self, job: Job) -> tuple[State | None, State | None]:
        """Both."""
        start, end, _ = job.subject
        return start, end

    def solve(self, job: Job, result: Result) -> None:
        """An edge between both states."""
        start, end, _ = job.subject
        self.report(self.solution(start, end, result))
