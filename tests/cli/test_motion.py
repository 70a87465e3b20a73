"""`kabo motion`: a plan file that is verified, ends in every spelling, errors that say what is wrong."""

import json
from pathlib import Path

import pytest

import kabo
from kabo.cli import exit_codes
from kabo.cli.main import main, parser
from kabo.cli.motion import where
from kabo.cli.usage import UsageError, parsed
from kabo.errors import InputError

SCENE = Path(__file__).parents[2] / "examples" / "two_cans" / "scene.yaml"


def test_the_plan_of_a_motion_is_verified(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    plan = tmp_path / "plan.json"
    command = ["motion", str(SCENE), "--to", "panda_joint1=60deg,panda_joint4=-1.2", "-o", str(plan)]
    assert main(command) == exit_codes.DONE
    assert "proven free of collision" in "".join(capsys.readouterr())
    assert main(["verify", str(SCENE), str(plan)]) == exit_codes.DONE
    again = tmp_path / "again.json"
    assert main([*command[:-1], str(again)]) == exit_codes.DONE
    assert plan.read_bytes() == again.read_bytes()


def test_the_trajectory_is_printed_for_programs(capsys: pytest.CaptureFixture[str]):
    assert main(["motion", str(SCENE), "--robot", "arm", "--to", "panda_joint1=0.5", "--json"]) == exit_codes.DONE
    told = json.loads(capsys.readouterr().out)
    assert told["robot"] == "arm"
    assert told["waypoints"][-1][0] == 0.5
    assert len(told["times"]) == len(told["coefficients"]) + 1


@pytest.mark.parametrize("goal", ["-0.5,0,0,-1.5,0,1.8,0", "-30deg,0,0,-1.5,0,1.8,0", "-.5,0,0,-1.5,0,1.8,0"])
def test_values_may_begin_with_a_negative_one(goal: str):
    options = parsed(parser(), ["motion", "scene.yaml", "--from", "-1,0", "--to", goal, "--seed", "1"])
    assert (options.start, options.goal, options.seed) == ("-1,0", goal, 1)
    with pytest.raises(UsageError, match="no option -x"):
        parsed(parser(), ["motion", "scene.yaml", "--to", "home", "-x"])


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--to", "hoem"], 'did you mean "home"?'),
        (["--to", "1,2"], "plans 7 joints"),
        (["--to", "panda_joint1=x"], "is no value of a joint"),
        (["--to", "1\n2"], "is no value of a joint"),
        (["--to", "panda_joint1=1,panda_joint1=2"], "is given twice"),
        (["--to", "panda_joint1=1,panda_joint2"], "'panda_joint2' has no value"),
        (["--to", "panda_joint1="], "'panda_joint1' has no value"),
        (["--to", "home", "--robot", "arn"], 'did you mean "arm"?'),
        (["--to", "home", "--keep", "upright"], "no motion constraint"),
        (["--to", "home", "--holding", "cam_1"], 'did you mean "can_1"?'),
    ],
)
def test_what_does_not_fit_is_refused_at_its_option(
    arguments: list[str], said: str, capsys: pytest.CaptureFixture[str]
):
    assert main(["motion", str(SCENE), *arguments]) == exit_codes.BAD_INPUT
    told = capsys.readouterr().err
    assert said in told
    assert f"{arguments[-2]}:1:1: " in told


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ("panda_joint1=5mm", "'panda_joint1' turns, and '5mm' is no value of it"),
        ("0.1, 2m, 0, -2, 0, 2, 0.7", "'panda_joint2' turns"),
    ],
)
def test_a_length_is_no_value_of_a_joint_that_turns(given: str, said: str, capsys: pytest.CaptureFixture[str]):
    assert main(["motion", str(SCENE), "--to", given]) == exit_codes.BAD_INPUT
    assert said in capsys.readouterr().err


def test_a_unit_must_be_that_of_the_joint():
    slides = {"lift": True, "turn": False}
    assert where("20mm, 90deg", "--to", slides) == pytest.approx([0.02, 1.5707963])
    assert where("turn=1rad, lift=1m", "--to", slides) == {"turn": 1.0, "lift": 1.0}
    with pytest.raises(InputError, match="'lift' slides"):
        where("20deg, 90deg", "--to", slides)
    with pytest.raises(InputError, match="'turn' turns"):
        where("turn=90mm", "--to", slides)


def test_ends_are_names_or_values_in_order_or_by_name():
    assert where("home", "--to") == "home"
    assert where("0.5, -90deg, 20 mm", "--to") == pytest.approx([0.5, -1.5707963, 0.02])
    assert where("a=1,b=-2", "--to") == {"a": 1.0, "b": -2.0}
    assert where("0.5", "--to") == [0.5]
    with pytest.raises(InputError, match="no value"):
        where("0.5,x", "--to")


def test_the_command_is_there_in_python_too():
    assert kabo.plan_motion is not None
