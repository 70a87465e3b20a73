"""The turn that a family leaves open is found, and grasps are spread along it."""

from collections.abc import Callable

import numpy as np
import pytest

from kabo.geometry_server import GeometryServer, grasp_stream
from kabo.geometry_server.frames import Frame
from kabo.geometry_server.open_turns import open_turn
from kabo.kinematics import FrameFeature, rows_of, stacked, values
from kabo.kinematics.kernels import rows as columns
from kabo.scene import world_T

Servers = Callable[..., GeometryServer]
TOOL = Frame(4, np.eye(4), {})
TIP = FrameFeature(4, "point", (0.0, 0.0, 0.0))
DOWN, SIDE = (FrameFeature(4, "line", (0.0, 0.0, 0.0), d) for d in ((0.0, 0.0, 1.0), (0.0, 1.0, 0.0)))
LEAN = (0.6, 0.0, 0.8)
AXIS, FOOT = (FrameFeature(0, kind, (0.4, 0.2, 0.1), LEAN) for kind in ("line", "plane"))
ALONG = FrameFeature(0, "line", (0.4, 0.2, 0.1), (0.0, 1.0, 0.0))
FROM_ABOVE = [
    rows_of("opposed", DOWN, AXIS),
    rows_of("coincident", TIP, AXIS),
    rows_of("height", TIP, FOOT, 0.1, 0.2),
]
FROM_ASIDE = [rows_of("perpendicular", DOWN, AXIS), rows_of("perpendicular", SIDE, AXIS), *FROM_ABOVE[1:]]


@pytest.mark.parametrize(("parts", "across"), [(FROM_ABOVE, (0, 1)), (FROM_ASIDE, (1, 2))])
def test_a_turn_about_the_object_is_found_whatever_way_it_leans(
    parts: list[np.ndarray], across: tuple[int]
) -> None:
    row = open_turn(stacked(parts), TOOL)
    assert row is not None
    assert (row[0, columns.KIND], row[0, columns.FIRST], row[0, columns.SECOND]) == (columns.AZIMUTH, 4, 0)
    assert np.allclose(np.abs(row[0, 12:15]), LEAN)
    assert int(np.argmax(np.abs(row[0, 5:8]))) in across


@pytest.mark.parametrize("parts", [[*FROM_ABOVE, rows_of("perpendicular", SIDE, ALONG)], []])
def test_nothing_is_found_where_nothing_is_left_open_or_nothing_is_said(parts: list[np.ndarray]) -> None:
    assert open_turn(stacked(parts), TOOL) is None


def test_rows_that_nothing_fulfils_and_rows_about_other_joints_leave_nothing() -> None:
    contrary = [rows_of("height", TIP, FOOT, h, h) for h in (0.1, 0.4)]
    assert open_turn(stacked([*FROM_ABOVE[:2], *contrary]), TOOL) is None
    elbow = rows_of("height", FrameFeature(2, "point", (0.0, 0.0, 0.0)), FOOT, 0.1)
    assert open_turn(stacked([*FROM_ABOVE, elbow]), TOOL) is None


def test_grasps_of_a_bottle_come_from_all_sides(server: Servers) -> None:
    """Every tenth of the angles that the arm reaches at all is met in few batches, and none of them dominates."""
    asked = server("bartender/four_bottles.yaml")
    robot, body = asked.scene.robots["right"], asked.scene.bodies["bottle_4"]
    hand = tuple(asked.scene.start.robots["right"][robot.planned :])
    pose = world_T(asked.scene, asked.scene.start, "bottle_4")
    made = grasp_stream(robot, body, body.grasps["side"], pose, hand, 0)
    assert made is not None
    assert made.turn is not None
    counts = {}
    for name, along in (("plain", None), ("even", made.turn)):
        found = [c.q for number in range(8) for c in made.stream.batch(number, along=along)]
        angles = [values(made.turn, q, robot.tree)[0] for q in found]
        counts[name] = np.histogram(angles, 10, (-np.pi, np.pi))[0]
    reached = counts["plain"] + counts["even"] > 0
    assert np.all(counts["even"][reached] > 0)
    deviation = {name: float(np.std(found[reached]) / np.mean(found[reached])) for name, found in counts.items()}
    assert deviation["even"] < deviation["plain"]
