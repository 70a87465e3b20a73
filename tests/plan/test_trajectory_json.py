import json
from dataclasses import replace

import jsonschema
import numpy as np
import pytest

from kabo.errors import InputError
from kabo.motion import Trajectory
from kabo.plan import plan_from_json, plan_to_json, schema

JOINTS, WAYPOINTS, TIMES = ("j1", "j2"), ((0.0, 1.0), (0.5, 1.25)), (0.0, 0.5)
SMOOTH = Trajectory(
    JOINTS,
    WAYPOINTS,
    (0.0, 0.25, 0.5),
    (
        ((0.0, 0.0, 0.0, 16.0), (1.0, 0.0, 0.0, 8.0)),
        ((0.25, 3.0, -3.0, 0.0, 0.0, -7.0), (1.125,)),
    ),
    0.001,
)
WHERE = "$.nodes.n1.motion[0].trajectory"
FIRST, LAST = [[0.0], [1.0]], [[0.5], [1.25]]


@pytest.fixture
def moving(plan):
    """The plan of the room's tests, with a trajectory in its only motion."""
    return with_trajectory(plan, SMOOTH)


def with_trajectory(plan, trajectory):
    node = plan.nodes["n1"]
    motion = (replace(node.motion[0], trajectory=trajectory),)
    return replace(plan, nodes={**plan.nodes, "n1": replace(node, motion=motion)})


def spoiled(plan, *path, to) -> bytes:
    value = json.loads(plan_to_json(plan))
    inner = value["nodes"]["n1"]["motion"][0]["trajectory"]
    for step in path[:-1]:
        inner = inner[step]
    inner[path[-1]] = to
    return json.dumps(value).encode()


def said(content: bytes) -> str:
    with pytest.raises(InputError) as caught:
        plan_from_json(content, file="p.json")
    return str(caught.value)


def test_a_trajectory_is_written_and_read_and_fits_the_schema(moving):
    content = plan_to_json(moving)
    jsonschema.Draft202012Validator(schema("kabo-plan-2")).validate(json.loads(content))
    assert plan_from_json(content) == moving
    assert set(json.loads(content)["nodes"]["n1"]["motion"][0]["trajectory"]) == {
        "times",
        "coefficients",
        "deviation",
    }


def test_numbers_of_a_trajectory_are_rounded_and_trailing_zeros_left_out(plan):
    rough = Trajectory(
        JOINTS,
        ((0.0000000001, 1.0), (0.5, 1.25)),
        (0.0, 0.1999999999, 0.5),
        (((-0.0, 1.000000000004, 2e-13), (1.0, 1e-11, -0.0)), ((0.0, 0.0, -3e-13), (1.0, 2 / 3))),
        0.0010000001,
    )
    written = plan_from_json(plan_to_json(with_trajectory(plan, rough))).nodes["n1"].motion[0].trajectory
    assert written.waypoints == WAYPOINTS and written.times == (0.0, 0.2, 0.5)
    assert written.coefficients == (((0.0, 1.0), (1.0, 1e-11)), ((0.0,), (1.0, 0.66666666667)))
    assert written.deviation == 0.001000001  # rounded up: what is claimed stays true
    assert b"[-0.0" not in plan_to_json(with_trajectory(plan, rough))


def test_the_rounded_deviation_of_any_trajectory_is_its_own_rounding(plan):
    for deviation in np.random.default_rng(1).random(500) * 0.1:
        once = plan_from_json(plan_to_json(with_trajectory(plan, replace(SMOOTH, deviation=float(deviation)))))
        assert deviation <= once.nodes["n1"].motion[0].trajectory.deviation <= deviation + 1.000001e-9
        assert plan_from_json(plan_to_json(once)) == once


def test_rounding_moves_values_and_derivatives_by_less_than_a_billionth(plan):
    random = np.random.default_rng(2)
    own = tuple(tuple(tuple(row) for row in piece) for piece in random.normal(size=(2, 2, 6)))
    rough = replace(SMOOTH, coefficients=own)
    fine = plan_from_json(plan_to_json(with_trajectory(plan, rough))).nodes["n1"].motion[0].trajectory
    at = np.linspace(0.0, 0.5, 200)
    for order in range(3):
        assert np.abs(rough.at(at, order) - fine.at(at, order)).max() < 1e-9


