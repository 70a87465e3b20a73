"""Solutions at hand are tried first in the scene that was observed, and only what is proven there is taken."""

from pathlib import Path

import pytest

import kabo
from kabo.tasks import TaskReport

EXAMPLES = Path(__file__).resolve().parents[3] / "examples"
EXAMPLE = EXAMPLES / "pick_and_place"
TASK = EXAMPLE / "task.yaml"
CANS = EXAMPLES / "two_cans" / "scene.yaml"


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


LOWER_LIMITS = {
    "velocity": ("inverse_kinematics: projection", "inverse_kinematics: projection\n    velocity: 0.3"),
    "acceleration": ("inverse_kinematics: projection", "inverse_kinematics: projection\n    acceleration: 0.9"),
    "jerk": ("inverse_kinematics: projection", "inverse_kinematics: projection\n    jerk: 9"),
}


@pytest.mark.parametrize("rate", LOWER_LIMITS)
def test_a_motion_that_is_too_fast_for_the_robot_now_is_left_out(
    before: TaskReport, tmp_path: Path, rate: str
) -> None:
    scene = observed(tmp_path, slower=LOWER_LIMITS[rate])
    again = kabo.plan_task(TASK, scene, max_solutions=1, from_=before)
    assert len(again.runs[0].left_out) == 2
    assert all("arm." in why and f"limit of {rate}" in why for why in again.runs[0].left_out)
    assert kabo.verify(again.scene, kabo.task_plan(again, certificate=False)).ok


def test_a_motion_beyond_narrower_limits_of_position_is_left_out(before: TaskReport, tmp_path: Path) -> None:
    arm = [s for s in motions(before)[0] if len(s["joints"]) == 7]
    joint = arm[0]["joints"][0]
    least = min(row[0] for segment in arm for row in segment["waypoints"])
    narrower = f"inverse_kinematics: projection\n    limits: {{{joint}: [{least + 0.1}, 2.5]}}"
    scene = observed(tmp_path, narrower=("inverse_kinematics: projection", narrower))
    again = kabo.plan_task(TASK, scene, max_solutions=1, timeout=1, from_=before)
    assert f"arm.{joint} leaves its limits of position" in again.runs[0].left_out[0]


def test_a_motion_that_holds_a_thing_that_is_heavier_now_is_left_out(tmp_path: Path) -> None:
    light, heavy = (
        observed(
            folder,
            held=("movable: true", f"movable: true\n    mass: {mass}"),
            firm=("closed:", "force: 40\n      closed:"),
        )
        for folder, mass in ((tmp_path / "light", 1.0), (tmp_path / "heavy", 1.9))
        if folder.mkdir() is None
    )
    before = kabo.plan_task(TASK, light, max_solutions=1)
    again = kabo.plan_task(TASK, heavy, max_solutions=1, from_=before)
    (why,) = again.runs[0].left_out
    assert "arm could hold object while it moved faster than it can now" in why
    assert kabo.verify(again.scene, kabo.task_plan(again, certificate=False)).ok
    lighter = kabo.plan_task(TASK, light, max_solutions=1, from_=again)
    assert not lighter.runs[0].left_out and calls(lighter) == 0


def test_a_saved_report_will_do(before: TaskReport, tmp_path: Path) -> None:
    before.save(tmp_path / "before.json")
    again = kabo.plan_task(TASK, EXAMPLE / "scene.yaml", max_solutions=1, from_=tmp_path / "before.json")
    assert calls(again) == 0 and motions(again)[0] == motions(before)[0]


def test_a_plan_is_no_report_of_solutions_at_hand(before: TaskReport) -> None:
    with pytest.raises(kabo.InputError, match="from_:1:1: solutions at hand are those of a report, not of a Plan"):
        kabo.plan_task(TASK, EXAMPLE / "scene.yaml", from_=kabo.task_plan(before, certificate=False))  # type: ignore[arg-type]


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


