"""`kabo replan`, `kabo execute --state` and `kabo verify --after`: a run is left, and planned on by another process."""

import json
from pathlib import Path

import pytest

import kabo
from kabo.cli import exit_codes
from kabo.cli.main import main

MISTYPED = {"action": "sense_door", "arguments": {"i": "c1_2", "j": "c2_22"}}
DOORS = Path(__file__).parents[2] / "domains" / "doors" / "n3.yaml"


@pytest.fixture
def plan(tmp_path: Path) -> Path:
    assert main(["solve", str(DOORS), "-o", str(tmp_path / "plan.json")]) == exit_codes.DONE
    return tmp_path / "plan.json"


@pytest.fixture
def stopped(plan: Path, tmp_path: Path) -> Path:
    """The state of a run that has ended since a sensor said what the plan does not know."""
    formula = next(node.on for node in kabo.load_plan(plan).nodes.values() if node.on is not None)
    state = tmp_path / "state.json"
    command = ["execute", str(DOORS), str(plan), "--truth", f"{formula}=ajar", "--state", str(state)]
    assert main(command) == exit_codes.STOPPED
    return state


def test_a_run_that_was_left_is_planned_on_and_verified(
    plan: Path, stopped: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    rest = tmp_path / "rest.json"
    assert main(["replan", str(DOORS), str(plan), "--after", str(stopped), "-o", str(rest)]) == exit_codes.DONE
    found = kabo.load_plan(rest)
    assert found.done == kabo.load_state(stopped).done and found.root in kabo.load_plan(plan).nodes
    assert main(["verify", str(DOORS), str(rest), "--after", str(stopped)]) == exit_codes.DONE
    assert "note: the plan begins after" not in capsys.readouterr().err
    assert main(["verify", str(DOORS), str(rest)]) == exit_codes.DONE
    assert "the plan begins after" in "".join(capsys.readouterr())
    assert main(["execute", str(DOORS), str(rest)]) == exit_codes.DONE
    assert main(["verify", str(DOORS), str(plan), "--after", str(stopped)]) == exit_codes.VERIFICATION_FAILED
    assert "what was done before the plan begins is not what was done" in "".join(capsys.readouterr())


def test_states_that_do_not_fit_are_refused_with_what_is_wrong(
    plan: Path, stopped: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    command = ["replan", str(DOORS), str(plan), "-o", str(tmp_path / "rest.json"), "--after"]
    body = json.loads(stopped.read_text())
    for change, text in (
        ({"format": "kabo-state/2"}, "of another version, or no state"),
        ({"format": "kabo-plan/2"}, "the state of a run is needed here, this is a plan"),
        ({"done": [{"action": "fly", "arguments": {}}]}, "fly() is no action that matters"),
        ({"done": [*body["done"], {"on": "open(moon)", "outcome": "true"}]}, "nothing that can be observed"),
        ({"dome": []}, 'unknown key "dome"'),
        ({"done": [MISTYPED]}, 'did you mean "sense_door(c1_2, c2_2)"?'),
    ):
        (tmp_path / "wrong.json").write_text(json.dumps({**body, **change}))
        assert main([*command, str(tmp_path / "wrong.json")]) == exit_codes.BAD_INPUT
        said = capsys.readouterr().err
        assert text in said and f"{tmp_path / 'wrong.json'}:1:1: " in said
        assert not (tmp_path / "rest.json").exists()
    assert main([*command, str(tmp_path / "nowhere.json")]) == exit_codes.BAD_INPUT
    grid = DOORS.parents[1] / "grid" / "n3.yaml"
    assert main(["replan", str(grid), str(plan), "--after", str(stopped)]) == exit_codes.BAD_INPUT
    assert "the plan is of doors_n3, not of grid_n3" in capsys.readouterr().err
