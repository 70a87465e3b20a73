"""`-v`, `-q` and `--log`: what is told, what is kept, and that nothing is kept by halves."""

import json
import logging
import os

import pytest

from kabo.cli.logs import logged


@pytest.fixture
def lines(tmp_path):
    return lambda: [json.loads(line) for line in (tmp_path / "log.jsonl").read_text().splitlines()]


@pytest.mark.parametrize("before", [True, False])
def test_a_log_holds_whole_lines_of_json_with_the_same_keys(kabo, parcels, tmp_path, lines, before):
    options, command = ["--log", tmp_path / "log.jsonl"], ["solve", "one.yaml", "-o", tmp_path / "plan.json"]
    assert kabo(*(options + command if before else command + options)).code == 0
    assert all(set(line) == {"time", "level", "logger", "message", "fields"} for line in lines())
    phases = [line["fields"] for line in lines() if "phase" in line["fields"]]
    assert {"reading the problem", "searching"} <= {each["phase"] for each in phases}
    assert all(each["seconds"] >= 0.0 for each in phases)
    assert any(line["fields"].get("file", "").endswith("one.yaml") for line in lines())


def test_a_second_run_appends(kabo, parcels, tmp_path, lines):
    for _ in range(2):
        kabo("check", "one.yaml", "--log", tmp_path / "log.jsonl")
    assert sum("version" in line["fields"] for line in lines()) == 2


def test_a_log_keeps_what_q_does_not_tell(kabo, parcels, tmp_path, lines):
    said = kabo("solve", "one.yaml", "-q", "-o", tmp_path / "plan.json", "--log", tmp_path / "log.jsonl")
    assert said.code == 0 and said.err == "" and said.out
    assert any("solved in" in line["message"] for line in lines())


def test_q_tells_errors_and_answers(kabo, parcels, tmp_path):
    assert "missing.yaml" in kabo("-q", "check", "missing.yaml").err
    kabo("solve", "one.yaml", "-o", "plan.json")
    assert "verified" in kabo("verify", "one.yaml", "plan.json", "-q").err


@pytest.mark.parametrize(("times", "found"), [(0, ()), (1, ("searching:",)), (2, ("searching:", "read "))])
def test_v_tells_phases_and_vv_files(kabo, parcels, tmp_path, times, found):
    said = kabo("solve", "one.yaml", "-o", tmp_path / "plan.json", *(["-" + "v" * times] if times else []))
    for text in ("searching:", "read "):
        assert any(text in line for line in said.err.splitlines() if line.startswith("kabo.")) == (text in found)


def test_levels_are_as_before_when_a_command_has_ended(kabo, parcels, tmp_path):
    before = [(each.level, list(each.handlers)) for each in map(logging.getLogger, ("kabo", "kabo.cli"))]
    kabo("check", "one.yaml", "-vv", "--log", tmp_path / "log.jsonl")
    kabo("check", "one.yaml", "-q")
    assert [(each.level, list(each.handlers)) for each in map(logging.getLogger, ("kabo", "kabo.cli"))] == before
    assert "1 file" in kabo("check", "one.yaml").err


@pytest.mark.parametrize("path", ["one.yaml", "plan.json", "no/such/folder/log", ".", "locked/log"])
def test_a_log_that_cannot_be_is_told_before_the_command_begins(kabo, parcels, path):
    (parcels / "locked").mkdir()
    (parcels / "locked").chmod(0o500)
    if path == "locked/log" and os.access(parcels / "locked", os.W_OK):
        pytest.skip("this user may write everywhere")
    before = (parcels / "one.yaml").read_bytes()
    said = kabo("solve", "one.yaml", "-o", "plan.json", "--log", path)
    assert said.code == 2 and path in said.err
    assert (parcels / "one.yaml").read_bytes() == before and not (parcels / "plan.json").exists()


def test_a_full_disk_ends_the_log_and_not_the_command(kabo, parcels, tmp_path):
    said = kabo("solve", "one.yaml", "-o", tmp_path / "plan.json", "--log", "/dev/full")
    assert said.code == 0 and said.err.count("the log ends here") == 1


def test_a_record_says_its_fields():
    record = logging.makeLogRecord({"name": "kabo.plan", "levelname": "DEBUG", "msg": "read %s", "args": ("x",)})
    record.fields = {"bytes": 7}
    assert {**logged(record), "time": None} == {
        "time": None,
        "level": "debug",
        "logger": "kabo.plan",
        "message": "read x",
        "fields": {"bytes": 7},
    }
