"""The report in the view document: everything that a report says is in it, and films hang objects where they are held."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from kabo.errors import InputError
from kabo.language import load_scene_description
from kabo.scene import GeometricState, load_scene, world_T
from kabo.tasks.core import Failure, Serial, Task, forward
from kabo.tasks.files import load_task_file
from kabo.tasks.files.report_form import report_bytes
from kabo.tasks.files.reports import report
from kabo.tasks.files.running import PlanningOptions, TaskRun, plan_file
from kabo.viewer import document_of_file
from kabo.viewer.content.films import film_view
from kabo.viewer.content.report_view import report_view
from tests.support.giving_gantries import giving_gantries
from tests.tasks.files.conftest import Start, write

EXAMPLE = Path(__file__).parents[3] / "examples" / "pick_and_place"


@pytest.fixture(scope="module")
def planned(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A report of two solutions, beside a copy of nothing: its scene is named by its whole path."""
    scene = load_scene(load_scene_description(EXAMPLE / "scene.yaml"))
    runs = plan_file(load_task_file(EXAMPLE / "task.yaml"), {}, scene, PlanningOptions(max_solutions=2))
    path = tmp_path_factory.mktemp("report") / "report.json"
    path.write_bytes(report_bytes(report(runs, scene=scene, scene_file=str(EXAMPLE / "scene.yaml"))))
    return path


def test_the_scene_of_a_report_is_found_and_its_films_are_in_the_document(planned: Path) -> None:
    document = document_of_file(planned)
    assert document.scene is not None and document.report is not None and not document.findings
    solutions = document.report["runs"][0]["solutions"]
    assert len(solutions) == 2 and all(each["film"]["duration"] > 1.0 for each in solutions)  # noqa: PLR2004
    moving = [part["time"] for part in solutions[0]["parts"] if part["time"] is not None]
    assert moving == sorted(moving) and moving[0] == 0.0


def test_what_a_hand_takes_keeps_its_pose_in_the_world(planned: Path) -> None:
    scene = load_scene(load_scene_description(EXAMPLE / "scene.yaml"))
    document = document_of_file(planned)
    assert document.report is not None
    film = document.report["runs"][0]["solutions"][0]["film"]
    taken, let_go = film["handovers"]
    assert (taken["parent"], let_go["parent"]) == ("arm.tool0", "world")
    closing = next(segment for segment in film["segments"] if segment["attach"])
    lifted = next(segment for segment in film["segments"] if segment["times"][0] == closing["times"][-1])
    q = {**dict(zip(lifted["joints"], lifted["waypoints"][0], strict=True)), "finger_joint": 0.0}
    state = GeometricState(
        {"arm": tuple(q[name] for name in scene.robots["arm"].joint_names)}, scene.start.objects
    )
    hand = world_T(scene, state, "arm.tool0")
    object_T = world_T(scene, scene.start, "object")
    assert np.allclose((hand @ np.r_[taken["position"], 1.0])[:3], object_T[:3, 3], atol=1e-6)
    assert np.allclose(let_go["position"], film["after"]["objects"]["object"]["position"], atol=2e-6)


def test_what_another_robot_has_taken_is_not_let_go_by_the_one_that_gave_it(tmp_path: Path) -> None:
    problem = giving_gantries(tmp_path)
    assert problem.scene is not None
    scene = load_scene(problem.scene)
    hands = {"joints": ["x", "finger"], "constraint": None, "stage": "", "allowed": []}
    still = {**hands, "waypoints": [[0.0, 0.02], [0.0, 0.02]]}
    taken = {"object": "rod", "to": "other.hand"}
    motion: Any = {
        "start": {"objects": {"rod": {"parent": "gantry.hand", "position": [0, 0, 0], "quaternion": [0, 0, 0, 1]}}},
        "after": {},
        "segments": [
            {**still, "robot": "other", "times": [0.0, 1.0], "attach": [taken], "detach": []},
            {**still, "robot": "gantry", "times": [1.0, 2.0], "attach": [], "detach": ["rod"]},
        ],
    }  # fmt: skip
    assert [(each["time"], each["parent"]) for each in film_view(motion, scene)["handovers"]] == [
        (1.0, "other.hand")
    ]


def test_without_its_scene_a_report_is_shown_with_a_warning_and_without_motion(
    planned: Path, tmp_path: Path
) -> None:
    text = planned.read_text().replace(str(EXAMPLE / "scene.yaml"), "gone.yaml")
    (tmp_path / "r.json").write_text(text)
    document = document_of_file(tmp_path / "r.json")
    assert document.scene is None and document.report is not None
    assert "gone.yaml was not found" in document.findings[0]["message"]
    assert all(each["film"] is None for each in document.report["runs"][0]["solutions"])


def test_a_report_of_another_scene_is_an_error_that_says_what_is_missing(planned: Path, tmp_path: Path) -> None:
    other = EXAMPLE.parent / "two_arms" / "scene.yaml"
    (tmp_path / "r.json").write_text(planned.read_text().replace(str(EXAMPLE / "scene.yaml"), str(other)))
    with pytest.raises(InputError, match=r"is not of .*two_arms.*'arm' is not there"):
        document_of_file(tmp_path / "r.json")


def made(folder: Path, target: list[float], **settings: Any) -> Any:
    runs = plan_file(load_task_file(write(folder)), {"target": target}, None, PlanningOptions(**settings))
    return report_view(report(runs, file="task.yaml"), None)


def test_every_comment_change_and_stage_is_in_the_document(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from kabo.tasks.core import Result

    monkeypatch.setattr(Start, "generate", lambda self, scene, properties, seed: [Result(0.0)])
    view = made(tmp_path, [3, -1, 60, 2], repeat=2)
    text = str(view)
    for said in ("60 is above 40", "place -1 is below zero", "3 → 3.25", "grasp/approach"):
        assert said in text
    assert [run["seed"] for run in view["runs"]] == [0, 1]
    low = next(stage for stage in view["stages"] if stage["path"] == "grasp/low enough")
    assert low["reasons"] == [["too_high", "too high", 2]] and low["failed"] == 2  # noqa: PLR2004


def test_the_stage_that_is_to_blame_and_what_holds_it_are_open() -> None:
    @forward()
    def never(scene: Any, properties: Any, seed: int) -> Any:
        yield Failure("never", "not today")

    task = Task(
        "t", Serial("outer", Serial("deep", Serial("deeper", Start("first"), never("last")), never("other")))
    )
    task.plan(0.0)
    view = report_view(report([TaskRun(task, 0, 0.1)]), None)
    blamed = [stage for stage in view["stages"] if stage["blamed"]]
    assert [stage["name"] for stage in blamed] == ["last"] and blamed[0]["open"]
    assert all(stage["open"] for stage in view["stages"] if stage["name"] in ("outer", "deep", "deeper"))
    assert view["whys"][0]["stage"] == blamed[0]["path"]
