"""Solutions at hand are tried first in the scene that was observed, and only what is proven there is taken."""

from pathlib import Path

import pytest

import kabo
from kabo.tasks import TaskReport

EXAMPLES = Path(__file__).resolve().parents[3] / "examples"
EXAMPLE = EXAMPLES / "pick_and_place"
TASK = EXAMPLE / "task.yaml"


def observed(folder: Path, more: str = "", **changes: str) -> Path:
    """The example's scene, in which things have changed."""
    text = (EXAMPLE / "scene.yaml").read_text().replace("../../meshes", str(EXAMPLES.parent / "meshes"))
    for before, after in changes.values():
        assert before in text
        text = text.replace(before, after)
    path = folder / "observed.yaml"
    path.write_text(text.replace("objects:\n", f"objects:\n{more}", 1))
    return path


@pytest.fixture(scope="module")
def before() -> TaskReport:
    return kabo.plan_task(TASK, EXAMPLE / "scene.yaml", max_solutions=2)


def motions(report: TaskReport) -> list:
    return [whole["motion"]["segments"] for whole in report.content["runs"][0]["solutions"]]


def calls(report: TaskReport) -> int:
    return sum(figures["calls"] for figures in report.content["runs"][0]["stages"].values())


def test_in_the_same_scene_all_hold_without_any_search(before: TaskReport) -> None:
    again = kabo.plan_task(TASK, EXAMPLE / "scene.yaml", max_solutions=2, from_=before)
    assert calls(again) == 0
    assert motions(again) == motions(before)
    costs = [whole["cost"] for whole in again.content["runs"][0]["solutions"]]
    assert costs == pytest.approx([whole["cost"] for whole in before.content["runs"][0]["solutions"]], abs=1e-6)
    kinds = [[c["change"] for c in w["motion"]["changes"]] for w in again.content["runs"][0]["solutions"]]
    assert kinds == [[c["change"] for c in w["motion"]["changes"]] for w in before.content["runs"][0]["solutions"]]
    assert kabo.verify(again.scene, kabo.task_plan(again)).ok


def test_a_new_body_elsewhere_changes_nothing(before: TaskReport, tmp_path: Path) -> None:
    scene = observed(tmp_path, "  far: {box: [0.1, 0.1, 0.1], pose: {position: [-1.5, 0, 0.05]}}\n")
    again = kabo.plan_task(TASK, scene, max_solutions=1, from_=before)
    assert calls(again) == 0 and kabo.verify(again.scene, kabo.task_plan(again)).ok


def test_what_a_new_body_blocks_is_left_out_and_planning_goes_on(before: TaskReport, tmp_path: Path) -> None:
    hand = [segment for segment in motions(before)[0] if segment["stage"] == "move to place"][0]
    assert hand
    scene = observed(tmp_path, "  wall: {box: [0.02, 0.3, 0.16], pose: {position: [0.55, -0.35, 0.081]}}\n")
    again = kabo.plan_task(TASK, scene, max_solutions=1, timeout=60, from_=before)
    assert again.runs[0].left_out or calls(again) == 0
    for solution in range(1, len(again.solutions) + 1):
        assert kabo.verify(again.scene, kabo.task_plan(again, solution, certificate=False)).ok


def test_a_thing_that_is_to_be_taken_must_be_where_it_was(before: TaskReport, tmp_path: Path) -> None:
    scene = observed(tmp_path, moved=("position: [0.5, -0.25, 0.125]", "position: [0.49, -0.25, 0.125]"))
    again = kabo.plan_task(TASK, scene, max_solutions=1, timeout=60, from_=before)
    assert again.runs[0].left_out == tuple(
        f"solution {number} with seed 0: object is elsewhere" for number in (1, 2)
    )
    assert calls(again) > 0 and again.solutions
    assert kabo.verify(again.scene, kabo.task_plan(again, certificate=False)).ok


def test_a_saved_report_will_do(before: TaskReport, tmp_path: Path) -> None:
    before.save(tmp_path / "before.json")
    again = kabo.plan_task(TASK, EXAMPLE / "scene.yaml", max_solutions=1, from_=tmp_path / "before.json")
    assert calls(again) == 0 and motions(again)[0] == motions(before)[0]


def test_padding_and_pouring_are_replayed_as_well() -> None:
    for name in ("retract_transit_approach", "bottle_pouring"):
        folder = EXAMPLES / name
        first = kabo.plan_task(folder / "task.yaml", folder / "scene.yaml", max_solutions=1)
        again = kabo.plan_task(folder / "task.yaml", folder / "scene.yaml", max_solutions=1, from_=first)
        assert calls(again) == 0, again.runs[0].left_out
        changes = [
            [c["change"] for c in report.content["runs"][0]["solutions"][0]["motion"]["changes"]]
            for report in (first, again)
        ]
        assert changes[0] == changes[1]
