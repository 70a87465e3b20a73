"""How a target is out of a robot's reach: the joint limit that keeps it, and where the robot's base would do."""

from collections.abc import Sequence

from kabo.geometry_server.candidates import Stream
from kabo.geometry_server.foresight.joints import limiting_joint
from kabo.geometry_server.foresight.measures import Measure, millimetres
from kabo.geometry_server.shortfall import Shortfall, shortfall_of
from kabo.geometry_server.surroundings import SceneSurroundings
from kabo.scene import Robot, link_poses

CLEARLY = {"m": 2e-3, "rad": 1e-2}  # beyond a limit: estimates are rarely off by more than half of it


def reach_measures(surroundings: SceneSurroundings, stream: Stream, what: str) -> tuple[Measure, ...]:
    """What keeps a stream of candidates empty, in numbers; nothing if it is not empty. Kept by the stream's key.

    The joint comes first whose limit alone keeps it empty; then the least level move of the base that would do.

    Args:
        surroundings: the scene's surroundings, which keep the answer.
        stream: the candidates that were sampled in vain.
        what: what is to be reached, for users.
    """
    found: tuple[Measure, ...] = surroundings.remembered(
        ("reach", stream.robot.name, what, int(stream.key)), lambda: _measures(stream, what)
    )
    return found


def beyond_reach(surroundings: SceneSurroundings, stream: Stream, what: str) -> bool:
    """Whether a stream without a candidate misses every limit by more than what such estimates are wrong by.

    It proves nothing, but with thousands of samples without a candidate it is a reason to draw no more.
    """
    if stream.robot.drive is not None:
        key = "growth", stream.robot.name, int(stream.key)
        found: tuple[Shortfall | None] = surroundings.remembered(key, lambda: (shortfall_of(stream),))
        return found[0] is not None and found[0].metres > CLEARLY["m"]
    missed = reach_measures(surroundings, stream, what)
    return bool(missed) and all(each.missing > CLEARLY[each.unit] for each in missed)


def _measures(stream: Stream, what: str) -> tuple[Measure, ...]:
    if stream.robot.drive is not None:  # its joints and its floor are freed together, and neither alone says much
        return ()
    joint, base = limiting_joint(stream), base_measure(stream, what)
    return tuple(each for each in (joint, base) if each is not None)


def base_measure(stream: Stream, what: str) -> Measure | None:
    """How far the base would have to move at its height, and where it would stand; None if nothing is missing or found."""
    short = shortfall_of(stream, level=True) or shortfall_of(stream)
    if short is None or short.metres == 0.0:
        return None
    robot = stream.robot
    said = (
        f"{what} is out of reach of {robot.name} by {millimetres(short.metres)}: "
        f"its base would do at {_stands(robot, short.by)}"
    )
    return Measure(f"base of {robot.name}", said, 0.0, short.metres)


def moved_base(robot: Robot, metres: float, by: Sequence[float]) -> Measure:
    """The same for a displacement that is known already."""
    said = f"the base of {robot.name} would do {millimetres(metres)} away, at {_stands(robot, by)}"
    return Measure(f"base of {robot.name}", said, 0.0, metres)


def _stands(robot: Robot, by: Sequence[float]) -> str:
    """Where a robot's base would stand if it were displaced, and where it stands."""
    at = _base_at(robot)
    there = tuple(round(a + b, 3) + 0.0 for a, b in zip(at, by, strict=True))
    return f"({there[0]:g}, {there[1]:g}, {there[2]:g}), and is at ({at[0]:g}, {at[1]:g}, {at[2]:g})"


def _base_at(robot: Robot) -> tuple[float, ...]:
    """The position of a robot's root link in the world, to the millimetre [m]."""
    poses = link_poses(robot, (0.0,) * len(robot.joint_names))
    root = next((name for name in robot.links if robot.stands(name)), None)
    pose = None if root is None else poses[root]
    return (0.0, 0.0, 0.0) if pose is None else tuple(round(float(v), 3) + 0.0 for v in pose[:3, 3])
