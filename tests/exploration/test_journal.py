"""The journal: what is told stands in the file before the next question, and damage is said with its place."""

import fcntl
import json
import os
import threading
import time

import pytest

from kabo.errors import InputError
from kabo.exploration import ExplorationError, Journal, Validity, load_exploration
from tests.support.small_explorations import exploration, run, tell_random

BARS = {"bar": ["steel", "wood"]}
HEADER = ("format", "name", "space", "outcomes", "validity", "invalid_budget", "start", "retry", "seed")
HERE = {"a": 0.5, "b": 0.0}
OPTIONS = {
    "outcomes": ("torque", "noise"),
    "cases": BARS,
    "seed": -3,
    "validity": Validity(0.2, 0.3, 0.8),
    "invalid_budget": 0.2,
    "start": HERE,
    "retry": {"dröpped\n": {"a": -0.1}},
    "units": {"torque": "N m"},
    "name": "„bars“",
}


@pytest.fixture
def model(tmp_path):
    explored = exploration(**OPTIONS)
    tell_random(explored, 6, case={"bar": "steel"})
    explored.tell({"bar": "wood"}, HERE, False, reason='"dröpped" \\ ✓')
    explored.save(tmp_path / "model.jsonl")
    return tmp_path / "model.jsonl"


def damaged(path, lines) -> tuple[int, int, str]:
    """Line, column and message of what is wrong with these lines."""
    path.write_bytes(b"".join(line if isinstance(line, bytes) else (line + "\n").encode() for line in lines))
    before = path.read_bytes()
    for read in (load_exploration, Journal.resume):
        with pytest.raises(InputError) as caught:
            read(path)
    assert path.read_bytes() == before
    (found,) = caught.value.diagnostics
    assert found.file == str(path)
    assert "\n" not in found.message
    assert len(found.message) < 600
    return found.line, found.column, found.message + (f" = {found.hint}" if found.hint else "")


# ------------------------------------------------------------------------------------------------------ round trip
def test_what_is_saved_is_loaded_and_saved_again_byte_for_byte(model):
    loaded = load_exploration(model)
    assert loaded.text.encode() == model.read_bytes()
    assert loaded.header == exploration(**OPTIONS).header
    assert loaded.space == exploration(**OPTIONS).space
    assert loaded.trials[-1].reason == '"dröpped" \\ ✓'


def test_a_journal_has_a_header_and_a_line_for_each_trial(model):
    lines = [json.loads(line) for line in model.read_text().split("\n")[:-1]]
    assert tuple(lines[0]) == HEADER
    assert lines[0]["format"] == "kabo-exploration/1"
    assert lines[1] == {
        "case": {"bar": "steel"},
        "parameters": HERE,
        "valid": True,
        "outcomes": lines[1]["outcomes"],
    }
    assert lines[-1] == {
        "case": {"bar": "wood"},
        "parameters": HERE,
        "valid": False,
        "reason": '"dröpped" \\ ✓',
    }


def test_a_journal_that_is_told_trials_is_what_saving_writes(tmp_path):
    explored = exploration(**OPTIONS)
    journal = Journal.create(tmp_path / "journal.jsonl", exploration(**OPTIONS))
    for other in (explored, journal):
        other.tell({"bar": "steel"}, HERE, True, {"torque": 0.1 + 0.2, "noise": 1e-300})
        other.tell({"bar": "wood"}, HERE, False, reason="dröpped")
    assert journal.path.read_text() == explored.text == journal.exploration.text


def test_each_trial_is_in_the_file_before_the_next_question(tmp_path):
    journal = Journal.create(tmp_path / "journal.jsonl", exploration(start=HERE))
    for number in range(4):
        assert len(load_exploration(journal.path).trials) == number
        question = journal.exploration.ask()
        journal.tell(question.case, question.parameters, True, {"torque": float(number)})


def test_a_run_that_is_resumed_after_each_trial_writes_the_same_bytes(tmp_path):
    whole = exploration(start=HERE, invalid_budget=0.2)
    run(whole, 15)
    Journal.create(tmp_path / "journal.jsonl", exploration(start=HERE, invalid_budget=0.2))
    for trial in whole.trials:
        journal = Journal.resume(tmp_path / "journal.jsonl")
        assert journal.exploration.ask().parameters == trial.parameters
        journal.tell(trial.case, trial.parameters, trial.valid, trial.outcomes, trial.reason)
    assert journal.path.read_text() == whole.text


# ------------------------------------------------------------------------------------------------------- torn tails
def test_a_line_torn_at_any_byte_is_dropped_and_all_before_it_is_kept(model):
    content = model.read_bytes()
    header = content.index(b"\n") + 1
    for length in range(header, len(content) + 1):
        model.write_bytes(content[:length])
        whole = content[:length].rfind(b"\n") + 1
        assert load_exploration(model).text.encode() == content[:whole]
        assert model.stat().st_size == length, "reading changes no file"
    for length in range(header):
        model.write_bytes(content[:length])
        with pytest.raises(InputError, match="it has no header"):
            load_exploration(model)


