"""Procedures: the calls of a domain, planned as tasks on a geometry server; answers are cached [T 3.9].

A call is bound to a task file. It succeeds with a solution of the task: the segments of its motion and the components
that it changes. Each further attempt returns the task's next solution. It fails with the failures of its stages.

`GeometricProcedures.call` is a pure function of (call, situation, attempt, effort): earlier calls, and the process
that answers, only change when an answer is ready, never what it is. So answers may be computed elsewhere, ahead of
time.

A call that is cut off has no answer: it raises CutOff, and is neither cached nor counted nor learnt from.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path

from kabo.errors import CutOff
from kabo.geometry_server import Answer, GeometryServer, GeometryStatistics, Refusal, Situation, Stream, Success
from kabo.language.formulas import GroundCall
from kabo.language.source import beside
from kabo.plan import Learned
from kabo.scene import GeometricState, Scene
from kabo.tasks.binding import Bindings, TaskCall
from kabo.tasks.core import InitialisationError, Solution, Stage, Task
from kabo.tasks.core.model.results import Refused
from kabo.tasks.files.running import located_at_stage
from kabo.tasks.learned import learned_in
from kabo.tasks.records import FORESEEN, Records, Where
from kabo.tasks.refusals import Refusals
from kabo.tasks.robots import RobotStage, TaskScene, changed, first_failing, found_motion

Observe = Callable[[Stage, Refused], None]

# Failed path searches that end a call: short ones (hasty), long ones; the factor by which each effort multiplies them.
MAX_FAILED_PATHS_HASTY, MAX_FAILED_PATHS, PATHS_FACTOR = 8, 4, 4
MAX_CACHED_TASKS = 256  # calls whose tasks are kept for further attempts; others start over


# The answer of another process to a call in a situation (attempt, effort), with its statistics; None: not asked for.
Elsewhere = Callable[[GroundCall, Situation, int, int], tuple[Answer, GeometryStatistics] | None]


@dataclass
class _PlannedCall:
    """The task of a call in a situation, with its results so far."""

    task: Task
    refusals: Refusals
    successes: list[Success] = field(default_factory=list)


@dataclass
class GeometricProcedures:
    """Answers the calls of procedures on a geometry server.

    `folder` (of the domain) may have task files of its own. `elsewhere` is asked first for an answer that another process
    may have computed: answers are pure functions of call, situation, attempt and effort.
    """

    server: GeometryServer
    folder: Path | None = None
    elsewhere: Elsewhere | None = None

    def __post_init__(self) -> None:
        self._bindings = Bindings(self.scene, self.folder)
        self._asked: dict[tuple[object, ...], _PlannedCall] = {}
        self._answers: dict[tuple[object, ...], Answer] = {}
        self.records = Records()
        self._present: tuple[GroundCall, Situation, int, int, Refusals] | None = None

    # ------------------------------------------------------------------------------------- the server beneath
    @property
    def scene(self) -> Scene:
        """The scene in which calls are answered."""
        return self.server.scene

    @property
    def statistics(self) -> GeometryStatistics:
        """The statistics of the geometry server: how often each of its operations was executed."""
        return self.server.statistics

    @property
    def stop(self) -> Callable[[], bool]:
        """A function that returns True once the time or the budget is spent."""
        return self.server.stop

    @property
    def states_met(self) -> int:
        """The number of distinct geometric states that successful calls have led to."""
        return len(self.server.identifiers)

    def identify(self, state: GeometricState) -> int:
        """The identifier of a geometric state; equal states have the same identifier [K Def. 5]."""
        return self.server.identify(state)

    def state(self, identifier: int) -> GeometricState:
        """The geometric state that has a given identifier."""
        return self.server.state(identifier)

    # ---------------------------------------------------------------------------------------------- the calls
    def bind(self, call: GroundCall) -> TaskCall:
        """The task that a call is bound to, with the call's arguments."""
        return self._bindings.bind(call)

    def stages(self, call: GroundCall) -> tuple[RobotStage, ...]:
        """The robot stages of a call's task with the call's arguments set, in order of time.

        They are valid only until another call is bound, because calls of the same task share them.
        """
        return self._bindings.stages(call)

    def single(self, call: GroundCall, situation: Situation) -> tuple[str, ...]:
        """The components that must have a single value before a call that moves, carries or reads them."""
        bound = self.bind(call)
        robots = [name for name in bound.moves if name in self.scene.robots]
        held = {name for robot in robots for name in situation.carried(robot)}
        return tuple(sorted({*bound.moves, *bound.reads, *held}))

    def knows(self, call: GroundCall, situation: Situation, attempt: int = 0, effort: int = 0) -> bool:
        """Whether the answer to a call is cached."""
        return ((call, effort, situation.key), attempt) in self._answers

    def call(self, call: GroundCall, situation: Situation, attempt: int = 0, effort: int = 0) -> Answer:
        """The answer to a call, valid for every value that the situation leaves open; cached.

        `attempt` is the number of solutions to skip: planning continues where it was left.

        Raises:
            CutOff: time or budget was spent before there was an answer.
        """
        key = (call, effort, situation.key)
        if (key, attempt) not in self._answers:
            made = None if self.elsewhere is None else self.elsewhere(call, situation, attempt, effort)
            if made is None:
                answer = self._answered(key, call, situation, attempt, effort)
                self.statistics.record(call.procedure, answer)
            else:
                answer = made[0]
                self.statistics.add(made[1])
            self._answers[key, attempt] = answer
            self.records.note(call, situation, attempt, effort, answer)
            if isinstance(answer, Success):
                self.identify(situation.replace(answer.changes).first)
        return self._answers[key, attempt]

    def _answered(
        self, key: tuple[object, ...], call: GroundCall, situation: Situation, attempt: int, effort: int
    ) -> Answer:
        refused = self._refuted(call, situation)
        if refused is not None:
            refusals = Refusals()
            refusals.observe(*refused)
            return self._refusal(call, situation, refusals, False)
        for hasty in (True, False):
            asked = self._planned((*key, hasty), call, situation, attempt, effort, hasty)
            if attempt < len(asked.successes):
                return asked.successes[attempt]
            if asked.successes or not asked.refusals.count("no_path"):
                break
        refusal = self._refusal(call, situation, asked.refusals, bool(asked.successes))
        blamed = asked.task.explain()
        if asked.successes or not blamed.mismatches:
            return refusal
        # Solutions of stages were found, but never joined.
        return replace(refusal, comment=f"{self.bind(call).sentence}: {blamed.text}")

    def _planned(
        self,
        key: tuple[object, ...],
        call: GroundCall,
        situation: Situation,
        attempt: int,
        effort: int,
        hasty: bool,
    ) -> _PlannedCall:
        """Plans a call's task until it has enough solutions, is exhausted, or has too often found no path.

        A hasty call uses short path searches: where a path is hard to find, another grasp or place may be easy to reach.
        At effort 0 parts of bodies are seldom divided: what is free without is free, and another call may be, too.
        """
        asked = self._asked.pop(key, None) or self._ask(call)
        self._present = call, situation, attempt, effort, asked.refusals
        most = (MAX_FAILED_PATHS_HASTY if hasty else MAX_FAILED_PATHS) * PATHS_FACTOR**effort

        def stop() -> bool:
            return asked.refusals.count("no_path") >= most or self.stop()

        scene = TaskScene.of(self.server.context(effort, hasty, coarse=effort == 0), situation)
        try:
            found = asked.task.plan(scene, attempt + 1, stop=stop)
            if len(found) <= attempt:
                self.server.look()  # raises CutOff if planning was cut off: then the failures so far prove nothing
        except CutOff:
            self.records.unfinished.update(self.refused_so_far())
            raise
        except (InitialisationError, ValueError) as error:
            told = located_at_stage(self.bind(call).file, asked.task, error)
            if told is None:
                raise
            raise told from error
        self._asked[key] = asked
        if len(self._asked) > MAX_CACHED_TASKS:
            del self._asked[next(iter(self._asked))]
        for solution in found[len(asked.successes) :]:
            motion = found_motion(solution, self.scene, call.procedure)
            movable = asked.refusals.movable(self.scene)
            learned = _opened(solution, self.bind(call))
            asked.successes.append(Success(motion, changed(solution), movable, learned))
        return asked

    def _refusal(self, call: GroundCall, situation: Situation, refusals: Refusals, again: bool) -> Refusal:
        bound = self.bind(call)
        total = refusals.total(bound.sentence, frozenset(bound.reads), self.scene, again=again)
        return replace(total, reads=total.reads | situation.carriers(total.reads) - {*bound.moves})

    def _ask(self, call: GroundCall) -> _PlannedCall:
        bound = self.bind(call)
        task, refusals = bound.file.task(bound.arguments, seed=self.server.seed), Refusals()
        task.lazy, task.observe = True, refusals.observe
        return _PlannedCall(task, refusals)

    # ------------------------------------------------------------------------------------------- explanations
    @property
    def calls(self) -> tuple[GroundCall, ...]:
        """Every call that was bound, in order of first use."""
        return self._bindings.calls

    def refused_so_far(self) -> dict[GroundCall, Where]:
        """What the call that was planned last has been refused for until now; empty if nothing was refused yet."""
        if self._present is None or not self._present[-1].tallies:
            return {}
        call, situation, attempt, effort, refusals = self._present
        so_far = replace(self._refusal(call, situation, refusals, bool(attempt)), proof=False)
        return {call: Where(situation, attempt, effort, so_far)}

    def again(
        self,
        call: GroundCall,
        situation: Situation,
        attempt: int,
        effort: int,
        observe: Observe,
        enough: Callable[[], bool],
    ) -> int:
        """The number of solutions when a call is planned anew, uncached; `observe` gets all failed attempts.

        Raises:
            CutOff: time or budget was spent; planning just ends if `enough`, called between jobs, is True.
        """
        refused = self._refuted(call, situation)
        if refused is not None:
            observe(*refused)
            return 0
        bound = self.bind(call)
        task = bound.file.task(bound.arguments, seed=self.server.seed)
        task.lazy, task.observe = True, observe
        return len(task.plan(TaskScene.of(self.server.context(effort), situation), attempt + 1, stop=enough))

    def wanted(self, call: GroundCall, situation: Situation) -> list[Stream]:
        """The streams that the stages of a call would sample in a situation, including targets out of reach."""
        context = self.server.context()
        return [stream for stage in self.stages(call) for stream in stage.wanted(context, situation)]

    # ------------------------------------------------------------------------------------------------- proofs
    def _refuted(self, call: GroundCall, situation: Situation) -> tuple[Stage, Refused] | None:
        for learned in self._bindings.learned(call):
            failure = learned.refute()
            if failure is not None:
                return learned, failure
        context = self.server.context()
        return first_failing(
            self._bindings.refuting(call), lambda stage: stage.refute(context, situation), situation
        )

    def refuted(self, call: GroundCall) -> Refusal | None:
        """The refusal of a call in the start situation, proven or predicted by its stages before any search.

        The result is None if no stage proves or predicts that the call fails.
        """
        start, bound = Situation.of(self.scene.start), self.bind(call)
        found = self._refuted(call, start)
        if found is None:
            context = self.server.context()
            found = first_failing(
                self._bindings.refuting(call), lambda stage: stage.foresee(context, start), start
            )
        if found is None:
            return None
        refusals = Refusals()
        refusals.observe(*found)
        refusal = refusals.total(bound.sentence, frozenset(), self.scene)
        self.records.note(call, start, 0, FORESEEN, refusal)
        return refusal


def _opened(solution: Solution, bound: TaskCall) -> tuple[Learned, ...]:
    """The learned parameters of a solution, their models named by the paths at which they were opened."""
    folder = str(bound.file.description.source.path.parent)
    return tuple(replace(each, model=beside(folder, each.model)) for each in learned_in(solution))
