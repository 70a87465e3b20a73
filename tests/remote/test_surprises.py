"""Surprises in the world of a robot server of another process: the run plans anew, over zenoh as without."""

import json
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.remote.conftest import PROBLEM, Started
from tests.service.conftest import free_endpoint

PROGRAM = Path(__file__).with_name("disturbed_server.py")


@pytest.mark.parametrize(
    ("kind", "body", "when", "last"),
    [
        ("pushed", "o1", 0.4, "repair"),
        ("pushed", "o2", 7.5, "repair"),
        ("dropped", "o1", 2.5, "replan"),
        ("dropped", "o2", 7.0, "replan"),
    ],
)
def test_a_body_that_is_pushed_or_dropped_is_still_brought_to_its_goal(
    kind: str,
    body: str,
    when: float,
    last: str,
    program: Callable[..., Started],
    kabo_process: Callable[..., Started],
    plan_file: Path,
    tmp_path: Path,
) -> None:
    endpoint, log = free_endpoint(), tmp_path / "log.jsonl"
    server = program(PROGRAM, PROBLEM, endpoint, kind, body, when)
    server.wait_for("serves")
    given = ("--no-verify", "--on", "zenoh", "--endpoint", endpoint, "-o", log)
    code, said = kabo_process("execute", PROBLEM, plan_file, *given).end()
    assert code == 0 and "the goal is reached" in said, said
    assert any(f"{body} was {kind}" in line for line in server.said)
    answers = [record for record in map(json.loads, log.read_text().splitlines()) if record["event"] == "answer"]
    assert answers and answers[-1]["kind"] == last
    assert {each["kind"] for each in answers[:-1]} <= {"finish", "undo"}
