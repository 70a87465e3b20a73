"""Runs: trials are written before the next is asked for; killed and resumed, a run writes the same bytes."""

import math
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from kabo.errors import CutOff
from kabo.exploration import Exploration, Journal, Space, load_exploration, trial_seed
from kabo.trials import Invalid, TrialError, TrialReport, TrialResult, Valid, run_exploration

SPACE = Space({"x": (0.0, 1.0), "y": (-1.0, 1.0)}, {"side": ["left", "right"]})
WHOLE = 14


def disc(case: object, parameters: dict[str, float], seed: int) -> TrialResult:
    """Valid within a disc, with noise that the seed decides."""
    away = math.hypot(parameters["x"] - 0.5, parameters["y"] / 2)
    return Valid({"depth": away + 1e-3 * (seed % 100)}) if away < 0.35 else Invalid("beside")


def new(path: Path, seed: int = 0) -> Journal:
    start, retry = {"x": 0.5, "y": 0.9}, {"beside": {"y": -0.2}}
    return Journal.create(path, Exploration(SPACE, ["depth"], seed=seed, start=start, retry=retry))


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    path = tmp_path_factory.mktemp("whole") / "m.jsonl"
    assert run_exploration(new(path), disc, WHOLE).ended == "done"
    return path.read_bytes()


def test_a_run_makes_as_many_trials_as_there_are_to_be_in_all(tmp_path: Path) -> None:
    path, reports = tmp_path / "m.jsonl", list[TrialReport]()
    journal = new(path)
    first = run_exploration(journal, disc, 5, progress=reports.append)
    assert (first.ended, first.made, len(journal.exploration.trials)) == ("done", 5, 5)
    again = run_exploration(journal, disc, 8, progress=reports.append)
    assert (again.ended, again.made) == ("done", 3)
    assert run_exploration(journal, disc, 8).made == 0 == run_exploration(journal, disc, 3).made
    assert [(each.number, each.trials) for each in reports] == [(n, 5 if n <= 5 else 8) for n in range(1, 9)]
    known = load_exploration(path).trials
    assert known == journal.exploration.trials
    assert [each.question.parameters for each in reports] == [each.parameters for each in known]
    assert {each.case["side"] for each in known} == {"left", "right"}


def test_each_trial_is_in_the_file_before_the_next_and_has_a_seed_of_its_own(tmp_path: Path) -> None:
    path, seeds = tmp_path / "m.jsonl", list[int]()
    counts = {"left": 0, "right": 0}

    def watching(case: dict[str, str], parameters: dict[str, float], seed: int) -> TrialResult:
        assert len(path.read_bytes().splitlines()) == 1 + len(seeds)
        assert seed == trial_seed(3, case, counts[case["side"]])
        counts[case["side"]] += 1
        seeds.append(seed)
        return disc(case, parameters, seed)

    run_exploration(new(path, 3), watching, 9)
    assert len(set(seeds)) == 9


@settings(max_examples=12)
@given(
    st.lists(st.tuples(st.integers(1, 4), st.integers(0, 40), st.sampled_from(["stop", "cut", "raise", "kill"])))
)
def test_a_run_that_is_interrupted_again_and_again_writes_the_same_bytes(
    whole: bytes, tmp_path_factory: pytest.TempPathFactory, ends: list[tuple[int, int, str]]
) -> None:
    """`ends`: after how many trials a run ends, how many bytes of the next line are torn, and how it ends."""
    path = tmp_path_factory.mktemp("torn") / "m.jsonl"
    new(path)
    for trials, torn, how in ends:
        journal = Journal.resume(path)
        _interrupted(journal, trials, how)
        lines = len(path.read_bytes().splitlines())
        if lines <= WHOLE:
            with path.open("ab") as file:
                file.write(whole.splitlines(keepends=True)[lines][:-1][:torn])
    assert run_exploration(Journal.resume(path), disc, WHOLE).ended == "done"
    assert path.read_bytes() == whole


def _interrupted(journal: Journal, trials: int, how: str) -> None:
    made = 0

    def trial(case: dict[str, str], parameters: dict[str, float], seed: int) -> TrialResult:
        nonlocal made
        made += 1
        if made > trials and how != "stop":
            raise {"cut": CutOff(), "raise": RuntimeError("broken"), "kill": KeyboardInterrupt()}[how]
        return disc(case, parameters, seed)

    before = len(journal.exploration.trials)
    left = WHOLE - before
    try:
        ended = run_exploration(journal, trial, WHOLE, stop=lambda: how == "stop" and made >= trials).ended
        assert ended == ("done" if left <= trials else "stopped")
    except (TrialError, KeyboardInterrupt):
        assert how in ("raise", "kill")
    assert len(journal.exploration.trials) == before + min(trials, left)


def test_a_trial_that_raises_ends_the_run_names_itself_and_all_before_are_kept(tmp_path: Path) -> None:
    path = tmp_path / "m.jsonl"

    def failing(case: dict[str, str], parameters: dict[str, float], seed: int) -> TrialResult:
        if len(path.read_bytes().splitlines()) > 6:
            raise ZeroDivisionError("no bar")
        return disc(case, parameters, seed)

    with pytest.raises(
        TrialError, match=r"trial 7 \(side .*; x .*, y .*\) raised ZeroDivisionError: no bar"
    ) as caught:
        run_exploration(new(path), failing, 20)
    assert caught.value.number == 7
    assert len(load_exploration(path).trials) == 6


def test_a_case_without_parameters_to_try_does_not_end_the_run(tmp_path: Path) -> None:
    def left_only(case: dict[str, str], parameters: dict[str, float], seed: int) -> TrialResult:
        return disc(case, parameters, seed) if case["side"] == "left" else Invalid("blocked")

    journal = new(tmp_path / "m.jsonl")
    assert run_exploration(journal, left_only, 40).ended == "done"
    assert len(journal.exploration.trials_of({"side": "right"})) == 10  # as many as are tried around a start


def test_a_run_ends_with_the_reason_of_each_case_if_no_case_has_parameters_to_try(tmp_path: Path) -> None:
    journal = new(tmp_path / "m.jsonl")
    run = run_exploration(journal, lambda case, parameters, seed: Invalid("blocked"), 100)
    assert (run.ended, run.made) == ("no_parameters", 20)
    assert [(case, error.reason) for case, error in run.refusals] == [
        ({"side": "left"}, "nothing_valid"),
        ({"side": "right"}, "nothing_valid"),
    ]
    assert "10 × blocked" in str(run.refusals[0][1])


def test_an_exploration_without_a_start_ends_at_once(tmp_path: Path) -> None:
    journal = Journal.create(tmp_path / "m.jsonl", Exploration(SPACE, ["depth"]))
    run = run_exploration(journal, disc, 5)
    assert (run.ended, run.made, run.refusals[0][1].reason) == ("no_parameters", 0, "not_explored")
