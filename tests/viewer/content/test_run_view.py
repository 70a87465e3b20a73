"""Logs of runs in view documents: whole lines are records, and what is no record is told by its line."""

import json
from pathlib import Path

import pytest

from kabo.errors import InputError
from kabo.viewer import document_of_run, has_ended, page_of, read_log

RECORDS = [{"time": 0.0, "event": "start", "problem": "p"}, {"time": 1.0, "event": "goal", "node": "n1"}]


def test_a_line_that_is_still_being_written_is_left_out(tmp_path: Path) -> None:
    log = tmp_path / "log.jsonl"
    lines = "".join(json.dumps(each) + "\n" for each in RECORDS)
    for cut in range(len(lines) + 1):
        log.write_text(lines[:cut])
        assert read_log(log) == RECORDS[: lines[:cut].count("\n")]
    assert has_ended(RECORDS) and not has_ended(RECORDS[:1]) and not has_ended([])


@pytest.mark.parametrize("line", ["", "{", "[]", '{"time": 1}', '{"event": "goal", "time": NaN}', "[" * 5000])
def test_a_line_that_is_no_record_is_told(line: str, tmp_path: Path) -> None:
    log = tmp_path / "log.jsonl"
    log.write_text(json.dumps(RECORDS[0]) + f"\n{line}\n")
    with pytest.raises(InputError, match="log.jsonl:2:1: this line is no record"):
        read_log(log)


def test_the_page_of_a_log_needs_no_plan_and_asks_nobody() -> None:
    page = page_of(document_of_run(RECORDS, "log.jsonl"))
    assert b"connect-src" not in page and b"log.jsonl" in page
