"""A plan with one of everything that exports must tell: two robots, hands, an early beginning, branches that meet."""

from pathlib import Path

import numpy as np
import pytest

from kabo.motion import Trajectory
from kabo.plan import Node, Plan, Segment, ValueOf

DOMAINS = Path(__file__).parents[2] / "domains"
SMALL = ("asking_bartender/n3.yaml", "doors/n3.yaml", "safes/n3.yaml", "unix/n1.yaml")
ARM, HAND = ("a_1", "a_2"), ("finger",)
UR = tuple(
    f"left_{name}_joint" for name in ("shoulder_pan", "shoulder_lift", "elbow", "wrist_1", "wrist_2", "wrist_3")
)


def rest_to_rest(joints: tuple[str, ...], first: float, last: float, begin: float, end: float) -> Trajectory:
    """All joints from a value to another, by the polynomial of degree five that rests at both ends."""
    way, time = last - first, end - begin
    own = (first, 0.0, 0.0, 10.0 * way / time**3, -15.0 * way / time**4, 6.0 * way / time**5)
    rows = ((first,) * len(joints), (last,) * len(joints))
    return Trajectory(joints, rows, (begin, end), ((own,) * len(joints),))


def segment(robot: str, trajectory: Trajectory, **more: object) -> Segment:
    """A segment of a trajectory."""
    times = (trajectory.times[0], trajectory.times[-1])
    return Segment(robot, trajectory.joints, trajectory.waypoints, times, "move", trajectory=trajectory, **more)  # type: ignore[arg-type]


def made(arm: tuple[str, ...], overlap: float = 0.5) -> Plan:
    """The plan, for an arm with these joints; the other arm begins so many seconds early."""
    whole = rest_to_rest(arm, 0.0, 1.0, 0.0, 2.0)
    first, second = whole.split(0.75)  # the arm passes from one segment to the next
    grasp = segment("left", rest_to_rest(HAND, 0.04, 0.01, 2.0, 2.5), attach=(("cup", "left.hand"),))
    back = segment("left", rest_to_rest(arm, 1.0, -0.5, 0.0, 1.0))
    opens = segment("left", rest_to_rest(HAND, 0.01, 0.04, 1.0, 1.5), detach=("cup",))
    other = segment("right", rest_to_rest(("b_1",), 0.2, 0.4, 0.0, 1.0))
    nodes = {
        "n0": Node(
            "action", "pick", {"o": 'a "cup"', "r": "left"}, next="n1",
            motion=(segment("left", first), segment("left", second), grasp),
        ),
        "n1": Node("sense", "look", {"o": "cup"}, on="full(cup)", branches={"true": "n2", "false": "n3"}),
        "n2": Node("action", "pour", {"v": ValueOf("volume(cup)"), "n": 2.0}, next="n3"),
        "n3": Node("action", "put", {"r": "left"}, next="n4", motion=(back, opens)),
        "n4": Node("action", "wave", {"r": "right"}, next="n5", motion=(other,), overlap=overlap),
        "n5": Node("goal"),
    }  # fmt: skip
    options = {"search": "greedy", "seed": 0, "epsilon": 0.01, "geometry": "bounding"}
    return Plan("one <of> everything -- really", {}, options, "n0", nodes)


@pytest.fixture
def moving() -> Plan:
    return made(ARM)


@pytest.fixture
def with_ur() -> Plan:
    return made(UR, overlap=0.0)


def close(first: object, second: object) -> bool:
    """Whether two arrays agree to nine decimals."""
    return bool(np.allclose(np.asarray(first, float), np.asarray(second, float), atol=2e-9))
