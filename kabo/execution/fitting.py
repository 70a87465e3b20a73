"""Whether a plan can be carried out in a scene at all: its names are those of the scene, its motions can be sent."""

from collections.abc import Collection, Iterable, Iterator

from kabo.errors import Diagnostic, InputError, did_you_mean
from kabo.execution.sendable import unsendable
from kabo.plan import Plan, StateChange, topological_order
from kabo.scene import Scene

Fault = tuple[str, str | None]  # what is wrong, and the remedy


def require_graph(plan: Plan) -> None:
    """Checks that a plan can be walked through.

    Raises:
        InputError: it leads to nodes that it does not have, or in a circle.
    """
    _refuse(_no_graph(plan))


def require_fit(plan: Plan, scene: Scene) -> None:
    """Checks the names of a plan and its trajectories.

    Raises:
        InputError: the plan names robots, joints, links or bodies that the scene does not have; its start leaves out one
            that the scene has; a segment has no trajectory; or joints would jump, or leave their limits.
    """
    _refuse(_Names(scene).faults(plan))
    for name, node in plan.nodes.items():
        if any(segment.trajectory is None for segment in node.motion):
            text = f"{name} has no trajectory, as in plans of the format kabo-plan/1"
            raise InputError([Diagnostic("plan", 1, 1, text, "plan it anew")])
    _refuse((text, "plan it anew") for text in unsendable(plan, scene))


def _refuse(faults: Iterable[Fault]) -> None:
    if wrong := dict.fromkeys(faults):
        raise InputError([Diagnostic("plan", 1, 1, text, hint) for text, hint in wrong])


def _no_graph(plan: Plan) -> Iterator[Fault]:
    """What keeps the plan from being walked through."""
    ends = [
        ("its root", plan.root),
        *((f"{name} leads to", to) for name, n in plan.nodes.items() for to in n.successors),
    ]
    lost = [(where, name) for where, name in ends if name not in plan.nodes]
    for where, name in lost:
        yield f'{where} "{name}", and there is no such node', did_you_mean(name, plan.nodes)
    if not lost and topological_order(plan) is None:
        yield "its nodes lead in a circle", "plan it anew"


class _Names:
    """The names of a scene."""

    def __init__(self, scene: Scene) -> None:
        self.joints = {name: robot.joint_names for name, robot in scene.robots.items()}
        self.bodies = tuple(scene.movable)
        links = (f"{name}.{link}" for name, robot in scene.robots.items() for link in robot.links)
        self.parents = ("world", *scene.bodies, *links)

    def faults(self, plan: Plan) -> Iterator[Fault]:
        """What is wrong with the names in a plan, and the remedy."""
        for change in (plan.start, *(node.after for node in plan.nodes.values())):
            if change is not None:
                for robot, joints in change.robots.items():
                    yield from self._moved(robot, tuple(joints))
                yield from _missing("body", change.objects, self.bodies)
                yield from _missing("body or link", (own.parent for own in change.objects.values()), self.parents)
        for segment in (segment for node in plan.nodes.values() for segment in node.motion):
            yield from self._moved(segment.robot, segment.joints)
            yield from _missing("body", (*segment.detach, *(body for body, _ in segment.attach)), self.bodies)
            yield from _missing("body or link", (to for _, to in segment.attach), self.parents)
        if plan.start is not None:
            yield from self._left_out(plan.start)

    def _moved(self, robot: str, joints: tuple[str, ...]) -> Iterator[Fault]:
        yield from _missing("robot", (robot,), tuple(self.joints))
        yield from _missing(f"joint of {robot}", joints, self.joints.get(robot, joints))

    def _left_out(self, start: StateChange) -> Iterator[Fault]:
        """What the start does not say: where all of the scene is."""
        said = {(robot, joint) for robot, joints in start.robots.items() for joint in joints}
        lacks = [
            f"{joint} of {robot}"
            for robot, joints in self.joints.items()
            for joint in joints
            if (robot, joint) not in said
        ]
        robots = [robot for robot in self.joints if robot not in start.robots]
        lacks = [*robots, *(each for each in lacks if each.rpartition(" ")[2] not in robots)]
        for name in (*lacks, *(body for body in self.bodies if body not in start.objects)):
            yield f"its start does not say where {name} is", "plan it anew"


def _missing(kind: str, names: Iterable[str], known: Collection[str]) -> Iterator[Fault]:
    for name in names:
        if name not in known:
            yield f'the scene has no {kind} "{name}": the plan is of another one', did_you_mean(name, known)
