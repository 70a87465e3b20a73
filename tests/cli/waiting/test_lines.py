"""What is shown of waiting: rows that fit, times in words, estimates that need something to go by."""

import re

from hypothesis import given
from hypothesis import strategies as st

from kabo.cli.waiting.doing import Doing, of_phase, of_progress
from kabo.cli.waiting.lines import Estimate, Style, barred, piped, span
from kabo.phases import Phase
from kabo.planner.result import Progress

FRACTIONS = st.none() | st.floats(0.0, 1.0)
CODES = re.compile(r"\x1b\[[0-9]*m")


@given(
    text=st.text(max_size=300),
    fraction=FRACTIONS,
    columns=st.integers(1, 300),
    seconds=st.floats(0, 1e6),
    left=st.none() | st.floats(0, 1e6),
    wide=st.booleans(),
    colours=st.booleans(),
)
def test_a_row_is_never_wider_than_the_terminal_and_never_two(
    text, fraction, columns, seconds, left, wide, colours
):
    doing = Doing("step", text, fraction)
    row = barred(doing, fraction, seconds, left, Style(colours, wide, columns), 3)
    shown = CODES.sub("", row)
    assert len(shown) <= max(3, columns - 1)
    assert shown.isprintable() and (wide or shown.isascii())
    assert colours or shown == row


@given(done=st.integers(0, 50), total=st.integers(1, 50), seconds=st.floats(0, 1e5))
def test_a_line_says_counts_share_and_time(done, total, seconds):
    line = piped(of_phase(Phase("checking", min(done, total), total, "nodes")), seconds, None)
    assert line.startswith(f"kabo: checking: {min(done, total)} of {total} nodes (")
    assert line.endswith(f"; {span(seconds)} so far") and "\n" not in line


def test_spans_of_time_are_told_in_words():
    assert [span(s) for s in (0.2, 59.4, 59.6, 61, 3599.7, 7260)] == [
        "0 s",
        "59 s",
        "1 min 0 s",
        "1 min 1 s",
        "1 h 0 min",
        "2 h 1 min",
    ]


def test_the_end_of_a_step_is_estimated_by_what_was_done_of_it():
    estimate = Estimate()
    assert estimate.left(Doing("a", "a", 0.0), 100.0) is None
    assert estimate.left(Doing("a", "a", 0.01), 101.0) is None  # too early to say
    assert estimate.left(Doing("a", "a", 0.25), 110.0) == 30.0
    assert estimate.left(Doing("b", "b", 0.5), 111.0) is None  # another step begins anew
    assert estimate.left(Doing("b", "b", 0.75), 121.0) == 10.0


def test_what_is_left_of_a_budget_of_time_only_shrinks():
    doing = Doing("searching", "searching", 0.0, of_budget=True, ends=200.0)
    left = [Estimate().left(doing, now) for now in (100.0, 150.0, 250.0)]
    assert left == [100.0, 50.0, 0.0]
    assert doing.share(100.0, 150.0) == 0.5 and doing.share(100.0, 300.0) == 1.0


def test_a_search_counts_what_it_has_done_and_names_its_budget():
    doing = of_progress(Progress("searching", 120, 0, 7, spent=0.25, seconds_left=30.0))
    assert doing.text == "searching: 120 nodes expanded, 7 procedure calls"
    assert doing.of_budget and doing.said == "searching"
    assert of_progress(Progress("searching", spent=0.0)).text == "searching"
    said = of_progress(
        Progress("looking for motions", 6, refused="pick(arm, cup) refused 80 times, mostly by lid")
    )
    assert said.text == "looking for motions: 6 nodes expanded; pick(arm, cup) refused 80 times, mostly by lid"
