"""Motions that no robot can follow are not sent, verified or not."""

from dataclasses import replace

import numpy as np
import pytest

from kabo.errors import InputError
from kabo.execution import KinematicRobot, KnownTruth, execute
from kabo.execution.sendable import unsendable
from kabo.plan import Plan, Segment
from kabo.scene import Scene


def with_power(plan: Plan, node: str, number: int, piece: int | None, joint: int, power: int, by: float) -> Plan:
    """The plan with one coefficient of a piece increased, or with those of all pieces of a segment."""
    motion = list(plan.nodes[node].motion)
    given = motion[number].trajectory
    assert given is not None
    pieces = [[list(row) for row in rows] for rows in given.coefficients]
    for own in pieces if piece is None else [pieces[piece]]:
        own[joint] += [0.0] * (power + 1 - len(own[joint]))
        own[joint][power] += by
    changed = replace(given, coefficients=tuple(tuple(map(tuple, rows)) for rows in pieces))
    motion[number] = replace(motion[number], trajectory=changed)
    return replace(plan, nodes={**plan.nodes, node: replace(plan.nodes[node], motion=tuple(motion))})


def arm(plan: Plan, node: str) -> tuple[int, Segment]:
    return next((k, each) for k, each in enumerate(plan.nodes[node].motion) if len(each.joints) > 1)


def test_plans_as_they_are_can_be_sent(stacked_plan: Plan, stacked_scene: Scene) -> None:
    assert list(unsendable(stacked_plan, stacked_scene)) == []


def test_no_change_of_a_coefficient_goes_unseen(stacked_plan: Plan, stacked_scene: Scene) -> None:
    draws = np.random.default_rng(22)
    moving = [name for name, node in stacked_plan.nodes.items() if node.motion]
    for _ in range(200):
        node = moving[draws.integers(len(moving))]
        number = int(draws.integers(len(stacked_plan.nodes[node].motion)))
        given = stacked_plan.nodes[node].motion[number].trajectory
        assert given is not None
        piece, joint = int(draws.integers(len(given.coefficients))), int(draws.integers(len(given.joints)))
        power, size = int(draws.integers(4)), 10.0 ** draws.uniform(-5.0, draws.choice([2.0, 300.0]))
        by = size / float(np.diff(given.times)[piece]) ** power * draws.choice([-1.0, 1.0])
        found = list(unsendable(with_power(stacked_plan, node, number, piece, joint, power, by), stacked_scene))
        assert any(given.joints[joint] in each and each.startswith(f"{node}: ") for each in found), (node, found)


@pytest.mark.parametrize(
    ("piece", "power", "by", "said"),
    [
        (3, 0, 0.3, r"n0: segment 0: \w+ of mobile jumps by 0\.3 at 0\.\d+ s"),
        (3, 1, 1e-3, r"n0: segment 0: the velocity of \w+ of mobile jumps by 0\.001 at"),
        (None, 0, 1e-3, r"n0: segment 0: it begins with \w+ of mobile at .*, which is at .* before"),
        (None, 0, 9.0, r"n0: segment 0: \w+ of mobile goes from .* to .*, outside its limits"),
    ],
)
def test_the_joint_and_the_place_are_told_before_anything_moves(
    stacked_plan: Plan, stacked_scene: Scene, piece: int | None, power: int, by: float, said: str
) -> None:
    number, _ = arm(stacked_plan, "n0")
    plan, robot = with_power(stacked_plan, "n0", number, piece, 0, power, by), KinematicRobot(stacked_scene)
    with pytest.raises(InputError, match=said):
        execute(plan, stacked_scene, robot, KnownTruth(poses=robot.poses))
    assert robot.time == 0.0
