"""`kabo export`: files, standard output, checks, errors that leave no file behind."""

from pathlib import Path

import pytest

from kabo.cli import exit_codes
from kabo.cli.export import FORMATS
from kabo.cli.main import main
from kabo.exporting import FORMATS as KNOWN
from kabo.exporting import ros_trajectories
from kabo.plan import load_plan
from tests.exporting.conftest import ARM, made


@pytest.fixture
def plan(tmp_path: Path) -> Path:
    made(ARM).save(tmp_path / "plan.json")
    return tmp_path / "plan.json"


def test_the_formats_of_the_help_are_those_that_there_are() -> None:
    assert set(FORMATS) == {*KNOWN, "up"}  # which needs the problem, too


def test_a_file_is_written_and_checked(plan: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "tree.xml"
    command = ["export", str(plan), "--to", "bt"]
    assert main([*command, "-o", str(file)]) == exit_codes.DONE
    assert main([*command, "--check", str(file)]) == exit_codes.DONE
    assert main(command) == exit_codes.DONE
    assert capsys.readouterr().out == file.read_text()
    file.write_text(file.read_text().replace("outcome_n1", "outcome_n2"))
    assert main([*command, "--check", str(file)]) == exit_codes.VERIFICATION_FAILED
    assert "variable='{outcome_n1}'" in capsys.readouterr().err
    file.write_bytes(b"\xff\xfe")
    assert main([*command, "--check", str(file)]) == exit_codes.VERIFICATION_FAILED


def test_bytes_are_of_one_message(plan: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "message.cdr"
    command = ["export", str(plan), "--to", "trajectory", "--cdr", "-o", str(file)]
    assert main([*command, "--node", "n4"]) == exit_codes.BAD_INPUT
    assert "n4 begins before n3 has ended" in capsys.readouterr().err
    assert main([*command, "--branch", "true"]) == exit_codes.BAD_INPUT
    said = capsys.readouterr().err
    assert "5 messages, and a file holds the bytes of one" in said and "--message 1 to 5 chooses one" in said
    assert main([*command, "--branch", "true", "--message", "6"]) == exit_codes.BAD_INPUT
    assert "1 to 5" in capsys.readouterr().err
    assert not file.exists()
    messages = ros_trajectories(load_plan(plan), "trajectory", branch="true")
    for number, message in enumerate(messages, 1):
        assert main([*command, "--branch", "true", "--message", str(number)]) == exit_codes.DONE
        assert file.read_bytes() == message.to_cdr()
    assert main([*command, "--branch", "true", "--robot", "right"]) == exit_codes.DONE
    assert file.read_bytes()[:4] == b"\x00\x01\x00\x00"
    yaml = ["export", str(plan), "--to", "trajectory", "--branch", "true", "--message", "1", "-o", str(file)]
    assert main(yaml) == exit_codes.BAD_INPUT and "--cdr, or leave it out" in capsys.readouterr().err


def test_a_plan_without_motion_has_no_message(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    doors = Path(__file__).parents[2] / "domains" / "doors" / "n3.yaml"
    plan = tmp_path / "plan.json"
    assert main(["solve", str(doors), "-o", str(plan)]) == exit_codes.DONE
    command = ["export", str(plan), "--to", "trajectory", "--cdr", "-o", str(tmp_path / "message.cdr")]
    assert main([*command, "--branch", "false,false"]) == exit_codes.BAD_INPUT
    assert "Traceback" not in (said := capsys.readouterr().err) and said.count("\n      = ") == 1, said


@pytest.mark.parametrize("more", [["--to", "btt"], ["--to", "csv"], ["--to", "dot", "--rate", "5"]])
def test_an_error_is_one_message_and_leaves_no_file(
    more: list[str], plan: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    before = set(tmp_path.iterdir())
    assert main(["export", str(plan), *more, "-o", str(tmp_path / "out")]) == exit_codes.BAD_INPUT
    said = capsys.readouterr().err
    assert "Traceback" not in said and said.count("\n      = ") == 1 and set(tmp_path.iterdir()) == before


def test_the_plan_and_its_problem_are_written_for_unified_planning(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    doors = Path(__file__).parents[2] / "domains" / "doors" / "n3.yaml"
    plan, file = tmp_path / "plan.json", tmp_path / "plan.py"
    assert main(["solve", str(doors), "-o", str(plan)]) == exit_codes.DONE
    command = ["export", str(plan), "--to", "up"]
    assert main([*command, "--problem", str(doors), "-o", str(file)]) == exit_codes.DONE
    made_there: dict[str, object] = {}
    exec(compile(file.read_text(), str(file), "exec"), made_there)
    assert type(made_there["plan"]).__name__ == "ContingentPlan"
    grid = doors.parents[1] / "grid" / "n3.yaml"
    for more, text in (
        ([], "it is missing: up writes the problem"),
        (["--problem", str(doors), "--cdr"], "up has the whole plan and no motions"),
        (["--problem", str(grid)], "the plan is none of this problem"),
    ):
        assert main([*command, *more, "-o", str(tmp_path / "none.py")]) == exit_codes.BAD_INPUT
        assert text in capsys.readouterr().err
        assert not (tmp_path / "none.py").exists()
    assert main(["export", str(plan), "--to", "dot", "--problem", str(doors)]) == exit_codes.BAD_INPUT
