"""The least distances along a plan: where branches meet, the greatest of theirs is what still decides something."""

import numpy as np

from kabo.planner.certify.least_so_far import LeastSoFar

NEAR = 0.01


def test_where_branches_meet_the_greatest_least_distance_counts():
    least = LeastSoFar(["cup", "can"], NEAR)
    assert (least.scope("cup"), least.scope("can"), least.scope("robot.hand")) == (1, 2, 0)
    for node, caps, after in [
        ("n0", [0.004, 0.008, NEAR], ["n1", "n2"]),
        ("n1", [0.002, 0.005, 0.003], ["n3"]),
        ("n2", [0.006, NEAR, 0.004], ["n3"]),
    ]:
        least.enter(node)
        least.note(np.array(caps))
        least.leave(node, after)
    least.enter("n3")
    assert least.caps.tolist() == [NEAR, 0.008, 0.004]
