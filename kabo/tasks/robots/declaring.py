"""What robot stages declare beside their properties: which components of the state they move, and which they read.

A procedure's moves and reads follow from those of its stages, and so does what can be refuted without sampling.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

from kabo.errors import did_you_mean
from kabo.geometry_server import Pair, ProcedureContext, Situation, Stream
from kabo.scene import Scene
from kabo.tasks.core import PARENT, Container, Failure, InitialisationError, Property, Stage, TaskError, tree
from kabo.tasks.robots import meanings

if TYPE_CHECKING:
    from kabo.tasks.robots.motion.questions import Question

ROBOT = Property(str, PARENT, "the robot that moves", meanings.name)
OBJECT = Property(str, PARENT, "the body that this is about", meanings.name)
KEEP = Property(
    (str, dict, type(None)),
    None,
    "a motion constraint to keep for what is held: its name, or {object, constraint}; none or an empty name: nothing",
    meanings.keeping,
)


@dataclass(frozen=True)
class Details:
    """What a failure is about, for programs: pairs that came too close, with counts; proofs; what was read and asked."""

    pairs: tuple[tuple[Pair, int], ...] = ()
    reads: frozenset[str] = frozenset()
    proof: bool = False
    missing: float | None = None
    question: "Question | None" = None


def refusal(
    reason: str,
    comment: str = "",
    *,
    pairs: tuple[tuple[Pair, int], ...] = (),
    hit: Pair | None = None,
    reads: frozenset[str] = frozenset(),
    proof: bool = False,
    missing: float | None = None,
    question: "Question | None" = None,
) -> Failure:
    """A failure with its details; `hit` is the one pair that was in the way."""
    if hit is not None:
        pairs = ((hit, 1),)
    if not comment and pairs:
        comment = f"{pairs[0][0][0]} – {pairs[0][0][1]}"
    return Failure(reason, comment, Details(pairs, reads, proof, missing, question))


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
    """A stage on the geometry server; `MOVES` and `READS` are properties whose values name components."""

    MOVES: ClassVar[tuple[str, ...]] = ()
    READS: ClassVar[tuple[str, ...]] = ()
    FROM_START: ClassVar[bool] = False  # whether, going forward, its end depends on where the robot stood before

    def moves(self) -> tuple[str, ...]:
        """The components that it changes, as far as they are known before planning."""
        return self.named(self.MOVES)

    def reads(self) -> tuple[str, ...]:
        """The components on which what it computes depends, beside those that stages before it have set."""
        return self.named(self.READS)

    def names(self) -> tuple[tuple[str, str], ...]:
        """What its properties name, as far as they are known before planning: (kind of thing, name)."""
        values = ((kind, self.known(name)) for name, kind in _NAMED.items())
        flat = ((kind, v.get("constraint") if isinstance(v, Mapping) else v) for kind, v in values)
        return tuple((kind, v.partition(".")[0]) for kind, v in flat if isinstance(v, str) and v)

    def faults(self, scene: Scene, start: Situation | None = None) -> Iterable[str]:
        """What it is asked for and cannot mean in a scene, as far as that is known before planning.

        `start`: the situation in which the whole task begins, if that is known.
        """
        return ()

    def refute(self, context: ProcedureContext, situation: Situation) -> Failure | None:
        """A proof, without sampling, that the stage fails wherever what the proof reads is as in the situation."""
        return None

    def foresee(self, context: ProcedureContext, situation: Situation) -> Failure | None:
        """Why the stage is not likely to succeed, whatever comes before it; asked once, before any search."""
        return None

    def wanted(self, context: ProcedureContext, situation: Situation) -> Sequence[Stream]:
        """What it would sample in a situation, within reach or not: for telling how far out of reach that is."""
        return ()

    def known(self, name: str) -> Any:
        """The value of a property if it does not depend on an interface state, else None."""
        properties = self.properties
        if not properties.has(name) or properties.reads_interface(name):
            return None
        try:
            return properties.value(name)
        except TaskError:
            return None

    def undecided(self, name: str) -> bool:
        """Whether the value of a property is only known later: it is a caller's, or an interface state's."""
        if self.properties.reads_interface(name):
            return True
        try:
            self.properties.value(name)
        except TaskError:
            return True
        return False

    def named(self, names: tuple[str, ...]) -> tuple[str, ...]:
        """The texts that properties have for values, each once."""
        values = (self.known(name) for name in names)
        return tuple(dict.fromkeys(value for value in values if isinstance(value, str)))


def check_names(task: Container, scene: Scene) -> None:
    """Refuses a task whose stages name what the scene does not have.

    Raises:
        InitialisationError: with all of them.
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
    """Refuses a task whose stages ask for what means nothing in the scene, as far as that is known before planning.

    `start`: the situation in which it begins, if that is known.

    Raises:
        InitialisationError: with all that means nothing.
    """
    stages = [stage for stage in task.walk() if isinstance(stage, RobotStage)]
    found = (
        (stage, fault) for stage in stages for fault in (*_unmoved(stage, scene), *stage.faults(scene, start))
    )
    errors = [f"{stage.path!r}: {fault}" for stage, fault in found]
    if errors:
        raise InitialisationError(errors, tree(task))


def _unmoved(stage: RobotStage, scene: Scene) -> Iterator[str]:
    """Bodies that a stage is to take or to let go, and that never move."""
    for name in stage.moves():
        if name in scene.bodies and name not in scene.movable:
            yield f"{name} is not movable: nobody takes it or lets it go"


def _hint(name: str, known: Mapping[str, Any]) -> str:
    return f", {did_you_mean(name, known) or 'it has ' + (', '.join(known) or 'none')}"
