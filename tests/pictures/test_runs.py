"""Pictures of runs: which frames are taken, what is told under them, what is true beside what was seen, whole files."""

import json
from io import BytesIO
from pathlib import Path

import numpy as np
import pytest

import kabo
from kabo.errors import InputError
from kabo.pictures import PictureWishes, ViewWishes, Witness, picture_of_file, run_animation, write_run_frames
from kabo.pictures import runs as runs_module
from kabo.pictures.run_frames import frames_of_run, key_frames_of_run, step_of_run
from kabo.scene.transforms import transform
from tests.pictures.scenes import table_and_arm

VIEW = ViewWishes(size=(200, 160), camera=(1.5, -1.5, 1.0), labels=False)
CUP = {"position": [0.3, 0.0, 0.5], "quaternion": [0.0, 0.0, 0.0, 1.0]}


@pytest.fixture
def scene(tmp_path: Path) -> "kabo.Scene":
    table_and_arm(tmp_path)
    return kabo.load_scene(tmp_path / "scene.yaml")


def state(scene: "kabo.Scene", time: float, **bodies: dict) -> dict:
    robots = {name: list(values) for name, values in scene.start.robots.items()}
    return {"time": time, "event": "state", "robots": robots, "bodies": bodies}


def run_of(scene: "kabo.Scene") -> list[dict]:
    """Two seconds at 20 Hz; after one a surprise, and what is answered."""
    movable = scene.movable[0]
    found: list[dict] = [{"time": 0.0, "event": "start"}]
    found += [{"time": 0.0, "event": "node", "node": "n0", "action": "pick", "arguments": {"o": movable}}]
    for k in range(41):
        if k == 20:
            found += [{"time": 1.0, "event": "stopping", "reason": "it is elsewhere"}]
            found += [{"time": 1.0, "event": "answer", "kind": "undo", "reason": "back along the path"}]
        found.append(state(scene, round(0.05 * k, 6), **{movable: CUP}))
    return [*found, {"time": 2.0, "event": "goal", "node": "n1"}]


def test_frames_come_at_the_rate_and_the_end_is_among_them(scene) -> None:
    frames = frames_of_run(run_of(scene), scene, 0.15, "log")
    assert [frame.time for frame in frames] == pytest.approx([*np.arange(0.0, 2.0, 0.15), 2.0])
    assert frames[-1].told == "the goal is reached"
    assert frames[0].doing == f"n0 pick(o={scene.movable[0]})"
    assert frames[3].state.objects[scene.movable[0]].position == pytest.approx(CUP["position"])


def test_what_happened_is_told_under_the_frames_after_it(scene) -> None:
    told = {frame.time: frame.told for frame in frames_of_run(run_of(scene), scene, 0.0, "log")}
    assert told[0.5] == "" and told[1.5] == "undo: back along the path"
    keys = key_frames_of_run(run_of(scene), scene, "log")
    assert [frame.time for frame in keys] == pytest.approx([0.0, 0.95, 2.0])


def test_long_runs_are_shown_faster_unless_a_rate_is_asked_for(scene) -> None:
    records = [state(scene, 0.0), state(scene, 600.0)]
    assert step_of_run(records, None) == pytest.approx((5.0, 0.1))
    assert step_of_run(records[:1], None) == pytest.approx((0.1, 0.1))
    assert step_of_run(records, 4.0) == pytest.approx((0.25, 0.25))


def test_a_witness_notes_what_is_true_and_not_what_sensors_say(scene) -> None:
    movable, truth = scene.movable[0], np.array(transform((0.1, 0.2, 0.3)))
    robot = kabo.execution.KinematicRobot(scene)
    robot.poses = lambda: {movable: truth}
    witness = Witness(robot)
    witness(state(scene, 0.0, **{movable: CUP}))
    witness({"time": 0.0, "event": "goal"})
    assert witness.records[0]["bodies"][movable]["position"] == pytest.approx([0.1, 0.2, 0.3])
    assert witness.records[1]["event"] == "goal"


@pytest.mark.parametrize(
    "changed",
    [
        {"robots": {"nobody": [0.0]}},
        {"bodies": {"nothing": CUP}},
        {"bodies": None},
        {"bodies": {"cup": {"position": [0.0], "quaternion": [0.0, 0.0, 0.0, 1.0]}}},
    ],
)
def test_a_log_of_another_scene_is_refused(scene, changed) -> None:
    with pytest.raises(InputError, match="another scene"):
        frames_of_run([{**state(scene, 0.0), **changed}], scene, 0.1, "log")


def test_a_log_without_states_is_refused_with_the_remedy(scene) -> None:
    with pytest.raises(InputError, match="--log-rate"):
        frames_of_run([{"time": 0.0, "event": "goal"}], scene, 0.1, "log")


def test_an_animation_has_a_frame_for_each_moment(scene) -> None:
    pytest.importorskip("pyvista")
    from PIL import Image

    made = Image.open(BytesIO(run_animation(run_of(scene)[:15], scene, "log", VIEW, 10.0)))
    assert made.format == "GIF" and made.n_frames == 7
    assert made.info["duration"] == 100


def test_frames_are_all_written_or_none(scene, tmp_path, monkeypatch) -> None:
    pytest.importorskip("pyvista")
    folder = tmp_path / "frames"
    records = run_of(scene)[:6]

    def fails(*_: object) -> bytes:
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as context:
        context.setattr(runs_module, "png", fails)
        with pytest.raises(OSError, match="No space"):
            write_run_frames(records, scene, folder, VIEW)
    assert sorted(path.name for path in tmp_path.iterdir() if "frames" in path.name) == []
    assert write_run_frames(records, scene, folder, VIEW) == 3
    assert sorted(path.name for path in folder.iterdir()) == ["0001.png", "0002.png", "0003.png"]
    with pytest.raises(InputError, match="it holds something"):
        write_run_frames(records, scene, folder, VIEW)


def test_a_log_is_drawn_as_a_strip_and_as_an_animation_if_its_problem_is_named(scene, tmp_path) -> None:
    pytest.importorskip("pyvista")
    log = tmp_path / "log.jsonl"
    log.write_text("".join(json.dumps(record) + "\n" for record in run_of(scene)))
    wishes = PictureWishes(problem=tmp_path / "scene.yaml", view=VIEW)
    assert picture_of_file(log, ".png", wishes).startswith(b"\x89PNG")
    assert picture_of_file(log, ".gif", wishes).startswith(b"GIF89a")
    with pytest.raises(InputError, match="--problem FILE"):
        picture_of_file(log, ".gif", PictureWishes())
    with pytest.raises(InputError, match="not drawn as .svg"):
        picture_of_file(log, ".svg", wishes)