CASES = [
    ((), [], f"{WHERE}: expected an object, found a list"),
    (("speed",), 1, f'{WHERE}: unknown key "speed"'),
    (("times",), [0, "1", 0.5], f'{WHERE}.times[1]: expected a finite number, found "1"'),
    (("times",), [0], f"{WHERE}.times: expected at least 2, found 1"),
    (("times",), None, f"{WHERE}.times: expected a list, found null"),
    (("times",), [-0.1, 0.25, 0.5], f"{WHERE}.times[0]: a time is never negative"),
    (("times",), [0, 0.6, 0.5], f"{WHERE}.times[2]: times increase, but 0.5 follows 0.6"),
    (("times",), [0, 0, 0.5], f"{WHERE}.times[1]: times increase, but 0 follows 0"),
    (("times",), [0.1, 0.2, 0.5], f"{WHERE}.times[0]: the segment begins at 0 s, its trajectory at 0.1 s"),
    (("times",), [0, 0.2, 0.6], f"{WHERE}.times[2]: the segment ends at 0.5 s, its trajectory at 0.6 s"),
    (("times",), [0, 0.5], f"{WHERE}.coefficients: 2 pieces for 2 times"),
    (("coefficients",), [FIRST], f"{WHERE}.coefficients: 1 pieces for 3 times"),
    (("coefficients",), {}, f"{WHERE}.coefficients: expected a list, found an object"),
    (("coefficients", 1), [[0.5]], f"{WHERE}.coefficients[1]: expected 2 entries, found 1"),
    (("coefficients", 1), 0.5, f"{WHERE}.coefficients[1]: expected a list, found 0.5"),
    (("coefficients", 1, 0), [], f"{WHERE}.coefficients[1][0]: expected at least 1, found 0"),
    (("coefficients", 1, 0), [0.0] * 7, f"{WHERE}.coefficients[1][0]: 7 coefficients: a piece has degree 5 or less"),
    (("coefficients", 1, 0, 1), None, f"{WHERE}.coefficients[1][0][1]: expected a finite number, found null"),
    (("coefficients", 1, 0, 1), True, f"{WHERE}.coefficients[1][0][1]: expected a finite number, found true"),
    (("deviation",), -1e-9, f"{WHERE}.deviation: a deviation is a distance, never negative"),
    (("deviation",), "1 mm", f"{WHERE}.deviation: expected a finite number"),
]  # fmt: skip


@pytest.mark.parametrize(("path", "value", "message"), CASES)
def test_what_is_wrong_in_a_trajectory_is_said_with_its_path(moving, path, value, message):
    if not path:
        content = json.loads(plan_to_json(moving))
        content["nodes"]["n1"]["motion"][0]["trajectory"] = value
        assert message in said(json.dumps(content).encode())
    else:
        assert message in said(spoiled(moving, *path, to=value))


@pytest.mark.parametrize("number", ["NaN", "Infinity", "1e999"])
def test_coefficients_are_finite(moving, number):
    content = spoiled(moving, "coefficients", 0, 0, to=[0.0, 12345.5]).replace(b"12345.5", number.encode())
    assert "finite" in said(content)


@pytest.mark.parametrize("key", ["times", "coefficients", "deviation"])
def test_missing_keys_of_a_trajectory_are_named(moving, key):
    value = json.loads(plan_to_json(moving))
    del value["nodes"]["n1"]["motion"][0]["trajectory"][key]
    assert said(json.dumps(value).encode()).count("\n") == 0
    assert f'{WHERE}: "{key}" is missing' in said(json.dumps(value).encode())


def test_several_faults_of_a_trajectory_come_at_once(moving):
    value = json.loads(plan_to_json(moving))
    own = value["nodes"]["n1"]["motion"][0]["trajectory"]
    own["times"], own["coefficients"][0], own["deviation"] = [0, 0.7, 0.5], [[0.0]], -1
    text = said(json.dumps(value).encode())
    assert all(place in text for place in (".times[2]", ".coefficients[0]", ".deviation"))


def test_a_plan_of_the_first_format_is_read_without_trajectories(plan):
    old = plan_to_json(plan).replace(b"kabo-plan/2", b"kabo-plan/1")
    jsonschema.Draft202012Validator(schema("kabo-plan-1")).validate(json.loads(old))
    assert plan_from_json(old) == plan
    assert plan_from_json(old).nodes["n1"].motion[0].trajectory is None
    assert b'"format":"kabo-plan/2"' in plan_to_json(plan_from_json(old))


def test_a_trajectory_in_a_plan_of_the_first_format_is_refused(moving):
    old = plan_to_json(moving).replace(b"kabo-plan/2", b"kabo-plan/1")
    assert not jsonschema.Draft202012Validator(schema("kabo-plan-1")).is_valid(json.loads(old))
    assert '$.format: "trajectory" is a key of "kabo-plan/2"' in said(old)
