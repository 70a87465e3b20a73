"""Predicates by the names of a scene."""

from collections.abc import Callable

import numpy as np
import pytest
import trimesh

from kabo.geometry_server import GeometryServer, Situation, Success
from kabo.language.formulas import GroundCall
from kabo.scene import GeometricState, link_poses
from kabo.tasks.procedures import GeometricProcedures

Servers = Callable[..., GeometryServer]
BARTENDER, FORCE = "bartender/four_bottles.yaml", "force_sensing/n2.yaml"


def moved(state: GeometricState, name: str, shift: tuple[float, float, float]) -> GeometricState:
    """The state with an object elsewhere."""
    from dataclasses import replace

    held = state.objects[name]
    position = tuple(float(p + s) for p, s in zip(held.position, shift, strict=True))
    return GeometricState(state.robots, {**state.objects, name: replace(held, position=position)})


@pytest.mark.parametrize("exact", [False, True])
def test_bodies_collide_where_they_meet(server: Servers, exact: bool) -> None:
    asked = server(BARTENDER, exact=exact)
    start = asked.scene.start
    first, second = start.objects["bottle_1"], start.objects["bottle_2"]
    assert not asked.collides("bottle_1", "bottle_2")
    onto = tuple(b - a + d for a, b, d in zip(first.position, second.position, (0.0, 0.0, 0.01), strict=True))
    assert asked.collides("bottle_1", "bottle_2", moved(start, "bottle_1", onto))
    assert asked.collides("left.link_1", "left.link_2"), "neighbours touch; what is allowed is not asked for"
    assert not asked.collides("left.link_6", "right.link_6")


@pytest.mark.parametrize("exact", [False, True])
def test_a_thing_is_included_in_a_region_or_a_body(server: Servers, exact: bool) -> None:
    asked = server(BARTENDER, exact=exact)
    assert not asked.includes("table", "bottle_1"), "it stands on it, not in it"
    assert not asked.includes("dishwasher", "bottle_1")
    assert asked.includes("anywhere", "bottle_1")


def test_distances_of_things_have_both_bounds(server: Servers) -> None:
    asked = server(BARTENDER).predicates()
    found = asked.distance("bottle_1", "bottle_2")
    assert 0 < found.lower < found.upper < found.lower + 2.1 * asked.surroundings.budget.geometry
    start = asked.state
    deep = server(BARTENDER).predicates(moved(start, "bottle_1", _onto(start))).distance("bottle_1", "bottle_2")
    assert deep.lower < -0.02
    assert deep.lower <= deep.upper


def _onto(state: GeometricState) -> tuple[float, float, float]:
    first, second = state.objects["bottle_1"].position, state.objects["bottle_2"].position
    return tuple(b - a for a, b in zip(first, second, strict=True))  # type: ignore[return-value]


def test_the_swept_volume_of_an_arm_holds_what_it_carries(server: Servers) -> None:
    asked = server(BARTENDER)
    home = asked.scene.start.robots["right"]
    away = (home[0] + 0.4, *home[1:])
    empty = asked.predicates().motion("right", [home, away])
    volume = asked.predicates().swept_volume(empty, 0.02)
    mesh = trimesh.Trimesh(*volume.mesh(), process=False)
    assert mesh.is_watertight
    assert volume.deviation <= 0.02 + asked.budget.geometry
    procedures = GeometricProcedures(asked)
    pick = procedures.call(GroundCall("pick", ("right", "bottle_4"), ()), Situation.of(asked.scene.start))
    assert isinstance(pick, Success)
    holding = Situation.of(asked.scene.start).replace(pick.changes).first
    full = asked.predicates(holding).motion("right", [home, away])
    assert len(full.bodies) == len(empty.bodies) + 1


@pytest.mark.parametrize("exact", [False, True])
def test_motions_of_two_arms_meet_or_not(server: Servers, exact: bool) -> None:
    asked = server(BARTENDER, exact=exact)
    here = asked.predicates()
    left, right = (asked.scene.start.robots[name] for name in ("left", "right"))
    still = here.motion("left", [left])
    assert here.sweeps(still, here.motion("left", [left])), "an arm meets itself"
    assert not here.sweeps(still, here.motion("right", [right]))
    assert not here.sweeps(still, "bottle_4")
    down = (right[0], right[1] + 1.2, *right[2:])
    assert here.sweeps(here.motion("right", [right, down]), "table")
    assert not here.sweeps(here.motion("right", [right, (right[0] + 0.2, *right[1:])]), "bottle_1")


def test_predicates_are_one_sided_at_the_start(server: Servers) -> None:
    asked = server(BARTENDER)
    home = asked.scene.start.robots["left"]
    assert not asked.collides("left", home)
    robot = asked.scene.robots["left"]
    drawn = np.random.default_rng(0).uniform(robot.tree.lower, robot.tree.upper, (400, robot.tree.size))
    below = [q for q in drawn if link_poses(robot, q)["tool0"][2, 3] < -0.06 and asked.collides("left", q)]
    missed = [
        q for q in drawn if _in_the_table(link_poses(robot, q)["tool0"][:3, 3]) and not asked.collides("left", q)
    ]
    assert below
    assert not missed
    assert asked.sweep_collides("left", home, below[0])
    found = asked.sample(asked.scene.bodies["bottle_4"].grasps["side"].constraints, "right", "bottle_4", batches=2)
    assert len(found) > 5


def _in_the_table(point: np.ndarray) -> bool:
    """Whether the middle of the tool's flange lies within the table top."""
    return bool(abs(point[2] + 0.02) < 0.02 and abs(point[0] - 0.025) < 0.4 and abs(point[1]) < 0.9)
