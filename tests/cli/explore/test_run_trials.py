"""`kabo explore run`: makes trials, keeps all of them whatever happens, and goes on where it ended."""

import json
import signal

import jsonschema
import pytest

from kabo.exploration import load_exploration
from kabo.plan import schema
from tests.support.discs import FILE, STAGES, write_files
from tests.support.folders import written_in

SCHEMA = schema("kabo-explore-1")


@pytest.fixture
def discs(tmp_path, monkeypatch):
    write_files(tmp_path)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def run(kabo, trials, *arguments):
    return kabo(
        "explore", "run", "disc.yaml", "--stages", "disc.py", "--trials", trials, "-o", "m.jsonl", *arguments
    )


def test_a_run_writes_the_model_and_tells_what_it_holds(kabo, discs):
    said = run(kabo, 20)
    assert said.code == 0
    assert said.out.startswith("disc: 20 trials, ") and "bar wood: " in said.out
    assert "m.jsonl: 20 new trials" in said.err
    assert len(load_exploration("m.jsonl").trials) == 20
    assert written_in(discs) == ["disc.py", "disc.yaml", "m.jsonl"]


def test_json_is_one_object_of_the_schema(kabo, discs):
    said = run(kabo, 12, "--json", "--seed", 3, "--invalid-budget", 0.2)
    jsonschema.validate(said.json, SCHEMA)
    jsonschema.validate(said.json, {**SCHEMA, "anyOf": [{"$ref": "#/$defs/Ran"}]})
    assert (said.json["made"], said.json["trials"], said.json["stopped"]) == (12, 12, None)
    made = load_exploration("m.jsonl")
    assert (made.seed, made.invalid_budget) == (3, 0.2)


def test_no_trials_write_the_header_alone_even_of_trials_that_are_made_elsewhere(kabo, discs):
    (discs / "disc.yaml").write_text(FILE.replace("trial: tests/Disc\n", ""))
    said = kabo("explore", "run", "disc.yaml", "--trials", 0, "-o", "m.jsonl")
    assert said.code == 0 and said.out.startswith("disc: 0 trials, 0 valid, 2 cases")
    assert len((discs / "m.jsonl").read_text().splitlines()) == 1
    said = kabo("explore", "run", "disc.yaml", "--trials", 1, "--resume", "-o", "m.jsonl")
    assert said.code == 2 and "does not say how a trial is made" in said.err
    assert len((discs / "m.jsonl").read_text().splitlines()) == 1


def test_a_model_is_not_overwritten_and_resumed_only_if_that_is_wanted(kabo, discs):
    run(kabo, 8)
    before = (discs / "m.jsonl").read_bytes()
    said = run(kabo, 12)
    assert said.code == 2 and "m.jsonl:1:1: there is such a file already" in said.err and "--resume" in said.err
    assert (discs / "m.jsonl").read_bytes() == before
    said = run(kabo, 12, "--resume", "--json")
    assert said.code == 0 and said.json["made"] == 4
    assert (discs / "m.jsonl").read_bytes().startswith(before)
    assert run(kabo, 12, "--resume", "--json").json["made"] == 0


def test_a_resumed_model_is_as_if_it_had_been_made_at_once(kabo, discs):
    run(kabo, 15)
    whole = (discs / "m.jsonl").read_bytes()
    (discs / "m.jsonl").unlink()
    for trials in (0, 4, 5, 11, 15):
        assert run(kabo, trials, "--resume").code == 0
    assert (discs / "m.jsonl").read_bytes() == whole


def test_a_torn_last_line_is_cut_off_and_made_again(kabo, discs):
    run(kabo, 9)
    whole = (discs / "m.jsonl").read_bytes()
    (discs / "m.jsonl").write_bytes(whole[:-20])
    assert run(kabo, 9, "--resume", "--json").json["made"] == 1
    assert (discs / "m.jsonl").read_bytes() == whole


