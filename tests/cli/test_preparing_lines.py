"""The lines of a preparation stand on standard error, with and without a terminal, and name what is not done."""

import pytest

from kabo.cli.limits import Surrounding
from kabo.cli.waiting.doing import of_progress
from kabo.geometry_server import PreparationCutOff, Preparing
from kabo.planner.result import Progress

STATE = Preparing(
    12, ("r.link5", "r.hand", "r.finger", "cup"), "r.link4: 300 triangles, 1 part, 44 vertices (0.5 s)"
)


def test_a_line_is_told_in_a_pipe_and_the_state_is_not(capsys: pytest.CaptureFixture[str]) -> None:
    surrounding = Surrounding()
    surrounding.preparing(STATE)
    surrounding.planning(Progress(str(STATE), fraction=STATE.fraction, line="second line"))
    surrounding.planning(Progress("searching", 3, 4))
    assert capsys.readouterr() == ("", f"{STATE.line}\nsecond line\n")


def test_the_state_names_what_is_next_and_counts_no_nodes() -> None:
    said = "preparing geometry: 8 of 12 done, not yet r.link5, r.hand, r.finger and 1 more"
    assert of_progress(Progress(str(STATE), fraction=STATE.fraction)).text == said


def test_a_cut_says_what_is_done_what_is_not_and_that_the_former_is_kept() -> None:
    error = PreparationCutOff(STATE)
    assert error.details[0].startswith("geometry was prepared for 8 of 12 links and bodies, not for r.link5, ")
    assert "kept" in error.details[1]
    assert error.exit_code == 4
