"""What an exploration file says about trials becomes a function, or an error at its place."""

from pathlib import Path

import pytest

from kabo.errors import InputError
from kabo.trials import Invalid, TrialResult, load_exploration_file, register, trial_findings, trial_of

TEXT = """\
exploration: e
trial: files/Slip
parameters: {x: {from: 0, to: 1}}
outcomes: {c: }
"""


def slip(case: object, parameters: object, seed: int) -> TrialResult:
    return Invalid("slipped")


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "e.yaml"
    path.write_text(TEXT)
    return path


def test_a_registered_function_makes_the_trials(file: Path) -> None:
    register(slip, "files/Slip")
    found = load_exploration_file(file)
    assert trial_of(found) is slip and not trial_findings(found)


def test_an_unknown_function_is_told_at_its_name(file: Path) -> None:
    register(slip, "files/Slip")
    file.write_text(TEXT.replace("files/Slip", "files/Slop"))
    found = load_exploration_file(file, "shown.yaml")
    assert not trial_findings(found)
    with pytest.raises(InputError) as caught:
        trial_of(found)
    (one,) = caught.value.diagnostics
    assert (one.file, one.line, one.column, one.message) == ("shown.yaml", 2, 8, 'unknown trial "files/Slop"')
    assert one.hint == 'did you mean "files/Slip"?'


def test_without_a_trial_there_is_nothing_to_run(file: Path) -> None:
    file.write_text(TEXT.replace("trial: files/Slip\n", ""))
    with pytest.raises(InputError, match=r'e\.yaml:1:14: "e" does not say how a trial is made'):
        trial_of(load_exploration_file(file))


def test_all_errors_of_a_file_are_raised_at_once(file: Path) -> None:
    file.write_text(TEXT.replace("to: 1", "to: 0").replace("{c: }", "{}"))
    with pytest.raises(InputError) as caught:
        load_exploration_file(file)
    assert len(caught.value.diagnostics) == 2
    with pytest.raises(InputError, match="there is no such file"):
        load_exploration_file(file.with_name("none.yaml"))
