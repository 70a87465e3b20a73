"""What verifications of one process keep: scenes whose files have not changed, and proofs by all they depend on."""

import shutil
from dataclasses import replace
from pathlib import Path

import pytest

import kabo
from kabo.execution import Margins
from kabo.plan import ObjectPose
from kabo.scene import KeptScenes

DOMAINS = Path(__file__).parents[2] / "domains"


def test_a_scene_is_loaded_again_only_when_one_of_its_files_has_changed(tmp_path: Path) -> None:
    shutil.copytree(DOMAINS / "stacked", tmp_path / "domains" / "stacked")
    shutil.copytree(DOMAINS.parent / "meshes", tmp_path / "meshes")
    problem = kabo.load_problem(tmp_path / "domains" / "stacked" / "n2.yaml")
    kept = KeptScenes()
    scene, notes = kept.scene(problem.scene)
    notes.add("prepared")
    again = kept.scene(problem.scene)
    assert again[0] is scene and again[1] == {"prepared"}
    other = kabo.load_problem(tmp_path / "domains" / "stacked" / "n2.yaml")
    assert kept.scene(other.scene)[0] is not scene
    model = next(path for path in scene.files if path.suffix == ".urdf")
    model.write_bytes(model.read_bytes() + b"\n")
    changed = kept.scene(problem.scene)
    assert changed[0] is not scene and changed[1] == set()


def test_a_plan_is_the_same_whatever_was_kept_and_a_moved_body_is_judged_anew() -> None:
    problem = kabo.load_problem(DOMAINS / "stacked" / "n2.yaml")
    first, second = kabo.solve(problem).plan, kabo.solve(problem).plan
    assert first is not None and first == second
    reports = [kabo.verify(problem, first) for _ in range(2)]
    assert reports[0].ok and reports[0] == reports[1]
    start = first.start
    assert start is not None and Margins(first).of_rest(first.root) < 0.03
    own = start.objects["o2"]
    x, y, z = own.position
    moved = replace(
        start, objects={**start.objects, "o2": ObjectPose(own.parent, (x + 0.03, y, z), own.quaternion)}
    )
    report = kabo.verify(problem, replace(first, start=moved))
    assert not report.ok


def test_the_least_distance_is_the_same_whatever_was_verified_before() -> None:
    problem = kabo.load_problem(DOMAINS / "circular_rearrange" / "n2.yaml")
    plans = [plan for seed in (0, 1, 2) if (plan := kabo.solve(problem, seed=seed, workers=1).plan) is not None]
    least = [kabo.verify(problem, plan, scene=kabo.load_scene(problem.scene)).least for plan in plans]
    assert len(set(least)) > 1
    scene = kabo.load_scene(problem.scene)
    kept = [kabo.verify(problem, plan, scene=scene).least for plan in (*plans, *reversed(plans))]
    assert kept == [*least, *reversed(least)]


@pytest.mark.parametrize("name", ["stacked/n2.yaml"])
def test_a_solve_with_a_fresh_problem_gives_the_same_plan(name: str) -> None:
    plans = [kabo.solve(kabo.load_problem(DOMAINS / name)).plan for _ in range(2)]
    assert plans[0] == plans[1]
