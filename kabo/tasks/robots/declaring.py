"""The base class of robot stages, which declare the components of the state that they move and read.

From these declarations the components that a procedure moves and reads are derived.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any, ClassVar

from kabo.errors import did_you_mean
from kabo.geometry_server import ProcedureContext, Refusal, Situation, Stream
from kabo.scene import Scene
from kabo.tasks.core import (
    PARENT,
    Alternatives,
    Container,
    Fallbacks,
    InitialisationError,
    Property,
    Stage,
    TaskError,
    tree,
)
from kabo.tasks.robots import meanings

ROBOT = Property(str, PARENT, "the robot that moves", meanings.name)
OBJECT = Property(str, PARENT, "the object", meanings.name)
KEEP = Property(
    (str, dict, type(None)),
    None,
    "a motion constraint to keep for what is held: its name, or {object, constraint}; none or empty: no constraint",
    meanings.keeping,
)
PLANNER = Property(
    (str, list, tuple),
    meanings.RRT_CONNECT,
    "`rrt_connect`: sampled; `straight`: all joints evenly; `tool_line`: the tool on a straight line; or a list, in order",
    meanings.planners,
)
ATTEMPT_TIMEOUT = Property(
    (float, type(None)),
    None,
    "the time after which each planner is cut off [s]; none: only the number of samples is limited",
    meanings.at_least(0.0, above=True),
)

_THINGS = ("robot", "body", "region", "motion constraint", "mate")
_NAMED = {
    "robot": "robot",
    "to": "robot",
    "partner": "robot",
    "object": "body",
    "part": "body",
    "support": "body",
    "onto": "body",
    "region": "region",
    "keep": "motion constraint",
    "mate": "mate",
}


class RobotStage(Stage):
    """A stage that is planned with the geometry server.

    `MOVES` and `READS` list the properties whose values name the components that the stage moves and reads.
    """

    MOVES: ClassVar[tuple[str, ...]] = ()
    READS: ClassVar[tuple[str, ...]] = ()
    FROM_START: ClassVar[bool] = False  # whether, forward, its result depends on where the robot was before

    def moves(self) -> tuple[str, ...]:
        """The components that the stage changes, as far as known before planning."""
        return self.named(self.MOVES)

    def reads(self) -> tuple[str, ...]:
        """The components that the stage's results depend on, except those set by earlier stages."""
        return self.named(self.READS)

    def names(self) -> tuple[tuple[str, str], ...]:
        """The things that the stage's properties name, as (kind, name), as far as known before planning."""
        values = ((kind, self.known(name)) for name, kind in _NAMED.items())
        flat = ((kind, v.get("constraint") if isinstance(v, Mapping) else v) for kind, v in values)
        return tuple((kind, v.partition(".")[0]) for kind, v in flat if isinstance(v, str) and v)

    def faults(self, scene: Scene, start: Situation | None = None) -> Iterable[str]:
        """Messages for property values that are invalid in the scene, as far as known before planning.

        `start` is the situation in which the whole task begins, if known.
        """
        return ()

    def refute(self, context: ProcedureContext, situation: Situation) -> Refusal | None:
        """A proof, without sampling, that the stage fails while the components it reads are as in the situation.

        The result is None if there is no such proof.
        """
        return None

    def foresee(self, context: ProcedureContext, situation: Situation) -> Refusal | None:
        """The reason why the stage will probably fail whatever precedes it, or None; called once, before the search."""
        return None

    def wanted(self, context: ProcedureContext, situation: Situation) -> Sequence[Stream]:
        """The streams that the stage would sample in a situation, used to explain by how much targets are out of reach."""
        return ()

    def known(self, name: str) -> Any:
        """The value of a property, or None if it is undefined or depends on an interface state."""
        try:
            return self.properties.value(name) if self.properties.has(name) else None
        except TaskError:
            return None

    def undecided(self, name: str) -> bool:
        """Whether a property's value is unknown before planning: the caller or an interface state gives it."""
        try:
            self.properties.value(name)
        except TaskError:
            return True
        return False

    def named(self, names: tuple[str, ...]) -> tuple[str, ...]:
        """The values of these properties that are texts, as far as known before planning, no duplicates."""
        values = (self.known(name) for name in names)
        return tuple(dict.fromkeys(value for value in values if isinstance(value, str)))


def check_names(task: Container, scene: Scene) -> None:
    """Checks that the scene has everything that the stages of a task name.

    Raises:
        InitialisationError: lists all names that the scene lacks.
    """
    things = scene.robots, scene.bodies, scene.regions, scene.motion_constraints, scene.mates
    known = dict(zip(_THINGS, things, strict=True))
    errors = [
        f"{stage.path!r}: the scene has no {kind} {name!r}{_hint(name, known[kind])}"
        for stage in task.walk()
        if isinstance(stage, RobotStage)
        for kind, name in stage.names()
        if name not in known[kind]
    ]
    if errors:
        raise InitialisationError(errors, tree(task))


def check_meaning(task: Container, scene: Scene, start: Situation | None = None) -> None:
    """Checks that the property values of all stages make sense in the scene, as far as known before planning.

    `start` is the situation in which the task begins, if known.

    Raises:
        InitialisationError: lists all values that make no sense.
    """
    stages = [stage for stage in task.walk() if isinstance(stage, RobotStage)]
    found = ((stage, fault) for stage in stages for fault in _faults(stage, scene, start))
    errors = [f"{stage.path!r}: {fault}" for stage, fault in found]
    if errors:
        raise InitialisationError(errors, tree(task))


def _faults(stage: RobotStage, scene: Scene, start: Situation | None) -> Iterable[str]:
    """What is wrong with a stage's values by themselves; if nothing is, what is wrong with them in the scene."""
    return stage.properties.invalid() or [*_unmoved(stage, scene), *stage.faults(scene, start)]


def _unmoved(stage: RobotStage, scene: Scene) -> Iterator[str]:
    """Faults: bodies that the stage is to grasp or release and that are not movable."""
    for name in stage.moves():
        if name in scene.bodies and name not in scene.movable:
            yield f"{name} is not movable: nobody takes it or lets it go"


def is_optional(stage: Stage) -> bool:
    """Whether a stage stands below `Alternatives` or `Fallbacks`, so that there may be another way if it fails."""
    above = stage.parent
    while above is not None and not isinstance(above, (Alternatives, Fallbacks)):
        above = above.parent
    return above is not None


def keep_faults(stage: RobotStage, start: Situation | None) -> Iterator[str]:
    """Messages if the motion constraint `keep` of a stage applies to nothing that the robot can hold."""
    given, robot = stage.known("keep"), stage.known("robot")
    if not given or start is None or robot not in start.robots or start.carried(robot):
        return
    top: Stage = stage
    while top.parent is not None:
        top = top.parent
    if isinstance(top, Container) and not any(_may_take(each) for each in top.walk()):
        name = given.get("constraint") if isinstance(given, Mapping) else given
        yield f"nothing can keep {name}: {robot} holds nothing, and nothing is taken in this task"


def _may_take(stage: Stage) -> bool:
    """Whether a robot may hold an object after the stage that it did not hold before."""
    moving = isinstance(stage, RobotStage) and ("object" in stage.MOVES or stage.properties.has("scene"))
    return moving or not (isinstance(stage, (RobotStage, Container)) or type(stage).__module__.startswith("kabo."))


def _hint(name: str, known: Mapping[str, Any]) -> str:
    return f", {did_you_mean(name, known) or 'it has ' + (', '.join(known) or 'none')}"