@pytest.mark.parametrize("cut", [1, 2, 30, 70])
def test_resuming_cuts_a_torn_line_off_and_goes_on(model, cut):
    content = model.read_bytes()
    model.write_bytes(content[:-cut])
    journal = Journal.resume(model)
    last = content.rstrip(b"\n").rfind(b"\n") + 1
    assert model.read_bytes() == content[:last]
    journal.tell({"bar": "wood"}, HERE, False, reason='"dröpped" \\ ✓')
    assert model.read_bytes() == content


def test_resuming_a_whole_file_does_not_touch_it(model):
    before = model.stat().st_mtime_ns
    Journal.resume(model)
    assert model.stat().st_mtime_ns == before


# --------------------------------------------------------------------------------------------- several programs at once
def test_two_journals_of_one_file_take_in_what_the_other_has_told(model):
    first, second = Journal.resume(model), Journal.resume(model)
    for number, journal in enumerate((first, second, second, first)):
        journal.tell({"bar": "wood"}, HERE, False, reason=f"dropped {number}")
    assert [each.reason for each in first.exploration.trials[-4:]] == [f"dropped {number}" for number in range(4)]
    second.tell({"bar": "steel"}, HERE, False)
    assert model.read_text() == second.exploration.text == load_exploration(model).text


def test_a_line_that_another_program_has_torn_is_cut_off_before_the_next(model):
    journal, before = Journal.resume(model), model.read_text()
    model.write_text(before + '{"case": {"bar"')
    journal.tell({"bar": "wood"}, HERE, False, reason="dropped")
    assert model.read_text() == journal.exploration.text
    assert journal.exploration.trials[-1].reason == "dropped"


def test_a_line_that_is_written_to_its_end_meanwhile_is_no_torn_one(model):
    whole = model.read_bytes()
    model.write_bytes(whole[:-9])
    begun = threading.Event()

    def finish() -> None:
        with model.open("r+b") as file:
            fcntl.flock(file, fcntl.LOCK_EX)
            begun.set()
            time.sleep(0.3)
            file.write(whole)

    other = threading.Thread(target=finish)
    other.start()
    begun.wait()
    journal = Journal.resume(model)
    other.join()
    assert model.read_bytes() == whole == journal.exploration.text.encode()


def test_a_file_that_another_program_has_damaged_is_told_and_not_written(model):
    journal, before = Journal.resume(model), model.read_bytes()
    for damage, message in ((before + b"{}\n", ":9:1: "), (before[:-30], ":1:1: another program has shortened")):
        model.write_bytes(damage)
        with pytest.raises(InputError, match=message):
            journal.tell({"bar": "wood"}, HERE, False, reason="dropped")
        assert model.read_bytes() == damage
    model.write_bytes(before)
    journal.tell({"bar": "wood"}, HERE, False, reason="dropped")
    assert load_exploration(model).text == journal.exploration.text


# ------------------------------------------------------------------------------------------------- files that are there
def test_a_journal_is_not_created_over_a_file(model):
    before = model.read_bytes()
    with pytest.raises(FileExistsError):
        Journal.create(model, exploration())
    assert model.read_bytes() == before


def test_a_file_that_cannot_be_read_is_said(tmp_path):
    for path in (tmp_path / "none.jsonl", tmp_path):
        with pytest.raises(InputError, match=f"{path}:1:1: "):
            load_exploration(path)


def test_messages_call_the_file_by_the_name_they_are_given(tmp_path):
    (tmp_path / "model.jsonl").write_text("")
    with pytest.raises(InputError, match="^the model:1:1: this is no model of an exploration"):
        load_exploration(tmp_path / "model.jsonl", "the model")


def test_a_refused_trial_is_not_written(model):
    journal, before = Journal.resume(model), model.read_bytes()
    for call in (
        lambda: journal.tell({"bar": "brass"}, HERE, False),
        lambda: journal.tell({"bar": "wood"}, HERE, True),
        lambda: journal.tell({"bar": "wood"}, HERE, False, reason="\ud800"),
    ):
        with pytest.raises(ExplorationError):
            call()
    assert model.read_bytes() == before
    assert journal.exploration.text.encode() == before