@pytest.mark.parametrize(
    ("change", "options", "differs"),
    [
        (("to: 0.08", "to: 0.09"), (), "space parameters along to is 0.09, in the model 0.08"),
        (("bar: [steel, wood]", "bar: [steel]"), (), "space cases bar is steel, in the model steel, wood"),
        (
            ("torque: {unit: Nm}", "twist: {unit: Nm}"),
            (),
            "outcomes twist is not in the model; outcomes torque is only",
        ),
        (("force: 20}", "force: 21}"), (), "start force is 21.0, in the model 20.0"),
        (("dropped: {force: 2}", "dropped: {force: 3}"), (), "retry dropped force is 3.0, in the model 2.0"),
        (("start: {along: 0.0, force: 20}", ""), (), "start force is 20.5, in the model 20.0"),
        (("exploration: disc", "exploration: disk"), (), "name is disk, in the model disc"),
        (("", ""), ("--seed", 1), "seed is 1, in the model 0"),
        (("", ""), ("--invalid-budget", 0.3), "invalid_budget is 0.3, in the model not given"),
    ],
)
def test_a_model_of_another_exploration_is_refused_with_what_differs(kabo, discs, change, options, differs):
    run(kabo, 3)
    before = (discs / "m.jsonl").read_bytes()
    (discs / "disc.yaml").write_text(FILE.replace(*change))
    said = run(kabo, 6, "--resume", *options)
    assert said.code == 2 and differs in said.err, said.err
    assert (discs / "m.jsonl").read_bytes() == before


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--invalid-budget", "nan"], "--invalid-budget:1:1: write a share above 0 and below 1"),
        (["--invalid-budget", "1.5"], "--invalid-budget:1:1"),
        (["--seed", "-1"], "'-1' is not a whole number"),
        (["--seed", 10**30], "is not a whole number from 0 on: 9223372036854775807 is the largest"),
        (["--trials", "x"], "'x' is not a whole number"),
        (["-o", "nowhere/m.jsonl"], "is no file in a folder that exists"),
        (["--stages", "none.py"], "none.py:1:1: this is no Python file"),
    ],
)
def test_wrong_arguments_are_refused_and_nothing_is_written(kabo, discs, arguments, message):
    said = run(kabo, 3, *arguments)
    assert said.code == 2 and message in said.err and "Traceback" not in said.err
    assert written_in(discs) == ["disc.py", "disc.yaml"]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("to: 0.08", "to: -0.08"), "disc.yaml:4:"),
        (("from: 1,", "from: .nan,"), "disc.yaml:5:"),
        (("force: 20}", "force: 99}"), "disc.yaml:8:"),
        (("force: 20}", "fcrce: 20}"), 'did you mean "force"?'),
        (("outcomes:", "outcome:"), 'did you mean "outcomes"?'),
        (("tests/Disc", "tests/Disk"), 'unknown trial "tests/Disk"'),
    ],
)
def test_a_wrong_file_is_refused_with_its_place_and_no_trial_is_made(kabo, discs, change, message):
    (discs / "disc.yaml").write_text(FILE.replace(*change, 1))
    said = run(kabo, 3)
    assert said.code == 2 and message in said.err and "Traceback" not in said.err
    assert not (discs / "m.jsonl").exists()


def test_a_trial_that_raises_ends_the_run_is_named_and_all_before_it_is_kept(kabo, discs):
    text = STAGES.replace(
        "    if hypot", "    if seed % 7 == 4:\n        raise RuntimeError('no air')\n    if hypot"
    )
    (discs / "disc.py").write_text(text)
    said = run(kabo, 60)
    assert said.code == 2 and "disc.py:8:1: trial " in said.err and "RuntimeError: no air" in said.err
    assert "along " in said.err and "force " in said.err and "Traceback" not in said.err
    kept = load_exploration("m.jsonl").trials
    assert 0 < len(kept) < 60
    assert f"trial {len(kept) + 1} " in said.err


@pytest.mark.parametrize("given", ["None", 'Valid({"torque": float("nan")})', "Valid({})", 'Invalid("")', "True"])
def test_what_is_no_result_ends_the_run(kabo, discs, given):
    (discs / "disc.py").write_text(STAGES.replace("    along,", f"    return {given}\n    along,"))
    said = run(kabo, 5)
    assert said.code == 2 and "disc.py:5:1: trial 1 (bar " in said.err and "Traceback" not in said.err
    assert load_exploration("m.jsonl").trials == ()


def test_a_name_that_is_registered_twice_is_told_at_its_line(kabo, discs):
    other = "\ndef other(case, parameters, seed): ...\n\nregister(other, 'tests/Twice')\n"
    (discs / "twice.py").write_text(STAGES.replace("tests/Disc", "tests/Twice") + other)
    said = kabo("explore", "run", "disc.yaml", "--stages", "twice.py", "--trials", 1, "-o", "m.jsonl")
    assert said.code == 2 and "twice.py:15:1: ExplorationError: the name 'tests/Twice'" in said.err
    assert not (discs / "m.jsonl").exists()


def test_where_nothing_is_valid_the_run_ends_and_says_why(kabo, discs):
    (discs / "disc.py").write_text(STAGES.replace("> 1:", "> 0:"))
    said = run(kabo, 60, "--json")
    assert said.code == 4 and said.json["stopped"] == "nothing_valid" and said.json["valid"] == 0
    assert "none of 10 trials is valid" in said.json["message"] and said.json["message"] in said.err
    jsonschema.validate(said.json, SCHEMA)


def test_an_interrupt_ends_the_run_and_keeps_all_trials(kabo, discs):
    kill = "    os.kill(os.getpid(), signal.SIGINT)\n    along,"
    (discs / "disc.py").write_text("import os, signal\n" + STAGES.replace("    along,", kill, 1))
    before = signal.getsignal(signal.SIGINT)
    said = run(kabo, 60, "--json")
    assert said.code == 4 and said.json["stopped"] == "interrupted" and said.json["made"] == 1
    assert "--resume goes on" in said.err
    assert signal.getsignal(signal.SIGINT) is before
    assert len(load_exploration("m.jsonl").trials) == 1


def test_time_ends_the_run_and_keeps_all_trials(kabo, discs):
    (discs / "disc.py").write_text(
        "import time\n" + STAGES.replace("    along,", "    time.sleep(0.2)\n    along,", 1)
    )
    said = run(kabo, 60, "--json", "--timeout", 0.5)
    assert said.code == 4 and said.json["stopped"] == "time" and 0 < said.json["made"] < 5
    assert len((discs / "m.jsonl").read_text().splitlines()) == said.json["trials"] + 1


def test_every_line_of_the_model_is_json(kabo, discs):
    run(kabo, 5)
    header, *trials = map(json.loads, (discs / "m.jsonl").read_text().splitlines())
    assert header["format"] == "kabo-exploration/1" and len(trials) == 5
