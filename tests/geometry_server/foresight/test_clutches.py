"""What was shifted in a hand so far that the open fingers meet it cannot be let go of, and the reason says so."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import kabo
from kabo.geometry_server import GeometryServer, start_faults
from kabo.geometry_server.surroundings import MAX_REMEMBERED
from kabo.plan import Plan, State
from kabo.scene import Scene, beginning_at
from tests.support.giving_gantries import giving_gantries

Case = tuple[kabo.Problem, Scene, Plan]


@pytest.fixture(scope="module")
def giving(tmp_path_factory: pytest.TempPathFactory) -> Case:
    folder: Path = tmp_path_factory.mktemp("giving")
    problem = giving_gantries(folder)
    plan = kabo.solve(problem).plan
    assert plan is not None and problem.scene is not None
    return problem, kabo.load_scene(problem.scene), plan


def shifted(case: Case, across: float) -> State:
    """The state after the rod was taken, shifted in the hand in the direction in which it closes [m]."""
    state = kabo.after(case[0], case[2], [("n0", None)])
    assert state.geometry is not None
    own = state.geometry.objects["rod"]
    x, y, z = np.add(own.position, (across, 0.0, 0.0)).tolist()
    objects = {**state.geometry.objects, "rod": replace(own, position=(x, y, z))}
    return replace(state, geometry=replace(state.geometry, objects=objects))


@pytest.mark.parametrize(("across", "told"), [(0.0, False), (0.014, False), (0.016, True), (-0.02, True)])
def test_a_hand_that_meets_what_it_holds_when_it_is_open_is_told(giving: Case, across: float, told: bool) -> None:
    """The rod is 40 mm wide, and open fingers are 70 mm apart."""
    state = shifted(giving, across)
    assert state.geometry is not None
    server = GeometryServer(beginning_at(giving[1], state.geometry))
    found = [fault for fault in start_faults(server.surroundings, parts=False) if fault.kind == "clutched"]
    assert bool(found) == told
    if told:
        assert found[0].metres == pytest.approx(abs(across) - 0.015, abs=1e-5)
        assert found[0].things == ("rod", "gantry.left" if across > 0.0 else "gantry.right")


def test_when_time_is_up_the_reason_begins_with_what_is_wrong_in_the_hand(giving: Case) -> None:
    result = kabo.solve(giving[0], start=shifted(giving, 0.016), memo=kabo.Memo.of_plan(*giving[::2]), timeout=5.0)
    assert result.plan is None and result.reason is not None
    assert "rod sits in the hand of gantry such that it cannot be let go of" in result.reason.details[0]


def test_what_is_wrong_at_the_start_is_remembered_whatever_else_is(giving: Case) -> None:
    state = shifted(giving, 0.016)
    assert state.geometry is not None
    surroundings = GeometryServer(beginning_at(giving[1], state.geometry)).surroundings
    found = start_faults(surroundings, parts=False)
    for number in range(MAX_REMEMBERED + 1):
        surroundings.remembered(("test", number), object)
    assert found and start_faults(surroundings, parts=False) is found
