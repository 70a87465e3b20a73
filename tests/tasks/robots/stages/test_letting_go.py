"""Room to let go: asked where something is put, it is what `release` finds afterwards, beside any neighbour."""

from collections.abc import Callable
from functools import lru_cache

import numpy as np
import pytest

from kabo.geometry_server import Refusal
from kabo.scene import attachment
from kabo.tasks.robots import TaskScene
from kabo.tasks.robots.stages.letting_go import letting_go
from tests.tasks.robots.conftest import first
from tests.tasks.robots.test_library import end, solve, task

FORCE = "force_sensing/n2.yaml"
ROBOT = {"robot": "arm", "object": "cup_1"}
First = Callable[..., TaskScene]


@lru_cache(maxsize=1)
def put() -> TaskScene:
    """The scene in which cup_1 stands in the target, still held, with nothing around it."""
    start = first(FORCE)
    held = end(solve(start, "pick", **ROBOT)[0])
    return end(solve(held, "transfer", **ROBOT, region="target")[0])


def beside(scene: TaskScene, away: float, turn: float) -> TaskScene:
    """The scene with cup_2 so far from cup_1, in a direction that is measured from where the hand opens."""
    link = scene.context.surroundings.links("arm", scene.situation.robots["arm"][0])["left_finger"]
    pose, across = scene.pose("cup_1").copy(), np.arctan2(*link[1::-1, 1]) + turn
    pose[:2, 3] += away * np.array([np.cos(across), np.sin(across)])
    return scene.placing("cup_2", attachment("world", pose))


@pytest.mark.parametrize("turn", [0.0, 0.5 * np.pi])
def test_there_is_room_to_let_go_exactly_where_release_succeeds(turn: float) -> None:
    answers = []
    for away in np.arange(0.08, 0.16, 0.01):
        scene = beside(put(), away, turn)
        if scene.permitting([("cup_1", "target_table")]).hit("arm") is not None:
            continue  # nobody would have put it there
        room = letting_go(scene.permitting([("cup_1", "target_table")]), "cup_1", "arm")
        assert (room is None) == bool(task("release", **ROBOT, region="target").plan(scene))
        answers.append(room)
    blocked = [each for each in answers if each is not None]
    assert answers[-1] is None, "far away there is room"
    for each in blocked:
        assert isinstance(each, Refusal)
        assert any("cup_2" in pair for pair, _ in each.pairs)
    assert bool(blocked) == (turn == 0.0), "only where it opens is there less room for the hand than for the cup"


def test_whatever_is_transferred_beside_a_neighbour_can_be_let_go() -> None:
    start = first(FORCE)
    middle = start.context.scene.regions["target"].world_T_region.copy()
    middle[2, 3] = 0.4
    held = end(solve(start.placing("cup_2", attachment("world", middle)), "pick", **ROBOT)[0])
    for solution in solve(held, "transfer", 4, **ROBOT, region="target"):
        assert task("release", **ROBOT, region="target").plan(end(solution))


def test_who_holds_nothing_lets_nothing_go() -> None:
    refused = letting_go(first(FORCE), "cup_1", "arm")
    assert isinstance(refused, Refusal)
    assert refused.proof
