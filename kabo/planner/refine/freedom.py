"""The parts of a task's motion that refinement may change without changing the task.

The path of a free motion between two configurations may be replaced by any other free path. A stroke (a straight
approach or retreat) may be shortened to the least length that its family requires. All other motion stays as its
stage made it.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

from kabo.language.scene_description import Stroke
from kabo.scene import Body
from kabo.tasks.robots.declaring import RobotStage
from kabo.tasks.robots.motion.directions import direction_of
from kabo.tasks.robots.stages.connecting import Connect
from kabo.tasks.robots.stages.geometry import AddGeometry, Pad
from kabo.tasks.robots.stages.grasps import LIFT
from kabo.tasks.robots.stages.moves import MoveTo
from kabo.tasks.robots.stages.reparameterising import Reparameterise
from kabo.tasks.robots.stages.states import SampleConfiguration
from kabo.tasks.robots.stages.strokes import MoveRelative


@dataclass(frozen=True)
class Freedom:
    """The permitted change of one stage's motion; `least` [m] is the least length to which a stroke may be cut."""

    kind: Literal["way", "stroke", "fixed"]
    least: float = 0.0


FIXED, WAY = Freedom("fixed"), Freedom("way")


@dataclass(frozen=True)
class Freedoms:
    """The permitted changes of the motions of a call's stages, by the path of each stage in the task.

    `anywhere`: whether the robot may end the task in another configuration.
    """

    by_stage: Mapping[str, Freedom]
    anywhere: bool = False

    def of(self, stage: str | None) -> Freedom:
        """The permitted changes of a stage's motion; unknown stages permit none."""
        return FIXED if stage is None else self.by_stage.get(stage, FIXED)


NONE = Freedoms({})


def freedoms(stages: Sequence[RobotStage], bodies: Iterable[Body]) -> Freedoms:
    """The permitted changes of the motion of a task's stages; `bodies` are the bodies among the task's arguments.

    Nothing may be changed if a stage of the task adds geometry or sets its own times.
    """
    if any(isinstance(stage, (AddGeometry, Pad, Reparameterise)) for stage in stages):
        return NONE
    least = _least(bodies)
    found = {stage.path: _freedom(stage, least) for stage in stages}
    return Freedoms(found, bool(stages) and isinstance(stages[-1], SampleConfiguration))


def _freedom(stage: RobotStage, least: float) -> Freedom:
    if isinstance(stage, Connect | MoveTo):
        return WAY
    if not isinstance(stage, MoveRelative):
        return FIXED
    if stage.properties.has("direction") and stage.properties.reads_interface("direction"):
        return _bounded(stage, least)
    given = stage.known("direction")
    if given is None or isinstance(given, Mapping) and not ("along" in given or "against" in given):
        return FIXED
    direction = direction_of(given, None)
    return FIXED if direction is None else _bounded(stage, direction.stroke.minimum)


def _bounded(stage: RobotStage, least: float) -> Freedom:
    own = stage.known("min_distance")
    return Freedom("stroke", least if own is None else float(own))


def _least(bodies: Iterable[Body]) -> float:
    """The greatest least length [m] that any family of the bodies requires; which one was used is not recorded."""
    strokes: list[Stroke | None] = [LIFT]
    for body in bodies:
        strokes += [stroke for family in body.grasps.values() for stroke in (family.approach, family.lift)]
        strokes += [family.retreat for family in body.placements.values()]
    return max(stroke.minimum for stroke in strokes if stroke is not None)
