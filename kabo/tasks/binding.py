"""Binds the calls of a domain to task files: arguments by name, and the components that a call moves and reads.

A call names a task file of the domain or of the library. Its arguments are bound to the file's declared properties; what
it moves and reads follows from the stages of the task with these arguments.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

from kabo.language import TASK_FOLDER, TASK_LIBRARY, TRUTH_VALUES
from kabo.language.formulas import GroundCall
from kabo.scene import Scene
from kabo.tasks.core import Generator, InitialisationError
from kabo.tasks.core.model.stages import Connector
from kabo.tasks.files import TaskFile, load_task_file
from kabo.tasks.learned import LearnedParameters
from kabo.tasks.robots import RobotStage, check_meaning, check_names
from kabo.tasks.robots.stages.states import CurrentState

_PREPOSITIONS = ("robot", "body", "region")


@lru_cache(maxsize=64)
def library_task(name: str) -> TaskFile:
    """The task file of a given name in the library; it is read once and cached."""
    return load_task_file(TASK_LIBRARY / f"{name}.yaml")


@dataclass(frozen=True)
class TaskCall:
    """A ground call bound to its task: the arguments by name, and the components that the call moves and reads."""

    file: TaskFile
    arguments: Mapping[str, Any]
    moves: tuple[str, ...]
    reads: tuple[str, ...]

    @property
    def sentence(self) -> str:
        """The beginning of the message about a failure of the call: `right cannot place bottle_4 in dishwasher`."""
        kinds = {each.name: each.kind for each in self.file.inputs}
        named = [
            (kinds[name], str(value)) for name, value in self.arguments.items() if kinds[name] in _PREPOSITIONS
        ]
        robot = next((value for kind, value in named if kind == "robot"), "nobody")
        text, bodies = f"{robot} cannot {self.file.name.replace('_', ' ')}", 0
        for kind, value in named:
            if kind == "body":
                text, bodies = f"{text} {'on ' if bodies else ''}{value}", bodies + 1
            elif kind == "region":
                text = f"{text} in {value}"
        return text


class _InspectedTask:
    """A task of a file that is only inspected, never planned; the arguments of one call after the other are bound to it."""

    def __init__(self, file: TaskFile) -> None:
        self._file, self._task = file, file.task(partly=True)
        self._stages = tuple(stage for stage in self._task.walk() if isinstance(stage, RobotStage))
        self._refuting = tuple(stage for stage in self._stages if _may_refute(type(stage)))
        self._learned = tuple(stage for stage in self._task.walk() if isinstance(stage, LearnedParameters))
        self._arguments: Mapping[str, Any] = {}

    def stages(self, arguments: Mapping[str, Any]) -> tuple[RobotStage, ...]:
        """The robot stages in order of time, with the arguments bound."""
        if arguments is not self._arguments:
            for name in self._arguments.keys() - arguments.keys():
                self._task.properties.unset(name)
            for name, value in arguments.items():
                self._task.properties.set(name, value)
            self._arguments = arguments
        return self._stages

    def check(self, arguments: Mapping[str, Any], scene: Scene) -> None:
        """Checks that property values make sense for any arguments, and that the scene has what the stages name.

        Raises:
            InputError: lists what is wrong, with its place in the file.
        """
        try:
            self.stages({})
            check_meaning(self._task, scene)
            self.stages(arguments)
            check_names(self._task, scene)
        except InitialisationError as error:
            raise self._file.located(error) from None

    def refuting(self, arguments: Mapping[str, Any]) -> tuple[RobotStage, ...]:
        """The stages that may refute a call, or foresee its failure, before any search."""
        self.stages(arguments)
        return self._refuting

    def learned(self, arguments: Mapping[str, Any]) -> tuple[LearnedParameters, ...]:
        """The stages that infer parameters from models, with the arguments bound."""
        self.stages(arguments)
        return self._learned


def _may_refute(kind: type[RobotStage]) -> bool:
    return kind.refute is not RobotStage.refute or kind.foresee is not RobotStage.foresee


class Bindings:
    """The tasks that calls are bound to, cached, in the order of their first use."""

    def __init__(self, scene: Scene, folder: Path | None) -> None:
        self._scene, self._folder = scene, folder
        self._bound: dict[GroundCall, TaskCall] = {}
        self._looked: dict[str, _InspectedTask] = {}
        self._files: dict[str, TaskFile] = {}

    @property
    def calls(self) -> tuple[GroundCall, ...]:
        """Every call that has been bound, in the order of first use."""
        return tuple(self._bound)

    def bind(self, call: GroundCall) -> TaskCall:
        """The task that a call is bound to, with the call's arguments; it is cached."""
        if call not in self._bound:
            file = self._file(call.procedure)
            arguments = self._arguments(file, call)
            if call.procedure not in self._looked:
                self._looked[call.procedure] = _InspectedTask(file)
                self._looked[call.procedure].check(arguments, self._scene)
            stages = self._looked[call.procedure].stages(arguments)
            components = {*self._scene.robots, *self._scene.movable}
            moves = dict.fromkeys(name for stage in stages for name in stage.moves() if name in components)
            reads = dict.fromkeys(name for name in _read(stages) if name in components)
            self._bound[call] = TaskCall(file, arguments, tuple(moves), tuple(reads))
        return self._bound[call]

    def stages(self, call: GroundCall) -> tuple[RobotStage, ...]:
        """The robot stages of a call's task with the call's arguments set, in order of time.

        They are valid only until another call is bound, because calls of the same task share them.
        """
        arguments = self.bind(call).arguments
        return self._looked[call.procedure].stages(arguments)

    def refuting(self, call: GroundCall) -> tuple[RobotStage, ...]:
        """The stages of a call's task that may prove, or predict, before any search that the call fails."""
        arguments = self.bind(call).arguments
        return self._looked[call.procedure].refuting(arguments)

    def learned(self, call: GroundCall) -> tuple[LearnedParameters, ...]:
        """The stages of a call's task that infer parameters from models; they, too, may prove that the call fails."""
        arguments = self.bind(call).arguments
        return self._looked[call.procedure].learned(arguments)

    def _file(self, name: str) -> TaskFile:
        if name not in self._files:
            own = None if self._folder is None else self._folder / TASK_FOLDER / f"{name}.yaml"
            self._files[name] = library_task(name) if own is None or not own.exists() else load_task_file(own)
        return self._files[name]

    def _arguments(self, file: TaskFile, call: GroundCall) -> dict[str, Any]:
        kinds = {each.name: each.kind for each in file.inputs}
        given = dict(zip(kinds, call.arguments, strict=False)) | dict(call.options)
        arguments = {name: _argument(value, kinds[name]) for name, value in given.items()}
        for each in file.inputs:  # a motion constraint that the scene may lack
            kept = each.kind == "motion_constraint" and each.name not in arguments
            if kept and each.default not in self._scene.motion_constraints:
                arguments[each.name] = ""
        return arguments


def _argument(value: str | float, kind: str | None) -> Any:
    """The value of an argument, of the type that the task declares."""
    if kind in ("boolean", "any") and value in TRUTH_VALUES:
        return value == "true"
    return value if kind in ("number", "any") else str(value)


def _read(stages: tuple[RobotStage, ...]) -> Iterator[str]:
    """The components that the stages read; also a robot whose first motion starts where it is, without a connector."""
    from_start = False
    for stage in stages:
        yield from stage.reads()
        if isinstance(stage, CurrentState):
            from_start = True
        elif isinstance(stage, (Connector, Generator)):
            from_start = False
        elif stage.FROM_START and from_start:
            yield from stage.moves()
