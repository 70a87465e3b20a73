"""`kabo execute` and `kabo simulate`: exit codes, logs, models, errors that say what is wrong."""

import json
from dataclasses import replace
from pathlib import Path

import pytest

import kabo
from kabo.cli import exit_codes
from kabo.cli.main import main, parser

DOMAINS = Path(__file__).parents[2] / "domains"
DOORS = DOMAINS / "doors" / "n3.yaml"


@pytest.fixture(scope="module")
def plan(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("doors") / "plan.json"
    found = kabo.solve(kabo.load_problem(DOORS)).plan
    assert found is not None
    found.save(path)
    return path


def test_a_plan_without_motions_reaches_its_goal_and_the_log_is_written(
    plan: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    log = tmp_path / "log.jsonl"
    assert main(["execute", str(DOORS), str(plan), "--seed", "3", "-o", str(log)]) == exit_codes.DONE
    assert "the goal is reached" in capsys.readouterr().err
    events = [json.loads(line)["event"] for line in log.read_text().splitlines()]
    assert events[0] == "start" and events[-1] == "goal"


def test_what_is_wrong_at_once_is_told_before_kernels_are_compiled(plan: Path) -> None:
    def waits(*given: object) -> bool:
        options = parser().parse_args(list(map(str, given)))
        return bool(options.needs_kernels(options))

    stacked = DOMAINS / "stacked" / "n2.yaml"
    assert waits("execute", stacked, plan) and not waits("execute", DOORS, plan)
    assert not waits("execute", stacked, "missing.json")
    assert not waits("execute", stacked, plan, "--on", "zenoh", "--endpoint", "here")
    assert waits("execute", stacked, plan, "--on", "zenoh", "--endpoint", "tcp/127.0.0.1:1")
    for command in (["motion", "{}", "--to", "home"], ["simulate", "{}", "-o", "model.xml"]):
        assert waits(*(each.format(stacked) for each in command))
        assert not waits(*(each.format("missing.yaml") for each in command))


def test_a_wrong_endpoint_is_told_before_the_plan_is_verified(
    plan: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    given = ["execute", str(DOMAINS / "stacked" / "n2.yaml"), str(plan), "--on", "zenoh", "--endpoint", "here"]
    assert main(given) == exit_codes.SERVICE
    assert "Endpoints must be of the form" in capsys.readouterr().err


def test_the_result_is_printed_for_programs(plan: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["execute", str(DOORS), str(plan), "--json"]) == exit_codes.DONE
    told = json.loads(capsys.readouterr().out)
    assert told["reached_goal"] and told["history"] and told["contacts"] == []
    assert [record["event"] for record in told["log"]][-1] == "goal"


def test_an_outcome_that_the_plan_does_not_know_is_a_stop(plan: Path, capsys: pytest.CaptureFixture[str]) -> None:
    formula = kabo.policy(kabo.load_plan(plan))().observe
    command = ["execute", str(DOORS), str(plan), "--truth", f"{formula}=ajar"]
    assert main(command) == exit_codes.STOPPED
    assert f"{formula} is ajar, for which the plan has no branch" in capsys.readouterr().err


def test_a_plan_that_is_not_verified_is_not_carried_out(
    plan: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    broken = json.loads(plan.read_text())
    name = next(n for n, node in broken["nodes"].items() if node["kind"] == "action")
    broken["nodes"][name]["kind"] = "goal"
    for key in ("action", "arguments", "next"):
        del broken["nodes"][name][key]
    file = tmp_path / "broken.json"
    file.write_text(json.dumps(broken))
    code = main(["execute", str(DOORS), str(file)])
    assert code in (exit_codes.VERIFICATION_FAILED, exit_codes.BAD_INPUT)
    assert "goal is reached" not in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--truth", "open"], "is no formula with its outcome"),
        (["--truth", "opem(door_1)=true"], 'did you mean "open"?'),
        (["--truth", "open(c2_22)=true"], 'there is no cell "c2_22"'),
        (["--on", "hardware"], "--on"),
        (["--rate", "5000"], "--rate"),
        (["--tracking-error", "fast"], "--tracking-error"),
    ],
)
def test_what_does_not_fit_is_refused(
    arguments: list[str], said: str, plan: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    try:
        code = main(["execute", str(DOORS), str(plan), *arguments])
    except SystemExit as end:
        code = end.code
    assert code == exit_codes.BAD_INPUT
    assert said in capsys.readouterr().err


def test_a_scene_becomes_a_model_that_mujoco_loads(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    mujoco = pytest.importorskip("mujoco")
    model = tmp_path / "model.xml"
    assert main(["simulate", str(DOMAINS / "stacked" / "n2.yaml"), "-o", str(model)]) == exit_codes.DONE
    assert "6 motors" in capsys.readouterr().err
    assert mujoco.MjModel.from_xml_path(str(model)).nu == 6
    again = tmp_path / "again.xml"
    main(["simulate", str(DOMAINS / "stacked" / "n2.yaml"), "-o", str(again)])
    assert model.read_bytes() == again.read_bytes()


def test_physics_without_mujoco_says_how_to_install_it(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    import sys

    from kabo.simulation.mujoco_library import mujoco

    monkeypatch.setitem(sys.modules, "mujoco", None)
    with pytest.raises(kabo.InputError, match=r'pip install "kabo\[simulation\]"'):
        mujoco()


UR5 = """
scene: ur
epsilon: 0.004
packages: {example-robot-data: installed}
robots:
  arm:
    urdf: package://example-robot-data/robots/ur_description/urdf/ur5_robot.urdf
    base: {position: [0, 0, 0.5]}
    configurations: {home: [0, -1.2, 1.2, -1.5, -1.5, 0], there: [1.2, -1.2, 1.2, -1.5, -1.5, 0]}
objects:
  pillar: {box: [0.1, 0.1, 0.3], pose: {position: [0.5, 0.5, 0.6]}}
"""


@pytest.mark.parametrize("robot", ["kinematic", "simulation"])
def test_a_motion_of_a_scene_is_carried_out_without_a_problem(
    robot: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    if robot == "simulation":
        pytest.importorskip("mujoco")
    scene, motion = tmp_path / "scene.yaml", tmp_path / "plan.json"
    scene.write_text(UR5)
    assert main(["motion", str(scene), "--to", "there", "-o", str(motion)]) == exit_codes.DONE
    assert main(["execute", str(scene), str(motion), "--on", robot]) == exit_codes.DONE
    assert "the goal is reached" in capsys.readouterr().err
    other = DOMAINS / "stacked" / "n2.yaml"
    assert main(["execute", str(other), str(motion), "--on", robot, "--no-verify"]) == exit_codes.BAD_INPUT
    assert 'the scene has no robot "arm": the plan is of another one' in capsys.readouterr().err


def test_a_plan_without_trajectories_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    scene, file = tmp_path / "scene.yaml", tmp_path / "plan.json"
    scene.write_text(UR5)
    assert main(["motion", str(scene), "--to", "there", "-o", str(file)]) == exit_codes.DONE
    plan = kabo.load_plan(file)
    nodes = {
        name: replace(node, motion=tuple(replace(each, trajectory=None) for each in node.motion))
        for name, node in plan.nodes.items()
    }
    replace(plan, nodes=nodes).save(file)
    assert main(["execute", str(scene), str(file), "--no-verify"]) == exit_codes.BAD_INPUT
    assert "has no trajectory" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (["--video", "run.mp4"], "does not end with .gif"),
        (["--video", "nowhere/run.gif"], "no file in a folder that exists"),
        (["--frame-rate", "10"], "it is of --video and --frames"),
        (["--frames", ".", "--frame-rate", "0"], "'0' is not"),
        (["--frames", ".", "--frame-rate", "99"], "'99' is not a number from 0.1 to 50 Hz"),
        (["--frames", "."], "it holds something"),
        (["--frames", "nowhere/frames"], "there is no folder"),
        (["--video", "run.gif"], "nothing moves in this plan"),
    ],
)
def test_pictures_of_a_run_that_cannot_be_are_refused_before_anything_moves(
    plan: Path,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    options: list[str],
    says: str,
) -> None:
    pytest.importorskip("pyvista")
    monkeypatch.chdir(tmp_path)
    (tmp_path / "something").write_text("")
    try:
        code = main(["execute", str(DOORS), str(plan), *options])
    except SystemExit as ended:
        code = int(str(ended.code))
    assert code == exit_codes.BAD_INPUT
    assert says in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["something"]
