"""The judge of motions sees what is wrong with a plan, and nothing where nothing is: it shares no code with kabo."""

import copy
import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).parents[2]
JUDGE = ROOT / "benchmarks" / "judge" / "motion_batch.py"
SCENE = """
scene: lonely
epsilon: 0.01
robots:
  arm:
    urdf: {meshes}/arm6/arm6.urdf
    gripper:
      urdf: {meshes}/gripper_wide/gripper_wide.urdf
      mount: tool0
      open: {{finger_joint: 0.055}}
      closed: {{finger_joint: 0.0}}
      force: 5.2
    velocity: 1.0
    acceleration: {{joint_1: 2.0}}
models:
  thing: {{box: [0.02, 0.02, 0.02], mass: 0.25}}
objects:
  wall: {{box: [0.1, 0.1, 1.0], pose: {{position: [0.0, 0.95, 0.6]}}}}
  ring: {{model: thing, movable: true, pose: {{position: [0.0, -0.8, 0.9]}}}}
"""
JOINTS = [f"joint_{i}" for i in range(1, 7)]
HOME = [0.0, 0.0, 1.0, 0.0, 0.5, 0.0]


def quintic(start, end, lasts):
    """The coefficients of the polynomial from rest to rest."""
    step = np.subtract(end, start)
    return [
        [a, 0.0, 0.0, 10 * d / lasts**3, -15 * d / lasts**4, 6 * d / lasts**5]
        for a, d in zip(start, step, strict=True)
    ]


def plan_of(end, lasts, deviation=1e-9):
    """A plan with a single straight motion from home to `end`, with the ring in the hand."""
    segment = {
        "robot": "arm",
        "joints": JOINTS,
        "waypoints": [HOME, end],
        "times": [0.0, lasts],
        "trajectory": {"times": [0.0, lasts], "coefficients": [quintic(HOME, end, lasts)], "deviation": deviation},
        "attach": [],
        "detach": [],
        "allowed_contacts": [["ring", "arm.palm"]],
    }
    held = {"parent": "arm.tool0", "position": [0.0, 0.0, 0.2], "quaternion": [0.0, 0.0, 0.0, 1.0]}
    joints = dict(zip(JOINTS, HOME, strict=True)) | {"finger_joint": 0.05}
    after = {"robots": {"arm": {"joints": joints | dict(zip(JOINTS, end, strict=True))}}}
    return {
        "format": "kabo-plan/2",
        "root": "n0",
        "nodes": {
            "n0": {"kind": "action", "motion": [segment], "after": after, "next": "n1"},
            "n1": {"kind": "goal"},
        },
        "start": {"robots": {"arm": {"joints": joints}}, "objects": {"ring": held}},
    }


@pytest.fixture
def ask(tmp_path):
    """The judge's verdict of a plan."""
    scene = tmp_path / "scene.yaml"
    scene.write_text(SCENE.format(meshes=ROOT / "meshes"))

    def asked(plan):
        file = tmp_path / "plan.json"
        file.write_text(json.dumps(plan))
        job = json.dumps({"problem": str(scene), "plan": str(file)})
        done = subprocess.run([sys.executable, JUDGE], input=job, capture_output=True, text=True, check=True)
        return json.loads(done.stdout)

    return asked


END = [0.5, *HOME[1:]]


def test_a_slow_motion_has_no_fault_and_its_figures_are_those_of_its_polynomial(ask):
    verdict = ask(plan_of(END, 2.0))
    assert verdict["violations"] == {}, verdict["faults"]
    assert verdict["worst"]["velocity_exact"] == pytest.approx(1.875 * 0.5 / 2.0)
    assert verdict["worst"]["acceleration_exact"] == pytest.approx(10 / np.sqrt(3) * 0.5 / 4.0 / 2.0)
    assert verdict["worst"]["jerk_exact"] == pytest.approx(60 * 0.5 / 8.0 / 40.0)
    assert verdict["worst"]["tool_doubt"] < 1e-3


@pytest.mark.parametrize(
    ("lasts", "kinds"),
    [(0.9, {"velocity", "velocity_exact", "velocity_by_differences"}), (0.8, {"acceleration", "jerk"})],
)
def test_a_hasty_motion_breaks_its_limits(ask, lasts, kinds):
    assert kinds <= set(ask(plan_of(END, lasts))["violations"])


def test_a_grip_that_is_too_weak_is_told(ask):
    """0.25 kg need 2.45 N to be held at rest, and 0.5 · 5.2 N = 2.6 N hold it: 3.4 m/s² are left sideways."""
    assert "tool" not in ask(plan_of(END, 1.2))["violations"]
    assert "tool" in ask(plan_of([1.5, *HOME[1:]], 1.0))["violations"]


def test_a_motion_into_the_wall_collides(ask):
    """The arm turns by a right angle, from the x axis to the wall on the y axis."""
    verdict = ask(plan_of([1.5708, 1.0, 0.6, *HOME[3:]], 8.0))
    assert verdict["violations"].get("collision", 0) > 0
    assert any("wall" in fault["where"] for fault in verdict["faults"])


def test_a_step_of_velocity_an_edge_that_is_cut_and_a_start_in_motion_are_told(ask):
    plan = plan_of(END, 2.0)
    trajectory = plan["nodes"]["n0"]["motion"][0]["trajectory"]
    middle, first = [0.25, *HOME[1:]], quintic(HOME, [0.25, *HOME[1:]], 1.0)
    second = [[a, 0.1, *row[2:]] for a, row in zip(middle, quintic(middle, END, 1.0), strict=True)]
    whole = copy.deepcopy(plan)
    trajectory |= {"times": [0.0, 1.0, 2.0], "coefficients": [first, second]}
    assert {"join", "path"} <= set(ask(plan)["violations"])
    whole["nodes"]["n0"]["motion"][0]["trajectory"]["coefficients"][0][0][1] = 0.01
    assert "rest" in ask(whole)["violations"]


def test_a_motion_beside_its_path_is_told_unless_the_plan_says_so(ask):
    plan = plan_of(END, 2.0)
    segment = plan["nodes"]["n0"]["motion"][0]
    segment["waypoints"] = [HOME, [0.25, 0.02, *HOME[2:]], END]
    segment["times"] = [0.0, 1.0, 2.0]
    assert "path" in ask(plan)["violations"]
    segment["trajectory"]["deviation"] = 0.021
    assert ask(plan)["violations"] == {}


def test_a_path_of_constant_velocity_begins_with_a_step(ask):
    plan = plan_of(END, 2.0)
    del plan["nodes"]["n0"]["motion"][0]["trajectory"]
    verdict = ask(plan)
    assert {"rest", "acceleration_by_differences"} <= set(verdict["violations"])
    assert verdict["worst"]["acceleration_by_differences"] == pytest.approx(0.25 / 2.0 * 1000, rel=1e-3)
