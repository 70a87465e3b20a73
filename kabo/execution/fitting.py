"""Whether a plan can be carried out in a scene at all: its names are those of the scene, its motions can be sent."""

from collections.abc import Iterable, Iterator, Mapping

from kabo.errors import Diagnostic, InputError, did_you_mean
from kabo.plan import Plan
from kabo.scene import Scene


def require_fit(plan: Plan, scene: Scene) -> None:
    """Checks the names of a plan and its trajectories.

    Raises:
        InputError: the plan names robots, joints or bodies that the scene does not have, or a segment has no trajectory.
    """
    robots = {name: robot.joint_names for name, robot in scene.robots.items()}
    wrong = dict.fromkeys(_unknown(plan, robots, tuple(scene.movable)))
    if wrong:
        raise InputError([Diagnostic("plan", 1, 1, text, hint) for text, hint in wrong])
    for name, node in plan.nodes.items():
        if any(segment.trajectory is None for segment in node.motion):
            text = f"{name} has no trajectory, as in plans of the format kabo-plan/1"
            raise InputError([Diagnostic("plan", 1, 1, text, "plan it anew")])


def _unknown(
    plan: Plan, robots: Mapping[str, tuple[str, ...]], bodies: tuple[str, ...]
) -> Iterator[tuple[str, str | None]]:
    """What is wrong with names, and the remedy."""
    moved: list[tuple[str, tuple[str, ...]]] = []
    for change in (plan.start, *(node.after for node in plan.nodes.values())):
        if change is not None:
            moved += [(robot, tuple(joints)) for robot, joints in change.robots.items()]
            yield from _missing("body", change.objects, bodies)
    moved += [(segment.robot, segment.joints) for node in plan.nodes.values() for segment in node.motion]
    for robot, joints in moved:
        yield from _missing("robot", (robot,), tuple(robots))
        yield from _missing(f"joint of {robot}", joints, robots.get(robot, joints))


def _missing(kind: str, names: Iterable[str], known: tuple[str, ...]) -> Iterator[tuple[str, str | None]]:
    for name in names:
        if name not in known:
            yield f'the scene has no {kind} "{name}": the plan is of another one', did_you_mean(name, known)
