"""How a target is out of a robot's reach: the joint limit that keeps it, and where the robot's base would do."""

from kabo.geometry_server.candidates import Stream
from kabo.geometry_server.foresight.joints import limiting_joint
from kabo.geometry_server.foresight.measures import Measure, millimetres
from kabo.geometry_server.shortfall import shortfall_of
from kabo.geometry_server.surroundings import SceneSurroundings
from kabo.scene import Robot, link_poses


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
    at = _base_at(robot)
    stands = tuple(round(a + b, 3) + 0.0 for a, b in zip(at, short.by, strict=True))
    said = (
        f"{what} is out of reach of {robot.name} by {millimetres(short.metres)}: its base would do at "
        f"({stands[0]:g}, {stands[1]:g}, {stands[2]:g}), and is at ({at[0]:g}, {at[1]:g}, {at[2]:g})"
    )
    return Measure(f"base of {robot.name}", said, 0.0, short.metres)


def _base_at(robot: Robot) -> tuple[float, ...]:
    """The position of a robot's root link in the world, to the millimetre [m]."""
    poses = link_poses(robot, (0.0,) * len(robot.joint_names))
    root = next((name for name in robot.links if robot.stands(name)), None)
    pose = None if root is None else poses[root]
    return (0.0, 0.0, 0.0) if pose is None else tuple(round(float(v), 3) + 0.0 for v in pose[:3, 3])
