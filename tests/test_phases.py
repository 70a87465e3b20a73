"""Phases are heard by who listens, in this process only, at most ten times a second; and logged with their seconds."""

import logging
import os

import pytest

from kabo.phases import Phase, heard_by, phase, timed


def test_a_phase_is_heard_at_its_begin_and_the_one_around_it_again_at_its_end():
    heard: list[Phase] = []
    with heard_by(heard.append), phase("checking", 3, "files"), phase("reading"):
        pass
    assert [each.doing for each in heard] == ["checking", "reading", "checking", "working"]
    assert heard[0] == Phase("checking", 0, 3, "files")


def test_many_steps_are_heard_rarely(monkeypatch):
    heard: list[Phase] = []
    with heard_by(heard.append), phase("counting", 100_000) as step:
        for _ in range(100_000):
            step()
    assert len(heard) < 60  # a tenth of a second each, with a slow machine in mind
    assert all(one.done <= other.done for one, other in zip(heard, heard[1:-1], strict=False))


def test_forked_processes_are_not_heard(tmp_path):
    kept = tmp_path / "heard"

    def listen(told: Phase) -> None:
        with kept.open("a") as file:
            file.write(f"{os.getpid()}\n")

    with heard_by(listen):
        child = os.fork()
        if child == 0:
            with phase("working in a child"):
                pass
            os._exit(0)
        assert os.waitpid(child, 0)[1] == 0
        with phase("working here"):
            pass
    assert set(kept.read_text().split()) == {str(os.getpid())}


def test_nobody_hears_and_nothing_breaks():
    with phase("alone", 2) as step:
        step()


@pytest.mark.parametrize("context", [phase, timed])
def test_seconds_are_logged_even_if_the_phase_fails(context, caplog):
    with caplog.at_level(logging.DEBUG, "kabo"), pytest.raises(KeyError), context("failing"):
        raise KeyError
    (record,) = caplog.records
    assert record.fields["phase"] == "failing" and record.fields["seconds"] >= 0.0