def test_solutions_of_other_arguments_are_left_out(before: TaskReport) -> None:
    given = {"destination": {"position": [0.62, -0.2, 0.125]}}
    again = kabo.plan_task(TASK, EXAMPLE / "scene.yaml", given, timeout=0, from_=before)
    assert len(again.runs[0].left_out) == 2 and not again.solutions
    assert all("destination of pick and place was {" in why for why in again.runs[0].left_out)
    given = {"destination": {"position": [0.6, -0.15, 0.125]}, "surface": "table"}  # as by default
    again = kabo.plan_task(TASK, EXAMPLE / "scene.yaml", given, max_solutions=1, from_=before)
    assert calls(again) == 0 and len(again.solutions) == 1


def test_solutions_of_another_task_are_left_out(before: TaskReport, tmp_path: Path) -> None:
    text = TASK.read_text()
    for old, new, reason in (
        ("name: pick and place", "name: bring", "another task, in which pick and place is where bring is now"),
        ("  - {name: go home, stage: MoveTo, goal: home}", "", "another task, which has not the same stages"),
        (
            "goal: home",
            "goal: [0, 0, 0, 0, 0, 0, 0]",
            "goal of go home was home, and is [0, 0, 0, 0, 0, 0, 0] now",
        ),
        ("family: side", "", "family of pick/grasp pose IK/grasp pose was side, and is not given now"),
    ):
        assert old in text
        (tmp_path / "task.yaml").write_text(text.replace(old, new))
        again = kabo.plan_task(tmp_path / "task.yaml", EXAMPLE / "scene.yaml", timeout=0, from_=before)
        assert len(again.runs[0].left_out) == 2 and all(reason in why for why in again.runs[0].left_out)
    (tmp_path / "task.yaml").write_text(text.replace("max_ik_solutions: 8", "max_ik_solutions: 9"))
    again = kabo.plan_task(tmp_path / "task.yaml", EXAMPLE / "scene.yaml", max_solutions=1, from_=before)
    assert calls(again) == 0 and len(again.solutions) == 1 and not again.runs[0].left_out


def test_what_a_task_names_must_be_as_it_was(before: TaskReport, tmp_path: Path) -> None:
    home = ("home: [0, -30 deg", "park: [0, 0, 0, 0, 0, 0, 0]\n      home: [0, -30 deg")
    task = tmp_path / "task.yaml"
    task.write_text(TASK.read_text().replace("goal: home", "goal: park"))
    scene = observed(tmp_path, home=home)
    first = kabo.plan_task(task, scene, max_solutions=1)
    assert first.solutions and kabo.plan_task(task, scene, max_solutions=1, from_=first).runs[0].left_out == ()
    scene = observed(tmp_path, home=home, park=("park: [0,", "park: [0.1,"))
    again = kabo.plan_task(task, scene, timeout=0, from_=first)
    assert "the configuration park of arm is another one" in again.runs[0].left_out[0]


def test_a_region_that_a_task_names_must_be_where_it_was(tmp_path: Path) -> None:
    task = tmp_path / "task.yaml"
    task.write_text(
        "name: bring\nproperties: {robot: {type: robot, default: arm}}\nstages:\n"
        "  - {name: now, stage: CurrentState}\n  - {name: take, stage: pick, object: can_1}\n"
        "  - {name: put, stage: place, object: can_1, region: bin}\n"
    )
    text = CANS.read_text()
    first = kabo.plan_task(task, CANS, max_solutions=1)
    moved = "bin: {box: [0.25, 0.25, 0.2], pose: {frame: tray, position: [0"
    assert first.solutions and moved in text
    (tmp_path / "scene.yaml").write_text(text.replace(moved, moved + ".001"))
    again = kabo.plan_task(task, tmp_path / "scene.yaml", timeout=0, from_=first)
    assert again.runs[0].left_out == ("solution 1 with seed 0: the region bin is elsewhere",)
