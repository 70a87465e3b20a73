"""Procedures: the calls of a domain as tasks on a geometry server, pure functions with a memory [T 3.9].

A call binds to a task file; it succeeds with the task's solution, the segments of its motion and the components that
it changes. Asked again, it gives the task's next solution. It fails with what its stages were refused for.

`GeometricProcedures.call` is a pure function of (call, situation, attempt, effort): what was asked before, or in which
process, changes when an answer is there, never which. So answers may be made elsewhere, ahead of time.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import lru_cache
from pathlib import Path
from typing import Any

from kabo.geometry_server import Answer, Failure, GeometryServer, Situation, Statistics, Stream, Success
from kabo.language.calls import TRUTH
from kabo.language.formulas import GroundCall
from kabo.language.procedures import FOLDER, LIBRARY
from kabo.scene import GeometricState, Scene
from kabo.tasks.core import Failure as StageFailure
from kabo.tasks.core import Generator, InitialisationError, Stage, Task
from kabo.tasks.core.stages import Connector
from kabo.tasks.files import TaskFile, load_task_file
from kabo.tasks.records import FORESEEN, Records
from kabo.tasks.refusals import Refusals
from kabo.tasks.robots import RobotStage, TaskScene, changed, check_names, segments
from kabo.tasks.robots.states import CurrentState

Observe = Callable[[Stage, StageFailure], None]

HASTY_WAYS, WAYS, MORE_WAYS = (
    8,
    4,
    4,
)  # ways in vain that end a call: short searches, long ones; more with each effort
REMEMBERED = 256  # calls whose tasks are kept to be asked again; a task that was dropped starts over


# The answer to a call in a situation (attempt, effort) and what it cost, if another process was asked for it.
Elsewhere = Callable[[GroundCall, Situation, int, int], tuple[Answer, Statistics] | None]


@lru_cache(maxsize=64)
def library_task(name: str) -> TaskFile:
    """A task file of the library."""
    return load_task_file(LIBRARY / f"{name}.yaml")


@dataclass(frozen=True)
class Bound:
    """A ground call bound to its task: arguments by name, and the components that it moves and reads."""

    file: TaskFile
    arguments: Mapping[str, Any]
    moves: tuple[str, ...]
    reads: tuple[str, ...]


class _Looked:
    """A task of a file that is only looked at: one call after the other is bound to it."""

    def __init__(self, file: TaskFile) -> None:
        self._file, self._task = file, file.task(partly=True)
        self._stages = tuple(stage for stage in self._task.walk() if isinstance(stage, RobotStage))
        self._refuting = tuple(stage for stage in self._stages if _may_refute(type(stage)))
        self._arguments: Mapping[str, Any] = {}

    def stages(self, arguments: Mapping[str, Any]) -> tuple[RobotStage, ...]:
        """Its robot stages, in order of time, with the arguments bound."""
        if arguments is not self._arguments:
            for name in self._arguments.keys() - arguments.keys():
                self._task.properties.unset(name)
            for name, value in arguments.items():
                self._task.properties.set(name, value)
            self._arguments = arguments
        return self._stages

    def check(self, arguments: Mapping[str, Any], scene: Scene) -> None:
        """Refuses names that the scene does not have.

        Raises:
            InputError: at their places in the file.
        """
        self.stages(arguments)
        try:
            check_names(self._task, scene)
        except InitialisationError as error:
            raise self._file.told(error) from None

    def refuting(self, arguments: Mapping[str, Any]) -> tuple[RobotStage, ...]:
        """Those that may tell, without sampling, that a call must fail."""
        self.stages(arguments)
        return self._refuting


def _may_refute(kind: type[RobotStage]) -> bool:
    return kind.refute is not RobotStage.refute or kind.foresee is not RobotStage.foresee


@dataclass
class _Asked:
    """A call in a situation: its task, and what came of it so far."""

    task: Task
    refusals: Refusals
    successes: list[Success] = field(default_factory=list)


@dataclass
class GeometricProcedures:
    """Answers calls of procedures on a geometry server.

    `folder` (of the domain) may have task files of its own. `elsewhere` is asked first: answers are pure functions of
    call, situation, attempt and effort, so they may come from another process that has a copy of this one.
    """

    server: GeometryServer
    folder: Path | None = None
    elsewhere: Elsewhere | None = None

    def __post_init__(self) -> None:
        self._bound: dict[GroundCall, Bound] = {}
        self._looked: dict[str, _Looked] = {}
        self._asked: dict[tuple[object, ...], _Asked] = {}
        self._answers: dict[tuple[object, ...], Answer] = {}
        self.records = Records()

    # ------------------------------------------------------------------------------------- the server beneath
    @property
    def scene(self) -> Scene:
        """The scene."""
        return self.server.scene

    @property
    def statistics(self) -> Statistics:
        """What the geometry did, in counts."""
        return self.server.statistics

    @property
    def stop(self) -> Callable[[], bool]:
        """Says that time or budget is spent."""
        return self.server.stop

    @property
    def states_met(self) -> int:
        """How many distinct geometric states procedures have led to."""
        return len(self.server.identifiers)

    def identify(self, state: GeometricState) -> int:
        """The identifier of a geometric state [K Def. 5]."""
        return self.server.identify(state)

    def state(self, identifier: int) -> GeometricState:
        """The geometric state of an identifier."""
        return self.server.state(identifier)

    # ---------------------------------------------------------------------------------------------- the calls
    def bind(self, call: GroundCall) -> Bound:
        """The task of a call with its arguments by name."""
        if call not in self._bound:
            file = self._file(call.procedure)
            arguments = self._arguments(file, call)
            if call.procedure not in self._looked:
                self._looked[call.procedure] = _Looked(file)
                self._looked[call.procedure].check(arguments, self.scene)
            stages = self._looked[call.procedure].stages(arguments)
            components = {*self.scene.robots, *self.scene.movable}
            moves = dict.fromkeys(name for stage in stages for name in stage.moves() if name in components)
            reads = dict.fromkeys(name for name in _read(stages) if name in components)
            self._bound[call] = Bound(file, arguments, tuple(moves), tuple(reads))
        return self._bound[call]

    def _file(self, name: str) -> TaskFile:
        own = None if self.folder is None else self.folder / FOLDER / f"{name}.yaml"
        return library_task(name) if own is None or not own.exists() else _task_file(own)

    def _arguments(self, file: TaskFile, call: GroundCall) -> dict[str, Any]:
        kinds = {each.name: each.kind for each in file.inputs}
        given = dict(zip(kinds, call.arguments, strict=False)) | dict(call.options)
        arguments = {name: _argument(value, kinds[name]) for name, value in given.items()}
        for each in file.inputs:  # a constraint that a scene need not have
            kept = each.kind == "motion_constraint" and each.name not in arguments
            if kept and each.default not in self.scene.motion_constraints:
                arguments[each.name] = ""
        return arguments

    def _refuting(self, call: GroundCall) -> tuple[RobotStage, ...]:
        arguments = self.bind(call).arguments
        return self._looked[call.procedure].refuting(arguments)

    def stages(self, call: GroundCall) -> tuple[RobotStage, ...]:
        """The robot stages of a call's task with its arguments, in order of time; until another one is asked for."""
        arguments = self.bind(call).arguments
        return self._looked[call.procedure].stages(arguments)

    def single(self, call: GroundCall, situation: Situation) -> tuple[str, ...]:
        """The components that must have one value before a call: what it moves, carries and refers to, sorted."""
        bound = self.bind(call)
        robots = [name for name in bound.moves if name in self.scene.robots]
        held = {name for robot in robots for name in situation.carried(robot)}
        return tuple(sorted({*bound.moves, *bound.reads, *held}))

    def knows(self, call: GroundCall, situation: Situation, attempt: int = 0, effort: int = 0) -> bool:
        """Whether the answer to a call is remembered."""
        return ((call, effort, situation.key), attempt) in self._answers

    def call(self, call: GroundCall, situation: Situation, attempt: int = 0, effort: int = 0) -> Answer:
        """The answer of a procedure for every value that the situation leaves open, remembered.

        `attempt` counts the successes to pass over: the task is planned on from where it was left.
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
            if isinstance(answer, Success) or not self.stop():  # what was cut off is no answer
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
            return self._failure(call, situation, refusals, False)
        for hasty in (True, False):
            asked = self._asked_on((*key, hasty), call, situation, attempt, effort, hasty)
            if attempt < len(asked.successes):
                return asked.successes[attempt]
            if asked.successes or not asked.refusals.count("no_path") or self.stop():
                break
        failure = self._failure(call, situation, asked.refusals, bool(asked.successes))
        blamed = asked.task.explain()
        if asked.successes or not blamed.mismatches:
            return failure
        return replace(
            failure, message=f"{_sentence(self.bind(call))}: {blamed.text}"
        )  # what was found never fitted

    def _asked_on(
        self,
        key: tuple[object, ...],
        call: GroundCall,
        situation: Situation,
        attempt: int,
        effort: int,
        hasty: bool,
    ) -> _Asked:
        """A call's task, planned on until it has that many solutions, no more to try, or too often found no way.

        At first with short searches for ways: where one is hard to find, another grasp or place may be easy to reach.
        """
        asked = self._asked.pop(key, None) or self._ask(call)
        self._asked[key] = asked
        if len(self._asked) > REMEMBERED:
            del self._asked[next(iter(self._asked))]
        most = (HASTY_WAYS if hasty else WAYS) * MORE_WAYS**effort

        def stop() -> bool:
            return asked.refusals.count("no_path") >= most or self.stop()

        scene = TaskScene.of(self.server.context(effort, hasty), situation)
        found = asked.task.plan(scene, attempt + 1, stop=stop)
        for solution in found[len(asked.successes) :]:
            motion = segments(solution, self.scene, call.procedure)
            asked.successes.append(Success(motion, changed(solution), asked.refusals.movable(self.scene)))
        return asked

    def _failure(self, call: GroundCall, situation: Situation, refusals: Refusals, again: bool) -> Failure:
        bound = self.bind(call)
        failure = refusals.failure(_sentence(bound), frozenset(bound.reads), self.scene, again=again)
        return replace(failure, reads=failure.reads | situation.carriers(failure.reads) - {*bound.moves})

    def _ask(self, call: GroundCall) -> _Asked:
        bound = self.bind(call)
        task, refusals = bound.file.task(bound.arguments, seed=self.server.seed), Refusals()
        task.lazy, task.observe = True, refusals.observe
        return _Asked(task, refusals)

    # ------------------------------------------------------------------------------------------- explanations
    @property
    def calls(self) -> tuple[GroundCall, ...]:
        """Every call that anything was asked about, in order."""
        return tuple(self._bound)

    def again(self, call: GroundCall, situation: Situation, attempt: int, effort: int, observe: Observe) -> int:
        """Makes a call afresh, every refused attempt told to `observe`; how many solutions there were. Kept nowhere."""
        refused = self._refuted(call, situation)
        if refused is not None:
            observe(*refused)
            return 0
        bound = self.bind(call)
        task = bound.file.task(bound.arguments, seed=self.server.seed)
        task.lazy, task.observe = True, observe
        return len(task.plan(TaskScene.of(self.server.context(effort), situation), attempt + 1, stop=self.stop))

    def wanted(self, call: GroundCall, situation: Situation) -> list[Stream]:
        """What the stages of a call would sample in a situation, within reach or not."""
        arguments, context = self.bind(call).arguments, self.server.context()
        stages = self._looked[call.procedure].stages(arguments)
        return [stream for stage in stages for stream in stage.wanted(context, situation)]

    # ------------------------------------------------------------------------------------------------- proofs
    def _refuted(self, call: GroundCall, situation: Situation) -> tuple[Stage, StageFailure] | None:
        context = self.server.context()
        for stage in self._refuting(call):
            failure = stage.refute(context, situation)
            if failure is not None:
                return stage, failure
        return None

    def refuted(self, call: GroundCall) -> Failure | None:
        """Why a call fails wherever what it reads is as at the start, if that can be told before any search."""
        start, bound = Situation.of(self.scene.start), self.bind(call)
        found = self._refuted(call, start)
        if found is None:
            context = self.server.context()
            foreseen = ((stage, stage.foresee(context, start)) for stage in self._refuting(call))
            found = next(((stage, failure) for stage, failure in foreseen if failure is not None), None)
        if found is None:
            return None
        refusals = Refusals()
        refusals.observe(*found)
        failure = refusals.failure(_sentence(bound), frozenset(), self.scene)
        self.records.note(call, start, 0, FORESEEN, failure)
        return failure


@lru_cache(maxsize=64)
def _task_file(path: Path) -> TaskFile:
    return load_task_file(path)


def _argument(value: str | float, kind: str | None) -> Any:
    """What a call gives, as the task declares it."""
    if kind in ("boolean", "any") and value in TRUTH:
        return value == "true"
    return value if kind in ("number", "any") else str(value)


def _read(stages: tuple[RobotStage, ...]) -> Iterator[str]:
    """What stages read; a robot as well, where a motion goes on from where it stood, with no way in between."""
    from_start = False
    for stage in stages:
        yield from stage.reads()
        if isinstance(stage, CurrentState):
            from_start = True
        elif isinstance(stage, (Connector, Generator)):
            from_start = False
        elif stage.FROM_START and from_start:
            yield from stage.moves()


def _sentence(bound: Bound) -> str:
    """`right cannot place bottle_4 in dishwasher`."""
    kinds = {each.name: each.kind for each in bound.file.inputs}
    named = [(kinds[name], str(value)) for name, value in bound.arguments.items() if kinds[name] in _PREPOSITIONS]
    robot = next((value for kind, value in named if kind == "robot"), "nobody")
    text, bodies = f"{robot} cannot {bound.file.name.replace('_', ' ')}", 0
    for kind, value in named:
        if kind == "body":
            text, bodies = f"{text} {'on ' if bodies else ''}{value}", bodies + 1
        elif kind == "region":
            text = f"{text} in {value}"
    return text


_PREPOSITIONS = ("robot", "body", "region")