def test_a_trial_is_not_known_if_it_cannot_be_written(model):
    journal = Journal.resume(model)
    known = journal.exploration.trials
    model.unlink()
    with pytest.raises(FileNotFoundError):
        journal.tell({"bar": "wood"}, HERE, False, reason="dropped")
    assert journal.exploration.trials == known
    assert not model.exists(), "a new file would have no header"


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="no full device")
def test_a_full_disk_is_an_error_and_no_trial(model, tmp_path):
    journal = Journal.resume(model)
    journal.path = tmp_path / "full"
    journal.path.symlink_to("/dev/full")
    known = journal.exploration.trials
    with pytest.raises(OSError, match=r"No space left|Invalid argument"):
        journal.tell({"bar": "wood"}, HERE, False, reason="dropped")
    assert journal.exploration.trials == known


# ----------------------------------------------------------------------------------------------------------- damage
FOREIGN = [
    (b"", "this is no model of an exploration: it has no header"),
    (b"\n", "this is no JSON"),
    (b'{"format": "kabo-plan/1"}\n', "its format is 'kabo-plan/1' = the format of a model is"),
    (b'{"format": ' + b"[" * 90 + b"]" * 90 + b"}\n", "its format is "),
    (b"{}\n", "this is no model of an exploration = "),
    (b"[1, 2]\n", "a line must be an object in braces"),
    (b"null\n", "a line must be an object in braces"),
    (b"\xff\xfe{}\n", "this is no text in UTF-8"),
    (b"\xef\xbb\xbf{}\n", "this is no JSON: Unexpected UTF-8 BOM"),
    (b"exploration: plucks\n", "this is no JSON"),
    (b'{"a": 1, "a": 2}\n', "the key 'a' stands here twice"),
    (b"[" * 100_000 + b"\n", "brackets are nested too deep"),
    (b'{"format": ' + b'{"a":' * 100_000 + b"\n", "brackets are nested too deep"),
    (b'{"format": NaN}\n', "NaN is no number that a model may have"),
    (b"\0" * 4_096 + b"\n", "this is no JSON"),
]


@pytest.mark.parametrize(("content", "message"), FOREIGN, ids=range(len(FOREIGN)))
def test_foreign_files_are_refused_in_their_first_line(tmp_path, content, message):
    line, _, text = damaged(tmp_path / "model.jsonl", [content])
    assert line == 1
    assert message in text


HEADERS = [
    ({"name": 3}, "the name must be a text"),
    ({"seed": 1.5}, "the seed must be a whole number"),
    ({"seed": True}, "the seed must be a whole number"),
    ({"seed": 2**70}, "the seed must be a whole number"),
    ({"seed": None}, "the seed must be a whole number"),
    ({"nam": "x"}, 'unknown key "nam": did you mean "name"'),
    ({"space": None}, "the header is not what kabo writes"),
    ({"space": {"parameters": {}, "cases": {}}}, "1 to 6 parameters"),
    ({"space": {"parameters": {"a": {"from": 1, "to": 0}}, "cases": {}}}, "wrong way round"),
    ({"space": {"parameters": {"a": {"from": True, "to": 2}}, "cases": {}}}, "finite number"),
    ({"space": {"parameters": {"a": {"from": 0}}, "cases": {}}}, "the header is not what kabo writes"),
    ({"space": {"parameters": {"a": {"from": 0, "to": 1, "unit": 3}}, "cases": {}}}, "unit of a must be a text"),
    ({"space": {"parameters": {"a": {"from": 0, "to": 1}}, "cases": {"bar": "steel"}}}, "list of names"),
    (
        {"space": {"parameters": {"a": {"from": 0, "to": 1}}, "cases": {str(k): ["x", "y"] for k in range(99)}}},
        "at most 10000",
    ),
    ({"outcomes": {}}, "one outcome or more"),
    ({"outcomes": ["torque"]}, "the header is not what kabo writes"),
    ({"outcomes": {"torque": {}, "noise": {"units": "Nm"}}}, '"outcomes" is not what kabo writes'),
    ({"validity": {"scale": 0, "noise": 0.1, "alpha": 0.7}}, "scale of validity must be"),
    ({"validity": {"scale": 0.1, "noise": 0.1}}, "the header is not what kabo writes"),
    ({"validity": {"scale": 0.1, "noise": 0.1, "alpha": 0.7, "beta": 1}}, '"validity" is not what kabo writes'),
    ({"invalid_budget": 2}, "the budget of invalid trials must be"),
    ({"start": {"a": 0.5}}, "the parameter b is missing"),
    ({"start": []}, "must map names to values"),
    ({"retry": {"dropped": [1]}}, "a change maps parameters to numbers"),
    ({"retry": None}, '"retry" is not what kabo writes'),
]


@pytest.mark.parametrize(("change", "message"), HEADERS, ids=range(len(HEADERS)))
def test_damaged_headers_are_refused(model, change, message):
    header, *lines = model.read_text().split("\n")[:-1]
    line, _, text = damaged(model, [json.dumps(json.loads(header) | change), *lines])
    assert line == 1
    assert message in text


