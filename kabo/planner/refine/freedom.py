"""The parts of a task's motion that refinement may change without changing the task.

The path of a free motion between two configurations may be replaced by any other free path. A stroke (a straight
approach or retreat) may be shortened to the least length that its family requires. All other motion stays as its
stage made it.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

from kabo.language.scene_description import Stroke
from kabo.scene import Body
from kabo.tasks.robots.declaring import RobotStage
from kabo.tasks.robots.motion.directions import direction_of
from kabo.tasks.robots.stages.connecting import Connect
from kabo.tasks.robots.stages.geometry import AddGeometry, Pad
from kabo.tasks.robots.stages.grasps import LIFT
from kabo.tasks.robots.stages.merging import Merger
from kabo.tasks.robots.stages.moves import MoveTo
from kabo.tasks.robots.stages.reparameterising import Reparameterise
from kabo.tasks.robots.stages.states import SampleConfiguration
from kabo.tasks.robots.stages.strokes import MoveRelative


@dataclass(frozen=True)
class Freedom:
    """The permitted change of one stage's motion; `least` [m] is the least length to which a stroke may be cut."""

    kind: Literal["way", "stroke", "fixed"]
    least: float = 0.0

    def longer(self, factor: float) -> "Freedom":
        """The same with a greater least length."""
        return replace(self, least=factor * self.least)


FIXED, WAY = Freedom("fixed"), Freedom("way")


@dataclass(frozen=True)
class Freedoms:
    """The permitted changes of the motions of a call's stages, by the path of each stage in the task.

    `anywhere`: whether the robot may end the task in another configuration. `mergers` are the paths of stages whose
    children move at once.
    """

    by_stage: Mapping[str, Freedom]
    anywhere: bool = False
    mergers: tuple[str, ...] = ()

    def of(self, stage: str | None) -> Freedom:
        """The permitted changes of a stage's motion; unknown stages permit none."""
        return FIXED if stage is None else self.by_stage.get(stage, FIXED)

    def longer(self, factor: float) -> "Freedoms":
        """The same with greater least lengths of all strokes."""
        return replace(self, by_stage={path: freedom.longer(factor) for path, freedom in self.by_stage.items()})


NONE = Freedoms({})


def freedoms(stages: Sequence[RobotStage], bodies: Iterable[Body]) -> Freedoms:
    """The permitted changes of the motion of a task's stages; `bodies` are the bodies among the task's arguments.

    Nothing may be changed if a stage of the task adds geometry or sets its own times.
    """
    if any(isinstance(stage, (AddGeometry, Pad, Reparameterise)) for stage in stages):
        return NONE
    known = tuple(bodies)
    found = {stage.path: _freedom(stage, known) for stage in stages}
    mergers = tuple(stage.path for stage in stages if isinstance(stage, Merger))
    anywhere = bool(stages) and not mergers and isinstance(stages[-1], SampleConfiguration)
    return Freedoms(found, anywhere, mergers)


def _freedom(stage: RobotStage, bodies: Sequence[Body]) -> Freedom:
    if isinstance(stage, Connect | MoveTo):
        return WAY
    if not isinstance(stage, MoveRelative):
        return FIXED
    if stage.properties.has("direction") and stage.properties.reads_interface("direction"):
        return _bounded(stage, _least(bodies, stage.properties.interface_name("direction")))
    given = stage.known("direction")
    if given is None or isinstance(given, Mapping) and not ("along" in given or "against" in given):
        return FIXED
    direction = direction_of(given, None)
    return FIXED if direction is None else _bounded(stage, direction.stroke.minimum)


def _bounded(stage: RobotStage, least: float) -> Freedom:
    own = stage.known("min_distance")
    return Freedom("stroke", least if own is None else float(own))


def _least(bodies: Sequence[Body], name: str | None) -> float:
    """The greatest least length [m] of the strokes of a name in any family of the bodies: which was used is not recorded.

    A name that no family gives may be any of them.
    """
    grasps = [family for body in bodies for family in body.grasps.values()]
    approaches, lifts = [family.approach for family in grasps], [family.lift or LIFT for family in grasps]
    retreats = [family.retreat for body in bodies for family in body.placements.values()]
    strokes: dict[str, Sequence[Stroke | None]] = {
        "approach": approaches,
        "lift": lifts,
        "lower": lifts,
        "retreat": [*approaches, *retreats],
    }
    chosen = [stroke for stroke in strokes.get(name or "", ()) if stroke is not None]
    if not chosen:
        chosen = [stroke for stroke in (LIFT, *approaches, *lifts, *retreats) if stroke is not None]
    return max(stroke.minimum for stroke in chosen)
