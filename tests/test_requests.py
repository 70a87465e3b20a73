"""What every door calls: files in, answers as data out."""

import shutil
from pathlib import Path

import pytest

from kabo.errors import InputError
from kabo.requests import check_files, explain_file, read_problem, solve_file, verify_file

PARCELS = Path(__file__).parent / "acceptance" / "parcels"


@pytest.fixture
def broken(tmp_path: Path) -> Path:
    """A problem whose domain has an unknown name."""
    shutil.copytree(PARCELS, tmp_path / "parcels")
    domain = tmp_path / "parcels" / "domain.yaml"
    domain.write_text(domain.read_text().replace("K(held(p))", "K(hold(p))"))
    return tmp_path / "parcels" / "one.yaml"


def test_bad_input_is_an_answer_of_solve_and_of_explain_and_an_error_of_verify(broken, tmp_path):
    solved = solve_file(broken, {})
    assert solved.body["status"] == "invalid" and solved.plan is None and len(solved.error.diagnostics) == 2
    explained, error = explain_file(broken)
    assert explained.verdict == "invalid" and error.diagnostics == solved.error.diagnostics
    (tmp_path / "plan.json").write_text("{}")
    with pytest.raises(InputError):
        verify_file(broken, tmp_path / "plan.json")
    assert [each.message for each in check_files([broken])] == [each.message for each in error.diagnostics]


def test_a_plan_that_is_found_is_verified(tmp_path):
    answer = solve_file(PARCELS / "one.yaml", {"seed": 2})
    (tmp_path / "plan.json").write_bytes(answer.plan)
    assert verify_file(PARCELS / "one.yaml", tmp_path / "plan.json").ok
    assert explain_file(PARCELS / "one.yaml", timeout=60.0)[0].verdict == "solvable"
    assert check_files([PARCELS / "one.yaml"]) == []


def test_nothing_outside_of_a_folder_is_read(tmp_path):
    shutil.copy(PARCELS / "one.yaml", tmp_path)
    with pytest.raises(InputError, match="domain"):
        read_problem(tmp_path / "one.yaml", within=tmp_path)