@pytest.mark.parametrize(
    "key", ["format", "name", "space", "outcomes", "validity", "invalid_budget", "start", "retry", "seed"]
)
def test_a_header_without_one_of_its_keys_is_refused(model, key):
    header = json.loads(model.read_text().split("\n")[0])
    del header[key]
    _, _, text = damaged(model, [json.dumps(header)])
    assert (f'the key "{key}" is missing' in text) == (key != "format")


INVALID = '{"case": {"bar": "steel"}, "parameters": {"a": 0, "b": 0}, "valid": false, "reason": "x"}'
FINE = (
    INVALID.replace('{"a": 0,', '{"a": 0.5,')
    .replace("false", "true")
    .replace('"reason": "x"', '"outcomes": {"torque": 1, "noise": 2}')
)
TRIALS = [
    ("", 1, "this is no JSON"),
    ("null", 1, "a line must be an object"),
    (FINE[:-1], len(FINE), "this is no JSON"),
    (FINE + FINE, len(FINE) + 1, "this is no JSON: Extra data"),
    (FINE.replace('"a": 0.5', '"a": 0.5, "a": 0.5'), 1, "the key 'a' stands here twice"),
    (FINE.replace("0.5", "NaN"), 1, "NaN is no number"),
    (FINE.replace("0.5", "1e999"), 1, "a must be a finite number up to 1e+100, this is inf"),
    (FINE.replace("0.5", "-Infinity"), 1, "-Infinity is no number"),
    (FINE.replace("0.5", "true"), 1, "a must be a finite number"),
    (FINE.replace("0.5", "9" * 10_000), 1, "a must be a finite number"),
    (FINE.replace("0.5", "7"), 1, "a is 7, outside its bounds 0 to 1"),
    (FINE.replace("0.5", "[" * 900 + "]" * 900), 1, "a must be a finite number"),
    (FINE.replace("0.5", "[" * 10**6), 1, "nested too deep"),
    (FINE.replace("steel", "brass"), 1, 'unknown value of bar "brass"'),
    (FINE.replace("steel", "\\ud800"), 1, "unknown value of bar"),
    (FINE.replace('"bar"', '"' + "b" * 10_000 + '"'), 1, "unknown case variable"),
    (FINE.replace('"case": {"bar": "steel"}', '"case": null'), 1, "the case must say bar"),
    (FINE.replace("valid", "vali"), 1, 'unknown key "vali": did you mean "valid"'),
    (FINE.replace("true", "1"), 1, 'the key "reason" is missing'),
    (FINE.replace("true", "false"), 1, 'the key "reason" is missing'),
    (FINE.replace('"torque": 1, ', ""), 1, "torque is missing"),
    (FINE.replace('"torque": 1', '"torque": null'), 1, "torque must be a finite number"),
    (FINE.replace("}}", '}, "reason": "dropped"}'), 1, "a valid trial has no reason"),
    (FINE.replace("}}", '}, "reason": ""}'), 1, "the trial is not what kabo writes"),
    (FINE.replace("}}", '}, "reason": 3}'), 1, "the reason must be a text"),
    (
        FINE.replace('"outcomes": {"torque": 1, "noise": 2}', '"outcomes": [1, 2]'),
        1,
        "outcomes must map names to numbers",
    ),
    (
        '{"case": {"bar": "steel"}, "parameters": {"a": 0, "b": 0}, "valid": false, "reason": "x", "outcomes": {}}',
        1,
        "not what",
    ),
    (
        '{"case": {"bar": "steel"}, "parameters": {"a": 0, "b": 0}, "valid": false, "reason": "\\ud800"}',
        1,
        "must be a text",
    ),
    (
        '{"case": {"bar": "steel"}, "parameters": [0, 0], "valid": false, "reason": ""}',
        1,
        "parameters must map names",
    ),
]


@pytest.mark.parametrize(("text", "column", "message"), TRIALS, ids=range(len(TRIALS)))
def test_damaged_trials_are_refused_with_their_line(model, text, column, message):
    lines = model.read_text().split("\n")[:-1]
    line, at, found = damaged(model, [*lines[:3], text, *lines[3:]])
    assert (line, at) == (4, column)
    assert message in found


def test_bytes_that_are_no_text_are_refused_with_their_column(model):
    lines = model.read_bytes().split(b"\n")[:-1]
    lines[2] = lines[2][:20] + b"\xc3\x28" + lines[2][20:]
    assert damaged(model, [line + b"\n" for line in lines])[:2] == (3, 21)


def test_numbers_and_line_ends_may_be_written_in_other_ways(model):
    other = model.read_bytes().replace(b'"a": 0.5,', b'"a": 5e-1,').replace(b"\n", b"\r\n")
    expected = load_exploration(model)
    model.write_bytes(other)
    assert load_exploration(model).text == expected.text
