"""Connect: a collision-free path between two scenes that differ only in the configuration of one arm [T 3.2]."""

from collections.abc import Iterator, Mapping

import numpy as np

from kabo.geometry_server import Refusal, Situation
from kabo.scene import Scene
from kabo.tasks.core import Connector, Result
from kabo.tasks.core.model.results import Answers, StructuralReason
from kabo.tasks.core.model.stages import Values
from kabo.tasks.robots.declaring import ATTEMPT_TIMEOUT, KEEP, PLANNER, ROBOT, RobotStage, keep_faults
from kabo.tasks.robots.motion.paths import length
from kabo.tasks.robots.motion.planners import planned_way
from kabo.tasks.robots.scenes import TaskScene

JOINT_TOLERANCE = 1e-6  # rad or m: joints that differ by less have not moved


class Connect(RobotStage, Connector):
    """A collision-free path of the robot's arm from one scene to the other, by one planner or the first that finds one.

    The scenes must agree in everything else: objects and their attachments, joints that the arm does not have, permitted
    contacts, added geometry. Pairs that do not agree are counted by what differs.
    """

    MOVES = ("robot",)
    PROPERTIES = {"robot": ROBOT, "keep": KEEP, "planner": PLANNER, "attempt_timeout": ATTEMPT_TIMEOUT}

    def mismatch(self, start: TaskScene, end: TaskScene, properties: Values) -> str | None:
        """The first difference between the scenes besides the arm's configuration; None if there is none."""
        if start.situation is end.situation and start.permitted == end.permitted and start.extras == end.extras:
            return None
        return (
            _objects(start, end)
            or _joints(start, end, properties["robot"])
            or _contacts(start, end)
            or _extras(start, end)
        )

    def connect(self, start: TaskScene, end: TaskScene, properties: Values, seed: int) -> Answers:
        """The path, or a failure if none is found with the number of samples that the context permits."""
        name = properties["robot"]
        goal = end.configuration(name)
        goal[start.robot(name).planned :] = start.configuration(name)[start.robot(name).planned :]
        if np.array_equal(goal, start.configuration(name)):
            return [Result(motion=())]
        found = planned_way(
            start, name, goal, self.name, properties["keep"], properties["planner"], properties["attempt_timeout"]
        )
        return [found] if isinstance(found, Refusal) else [Result(motion=(found,), cost=length((found,)))]

    def faults(self, scene: Scene, start: Situation | None = None) -> Iterator[str]:
        """Messages for a property `keep` that applies to nothing the robot can hold."""
        yield from keep_faults(self, start)

    def reads(self) -> tuple[str, ...]:
        """The held object that the property `keep` names, as a tuple; empty if it names none."""
        keep = self.known("keep")
        return (str(keep["object"]),) if isinstance(keep, Mapping) and isinstance(keep.get("object"), str) else ()


def _objects(start: TaskScene, end: TaskScene) -> str | None:
    first, second = start.situation.objects, end.situation.objects
    if first is second or first == second:
        return None
    for name, values in first.items():
        other = second.get(name)
        if other is None:
            return f"{name} is missing"
        if other == values:
            continue
        before, after = values[0].parent, other[0].parent
        if before != after:
            return f"{name} hangs on {before}, then on {after}"
        return f"{name} is held another way" if "." in before else f"{name} stands elsewhere"
    return next((f"{name} is new" for name in second if name not in first), None)


def _joints(start: TaskScene, end: TaskScene, moving: str) -> str | None:
    for name, values in start.situation.robots.items():
        others = end.situation.robots[name]
        if values == others:
            continue
        robot = start.robot(name)
        first = robot.planned if name == moving else 0
        for q, p in zip(values, others, strict=False):
            for i in range(first, len(q)):
                if abs(q[i] - p[i]) > JOINT_TOLERANCE:
                    return f"{name}: {robot.joint_names[i]} differs"
        if len(values) != len(others):
            return f"{name} differs"
    return None


def _contacts(start: TaskScene, end: TaskScene) -> str | None:
    # What the scene permits always is permitted on both sides, whoever permits it once more.
    differing = (start.permitted ^ end.permitted) - start.context.scene.allowed
    if not differing:
        return None
    first = min(tuple(sorted(pair)) for pair in differing)
    begins = frozenset(first) in start.permitted
    where = "begins: ForbidContact is missing before it" if begins else "ends: AllowContact is missing after it"
    return StructuralReason(f"contact of {' and '.join(first)} is permitted only where it {where}")


def _extras(start: TaskScene, end: TaskScene) -> str | None:
    differing = {e.name for e in set(start.extras) ^ set(end.extras)}
    if not differing:
        return None
    side = "begins" if any(e.name == min(differing) for e in start.extras) else "ends"
    return StructuralReason(f"{min(differing)} is there only where it {side}")
